//! From the zones to the displacement.

use crate::effect::{Instant, Moment, Seen, Standing};
use crate::plant::ExtendedPlant;
use crate::state::{ExtendedState, Zone};

impl<const L: usize> ExtendedPlant<L> {
    /// Displacement at an instant of the sample.
    #[inline(always)]
    pub(crate) fn show(
        &self,
        state: &mut ExtendedState<L>,
        moment: &Moment,
        instant: Instant,
    ) -> [f64; L] {
        let (mut displacement, seen) = self.stroke(state, instant);
        self.effects
            .displacement(&mut state.rod, moment, &seen, &mut displacement);
        displacement
    }

    /// Displacement by the fraction alone.
    #[inline(always)]
    pub(crate) fn stroke(&self, state: &ExtendedState<L>, instant: Instant) -> ([f64; L], Seen<L>) {
        let (mut fraction, mut temperature_degc) = self.moved_by(&state.middle, instant);
        if let Some(ends) = &state.ends {
            let (of_ends, ends_degc) = self.moved_by(ends, instant);
            fraction = self.mean(&[fraction, of_ends]);
            temperature_degc = self.mean(&[temperature_degc, ends_degc]);
        }
        let displacement = self.read_out(&fraction);
        let seen = Seen {
            temperature_degc,
            instant,
        };
        (displacement, seen)
    }

    /// gain ξ + offset.
    #[inline(always)]
    pub(crate) fn read_out(&self, fraction: &[f64; L]) -> [f64; L] {
        let mut displacement = [0.0; L];
        for l in 0..L {
            displacement[l] = self.gain[l] * fraction[l] + self.offset[l];
        }
        displacement
    }

    /// The fraction of a zone that counts for the displacement, and its temperature, °C.
    #[inline(always)]
    fn moved_by(&self, zone: &Zone<L>, instant: Instant) -> ([f64; L], [f64; L]) {
        let (mut fraction, temperature_degc) = if instant == Instant::Middle {
            (zone.middle_fraction, zone.middle_degc)
        } else {
            (zone.fraction, zone.temperature_degc)
        };
        if self.path.stands_in_zone {
            let mut transformed = [0.0; L];
            for l in 0..L {
                transformed[l] = self.scale.transformed(l, fraction[l]);
            }
            let at = Standing {
                temperature_degc,
                transformed,
            };
            self.effects.stroke(&zone.effects, &at, &mut fraction);
        }
        (fraction, temperature_degc)
    }

    /// Mean over the length of the rod of what the zones have.
    #[inline(always)]
    pub(crate) fn mean<const Z: usize>(&self, of_zones: &[[f64; L]; Z]) -> [f64; L] {
        let mut mean = of_zones[0];
        if Z > 1 {
            for l in 0..L {
                let difference = of_zones[Z - 1][l] - mean[l];
                mean[l] += self.effects.end_conduction.share[l] * difference;
            }
        }
        mean
    }
}
