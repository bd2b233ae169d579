//! How the input of a static loop goes up and down.

use recording::Recording;

/// Reversals below this share of the input's range are ripple: as cycles of a drive are counted (`recording::cycles`).
const RIPPLE: f64 = 0.05;

/// The way of an input, ripple left out by a play: it follows where it is pushed.
///
/// ```text
/// p → min(max(p, u - r), u + r),   n = ∫|dp|/(2 (range - 2r)),   2r = 0.05 range
/// ```
///
/// n counts cycles over the whole range, smaller ones by their path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct InputPath {
    half_play: f64,
    /// Cycles in a unit of the path.
    cycles_per_path: f64,
}

/// Which ways an input goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OneWay {
    /// It only rises.
    Heating,
    /// It only falls.
    Cooling,
}

impl InputPath {
    /// For inputs over this range; > 0.
    pub(crate) fn over(range: f64) -> Self {
        let half_play = 0.5 * RIPPLE * range;
        Self {
            half_play,
            cycles_per_path: 0.5 / (range - 2.0 * half_play),
        }
    }

    /// Where the play is pushed to.
    #[inline(always)]
    pub(crate) fn pushed(&self, play: f64, input: f64) -> f64 {
        play.max(input - self.half_play).min(input + self.half_play)
    }

    /// Cycles that a move of the play adds.
    #[inline(always)]
    pub(crate) fn cycles_between(&self, before: f64, after: f64) -> f64 {
        self.cycles_per_path * (after - before).abs()
    }

    /// Cycles of a whole recording.
    pub(crate) fn cycles(&self, input: &[f64]) -> f64 {
        let mut play = input[0];
        let added = input.iter().map(|&input| {
            let before = play;
            play = self.pushed(play, input);
            self.cycles_between(before, play)
        });
        added.sum()
    }

    /// The one way that the inputs of some recordings go, if they go one way.
    pub(crate) fn one_way<'a>(
        &self,
        recordings: impl IntoIterator<Item = &'a Recording>,
    ) -> Option<OneWay> {
        let (mut rises, mut falls) = (false, false);
        for recording in recordings {
            let mut play = recording.drive()[0];
            for &input in recording.drive() {
                let before = play;
                play = self.pushed(play, input);
                rises |= play > before;
                falls |= play < before;
            }
        }
        match (rises, falls) {
            (true, false) => Some(OneWay::Heating),
            (false, true) => Some(OneWay::Cooling),
            _ => None,
        }
    }
}
