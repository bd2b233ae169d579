use crate::{ClosedLoop, Ending};

/// Runs that have to end at rest: to the set point from other sides than the task itself.
///
/// A loop that rests after a step from cold may swing for ever after it came from hot, or after a small step: the
/// hysteresis is another one there.
#[derive(Debug, Clone, Copy)]
pub struct RestTest<'a> {
    /// The loops, each of which ends at the set point, at least a quarter of its samples long.
    pub loops: &'a [ClosedLoop<'a>],
    /// Height of the step, in the output's unit: swings of more than 2 % of it are none of a loop at rest.
    pub height: f64,
    /// Largest swing of the drive of a loop at rest, in its unit.
    pub drive_swing: f64,
}

impl RestTest<'_> {
    /// By how much an ending is no rest, as a share of what would still be one; `None` for rest. An output that is no
    /// number does not rest.
    pub(crate) fn unrest(&self, ending: &Ending) -> Option<f64> {
        if !ending.swing.is_finite() {
            return Some(f64::MAX);
        }
        if ending.oscillates(self.height) {
            return Some(ending.swing / self.height.abs());
        }
        ending
            .chatters(self.drive_swing)
            .then(|| ending.drive_swing / self.drive_swing)
    }
}
