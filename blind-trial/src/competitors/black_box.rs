//! A black box beside the baseline model.

use identify::{IdentifyError, OffsetSource};
use missing_physics::Stage;

use super::ridge::ridge;
use super::seen::{self, Seen};
use crate::verdict::Opened;

/// Time constants of the lags of the drive, as multiples of the rod's.
const LAGS: [f64; 3] = [1.0 / 3.0, 1.0, 3.0];

/// Variables: drive, temperature, its rate, output, lags.
const N: usize = 4 + LAGS.len();

/// Highest degree of a product, and of one that has another sign on cooling.
const DEGREES: [usize; 2] = [3, 2];

/// Share of the range of the temperature by which it must turn back before the direction changes.
const TURN: f64 = 1e-3;

/// Error on the unseen recordings of the baseline model and a black box, mm; `None` without any.
///
/// ```text
/// g(x) = Σ a_i Π P_(d_ij)(x_j) + s Σ b_i Π P_(d_ij)(x_j),   degrees up to 3, and up to 2
/// ```
///
/// P are Legendre's polynomials, x_j what the baseline model shows (see [`variables`]), each between -1 and 1 over the
/// training and held there beyond it, s = ±1 for heating and cooling. The coefficients are those of a ridge regression of the
/// training residual. The offset of an unseen recording is read where validation reads it, with the black box in place.
pub(super) fn unseen_mm(
    files: &Opened,
    plain: &Stage,
    training: &[Seen<'_>],
) -> Result<Option<f64>, IdentifyError> {
    let tau_s = plain
        .fit
        .parameter("tau_s")
        .map_or(0.0, |tau| tau.values[0]);
    let black_box = BlackBox::fitted(training, tau_s);
    let (mut n, mut squares) = (0, 0.0);
    for (seen, validated) in seen::unseen(files, plain)?.iter().zip(&plain.validated) {
        let n_offset = match validated.offset_source {
            OffsetSource::BeforeDrive { n_samples } => n_samples,
            _ => seen.residual.len(),
        };
        let shown = black_box.shown(seen);
        let pairs = seen.residual.iter().zip(&shown);
        let left: Vec<f64> = pairs.map(|(residual, shown)| residual - shown).collect();
        let offset = mean(&left[..n_offset.min(left.len())]);
        squares += left.iter().map(|left| (left - offset).powi(2)).sum::<f64>();
        n += left.len();
    }
    Ok((n > 0)
        .then(|| (squares / n as f64).sqrt())
        .filter(|mm| mm.is_finite()))
}

/// A fitted black box.
#[derive(Debug)]
struct BlackBox {
    tau_s: f64,
    /// Lowest and highest value of each variable in the training.
    ranges: [[f64; 2]; N],
    terms: Vec<Term>,
    /// Mean and standard deviation of each term in the training.
    scales: Vec<[f64; 2]>,
    coefficients: Vec<f64>,
}

/// A product of polynomials.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Term {
    /// Degree in each variable.
    degrees: [usize; N],
    /// True if its sign changes on cooling.
    is_signed: bool,
}

