use crate::Snapshot;
use crate::reference::edges_passed;

/// Shares of a step between which the rise is timed.
const RISE: [f64; 2] = [0.1, 0.9];
/// Half width of the band in which a response has settled, as a share of the step.
pub(crate) const SETTLED: f64 = 0.02;

/// Terms of the response to a step.
///
/// ```text
/// s(t) = (y(t) - y_0)/(r_f - y_0)
/// ```
///
/// is the share of the step that is done: y_0 is the output at the sample that shows the step, which the step
/// cannot have changed yet, and r_f the reference from then on. Times are read from straight lines between
/// samples and count from that sample.
///
/// A falling step is a rising one in s. A rod that starts away from the reference before the step (bent, warm,
/// of an unknown zero) is measured by the way that it has to go. Without any way to go, y_0 = r_f, there is
/// nothing to rise to and nothing to compare with: all three are 0, and what the response does then is in the
/// mean square alone.
///
/// # Differs from the source
///
/// The paper does not say what its terms mean. These are the definitions of `[Stepinfo]`, and of
/// `[Fuller2021]` but for the lines between samples and for y_0 = 0 there, with one difference: r_f is the
/// reference, not where the response ends. A response that stops short of the reference does not settle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepTerms {
    /// From the first time that s = 10 % to the first time that s = 90 %, s. All the time that was left after
    /// the step, if the response never gets there: no response that does is slower.
    pub rise_time_s: f64,
    /// Last time at which |s - 1| > 2 %, s. All the time that was left, if that is so at the last sample.
    pub settling_time_s: f64,
    /// Largest s - 1, but ≥ 0: a share of the step, %OS/100.
    pub overshoot: f64,
}

/// Collects [`StepTerms`] while `L` loops run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepResponse<const L: usize> {
    /// r_f.
    to: f64,
    at_s: f64,
    /// Samples from the step on.
    n_samples: usize,
    /// y_0.
    initial: [f64; L],
    /// 1/(r_f - y_0), but 0 where there is no way to go.
    per_height: [f64; L],
    /// s of the last sample.
    share: [f64; L],
    /// First times at which s = 10 % and 90 %, s; ∞ before.
    risen_s: [[f64; L]; 2],
    /// Last time at which the response entered the band, s; ∞ while it is outside.
    settled_s: [f64; L],
    /// Largest s - 1 so far, but ≥ 0.
    overshoot: [f64; L],
}

impl<const L: usize> StepResponse<L> {
    pub(crate) fn new(to: f64, at_s: f64) -> Self {
        Self {
            to,
            at_s,
            n_samples: 0,
            initial: [0.0; L],
            per_height: [0.0; L],
            share: [0.0; L],
            risen_s: [[f64::INFINITY; L]; 2],
            settled_s: [f64::INFINITY; L],
            overshoot: [0.0; L],
        }
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, snapshot: &Snapshot<L>, dt_s: f64) {
        if edges_passed(self.at_s, snapshot.k, dt_s) == 0 {
            return;
        }
        if self.n_samples == 0 {
            self.initial = snapshot.output;
            for l in 0..L {
                let height = self.to - self.initial[l];
                self.per_height[l] = if height == 0.0 { 0.0 } else { 1.0 / height };
            }
        }
        let now_s = self.n_samples as f64 * dt_s;
        for l in 0..L {
            let before = self.share[l];
            let share = (snapshot.output[l] - self.initial[l]) * self.per_height[l];
            // When the line from the last sample was at a level: of use only if it passed that level.
            let since_s = dt_s / (share - before);
            let passed_s = |level: f64| now_s - (share - level) * since_s;
            for (risen_s, level) in self.risen_s.iter_mut().zip(RISE) {
                let rises = share >= level && risen_s[l] == f64::INFINITY;
                risen_s[l] = if rises { passed_s(level) } else { risen_s[l] };
            }
            let edge = 1.0 + SETTLED.copysign(before - 1.0);
            let inside = (share - 1.0).abs() <= SETTLED;
            let enters = inside && self.settled_s[l] == f64::INFINITY;
            let settled_s = if enters {
                passed_s(edge)
            } else {
                self.settled_s[l]
            };
            self.settled_s[l] = if inside { settled_s } else { f64::INFINITY };
            self.overshoot[l] = self.overshoot[l].max(share - 1.0);
            self.share[l] = share;
        }
        self.n_samples += 1;
    }

    /// The terms of a lane; `None` before the second sample.
    pub(crate) fn terms(&self, l: usize, dt_s: f64) -> Option<StepTerms> {
        if self.n_samples < 2 {
            return None;
        }
        if self.per_height[l] == 0.0 {
            return Some(StepTerms {
                rise_time_s: 0.0,
                settling_time_s: 0.0,
                overshoot: 0.0,
            });
        }
        let left_s = (self.n_samples - 1) as f64 * dt_s;
        let [begun_s, done_s] = self.risen_s.map(|lanes| lanes[l]);
        Some(StepTerms {
            // ∞ - ∞ is NaN, which min leaves out.
            rise_time_s: (done_s - begun_s).min(left_s),
            settling_time_s: self.settled_s[l].min(left_s),
            overshoot: self.overshoot[l],
        })
    }
}
