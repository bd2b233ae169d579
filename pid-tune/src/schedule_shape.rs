use crate::error::positive;
use crate::{Answer, Answers, GainSchedule, GainScheduleParams, SCHEDULE_LEVELS, TuneError};

/// How a schedule follows from a plant's slopes: one kind for a whole search, so that no factor is searched by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScheduleShape {
    /// Exponent p, 0 to 1: 0 leaves gains alone, 1 makes up for all of a slope.
    pub exponent: f64,
    /// True for a factor on each branch; false for one factor, that of the steeper branch.
    pub by_branch: bool,
    /// Largest factor; > 1.
    pub largest_factor: f64,
    /// Way of the output from one branch to the other after a turn, in the output's unit; > 0.
    pub turn: f64,
}

impl ScheduleShape {
    /// The schedule of this shape for a plant that answers so:
    ///
    /// ```text
    /// φ(y, β) = min((s_max/s(y, β))^p, largest)
    /// ```
    ///
    /// with the slope s on the branch, or the larger one of both branches, and the largest slope s_max at a level. Gains
    /// are therefore those of the steepest level, with a factor of 1 there and larger ones elsewhere.
    ///
    /// # Errors
    ///
    /// [`TuneError::Exponent`], [`TuneError::ScheduleLimit`], [`TuneError::NotPositive`] for the turn; [`TuneError::Empty`]
    /// for a branch without answers, [`TuneError::ScheduleOutputs`].
    pub fn schedule(&self, answers: &Answers) -> Result<GainSchedule, TuneError> {
        let Self {
            exponent,
            by_branch,
            largest_factor,
            turn,
        } = *self;
        if !(0.0..=1.0).contains(&exponent) {
            return Err(TuneError::Exponent { value: exponent });
        }
        if !(largest_factor > 1.0 && largest_factor.is_finite()) {
            return Err(TuneError::ScheduleLimit {
                value: largest_factor,
            });
        }
        positive("turn", turn)?;
        let ones = GainSchedule::new(GainScheduleParams {
            outputs: answers.outputs,
            turn,
            heating: [1.0; SCHEDULE_LEVELS],
            cooling: [1.0; SCHEDULE_LEVELS],
        })?;
        let slopes = |name, answers: &[Answer]| {
            let known = sorted(answers);
            if known.is_empty() {
                return Err(TuneError::Empty { name });
            }
            Ok(core::array::from_fn(|index| {
                slope_at(&known, ones.level(index))
            }))
        };
        let heating: [f64; SCHEDULE_LEVELS] = slopes("heating", &answers.heating)?;
        let cooling: [f64; SCHEDULE_LEVELS] = slopes("cooling", &answers.cooling)?;
        let steepest = heating.iter().chain(&cooling).copied().fold(0.0, f64::max);
        let factor = |slope: f64| {
            let factor = libm::pow(steepest / slope, exponent);
            // Where nothing answers, the slope tells nothing.
            if slope > 0.0 && factor < largest_factor {
                factor.max(1.0)
            } else {
                largest_factor
            }
        };
        let of = |own: [f64; SCHEDULE_LEVELS], other: [f64; SCHEDULE_LEVELS]| {
            core::array::from_fn(|index| {
                let slope = if by_branch {
                    own[index]
                } else {
                    own[index].max(other[index])
                };
                factor(slope)
            })
        };
        GainSchedule::new(GainScheduleParams {
            heating: of(heating, cooling),
            cooling: of(cooling, heating),
            ..*ones.params()
        })
    }
}

/// Outputs and slopes, by output.
fn sorted(answers: &[Answer]) -> Vec<(f64, f64)> {
    let mut known: Vec<(f64, f64)> = answers
        .iter()
        .map(|answer| (answer.output, answer.slope))
        .collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    known
}

/// Slope at an output, on straight lines between those that are known; beyond them that of the nearest.
fn slope_at(known: &[(f64, f64)], output: f64) -> f64 {
    let above = known.partition_point(|&(at, _)| at < output);
    match (known.get(above.wrapping_sub(1)), known.get(above)) {
        (Some(&(y0, s0)), Some(&(y1, s1))) if y1 > y0 => s0 + (output - y0) / (y1 - y0) * (s1 - s0),
        (_, Some(&(_, slope))) | (Some(&(_, slope)), None) => slope,
        (None, None) => 0.0,
    }
}