impl BlackBox {
    fn fitted(training: &[Seen<'_>], tau_s: f64) -> Self {
        let shown: Vec<Variables> = training.iter().map(|seen| variables(seen, tau_s)).collect();
        let ranges = std::array::from_fn(|j| {
            let values = || shown.iter().flat_map(|one| one.values[j].iter().copied());
            [
                values().fold(f64::INFINITY, f64::min),
                values().fold(f64::NEG_INFINITY, f64::max),
            ]
        });
        let mut unfitted = Self {
            tau_s,
            ranges,
            terms: terms(),
            scales: Vec::new(),
            coefficients: Vec::new(),
        };
        let mut columns = vec![Vec::new(); unfitted.terms.len()];
        for one in &shown {
            for (column, part) in columns.iter_mut().zip(unfitted.columns(one)) {
                column.extend(part);
            }
        }
        for column in &mut columns {
            let middle = mean(column);
            let squares = column.iter().map(|value| (value - middle).powi(2));
            let deviation = (squares.sum::<f64>() / column.len().max(1) as f64).sqrt();
            unfitted.scales.push([middle, deviation]);
            for value in column {
                *value = scaled(*value, [middle, deviation]);
            }
        }
        let residual: Vec<f64> = training
            .iter()
            .flat_map(|seen| {
                let middle = mean(&seen.residual);
                seen.residual.iter().map(move |residual| residual - middle)
            })
            .collect();
        Self {
            coefficients: ridge(&columns, &residual),
            ..unfitted
        }
    }

    /// Contribution of the black box to the baseline model's output, mm, up to an offset.
    fn shown(&self, seen: &Seen<'_>) -> Vec<f64> {
        let mut shown = vec![0.0; seen.residual.len()];
        let columns = self.columns(&variables(seen, self.tau_s)).into_iter();
        for ((column, scale), coefficient) in columns.zip(&self.scales).zip(&self.coefficients) {
            for (shown, value) in shown.iter_mut().zip(column) {
                *shown += coefficient * scaled(value, *scale);
            }
        }
        shown
    }

    /// A column a term, a value a sample.
    fn columns(&self, variables: &Variables) -> Vec<Vec<f64>> {
        // Polynomials of degrees 0 to 3 of each variable.
        let polynomials: Vec<[Vec<f64>; 4]> = variables
            .values
            .iter()
            .zip(self.ranges)
            .map(|(values, range)| {
                let within: Vec<f64> = values.iter().map(|&value| place(value, range)).collect();
                std::array::from_fn(|degree| within.iter().map(|&x| legendre(degree, x)).collect())
            })
            .collect();
        let column = |term: &Term| {
            let mut column = if term.is_signed {
                variables.direction.clone()
            } else {
                vec![1.0; variables.direction.len()]
            };
            for (polynomials, &degree) in polynomials.iter().zip(&term.degrees) {
                if degree > 0 {
                    for (value, factor) in column.iter_mut().zip(&polynomials[degree]) {
                        *value *= factor;
                    }
                }
            }
            column
        };
        self.terms.iter().map(column).collect()
    }
}

/// Inputs of a black box.
#[derive(Debug)]
struct Variables {
    values: [Vec<f64>; N],
    /// 1 on heating, -1 on cooling.
    direction: Vec<f64>,
}

/// Inputs that have acted by the time that an output is read: the drive of the sample before, the temperature and output
/// of the baseline model and the temperature's rate, and the drive through first-order lags.
fn variables(seen: &Seen<'_>, tau_s: f64) -> Variables {
    let time_s = seen.recording.time_s();
    let n = time_s.len();
    let temperature_degc = &seen.shown.temperature_degc;
    let drive: Vec<f64> = (0..n)
        .map(|k| seen.recording.drive()[k.saturating_sub(1)])
        .collect();
    let dt_s = |k: usize| time_s[k] - time_s[k - 1];
    let rate = |k: usize| match k {
        0 => 0.0,
        _ => (temperature_degc[k] - temperature_degc[k - 1]) / dt_s(k),
    };
    let lagged = |multiple: f64| {
        let mut last = drive.first().copied().unwrap_or(0.0);
        (0..n)
            .map(|k| {
                if k > 0 {
                    last += (1.0 - (-dt_s(k) / (multiple * tau_s)).exp()) * (drive[k] - last);
                }
                last
            })
            .collect()
    };
    let [short, equal, long] = LAGS.map(lagged);
    Variables {
        direction: direction(temperature_degc),
        values: [
            drive.clone(),
            temperature_degc.clone(),
            (0..n).map(rate).collect(),
            seen.shown.output.clone(),
            short,
            equal,
            long,
        ],
    }
}

/// Direction of the temperature, ripple apart: 1 if it rises, -1 if it falls. It counts as falling at first.
fn direction(temperature_degc: &[f64]) -> Vec<f64> {
    let lowest = temperature_degc
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    let highest = temperature_degc
        .iter()
        .copied()
        .fold(f64::NEG_INFINITY, f64::max);
    let turn_k = TURN * (highest - lowest);
    let (mut sign, mut extreme) = (-1.0, temperature_degc.first().copied().unwrap_or(0.0));
    temperature_degc
        .iter()
        .map(|&degc| {
            let onward = sign * (degc - extreme);
            if onward > 0.0 {
                extreme = degc;
            } else if onward < -turn_k {
                (sign, extreme) = (-sign, degc);
            }
            sign
        })
        .collect()
}

/// Products of degrees 1 to the highest, then those that change their sign, of degree 0 and up.
fn terms() -> Vec<Term> {
    let of = |is_signed: bool, degrees: std::ops::RangeInclusive<usize>| {
        // A number's digits are the degrees.
        let base = DEGREES[0] + 1;
        (0..base.pow(N as u32))
            .map(move |number| Term {
                degrees: std::array::from_fn(|j| number / base.pow(j as u32) % base),
                is_signed,
            })
            .filter(move |term| degrees.contains(&term.degrees.iter().sum()))
    };
    of(false, 1..=DEGREES[0])
        .chain(of(true, 0..=DEGREES[1]))
        .collect()
}

/// Between -1 and 1 over a range, and held there outside.
fn place(value: f64, [lowest, highest]: [f64; 2]) -> f64 {
    if highest > lowest {
        ((2.0 * value - lowest - highest) / (highest - lowest)).clamp(-1.0, 1.0)
    } else {
        0.0
    }
}

fn legendre(degree: usize, x: f64) -> f64 {
    match degree {
        0 => 1.0,
        1 => x,
        2 => 0.5 * (3.0 * x * x - 1.0),
        _ => 0.5 * x * (5.0 * x * x - 3.0),
    }
}

/// About the mean, over the deviation; nothing of what never changes.
fn scaled(value: f64, [mean, deviation]: [f64; 2]) -> f64 {
    /// Deviation of a product of polynomials that is rounding.
    const ROUNDING: f64 = 1e-9;
    if deviation > ROUNDING {
        (value - mean) / deviation
    } else {
        0.0
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::opened;
    use super::*;
    use crate::Family;

    #[test]
    fn a_black_box_learns_some_of_latent_heat() {
        let (files, plain) = opened(Family::Single, 7);
        let training = seen::training(&files, &plain).unwrap();
        let with = unseen_mm(&files, &plain, &training).unwrap().unwrap();
        assert!(with > 0.0 && with < plain.validated[0].rmse, "{with}");
    }

    #[test]
    fn the_offset_alone_is_that_of_the_validation() {
        let (files, plain) = opened(Family::CleanWhite, 0);
        let seen = seen::unseen(&files, &plain).unwrap();
        let squares: f64 = seen[0].residual.iter().map(|left| left * left).sum();
        let rmse = (squares / seen[0].residual.len() as f64).sqrt();
        assert!((rmse / plain.validated[0].rmse - 1.0).abs() < 1e-9);
    }

    #[test]
    fn ripple_is_no_turn() {
        let rise = (0..1000).map(|k| 0.1 * f64::from(k) + 0.02 * f64::from(k % 2));
        let fall = (0..1000).map(|k| 100.0 - 0.1 * f64::from(k));
        let direction = direction(&rise.chain(fall).collect::<Vec<_>>());
        let turns = direction.windows(2).filter(|pair| pair[0] * pair[1] < 0.0);
        assert_eq!(turns.count(), 2);
        assert!(direction[500] > 0.0 && direction[1500] < 0.0);
    }

    #[test]
    fn there_are_as_many_terms_as_products() {
        // Of 7 variables: C(10, 3) - 1 up to degree 3, and C(9, 2) up to 2 with the constant.
        assert_eq!(terms().len(), 119 + 36);
    }
}
