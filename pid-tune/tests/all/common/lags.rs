//! A fleet of lags of first order.

use std::convert::Infallible;

use wiener::{Fleet, Input, Lanes, NARROW, Output, Plant, Started, WIDE};

use super::AMBIENT_DEGC;

/// Displacements that approach the drive; where it is above `breaks_above`, they are no number any more.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lags {
    pub(crate) breaks_above: f64,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct LagPlant<const L: usize> {
    tau_s: [f64; L],
    breaks_above: f64,
}

impl Fleet for Lags {
    type Member = f64;
    type Error = Infallible;

    fn narrow(&self, tau_s: &[f64; NARROW]) -> Result<Box<dyn Lanes<NARROW> + Send>, Infallible> {
        Ok(self.started(tau_s).boxed())
    }

    fn wide(&self, tau_s: &[f64; WIDE]) -> Result<Box<dyn Lanes<WIDE> + Send>, Infallible> {
        Ok(self.started(tau_s).boxed())
    }
}

impl Lags {
    fn started<const L: usize>(self, tau_s: &[f64; L]) -> Started<L, LagPlant<L>> {
        Started {
            plant: LagPlant {
                tau_s: *tau_s,
                breaks_above: self.breaks_above,
            },
            // A time constant that is no number starts at no number.
            state: tau_s.map(|tau_s| 0.0 * tau_s),
        }
    }
}

impl<const L: usize> Plant<L> for LagPlant<L> {
    type State = [f64; L];

    fn rest(&self, _: f64) -> [f64; L] {
        [0.0; L]
    }

    fn output(&self, state: &[f64; L]) -> Output<L> {
        Output {
            displacement: *state,
            temperature_degc: [AMBIENT_DEGC; L],
        }
    }

    fn step(&self, state: &mut [f64; L], input: &Input<L>, dt_s: f64) {
        for l in 0..L {
            let drive = input.drive[l];
            state[l] = drive + (state[l] - drive) * (-dt_s / self.tau_s[l]).exp();
            if drive > self.breaks_above {
                state[l] = f64::NAN;
            }
        }
    }
}
