use wiener::Fleet;

use crate::{
    DriveLimits, PidGains, PidParams, Reference, Response, Snapshot, StepTerms, Task, TaskError,
};

/// A run ends with its last two eighths.
const EIGHTH: usize = 8;
/// Swing that counts as an oscillation, as a share of the step: that of the band in which a response settles.
const OSCILLATES: f64 = 0.02;
/// Least share of an oscillation's swing that is left an eighth later.
const PERSISTS: f64 = 0.8;
/// Way between the ends of both eighths above which they are a drift, as a share of their swings: it is 1
/// for a drift, and at most ½ for whatever swings equally in both.
const DRIFTS: f64 = 0.75;

/// How a run ended: its last eighth of samples, and the eighth before it.
///
/// Without any samples in an eighth, which is a run of less than 8, there is no error and no swing. All but the
/// share of saturated samples is `NaN` if the last output is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ending {
    /// Mean of reference - output over the last eighth, in the output's unit: the steady-state error.
    pub mean_error: f64,
    /// Largest minus smallest reference - output in the last eighth, in the output's unit.
    pub swing: f64,
    /// Largest minus smallest reference - output in the eighth before, in the output's unit.
    pub swing_before: f64,
    /// Change of reference - output from the first sample of both eighths to the last, in the output's unit.
    pub drift: f64,
    /// Share of all samples whose drive is at a limit.
    pub saturated_share: f64,
    /// Way of the drive in the last eighth, up and down, in its unit per second: 0 for a drive at rest.
    pub travel_per_s: f64,
    /// Way of the drive in the last eighth, up and down, in its unit.
    pub drive_travel: f64,
    /// Largest minus smallest drive in the last eighth, in its unit.
    pub drive_swing: f64,
}

impl Ending {
    /// True if the response to a step still oscillates at the end, in a way that does not die out.
    ///
    /// Its swing in the last eighth is more than 2 % of the step, and at least 0.8 of its swing in the eighth before.
    /// A drift is no oscillation: from end to end, it goes more than ¾ of the sum of both swings.
    ///
    /// `step` is the height of the step in the output's unit, of either sign. For a step of 0, and for `NaN`, the result
    /// is false. For steps well before the last quarter. The limits are our own choice. An oscillation of several eighths
    /// a period may be missed.
    #[must_use]
    pub fn oscillates(&self, step: f64) -> bool {
        step.abs() > 0.0
            && self.swing > OSCILLATES * step.abs()
            && self.swing >= PERSISTS * self.swing_before
            && self.drift.abs() <= DRIFTS * (self.swing + self.swing_before)
    }

    /// True if the drive goes to and fro in the end by more than so much, in its unit. A drive that goes one way, to hold an
    /// output that has just got there, does not.
    #[must_use]
    pub fn chatters(&self, drive_swing: f64) -> bool {
        self.drive_swing > drive_swing && self.drive_travel > TO_AND_FRO * self.drive_swing
    }
}

/// Way of a drive over its swing from which it goes to and fro: it is 1 for a drive that goes one way.
const TO_AND_FRO: f64 = 1.5;

/// Collects [`Ending`] while `L` loops run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EndingLanes<const L: usize> {
    limits: DriveLimits,
    n_samples: usize,
    /// Samples of an eighth.
    eighth: usize,
    saturated: [f64; L],
    error_sum: [f64; L],
    /// Smallest and largest error, of the eighth before and of the last.
    range: [[[f64; L]; 2]; 2],
    first_error: [f64; L],
    last_error: [f64; L],
    /// Σ |u_k - u_(k-1)| of the last eighth.
    travel: [f64; L],
    last_drive: [f64; L],
    /// Smallest and largest drive of the last eighth.
    drive_range: [[f64; L]; 2],
    dt_s: f64,
}

