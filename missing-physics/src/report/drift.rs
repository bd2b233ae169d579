//! A drift's values along recordings: how far they change, and if they are slow.

use identify::Fit;
use identify::dense::{Matrix, symmetric_solved};

use crate::Candidate;
use crate::model::elsewhere::is_drift;
use crate::report::formula::HALF_95;
use crate::screen::scores::as_one;

/// Turns within a recording from which a curve of time is no slow one.
const RESTLESS: usize = 3;

/// Share of a drift's range from one of its values to the next from which that is an event, or a level: what approaches its end with a time
/// constant as long as values are apart goes that far in the time, 1 - 1/e, and what is slower less far.
const AT_ONCE: f64 = 0.632;

/// True of a drift with a value at each of several moments of a recording; a law of time of its own has none.
pub(crate) fn is_curve_of_time(effect: Candidate) -> bool {
    is_drift(effect) && effect.info().flexible
}

/// A drift in one recording: 0 at its start, then a value at each of its moments.
#[derive(Debug)]
pub(crate) struct Curve {
    values: Vec<f64>,
    /// Not finite where the recording does not tell.
    covariance: Matrix,
}

impl Curve {
    /// The drift in each recording of a fit.
    pub(crate) fn all(effect: Candidate, fit: &Fit) -> Vec<Self> {
        let parameters = effect.info().parameters.iter();
        let knots: Vec<_> = parameters
            .filter_map(|one| fit.parameter(one.name))
            .collect();
        let n_recordings = knots.first().map_or(0, |knot| knot.values.len());
        let of = |r: usize| {
            let rows = knots.iter().map(|knot| {
                let name = format!("{}[{r}]", knot.info.name);
                fit.covariance.names.iter().position(|own| *own == name)
            });
            let rows: Vec<Option<usize>> = rows.collect();
            let values = knots.iter().map(|knot| knot.values[r]);
            Self {
                values: std::iter::once(0.0).chain(values).collect(),
                covariance: Matrix::from_fn(rows.len() + 1, rows.len() + 1, |i, j| {
                    let [Some(i), Some(j)] = [i, j].map(|k| k.checked_sub(1)) else {
                        return 0.0;
                    };
                    match [rows[i], rows[j]] {
                        [Some(i), Some(j)] => fit.covariance.matrix[i][j],
                        _ => f64::INFINITY,
                    }
                }),
            }
        };
        (0..n_recordings).map(of).collect()
    }

    /// Covariance of two changes, each from one moment to another.
    fn of_changes(&self, [from, to]: [usize; 2], [other, end]: [usize; 2]) -> f64 {
        let c = &self.covariance;
        c[(to, end)] - c[(to, other)] - c[(from, end)] + c[(from, other)]
    }

    /// Half of the 95 % interval of a change; infinite where the recording does not tell.
    fn half(&self, change: [usize; 2]) -> f64 {
        let variance = self.of_changes(change, change);
        if variance.is_finite() {
            HALF_95 * variance.max(0.0).sqrt()
        } else {
            f64::INFINITY
        }
    }

    /// χ² of no change from the first of its moments on, and degrees of freedom. How it comes to its first value says nothing: it may be a level.
    fn against_no_change(&self) -> (f64, usize) {
        let told: Vec<usize> = (1..self.values.len())
            .filter(|&k| self.covariance[(k, k)].is_finite())
            .collect();
        let changes: Vec<[usize; 2]> = told.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        let n = changes.len();
        let covariance = Matrix::from_fn(n, n, |i, j| self.of_changes(changes[i], changes[j]));
        let by = Matrix::from_fn(n, 1, |i, _| {
            let [from, to] = changes[i];
            self.values[to] - self.values[from]
        });
        let weighed = symmetric_solved(&covariance, &by);
        let squares = by.iter().zip(weighed.iter()).map(|(a, b)| a * b);
        (squares.sum(), n)
    }

    fn range(&self) -> f64 {
        let ends = self
            .values
            .iter()
            .fold([0.0_f64; 2], |[low, high], &value| {
                [low.min(value), high.max(value)]
            });
        ends[1] - ends[0]
    }

    /// Longest way from one moment to the next, beyond what its interval makes.
    fn longest_step(&self) -> f64 {
        let steps = self.values.windows(2).enumerate();
        let beyond = steps.map(|(k, pair)| (pair[1] - pair[0]).abs() - self.half([k, k + 1]));
        beyond.fold(0.0, f64::max)
    }

    /// How often it turns back by more than an interval. A first value that may as well be a level is where it starts.
    fn turns(&self) -> usize {
        let starts = self
            .values
            .get(1)
            .is_some_and(|first| first.abs() <= self.half([0, 1]));
        let (mut turns, mut direction, mut extreme) = (0, 0.0, usize::from(starts));
        for k in extreme + 1..self.values.len() {
            let change = self.values[k] - self.values[extreme];
            if change * direction > 0.0 {
                extreme = k;
            } else if change.abs() > self.half([extreme, k]) {
                turns += usize::from(direction != 0.0);
                (direction, extreme) = (change.signum(), k);
            }
        }
        turns
    }
}

/// Half of a 95 % interval by which all changes of a drift together are off 0, as one change would be; each recording has its own drift.
/// `relative` is the error of its size by a formula beside it.
pub(crate) fn changes(curves: &[Curve], relative: f64) -> f64 {
    let each = curves.iter().map(Curve::against_no_change);
    let (squares, n) = each.fold((0.0, 0), |(squares, n), (own, of_own)| {
        (squares + own, n + of_own)
    });
    // An error along all changes at once.
    as_one(squares / (1.0 + relative.powi(2) * squares), n) / HALF_95
}

