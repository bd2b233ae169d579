//! Loops that lie where no recording has been.

use crate::IdentifyError;
use crate::fit::VERY_STRONG;
use crate::least_squares::{LeastSquaresConfig, Linearized, Minimum, SumOfSquares, minimize};
use crate::problem::Problem;
use crate::residual_noise::ResidualNoise;
use crate::tasks::try_in_parallel;

/// Sum of squares over the lowest up to which a fit counts: what lies no higher is told apart by what the model leaves out,
/// not by the recordings.
pub(crate) const NEAR: f64 = 1.5;

/// Share of the temperatures' span by which a branch may lie beyond them where that costs as much as [`NEAR`] allows.
const SLIGHTLY: f64 = 0.05;

/// Step of a difference, as a share of a coordinate's range.
const DIFFERENCE: f64 = 1e-5;

/// A branch of the limiting loop in the middle of which no recording has been.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeyondReach {
    /// True for the heating branch, above all that was reached; false for the cooling branch, below.
    pub is_heating: bool,
    /// Its middle, °C.
    pub branch_degc: f64,
    /// The highest temperature of the model in the training recordings for the heating branch, the lowest for the cooling
    /// branch, °C.
    pub reached_degc: f64,
}

/// The branches of the loop at a point that lie beyond the temperatures reached.
pub(crate) fn beyond_reach(
    problem: &Problem<'_>,
    point: &[f64],
) -> Result<Vec<BeyondReach>, IdentifyError> {
    let Some([cooling, heating]) = problem.branches_degc(point) else {
        return Ok(Vec::new());
    };
    let reached = problem.reached_degc(&[point.to_vec()])?;
    let [lowest, highest] = reached[0];
    let of = |is_heating, branch_degc, reached_degc| BeyondReach {
        is_heating,
        branch_degc,
        reached_degc,
    };
    let mut beyond = Vec::new();
    if heating > highest {
        beyond.push(of(true, heating, highest));
    }
    if cooling < lowest {
        beyond.push(of(false, cooling, lowest));
    }
    Ok(beyond)
}

/// How far the branches lie beyond the temperatures reached, at each point: shares of the span of these.
fn shares(problem: &Problem<'_>, points: &[Vec<f64>]) -> Result<Vec<[f64; 2]>, IdentifyError> {
    let reached = problem.reached_degc(points)?;
    let share = |(point, [lowest, highest]): (&Vec<f64>, [f64; 2])| {
        let Some([cooling, heating]) = problem.branches_degc(point) else {
            return [0.0; 2];
        };
        let span_k = (highest - lowest).max(f64::MIN_POSITIVE);
        [heating - highest, lowest - cooling].map(|beyond_k| beyond_k.max(0.0) / span_k)
    };
    Ok(points.iter().zip(reached).map(share).collect())
}

/// A problem, and what it costs that a branch lies where no recording has been.
///
/// ```text
/// Σ w r² + c Σ b²,   b how far a branch lies beyond the temperatures reached, a share of their span
/// ```
#[derive(Debug)]
pub(crate) struct WithinReach<'p, 'a> {
    problem: &'p Problem<'a>,
    /// Root of c; 0 where it costs nothing.
    root: f64,
}

impl<'p, 'a> WithinReach<'p, 'a> {
    /// No cost at all.
    pub(crate) fn free(problem: &'p Problem<'a>) -> Self {
        Self { problem, root: 0.0 }
    }

    /// The cost by which a branch is slightly outside at most where the sum of squares may be as high as near `lowest`.
    pub(crate) fn held(problem: &'p Problem<'a>, lowest: f64) -> Self {
        let root = ((NEAR - 1.0) * lowest).sqrt() / SLIGHTLY;
        Self { problem, root }
    }

    fn rows(&self, points: &[Vec<f64>]) -> Result<Vec<[f64; 2]>, IdentifyError> {
        let shares = shares(self.problem, points)?;
        Ok(shares
            .into_iter()
            .map(|rows| rows.map(|share| self.root * share))
            .collect())
    }
}

fn squares(rows: [f64; 2]) -> f64 {
    rows.iter().map(|row| row * row).sum()
}

impl SumOfSquares for WithinReach<'_, '_> {
    fn rounding(&self) -> f64 {
        self.problem.rounding()
    }

    fn n_derivatives(&self) -> usize {
        self.problem.n_derivatives()
    }

