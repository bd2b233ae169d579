//! Rest of a loop at its set point, whatever side it comes from.

use pid_tune::{ClosedLoop, Ending, PidGains, Reference};
use sma_effects::Member;

use super::Bench;
use crate::WorkbenchError;

/// Swing of the drive at rest, as a share of its range, from which it chatters: what four of the largest jumps that
/// gains may make of one step of the sensor come to, two up and two down.
pub const CHATTER: f64 = 0.2;
/// Share of the step within which an output is at the set point: the band in which a response has settled.
const BAND: f64 = 0.02;
/// Time constants of a run on its way to where it comes from, and then to the set point.
const BEFORE_TAUS: f64 = 8.0;
/// See [`BEFORE_TAUS`].
const AFTER_TAUS: f64 = 12.0;
/// Most samples of either.
const MOST_SAMPLES: f64 = 200_000.0;
/// Share of the way at which a loop that comes from near waits.
const NEAR: f64 = 0.95;

/// The side from which a set point is approached.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// From the cold rod.
    Cold,
    /// From a rod heated as far as the drive goes.
    Hot,
    /// From 5 % of the way below.
    Near,
}

impl Side {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Cold, Self::Hot, Self::Near];

    /// A word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cold => "cold",
            Self::Hot => "hot",
            Self::Near => "near",
        }
    }
}

/// How a run to a set point ended, with all effects of the rig, its sensor and its delay.
#[derive(Debug, Clone, Copy)]
pub struct Rest {
    /// The side that it came from.
    pub side: Side,
    /// Its end.
    pub end: End,
    /// Mean of reference - output in the end, in the output's unit.
    pub mean_error: f64,
    /// Swing of the output in the end, in its unit.
    pub output_swing: f64,
    /// Swing of the drive in the end, as a share of its range.
    pub drive_swing: f64,
}

/// End of a run: rest, or what keeps it from rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Output and drive are quiet, the output at the set point.
    Rests,
    /// The output swings by more than 2 % of the step.
    Swings,
    /// The drive swings by more than [`CHATTER`] of its range, the output by less.
    Chatters,
    /// It is quiet, and more than 2 % of the step away from the set point: the drive is at a limit, or there is no
    /// integral, or a slow one.
    Off,
}

impl End {
    /// A word for programs.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rests => "rests",
            Self::Swings => "swings",
            Self::Chatters => "chatters",
            Self::Off => "off_set_point",
        }
    }
}

/// References to a set point, as the controller sees it, from each side: first held somewhere else, then there.
#[derive(Debug, Clone)]
pub struct Approaches {
    levels: [Vec<f64>; 3],
    noise: Vec<f64>,
}

impl Approaches {
    /// The noise of the longest.
    fn noise(&self, side: usize) -> &[f64] {
        let n_samples = self.levels[side].len();
        self.noise.get(..n_samples).unwrap_or_default()
    }
}

impl Bench<'_> {
    /// References to a set point, as the controller sees it, from each side.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn approaches(&self, set_point: f64) -> Result<Approaches, WorkbenchError> {
        let rest = self.rig.rest_output()?;
        let samples = |taus: f64| {
            let samples = taus * self.rig.tau_s() / self.pid.dt_s;
            samples.ceil().clamp(16.0, MOST_SAMPLES) as usize
        };
        let levels = Side::ALL.map(|side| {
            let (before, first) = match side {
                Side::Cold => (0, set_point),
                // Never reached, so that the drive stays at its limit.
                Side::Hot => (samples(BEFORE_TAUS), rest + 2.0 * self.rig.stroke()),
                Side::Near => (samples(BEFORE_TAUS), rest + NEAR * (set_point - rest)),
            };
            let mut levels = vec![first; before];
            levels.resize(before + samples(AFTER_TAUS), set_point);
            levels
        });
        let longest = levels.iter().map(Vec::len).fold(0, usize::max);
        Ok(Approaches {
            noise: self.noise(longest),
            levels,
        })
    }

    /// The loop from each side.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn approaching<'a>(
        &self,
        approaches: &'a Approaches,
    ) -> Result<[ClosedLoop<'a>; 3], WorkbenchError> {
        let around = |side: usize| {
            let levels = &approaches.levels[side];
            let reference = Reference::Samples(levels);
            self.closed_loop(reference, levels.len(), approaches.noise(side), None)
        };
        Ok([around(0)?, around(1)?, around(2)?])
    }

    /// Runs a controller to a set point, as it sees it, from each side; the loops are those of [`Bench::approaching`].
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn rests(
        &self,
        gains: PidGains,
        set_point: f64,
        approaching: [ClosedLoop<'_>; 3],
    ) -> Result<[Rest; 3], WorkbenchError> {
        let [cold, hot, near] = approaching;
        let height = set_point - self.rig.rest_output()?;
        let rest = |side, closed_loop| self.ended(side, height, gains, closed_loop);
        Ok([
            rest(Side::Cold, cold)?,
            rest(Side::Hot, hot)?,
            rest(Side::Near, near)?,
        ])
    }

    /// Share of some rods on which a controller does not come to rest at a set point, as it sees it, from one of the
    /// sides.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn restless_share(
        &self,
        gains: PidGains,
        set_point: f64,
        approaching: [ClosedLoop<'_>; 3],
        rods: &[Member],
    ) -> Result<f64, WorkbenchError> {
        let height = set_point - self.rig.rest_output()?;
        let cases: Vec<_> = rods.iter().map(|&rod| (rod, gains)).collect();
        let mut restless = vec![false; rods.len()];
        for closed_loop in approaching {
            let responses = self.task(closed_loop)?.responses(&cases)?;
            for (restless, response) in restless.iter_mut().zip(&responses) {
                let end = self.end(&response.ending, height);
                *restless |= matches!(end, End::Swings | End::Chatters);
            }
        }
        let n_restless = restless.iter().filter(|restless| **restless).count();
        Ok(n_restless as f64 / rods.len() as f64)
    }

    fn ended(
        &self,
        side: Side,
        height: f64,
        gains: PidGains,
        closed_loop: ClosedLoop<'_>,
    ) -> Result<Rest, WorkbenchError> {
        let task = self.task(closed_loop)?;
        let ending = task.response(self.rig.member, gains)?.ending;
        Ok(Rest {
            side,
            end: self.end(&ending, height),
            mean_error: ending.mean_error,
            output_swing: ending.swing,
            drive_swing: ending.drive_swing / self.drive_range(),
        })
    }

    fn end(&self, ending: &Ending, height: f64) -> End {
        if !ending.swing.is_finite() || ending.oscillates(height) {
            End::Swings
        } else if ending.chatters(CHATTER * self.drive_range()) {
            End::Chatters
        } else if ending.mean_error.abs() > BAND * height.abs() {
            End::Off
        } else {
            End::Rests
        }
    }

    /// The drive's range, in its unit.
    #[must_use]
    pub fn drive_range(&self) -> f64 {
        let limits = self.pid.limits;
        limits.upper - limits.lower
    }
}
