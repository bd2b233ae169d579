//! Bounded Levenberg-Marquardt on the triangular factor of the Jacobian, with and without the curvature of the residuals.

use pso::Bound;
use serde::{Deserialize, Serialize};
use wiener::NARROW;

use crate::IdentifyError;
use crate::curvature::Curvature;
use crate::dense::{Matrix, least_squares};
use crate::factor::Triangle;

/// Settings of the least-squares search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastSquaresConfig {
    /// Most iterations; each costs one Jacobian and one batch of trial steps.
    pub iterations: usize,
    /// Relative offset below which the search has converged: the share of the residual that the
    /// parameters could still explain, as a ratio of norms (Bates1981 in REFERENCES.md).
    pub relative_offset: f64,
    /// Share of the sum of squares that an iteration gains, below which twice in a row the search ends; 0 goes on for any gain.
    /// Along a direction that the data hardly fix a search creeps for long and ends nowhere else that could be told.
    pub least_gain: f64,
}

impl Default for LeastSquaresConfig {
    fn default() -> Self {
        Self {
            iterations: 200,
            relative_offset: 1e-5,
            // Of the log-likelihood of a million samples that is 5e-4: nothing is told by it.
            least_gain: 1e-9,
        }
    }
}

/// Why a least-squares search ended.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
#[must_use]
pub enum Termination {
    /// The relative offset fell below its limit: a minimum.
    Converged {
        /// Relative offset reached.
        relative_offset: f64,
    },
    /// The residual is rounding: the data are met exactly.
    Exact,
    /// No step lowers the cost any more, at a relative offset above the limit: a minimum with a
    /// corner, or one as sharp as rounding allows.
    NoFurtherStep {
        /// Relative offset reached.
        relative_offset: f64,
    },
    /// The cost hardly falls any more, at a relative offset above the limit.
    HardlyFalls {
        /// Relative offset reached.
        relative_offset: f64,
    },
    /// The cost at the start was no number: nothing could be done.
    NotFinite,
    /// The limit of iterations.
    Iterations {
        /// Relative offset reached.
        relative_offset: f64,
    },
}

/// Sum of squares over rounding's up to which data are met exactly where no step gets nearer: as six digits are met.
const SIX_DIGITS: f64 = 1e3;

/// Relative offset of a minimum: a ten-thousandth of the sum of squares is left to gain.
const MINIMUM: f64 = 1e-2;

impl Termination {
    /// True if the result may be called a minimum: less than a ten-thousandth of the sum of squares is left to gain.
    /// The search itself goes on to far less ([`LeastSquaresConfig::relative_offset`]), or until the cost hardly falls.
    #[must_use]
    pub fn is_minimum(&self) -> bool {
        match self {
            Self::Exact => true,
            Self::NotFinite => false,
            Self::Converged { relative_offset }
            | Self::NoFurtherStep { relative_offset }
            | Self::HardlyFalls { relative_offset }
            | Self::Iterations { relative_offset } => *relative_offset < MINIMUM,
        }
    }
}

/// The residual of a problem to first order around a point, without its linear parameters.
#[derive(Debug, Clone)]
pub(crate) struct Linearized {
    /// Triangular factor of the Jacobian, square.
    pub(crate) jacobian: Matrix,
    /// The residual in the same frame.
    pub(crate) residual: Vec<f64>,
    /// Sum of squares of the whole residual.
    pub(crate) sum_of_squares: f64,
}

impl Linearized {
    /// Gradient of half of the sum of squares, a column: Jᵀr.
    pub(crate) fn gradient(&self) -> Matrix {
        let n = self.residual.len();
        self.jacobian
            .tr_mul(&Matrix::from_column_slice(n, 1, &self.residual))
    }