impl<const L: usize> EndingLanes<L> {
    pub(crate) fn new(n_samples: usize, pid: &PidParams) -> Self {
        Self {
            limits: pid.limits,
            dt_s: pid.dt_s,
            travel: [0.0; L],
            last_drive: [0.0; L],
            drive_range: [[f64::INFINITY; L], [f64::NEG_INFINITY; L]],
            n_samples,
            eighth: n_samples / EIGHTH,
            saturated: [0.0; L],
            error_sum: [0.0; L],
            range: [[[f64::INFINITY; L], [f64::NEG_INFINITY; L]]; 2],
            first_error: [0.0; L],
            last_error: [0.0; L],
        }
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, snapshot: &Snapshot<L>) {
        let DriveLimits { lower, upper } = self.limits;
        for l in 0..L {
            let inside = snapshot.drive[l] > lower && snapshot.drive[l] < upper;
            self.saturated[l] += if inside { 0.0 } else { 1.0 };
        }
        let begin = self.n_samples - 2 * self.eighth;
        if snapshot.k < begin {
            return;
        }
        let is_last = snapshot.k >= self.n_samples - self.eighth;
        let [smallest, largest] = &mut self.range[usize::from(is_last)];
        for l in 0..L {
            let error = snapshot.setpoint - snapshot.output[l];
            smallest[l] = smallest[l].min(error);
            largest[l] = largest[l].max(error);
            self.last_error[l] = error;
            self.error_sum[l] += if is_last { error } else { 0.0 };
            let way = (snapshot.drive[l] - self.last_drive[l]).abs();
            self.travel[l] += if is_last { way } else { 0.0 };
            self.last_drive[l] = snapshot.drive[l];
        }
        if is_last {
            let [smallest, largest] = &mut self.drive_range;
            for l in 0..L {
                smallest[l] = smallest[l].min(snapshot.drive[l]);
                largest[l] = largest[l].max(snapshot.drive[l]);
            }
        }
        if snapshot.k == begin {
            self.first_error = self.last_error;
        }
    }

    pub(crate) fn endings(&self) -> [Ending; L] {
        core::array::from_fn(|l| {
            let [before, last] = self
                .range
                .map(|[smallest, largest]| largest[l] - smallest[l]);
            let of_seen = |value: f64| match self.eighth {
                0 => 0.0,
                _ if self.last_error[l].is_nan() => f64::NAN,
                _ => value,
            };
            Ending {
                mean_error: of_seen(self.error_sum[l] / self.eighth as f64),
                swing: of_seen(last),
                swing_before: of_seen(before),
                drift: of_seen(self.last_error[l] - self.first_error[l]),
                saturated_share: self.saturated[l] / self.n_samples as f64,
                drive_swing: of_seen(self.drive_range[1][l] - self.drive_range[0][l]),
                drive_travel: of_seen(self.travel[l]),
                travel_per_s: of_seen(self.travel[l] / (self.eighth as f64 * self.dt_s)),
            }
        })
    }
}

/// Percentiles of the draws: values that 5, 50 and 95 % of them do not exceed.
///
/// ```text
/// p_q = x_j + (h - j)(x_(j+1) - x_j),   h = q (n - 1),   j = floor(h)
/// ```
///
/// with the n values in rising order from x_0 on. A value that is `NaN` counts as +∞.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Percentiles {
    /// 5 %.
    pub p5: f64,
    /// 50 %, the median.
    pub p50: f64,
    /// 95 %.
    pub p95: f64,
}

impl Percentiles {
    /// Of at least one value.
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut rising: Vec<f64> = values
            .map(|value| if value.is_nan() { f64::INFINITY } else { value })
            .collect();
        rising.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let place = share * (rising.len() - 1) as f64;
            let below = place as usize;
            let rest = place - below as f64;
            match rising.get(below + 1) {
                Some(above) if rest > 0.0 => rising[below] + rest * (above - rising[below]),
                _ => rising[below],
            }
        };
        Self {
            p5: at(0.05),
            p50: at(0.5),
            p95: at(0.95),
        }
    }
}

/// Performance of one controller on many plants that may be the real one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Robustness {
    /// Number of plants.
    pub draws: usize,
    /// [`Terms::mse`](crate::Terms::mse).
    pub mse: Percentiles,
    /// [`Terms::energy`](crate::Terms::energy).
    pub energy: Percentiles,
    /// Terms that only a step has.
    pub step: Option<StepRobustness>,
}