    fn sums(&self, points: &[Vec<f64>]) -> Result<Vec<f64>, IdentifyError> {
        let mut sums = self.problem.sums(points)?;
        if self.root > 0.0 {
            for (sum, rows) in sums.iter_mut().zip(self.rows(points)?) {
                *sum += squares(rows);
            }
        }
        Ok(sums)
    }

    fn linearized(
        &self,
        points: &[Vec<f64>],
        around: usize,
    ) -> Result<(Vec<f64>, Linearized), IdentifyError> {
        let (mut sums, local) = self.problem.linearized(points, around)?;
        if self.root <= 0.0 {
            return Ok((sums, local));
        }
        let rows = self.rows(points)?;
        for (sum, rows) in sums.iter_mut().zip(&rows) {
            *sum += squares(*rows);
        }
        let center = &points[around];
        let bounds = self.problem.bounds();
        let step = |j: usize| {
            let step = DIFFERENCE * (bounds[j].upper - bounds[j].lower);
            if center[j] + step <= bounds[j].upper {
                step
            } else {
                -step
            }
        };
        let moved: Vec<Vec<f64>> = (0..center.len())
            .map(|j| {
                let mut moved = center.clone();
                moved[j] += step(j);
                moved
            })
            .collect();
        let moved = self.rows(&moved)?;
        let added = (0..2).map(|row| {
            let value = rows[around][row];
            let slope = |j: usize| match step(j) {
                0.0 => 0.0,
                step => (moved[j][row] - value) / step,
            };
            ((0..center.len()).map(slope).collect(), value)
        });
        let local = local.with_rows(added, sums[around]);
        Ok((sums, local))
    }
}

/// A fit whose loop lies within the temperatures reached.
#[derive(Debug)]
pub(crate) struct Held {
    pub(crate) minimum: Minimum,
    /// Searches that ended there, of as many.
    pub(crate) agreeing: u64,
    /// True if the loop leaves the temperatures reached once it is no longer held.
    pub(crate) is_pressed: bool,
}

/// The lowest fit whose loop lies within the temperatures reached, where that of the lowest end does not; `None` where it does, and
/// where the recordings speak against one inside by as many independent samples as the residual of the lowest end counts. `ends` are in the order of their height.
///
/// Where no recording has been, a branch bends what little is seen of it as it likes: the sum of squares may well be lowest
/// there, and tells nothing of where the branch is.
pub(crate) fn held_within(
    problem: &Problem<'_>,
    ends: &[Minimum],
    config: &LeastSquaresConfig,
) -> Result<Option<Held>, IdentifyError> {
    let Some(lowest) = ends.first().filter(|end| end.sum_of_squares.is_finite()) else {
        return Ok(None);
    };
    if beyond_reach(problem, &lowest.point)?.is_empty() {
        return Ok(None);
    }
    let found = try_in_parallel(ends, |end| {
        // Of its own: what one task has solved last is nothing to the others, so that all of them count the same on any
        // number of threads.
        let own = problem.apart();
        let wall = WithinReach::held(&own, lowest.sum_of_squares);
        let pressed = minimize(&wall, own.bounds(), &end.point, config)?;
        let free = minimize(&own, own.bounds(), &pressed.point, config)?;
        let is_pressed = !beyond_reach(&own, &free.point)?.is_empty();
        let end = if is_pressed { pressed } else { free };
        let sum_of_squares = own.sums(std::slice::from_ref(&end.point))?[0];
        let minimum = Minimum {
            sum_of_squares,
            ..end
        };
        Ok((minimum, is_pressed, own.simulations()))
    })?;
    problem.count(found.iter().map(|(.., simulations)| simulations).sum());
    let sums = found.iter().map(|(minimum, ..)| minimum.sum_of_squares);
    let least = sums.clone().fold(f64::INFINITY, f64::min);
    let agreeing = sums.filter(|sum| *sum <= 1.01 * least).count() as u64;
    let nearest = found
        .into_iter()
        .find(|(minimum, ..)| minimum.sum_of_squares <= least);
    let solved = problem.solve_one(&lowest.point)?;
    let residuals = problem.residuals(&lowest.point, &solved)?;
    let outputs: Vec<&[f64]> = residuals.iter().map(|one| one.values.as_slice()).collect();
    let n_effective = ResidualNoise::of(&outputs).n_effective;
    let most = NEAR.min((VERY_STRONG / n_effective.max(1.0)).exp());
    Ok(nearest
        .filter(|(minimum, ..)| minimum.sum_of_squares <= most * lowest.sum_of_squares)
        .map(|(minimum, is_pressed, _)| Held {
            minimum,
            agreeing,
            is_pressed,
        }))
}