/// False of a drift that turns back again and again within a recording, or has most of its way where it has the largest range within one
/// step; both by more than intervals.
pub(crate) fn is_slow(curves: &[Curve]) -> bool {
    let largest = curves.iter().max_by(|a, b| a.range().total_cmp(&b.range()));
    curves.iter().all(|curve| curve.turns() < RESTLESS)
        && largest.is_none_or(|curve| curve.longest_step() <= AT_ONCE * curve.range())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curve through values whose intervals are as wide and independent, but for what they have in common.
    fn curve(values: &[f64], half: f64, common: f64) -> Curve {
        let n = values.len() + 1;
        let variance = |half: f64| (half / HALF_95).powi(2);
        Curve {
            values: std::iter::once(0.0).chain(values.iter().copied()).collect(),
            covariance: Matrix::from_fn(n, n, |i, j| match (i, j) {
                (0, _) | (_, 0) => 0.0,
                _ if i == j => variance(half) + variance(common),
                _ => variance(common),
            }),
        }
    }

    #[test]
    fn a_curve_turns_where_it_comes_back_by_more_than_its_intervals() {
        let of = |values: &[f64], half: f64| curve(values, half, 0.0).turns();
        assert_eq!(of(&[1.0, 2.0, 3.0, 2.5, 1.0, 0.5], 0.1), 1);
        assert_eq!(of(&[1.0, -1.0, 1.0, -1.0, 1.0], 0.1), 4);
        assert_eq!(of(&[1.0, -1.0, 1.0, -1.0, 1.0], 2.0), 0);
        assert_eq!(of(&[0.3, 1.0, 0.9, 1.1, 1.0, 1.2], 0.2), 0);
        // That all values may be off together says nothing of them but of the first.
        let together = curve(&[1.0, -1.0, 1.0, -1.0, 1.0], 0.1, 5.0);
        assert_eq!(together.turns(), 3);
    }

    #[test]
    fn a_level_and_an_event_go_most_of_their_way_at_once_and_a_drift_does_not() {
        let share = |values: [f64; 8], half: f64| {
            let curve = curve(&values, half, 0.0);
            curve.longest_step() / curve.range()
        };
        let level = [1.0, 1.1, 0.9, 1.0, 1.0, 1.1, 1.0, 1.0];
        assert!(share(level, 0.1) > AT_ONCE);
        // As far as the intervals tell.
        assert!(share(level, 0.4) < AT_ONCE);
        let event = [0.1, 0.0, -0.1, 0.1, 0.0, 0.1, 0.0, 2.0];
        assert!(share(event, 0.1) > AT_ONCE);
        let approach =
            |knots: f64| std::array::from_fn(|k| 1.0 - (-((k + 1) as f64) / knots).exp());
        assert!((share(approach(1.0), 0.0) - AT_ONCE).abs() < 1e-3);
        assert!(share(approach(2.0), 0.0) < 0.5);
        assert!(is_slow(&[curve(&approach(2.0), 0.1, 0.0)]));
        assert!(!is_slow(&[curve(&level, 0.1, 0.0)]));
    }

    #[test]
    fn a_drift_is_told_by_its_changes_and_a_level_is_none() {
        let ramp: Vec<f64> = (1..=8).map(|k| 0.25 * f64::from(k)).collect();
        let of = |curves: &[Curve]| changes(curves, 0.0);
        // However far all may be off together.
        let alone = of(&[curve(&ramp, 0.5, 0.0)]);
        let together = of(&[curve(&ramp, 0.5, 50.0)]);
        assert!(
            (alone / together - 1.0).abs() < 1e-6 && alone > 1.5,
            "{alone} {together}"
        );
        // χ² of the seven changes: the squares about the mean, 8 (8² - 1)/12 · 0.25², over the variance.
        let squares = 8.0 * 63.0 / 12.0 * 0.25_f64.powi(2) / (0.5 / HALF_95).powi(2);
        let (found, n) = curve(&ramp, 0.5, 3.0).against_no_change();
        assert!(
            (found / squares - 1.0).abs() < 1e-9 && n == 7,
            "{found} {squares}"
        );
        assert!(of(&[curve(&[2.0; 8], 0.5, 0.0)]) < 0.1);
        // Recordings without a drift make it harder to tell, and one more that has it easier.
        let none = || curve(&[0.0; 8], 0.5, 0.0);
        assert!(of(&[curve(&ramp, 0.5, 0.0), none()]) < alone);
        assert!(of(&[curve(&ramp, 0.5, 0.0), curve(&ramp, 0.5, 0.0)]) > alone);
        // A formula that may make a half of it.
        let by_formula = changes(&[curve(&ramp, 0.01, 0.0)], 0.5);
        assert!(by_formula < 1.0, "{by_formula}");
    }

    #[test]
    fn what_no_recording_tells_is_left_out() {
        let mut one = curve(&[0.0, 1.0, 2.0], 0.5, 0.0);
        let n = one.values.len();
        one.covariance = Matrix::from_fn(n, n, |i, j| match (i, j) {
            (2, _) | (_, 2) => f64::INFINITY,
            _ => one.covariance[(i, j)],
        });
        let (squares, degrees) = one.against_no_change();
        let expected = 2.0_f64.powi(2) / (2.0 * (0.5 / HALF_95).powi(2));
        assert!(
            (squares / expected - 1.0).abs() < 1e-9 && degrees == 1,
            "{squares}"
        );
        assert!(one.half([1, 2]).is_infinite() && one.turns() == 0);
    }
}