/// Performance of one controller on many plants at a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepRobustness {
    /// [`StepTerms::rise_time_s`], s.
    pub rise_time_s: Percentiles,
    /// [`StepTerms::settling_time_s`], s.
    pub settling_time_s: Percentiles,
    /// [`StepTerms::overshoot`], a share of the step.
    pub overshoot: Percentiles,
    /// Share of the draws that have not settled at the end.
    pub unsettled_share: f64,
    /// Share of the draws that oscillate at the end, [`Ending::oscillates`].
    pub oscillating_share: f64,
}

/// Runs one controller on many plants: draws from what is known of the parameters, made elsewhere.
///
/// # Errors
///
/// [`TuneError::Empty`](crate::TuneError::Empty) without members, else as [`Task::responses`].
pub fn robustness<F: Fleet<Member: Sync, Error: Send> + Sync>(
    task: &Task<'_, F>,
    gains: PidGains,
    members: &[F::Member],
) -> Result<Robustness, TaskError<F::Error>> {
    if members.is_empty() {
        return Err(crate::TuneError::Empty { name: "members" }.into());
    }
    let cases: Vec<_> = members.iter().map(|&member| (member, gains)).collect();
    let responses = task.responses(&cases)?;
    let of = |term: fn(&Response) -> f64| Percentiles::of(responses.iter().map(term));
    Ok(Robustness {
        draws: members.len(),
        mse: of(|response| response.terms.mse),
        energy: of(|response| response.terms.energy),
        step: at_step(task, &responses),
    })
}

fn at_step<F>(task: &Task<'_, F>, responses: &[Response]) -> Option<StepRobustness> {
    let Reference::Step { from, to, .. } = task.closed_loop().params().reference else {
        return None;
    };
    let left_s = task.left_s()?;
    let terms: Option<Vec<StepTerms>> = responses
        .iter()
        .map(|response| response.terms.step)
        .collect();
    let terms = terms?;
    let share = |n_of_draws: usize| n_of_draws as f64 / responses.len() as f64;
    let of = |term: fn(&StepTerms) -> f64| Percentiles::of(terms.iter().map(term));
    let unsettled = |step: &&StepTerms| step.settling_time_s >= left_s;
    let oscillates = |response: &&Response| response.ending.oscillates(to - from);
    Some(StepRobustness {
        rise_time_s: of(|step| step.rise_time_s),
        settling_time_s: of(|step| step.settling_time_s),
        overshoot: of(|step| step.overshoot),
        unsettled_share: share(terms.iter().filter(unsettled).count()),
        oscillating_share: share(responses.iter().filter(oscillates).count()),
    })
}

/// A plant with one parameter changed, once down and once up: by 20 % each way, say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variation<'n, M> {
    /// Name of the parameter.
    pub name: &'n str,
    /// The plant with less of it.
    pub minus: M,
    /// The plant with more of it.
    pub plus: M,
}

/// Effect of a [`Variation`] on a response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensitivity<'n> {
    /// Name of the parameter.
    pub name: &'n str,
    /// Response of the plant with less of it.
    pub minus: Response,
    /// Response of the plant with more of it.
    pub plus: Response,
}

/// Runs one controller on plants that differ from the one it was made for in one parameter each.
///
/// # Errors
///
/// As [`Task::responses`].
pub fn sensitivities<'n, F: Fleet<Member: Sync, Error: Send> + Sync>(
    task: &Task<'_, F>,
    gains: PidGains,
    variations: &[Variation<'n, F::Member>],
) -> Result<Vec<Sensitivity<'n>>, TaskError<F::Error>> {
    let cases: Vec<_> = variations
        .iter()
        .flat_map(|variation| [(variation.minus, gains), (variation.plus, gains)])
        .collect();
    let responses = task.responses(&cases)?;
    let (pairs, _) = responses.as_chunks::<2>();
    Ok(variations
        .iter()
        .zip(pairs)
        .map(|(variation, &[minus, plus])| Sensitivity {
            name: variation.name,
            minus,
            plus,
        })
        .collect())
}
