//! How time advances in a recording.

use crate::digits::Digits;

/// How time advances in a recording.
///
/// # Uniform
///
/// Sampling is uniform if the printed time stamps cannot be told from an equal grid: with
/// Δt = (t_(n−1) − t_0)/(n − 1),
///
/// ```text
/// |t_k − t_(k−1) − Δt|  ≤ min(r + r_e/(n−1), Δt/4) + 4 ε t_e     every step
/// |t_k − (t_0 + k Δt)|  ≤ min((r + r_e)/2,   Δt/4) + n ε t_e     every stamp
/// ```
///
/// where r is the resolution of the stamps (the coarser of the two of a step) and r_e, t_e that of
/// the first or last stamp and its size, whichever is larger. A stamp rounded to r is wrong by at
/// most r/2, so a step by r, Δt by r_e/(n−1), and the grid by r_e/2: 0.287 s printed as 0.29, 0.57,
/// 0.86, 1.15 is uniform. Where r is not small against Δt (stamps in whole seconds at 1 Hz) a
/// quarter of Δt is the most that passes, so that a lost sample is never taken for rounding. The
/// last terms are the rounding of binary numbers, ε = 2^−52; a logger may have added up its steps.
///
/// r comes from the values, so that a recording in memory and the same one written and read again
/// agree: with d the most decimals and s the most significant digits that any stamp needs,
/// r = max(10^−d, unit of the s-th digit of the stamp), with s no less than 6, to which C's `%g`
/// prints. Where a stamp needs more than 15 digits, r = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sampling {
    /// Equal steps: a fixed sample time serves.
    Uniform {
        /// The step, s.
        dt_s: f64,
    },
    /// Unequal steps.
    Jittered {
        /// Median step, s; the shorter of the middle two of an even number.
        median_dt_s: f64,
        /// Shortest step, s.
        min_dt_s: f64,
        /// Longest step, s.
        max_dt_s: f64,
    },
    /// Static data without time.
    Untimed,
}

/// A step that is a gap is longer than this many times the median step.
///
/// Our choice: up to four samples lost in a row pass as jitter, a logger that stopped does not.
pub const GAP_FACTOR: f64 = 5.0;

/// A step so long that samples are missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Index of the sample before the gap.
    pub index: usize,
    /// Its time, s.
    pub start_s: f64,
    /// Length of the step, s.
    pub dt_s: f64,
}

impl Sampling {
    /// The usual step, s: the equal one, or the median of unequal ones; `None` for static data.
    #[must_use]
    pub const fn usual_dt_s(&self) -> Option<f64> {
        match *self {
            Self::Uniform { dt_s } => Some(dt_s),
            Self::Jittered { median_dt_s, .. } => Some(median_dt_s),
            Self::Untimed => None,
        }
    }

    /// The sampling of rising times.
    pub(crate) fn of(time_s: &[f64]) -> Self {
        let (Some(&first), Some(&last)) = (time_s.first(), time_s.last()) else {
            return Self::Untimed;
        };
        let n_steps = time_s.len() - 1;
        let dt_s = (last - first) / n_steps as f64;
        let largest = first.abs().max(last.abs());
        let digits = Digits::of(time_s);
        let end_resolution = digits.resolution(largest);
        let rounding = f64::EPSILON * largest;
        let step_extra = end_resolution / n_steps as f64;

        let agrees = |error: f64, resolution: f64, rounding: f64| {
            error.abs() <= resolution.min(0.25 * dt_s) + rounding
        };
        let uniform = time_s.windows(2).enumerate().all(|(k, pair)| {
            let step = pair[1] - pair[0];
            let grid = first + (k + 1) as f64 * dt_s;
            let resolution = digits.resolution(pair[0].abs().max(pair[1].abs()));
            agrees(step - dt_s, resolution + step_extra, 4.0 * rounding)
                && agrees(
                    pair[1] - grid,
                    0.5 * (resolution + end_resolution),
                    n_steps as f64 * rounding,
                )
        });
        if uniform && dt_s.is_finite() {
            return Self::Uniform { dt_s };
        }
        let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let middle = (steps.len() - 1) / 2;
        let (shorter, &mut median_dt_s, longer) =
            steps.select_nth_unstable_by(middle, f64::total_cmp);
        Self::Jittered {
            median_dt_s,
            min_dt_s: shorter.iter().copied().fold(median_dt_s, f64::min),
            max_dt_s: longer.iter().copied().fold(median_dt_s, f64::max),
        }
    }
}

pub(crate) fn gaps(time_s: &[f64], sampling: Sampling) -> Vec<Gap> {
    let Sampling::Jittered { median_dt_s, .. } = sampling else {
        return Vec::new();
    };
    let steps = time_s.windows(2).enumerate().map(|(index, pair)| Gap {
        index,
        start_s: pair[0],
        dt_s: pair[1] - pair[0],
    });
    steps
        .filter(|gap| gap.dt_s > GAP_FACTOR * median_dt_s)
        .collect()
}
