//! Partial loops of a run that no other run has: a loop is known inside only where a run has turned back there.

use crate::model::turning::{TurningPoint, turning_points};

/// Turn of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turn {
    /// Sample at which it turns.
    at: usize,
    is_top: bool,
    /// Height over the lowest output of all runs, as a share of their span.
    share: f64,
}

/// Smallest swing that counts, as a share of the span.
const SWING: f64 = 0.03;

/// Farthest two turns whose partial loops are alike, as a share of the span.
const ALIKE: f64 = 0.2;

impl Turn {
    /// True if the way back from it leads through a loop: at the end to which it turns back, nothing has moved yet.
    fn leads_through_loop(&self) -> bool {
        let from_end = if self.is_top {
            self.share
        } else {
            1.0 - self.share
        };
        from_end > SWING
    }

    fn is_like(&self, other: &Self) -> bool {
        self.is_top == other.is_top && (self.share - other.share).abs() <= ALIKE
    }
}

/// Turns of an output whose lowest and highest values over all runs are these; its beginning counts as one.
pub(crate) fn turns(output: &[f64], [lowest, highest]: [f64; 2]) -> Vec<Turn> {
    let span = (highest - lowest).max(f64::MIN_POSITIVE);
    let turn = |point: TurningPoint| Turn {
        at: point.at,
        is_top: point.is_top,
        share: (output[point.at] - lowest) / span,
    };
    let points = turning_points(output, SWING * span);
    points.into_iter().map(turn).collect()
}

/// Which of `n` samples of a run lie in loops that others have as well: those after a turn like one of theirs.
pub(crate) fn is_known(own: &[Turn], others: &[Turn], n: usize) -> Vec<bool> {
    let mut known = vec![true; n];
    let is_known = |turn: &Turn| {
        let mut others = others.iter().filter(|other| other.leads_through_loop());
        !turn.leads_through_loop() || others.any(|other| turn.is_like(other))
    };
    for (k, turn) in own.iter().enumerate() {
        if !is_known(turn) {
            let end = own.get(k + 1).map_or(n, |next| next.at);
            known[turn.at..end].fill(false);
        }
    }
    known
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From corner to corner in ten samples each, the corner as the tenth.
    fn played(corners: &[f64]) -> Vec<f64> {
        let between = corners.windows(2);
        let steps = between.flat_map(|pair| {
            (0..10).map(move |k| pair[0] + (pair[1] - pair[0]) * f64::from(k) / 10.0)
        });
        steps.chain(corners.last().copied()).collect()
    }

    fn turned(corners: &[f64]) -> Vec<Turn> {
        turns(&played(corners), [0.0, 2.0])
    }

    #[test]
    fn turns_are_corners_and_ripples_are_none() {
        let turns = turned(&[0.0, 1.2, 1.17, 1.4, 0.2, 2.0, 0.0]);
        let told: Vec<_> = turns.iter().map(|turn| (turn.at, turn.is_top)).collect();
        assert_eq!(told, [(0, false), (30, true), (40, false), (50, true)]);
        assert!((turns[1].share - 0.7).abs() < 1e-12 && (turns[2].share - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_loop_inside_is_known_where_another_run_has_turned_back_near_it() {
        let known = |own: &[f64], others: &[f64]| {
            let n = played(own).len();
            is_known(&turned(own), &turned(others), n)
        };
        let major = [0.0, 2.0, 0.0];
        let inner = [0.0, 2.0, 0.0, 1.0, 0.0, 2.0, 0.0];
        assert!(known(&major, &major).iter().all(|one| *one));
        // The turn at a half of the stroke, and until the next.
        let mut only = vec![true; 61];
        only[30..40].fill(false);
        assert_eq!(known(&inner, &major), only);
        assert!(
            known(&inner, &[0.0, 0.8, 0.0, 2.0, 0.0])
                .iter()
                .all(|one| *one)
        );
        // A small loop at an end is none that a run to the other end knows.
        let small = known(&[0.0, 0.12, 0.0, 2.0], &[0.0, 0.04, 0.0, 2.0]);
        assert!(small[..10].iter().all(|one| *one) && !small[10]);
    }
}
