//! Gain schedules that a search tries.

use pid_tune::{Answers, PidParams, Requirements, ScheduleShape, Screen};

use super::Bench;
use crate::WorkbenchError;

/// Exponents that are tried.
const EXPONENTS: [f64; 2] = [0.5, 1.0];
/// Way of the output from one branch to the other after a turn, as a share of the levels' range, and in jumps of the sensor at
/// least: noise at rest goes to and fro by five jumps, ten times its standard deviation.
const TURN: [f64; 2] = [0.1, 10.0];

/// A controller with a gain schedule, and what its gains have to meet.
#[derive(Debug)]
pub struct Scheduled<'a> {
    /// Kind of its schedule.
    pub shape: ScheduleShape,
    /// The rig with it.
    pub bench: Bench<'a>,
    /// Its requirements, at every level.
    pub screen: Screen,
}

/// A gain schedule that was tried, and what its best gains cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriedSchedule {
    /// Exponent p on the slope, 0 to 1.
    pub exponent: f64,
    /// True for a factor on each branch.
    pub by_branch: bool,
    /// Cost of its best gains; `None` if none meet what is required.
    pub cost: Option<f64>,
}

impl TriedSchedule {
    /// Quantities that its factor depends on, in words.
    #[must_use]
    pub fn by(&self) -> &'static str {
        if self.by_branch {
            "level and branch"
        } else {
            "level"
        }
    }
}

impl<'a> Bench<'a> {
    /// How the rig answers small changes of the drive everywhere between rest and the highest output that is asked for, as the
    /// controller sees it.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn answers(&self, highest: f64) -> Result<Answers, WorkbenchError> {
        let changes = self.small_changes(highest)?;
        Ok(changes.everywhere(&self.rig.fleet, self.rig.member)?)
    }

    /// The schedules that are tried on a rig that answers so; none where the output does not answer the drive.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn scheduled(
        &self,
        answers: &Answers,
        largest_factor: f64,
        requirements: Requirements,
    ) -> Result<Vec<Scheduled<'a>>, WorkbenchError> {
        if answers.heating.is_empty() || answers.cooling.is_empty() {
            return Ok(Vec::new());
        }
        let [share, jumps] = TURN;
        let [lower, upper] = answers.outputs;
        let turn = (share * (upper - lower)).max(jumps * self.sensor.jump());
        let shapes = [false, true].into_iter().flat_map(|by_branch| {
            EXPONENTS.map(|exponent| ScheduleShape {
                exponent,
                by_branch,
                largest_factor,
                turn,
            })
        });
        let scheduled = shapes.map(|shape| {
            let pid = PidParams {
                gain_schedule: Some(shape.schedule(answers)?),
                ..self.pid
            };
            Ok(Scheduled {
                shape,
                bench: Bench { pid, ..*self },
                screen: Screen::everywhere(requirements, pid, answers)?,
            })
        });
        scheduled.collect()
    }
}
