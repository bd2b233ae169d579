use crate::EffectValues;
use crate::effect::{Base, Effect, Moment, without_memory_in_zones};
use crate::info::{EffectBlock, EffectInfo, EffectParameter, Smoothness};
use crate::part::{progress, unit};

/// Samples (sub-steps count) that the delay spans at most.
const LONGEST_SAMPLES: usize = 64;

parameters! {
    /// The drive reaches the rod late.
    ///
    /// ```text
    /// P(t) = P_drive(t - D)     (a pure delay of the heating power)
    /// ```
    ///
    /// Exact for a drive that is constant over samples of one length: where the delayed power changes
    /// within a sample, the sample is computed in two parts, because the rod may turn from heating to cooling
    /// there. If more than one change falls into a sample (samples of very different lengths), the
    /// powers before the last change count by what they leave at the end of it. Before the first
    /// sample the drive counts as off. A delay of more than 64 samples acts as one of 64.
    DeadTime {
        /// Delay D, s; 0 to 1.
        dead_time_s: EffectParameter::size("s", 0.05, [0.0, 1.0])
            .unchecked([0.001, 0.1], "logger and amplifier, half a sample and more"),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "dead-time",
    name: "dead time",
    block: EffectBlock::Drive,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "P(t) = P_drive(t - D)",
    sentence: "the drive reaches the rod {value} late",
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    delay_s: [f64; L],
    longest_s: f64,
    tau_s: [f64; L],
    capacity: usize,
}

/// Powers of the last samples and how long each lasted: a ring.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Past<const L: usize> {
    power_w_per_m: Vec<[f64; L]>,
    length_s: Vec<f64>,
    newest: usize,
    /// Share of the current sample before the delayed power last changes, 0 to 1.
    pub(crate) earlier_share: [f64; L],
    /// Power in that part, W/m.
    pub(crate) earlier_w_per_m: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_in_zones!();
    type Rod = Past<L>;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let delay_s = values.map(|lane| lane.dead_time.dead_time_s);
        let active = base.setting.active.contains(crate::EffectId::DeadTime);
        Self {
            delay_s,
            longest_s: delay_s.into_iter().fold(0.0, f64::max),
            tau_s: base.tau_s(),
            capacity: if active {
                LONGEST_SAMPLES * base.setting.sub_steps + 1
            } else {
                0
            },
        }
    }

    fn rod(&self) -> Past<L> {
        // Off since ever.
        Past {
            power_w_per_m: vec![[0.0; L]; self.capacity],
            length_s: vec![f64::INFINITY; self.capacity],
            newest: 0,
            earlier_share: [0.0; L],
            earlier_w_per_m: [0.0; L],
        }
    }

    #[inline(always)]
    fn power(&self, past: &mut Past<L>, moment: &Moment, power_w_per_m: &mut [f64; L]) {
        // In no time nothing arrives.
        if moment.dt_s <= 0.0 {
            past.earlier_share = [0.0; L];
            return;
        }
        past.push(*power_w_per_m, moment.dt_s);
        let count = past.length_s.len();
        let mut share = [0.0; L];
        let mut older = [0.0; L];
        // Age of the end of a past sample.
        let mut age_s = 0.0;
        for back in 0..count {
            let k = (past.newest + count - back) % count;
            // What is older than the ring was as its oldest sample.
            let is_oldest = back + 1 == count;
            let start_s = if is_oldest {
                f64::INFINITY
            } else {
                age_s + past.length_s[k]
            };
            for l in 0..L {
                // Both as shares of this sample, counted backward from its end.
                let last = unit((age_s - self.delay_s[l]) / moment.dt_s);
                let first = unit((start_s - self.delay_s[l]) / moment.dt_s);
                let sent = past.power_w_per_m[k][l];
                let is_newest = (last <= 0.0) & (first > 0.0);
                power_w_per_m[l] = if is_newest { sent } else { power_w_per_m[l] };
                share[l] = if is_newest { 1.0 - first } else { share[l] };
                // Share of the earlier part, counted from its start.
                let per_share = if share[l] > 0.0 { 1.0 / share[l] } else { 0.0 };
                let a = unit(moment.dt_s / self.tau_s[l]) * share[l];
                let (from, to) = (
                    unit((1.0 - first) * per_share),
                    unit((1.0 - last) * per_share),
                );
                let weight = progress(1.0 - from, a) - progress(1.0 - to, a);
                older[l] += if is_newest { 0.0 } else { sent * weight };
            }
            age_s = start_s;
            if age_s >= self.longest_s + moment.dt_s {
                break;
            }
        }
        past.earlier_share = share;
        past.earlier_w_per_m = older;
    }
}

impl<const L: usize> Past<L> {
    #[inline(always)]
    fn push(&mut self, power_w_per_m: [f64; L], length_s: f64) {
        self.newest = (self.newest + 1) % self.length_s.len();
        self.power_w_per_m[self.newest] = power_w_per_m;
        self.length_s[self.newest] = length_s;
    }
}