    /// Appends rows, each given by its derivatives and its value; `sum_of_squares` is that of the whole.
    pub(crate) fn with_rows(
        &self,
        rows: impl Iterator<Item = (Vec<f64>, f64)>,
        sum_of_squares: f64,
    ) -> Self {
        let n = self.residual.len();
        let own = (0..n).map(|row| {
            let derivatives = (0..n).map(|column| self.jacobian[(row, column)]);
            (derivatives.collect(), self.residual[row])
        });
        let mut whole = Triangle::new(n + 1);
        for (derivatives, value) in own.chain(rows) {
            let derivatives: Vec<f64> = derivatives;
            whole.push(|column| derivatives.get(column).copied().unwrap_or(value));
        }
        let r = whole.r();
        Self {
            jacobian: r.view((0, 0), (n, n)).into_owned(),
            residual: (0..n).map(|row| r[(row, n)]).collect(),
            sum_of_squares,
        }
    }
}

/// A sum of squares to be minimized.
pub(crate) trait SumOfSquares {
    /// Sum of squares that is rounding and nothing else.
    fn rounding(&self) -> f64;
    /// Derivatives of one point that a run computes, at most.
    fn n_derivatives(&self) -> usize;
    fn sums(&self, points: &[Vec<f64>]) -> Result<Vec<f64>, IdentifyError>;
    /// Sums of squares at the points, and the residual to first order around the point number `around`: in one run of
    /// the lanes.
    fn linearized(
        &self,
        points: &[Vec<f64>],
        around: usize,
    ) -> Result<(Vec<f64>, Linearized), IdentifyError>;
    fn linearize(&self, point: &[f64]) -> Result<Linearized, IdentifyError> {
        Ok(self.linearized(&[point.to_vec()], 0)?.1)
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Minimum {
    pub(crate) point: Vec<f64>,
    pub(crate) sum_of_squares: f64,
    pub(crate) termination: Termination,
}

/// Model of the sum of squares around a point.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Model {
    /// Residuals that are linear.
    GaussNewton,
    /// With their curvature, as far as it has been learned.
    Augmented,
}
use Model::{Augmented, GaussNewton};

/// A step to be tried: damped so many times as the last good one was, to the minimum of a model.
type Try = (f64, Model);

/// Steps that are tried at once, since they share one run of the lanes; those that are missed most come first.
const TRIES: [Try; 11] = [
    (1.0, GaussNewton),
    (0.3, GaussNewton),
    (30.0, GaussNewton),
    (1e-2, GaussNewton),
    (1e3, GaussNewton),
    (0.1, GaussNewton),
    (3.0, GaussNewton),
    (1e-4, GaussNewton),
    (10.0, GaussNewton),
    (3e-2, GaussNewton),
    (200.0, GaussNewton),
];

/// Those where the curvature of the residuals is known a little.
const AUGMENTED_TRIES: [Try; 13] = [
    (1.0, GaussNewton),
    (1.0, Augmented),
    (0.1, GaussNewton),
    (1e-2, Augmented),
    (30.0, GaussNewton),
    (1e-2, GaussNewton),
    (0.1, Augmented),
    (1e3, GaussNewton),
    (3.0, GaussNewton),
    (0.3, GaussNewton),
    (10.0, Augmented),
    (1e-4, Augmented),
    (200.0, GaussNewton),
];

/// Steps that are tried if nothing else decides, and those of them that are left out where that saves lanes.
const USUAL_TRIES: usize = 8;
const DISPENSABLE_TRIES: usize = 3;

/// The step around whose end the problem is made linear before it is known how low it lies: damped as the last was. In
/// seven of ten iterations it will do, and they take one run of the lanes instead of two.
const LIKELIEST: f64 = 1.0;

/// Share of the lowest trial's gain with which another will do.
const NEARLY: f64 = 0.7;

/// Steps to be tried with so many derivatives in the same run: as many as fill the lanes that it takes.
fn n_tries(n_derivatives: usize) -> usize {
    let lanes = USUAL_TRIES + n_derivatives;
    match lanes % NARROW {
        0 => USUAL_TRIES,
        over if lanes > NARROW && over <= DISPENSABLE_TRIES => USUAL_TRIES - over,
        over => USUAL_TRIES + NARROW - over,
    }
}

/// Minimizes from `start` within `bounds`.
///
/// ```text
/// min ‖J p + r‖² + μ ‖D p‖²,   x ← clamp(x + p)     [Marquardt1963], D the column norms [More1978]
/// min 2 gᵀp + pᵀ(JᵀJ + S) p + μ ‖D p‖²              [Dennis1981], see [`Curvature`]
/// ```
///
/// Steps to the minima of both models are tried at once, and the better one counts. Coordinates on a bound that the gradient pushes
/// outward are held for the step (Kanzow2004 in REFERENCES.md).
pub(crate) fn minimize(
    problem: &impl SumOfSquares,
    bounds: &[Bound],
    start: &[f64],
    config: &LeastSquaresConfig,
) -> Result<Minimum, IdentifyError> {
    let mut point = start.to_vec();
    let (mut damping, mut last_model) = (1e-2, GaussNewton);
    let mut weights = vec![0.0_f64; point.len()];
    let mut local = problem.linearize(&point)?;
    let mut curvature: Option<Curvature> = None;
    let (mut iterations, mut hardly) = (0, 0);
    let termination = loop {
        if !local.sum_of_squares.is_finite() {
            break Termination::NotFinite;
        }
        let free = free_coordinates(&local, bounds, &point);
        for &j in &free {
            weights[j] = weights[j].max(local.jacobian.column(j).norm());
        }
        let relative_offset = relative_offset(&local, &free);
        if local.sum_of_squares <= problem.rounding() {
            break Termination::Exact;
        }
        if relative_offset <= config.relative_offset {
            break Termination::Converged { relative_offset };
        }
        if iterations == config.iterations {
            break Termination::Iterations { relative_offset };
        }
        if hardly == 2 {
            break Termination::HardlyFalls { relative_offset };
        }
        iterations += 1;
        let augmented = curvature.as_ref().map(|known| known.augmented(&local));
        let step = |&(factor, model): &Try| {
            let damping = damping * factor;
            let step = match model {
                GaussNewton => damped_step(&local, &free, &weights, damping),
                Augmented => augmented.as_ref()?.step(&free, &weights, damping)?,
            };
            Some(((factor, model), moved(&point, &free, &step, bounds)))
        };
        let tries: &[Try] = match augmented {
            None => &TRIES,
            Some(_) => &AUGMENTED_TRIES,
        };
        let (tries, ends): (Vec<Try>, Vec<Vec<f64>>) = tries
            .iter()
            .filter_map(step)
            .take(n_tries(problem.n_derivatives()))
            .unzip();
        let as_last =
            |&(factor, model): &Try| factor.total_cmp(&LIKELIEST).is_eq() && model == last_model;
        // The first is damped as the last was, too.
        let likeliest = tries.iter().position(as_last).unwrap_or(0);
        let (sums, ahead) = problem.linearized(&ends, likeliest)?;
        let gain = |k: usize| local.sum_of_squares - sums[k];
        let best = (0..sums.len())
            .filter(|&k| gain(k) > 1e-13 * local.sum_of_squares)
            .min_by(|&a, &b| sums[a].total_cmp(&sums[b]));
        let Some(best) = best else {
            if damping < 1e9 {
                // All fail: shorter steps once more.
                damping *= 1e6;
                continue;
            }
            // They are as short as they can be.
            break Termination::NoFurtherStep { relative_offset };
        };
        let will_do = |&k: &usize| gain(k) >= NEARLY * gain(best);
        let length = |k: usize| {
            let moved = ends[k].iter().zip(&point).zip(&weights);
            let squares = moved.map(|((end, start), weight)| ((end - start) * weight).powi(2));
            squares.sum::<f64>()
        };
        let chosen = if will_do(&likeliest) {
            likeliest
        } else {
            // Of steps that gain about as much the longest leads furthest along a valley.
            let near = (0..sums.len()).filter(will_do);
            let longest = near.max_by(|&a, &b| length(a).total_cmp(&length(b)));
            longest.unwrap_or(best)
        };
        let falls = gain(chosen) >= config.least_gain * local.sum_of_squares;
        hardly = if falls { 0 } else { hardly + 1 };
        let (factor, model) = tries[best];
        damping = (damping * factor).clamp(1e-12, 1e12);
        last_model = model;
        let next = if chosen == likeliest {
            ahead
        } else {
            problem.linearize(&ends[chosen])?
        };
        let step: Vec<f64> = ends[chosen]
            .iter()
            .zip(&point)
            .map(|(end, start)| end - start)
            .collect();
        curvature
            .get_or_insert_with(|| Curvature::unknown(step.len()))
            .learn(&step, &local, &next);
        point.clone_from(&ends[chosen]);
        local = next;
    };
    let sum = local.sum_of_squares;
    let is_met = sum <= SIX_DIGITS * problem.rounding() && !termination.is_minimum();
    let termination = if is_met {
        Termination::Exact
    } else {
        termination
    };
    Ok(Minimum {
        point,
        // What is no number is never the lowest.
        sum_of_squares: if sum.is_nan() { f64::INFINITY } else { sum },
        termination,
    })
}

/// Coordinates that may move: not those on a bound that the gradient pushes outward.
fn free_coordinates(local: &Linearized, bounds: &[Bound], point: &[f64]) -> Vec<usize> {
    let gradient = local.gradient();
    (0..point.len())
        .filter(|&j| {
            let moves = local.jacobian.column(j).norm() > 0.0;
            let at_lower = point[j] <= bounds[j].lower && gradient[j] >= 0.0;
            let at_upper = point[j] >= bounds[j].upper && gradient[j] <= 0.0;
            moves && !at_lower && !at_upper
        })
        .collect()
}

/// ‖part of the residual in the span of the free columns‖ / ‖residual‖.
fn relative_offset(local: &Linearized, free: &[usize]) -> f64 {
    if free.is_empty() || local.sum_of_squares <= 0.0 {
        return 0.0;
    }
    let n = local.residual.len();
    let norms: Vec<f64> = (0..n).map(|j| local.jacobian.column(j).norm()).collect();
    // A trace of damping: along directions that the data do not fix there is nothing to explain, and
    // without it rounding would be taken for it.
    let step = damped_step(local, free, &norms, 1e-10);
    let explained: f64 = (0..n)
        .map(|row| {
            let fitted: f64 = free
                .iter()
                .zip(&step)
                .map(|(&j, step)| local.jacobian[(row, j)] * step)
                .sum();
            fitted * fitted
        })
        .sum();
    (explained / local.sum_of_squares).sqrt()
}

fn damped_step(local: &Linearized, free: &[usize], weights: &[f64], damping: f64) -> Vec<f64> {
    let n = local.residual.len();
    let matrix = Matrix::from_fn(n + free.len(), free.len(), |row, k| {
        if row < n {
            local.jacobian[(row, free[k])]
        } else if row - n == k {
            damping.sqrt() * weights[free[k]]
        } else {
            0.0
        }
    });
    let right: Vec<f64> = local
        .residual
        .iter()
        .map(|residual| -residual)
        .chain(free.iter().map(|_| 0.0))
        .collect();
    least_squares(&matrix, &right)
}

fn moved(point: &[f64], free: &[usize], step: &[f64], bounds: &[Bound]) -> Vec<f64> {
    let mut moved = point.to_vec();
    for (&j, step) in free.iter().zip(step) {
        moved[j] = (point[j] + step).clamp(bounds[j].lower, bounds[j].upper);
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::factor::Triangle;

    /// Rosenbrock's valley as a sum of squares: r = (10 (y - x²), 1 - x), minimum 0 at (1, 1), plus a
    /// constant residual that no parameter explains.
    struct Valley;

    const UNEXPLAINED: f64 = 0.25;

    impl SumOfSquares for Valley {
        fn linearized(
            &self,
            points: &[Vec<f64>],
            around: usize,
        ) -> Result<(Vec<f64>, Linearized), IdentifyError> {
            let point = &points[around];
            let rows = [
                [
                    -20.0 * point[0],
                    10.0,
                    10.0 * (point[1] - point[0] * point[0]),
                ],
                [-1.0, 0.0, 1.0 - point[0]],
                [0.0, 0.0, UNEXPLAINED],
            ];
            let mut triangle = Triangle::new(3);
            for row in &rows {
                triangle.push(|column| row[column]);
            }
            let r = triangle.r();
            let sums = self.sums(points)?;
            let linearized = Linearized {
                jacobian: r.view((0, 0), (2, 2)).into_owned(),
                residual: vec![r[(0, 2)], r[(1, 2)]],
                sum_of_squares: sums[around],
            };
            Ok((sums, linearized))
        }

        fn rounding(&self) -> f64 {
            0.0
        }

        fn n_derivatives(&self) -> usize {
            2
        }

        fn sums(&self, points: &[Vec<f64>]) -> Result<Vec<f64>, IdentifyError> {
            let sum = |point: &Vec<f64>| {
                let rise = 10.0 * (point[1] - point[0] * point[0]);
                rise * rise + (1.0 - point[0]).powi(2) + UNEXPLAINED * UNEXPLAINED
            };
            Ok(points.iter().map(sum).collect())
        }
    }

    fn end(bounds: [Bound; 2], start: [f64; 2]) -> Minimum {
        // A valley so curved wants many steps.
        let config = LeastSquaresConfig {
            iterations: 200,
            ..LeastSquaresConfig::default()
        };
        minimize(&Valley, &bounds, &start, &config).unwrap()
    }

    /// A corner that no step leads over: r = 1 + |x|; sums of squares are told to a rounding.
    struct Corner {
        rounding: f64,
    }

    impl SumOfSquares for Corner {
        fn linearized(
            &self,
            points: &[Vec<f64>],
            around: usize,
        ) -> Result<(Vec<f64>, Linearized), IdentifyError> {
            let sums = self.sums(points)?;
            let slope = if points[around][0] < 0.0 { -1.0 } else { 1.0 };
            let linearized = Linearized {
                jacobian: crate::dense::Matrix::from_element(1, 1, slope),
                residual: vec![sums[around].sqrt()],
                sum_of_squares: sums[around],
            };
            Ok((sums, linearized))
        }

        fn rounding(&self) -> f64 {
            self.rounding
        }

        fn n_derivatives(&self) -> usize {
            1
        }

        fn sums(&self, points: &[Vec<f64>]) -> Result<Vec<f64>, IdentifyError> {
            let sum = |point: &Vec<f64>| (1.0 + point[0].abs()).powi(2);
            Ok(points.iter().map(sum).collect())
        }
    }

    #[test]
    fn data_that_are_met_to_six_digits_are_met_where_no_step_leads_nearer() {
        let of = |rounding: f64| {
            let config = LeastSquaresConfig::default();
            let end = minimize(&Corner { rounding }, &[WIDE], &[0.0], &config).unwrap();
            end.termination.is_minimum()
        };
        assert!(!of(1e-4));
        assert!(of(1e-2));
    }

    const WIDE: Bound = Bound {
        lower: -10.0,
        upper: 10.0,
    };

    #[test]
    fn the_valley_is_followed_to_its_end() {
        for start in [[-1.2, 1.0], [5.0, -7.0], [-10.0, 10.0]] {
            let minimum = end([WIDE, WIDE], start);
            assert!(
                minimum.termination.is_minimum(),
                "{:?}",
                minimum.termination
            );
            assert!((minimum.point[0] - 1.0).abs() < 1e-4 && (minimum.point[1] - 1.0).abs() < 1e-4);
            assert!((minimum.sum_of_squares - UNEXPLAINED * UNEXPLAINED).abs() < 1e-8);
        }
    }

    #[test]
    fn a_bound_in_the_way_is_where_it_ends() {
        // With x ≤ ½ the valley's floor is y = x² = ¼ there.
        let bounds = [
            Bound {
                lower: -10.0,
                upper: 0.5,
            },
            WIDE,
        ];
        let minimum = end(bounds, [-1.2, 1.0]);
        assert!(minimum.termination.is_minimum());
        assert_eq!(minimum.point[0].to_bits(), 0.5_f64.to_bits());
        assert!((minimum.point[1] - 0.25).abs() < 1e-6);
    }
}
