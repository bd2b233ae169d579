use crate::effect::{Base, Effect, Instant, Moment, Seen, without_memory_in_zones};
use crate::info::{Belongs, EffectBlock, EffectInfo, Presence, Smoothness};
use crate::part::{Turn, progress, unit};
use crate::{EffectId, EffectParameter, EffectValues};

/// Samples (sub-steps count) that the delay spans at most.
const LONGEST_SAMPLES: usize = 64;

parameters! {
    /// The recording follows the drive late: the heat reaches the rod late, or the rod's motion reaches the record late.
    ///
    /// ```text
    /// P(t) = P_drive(t - (1 - b) D),   y'(t) = y(t - b D)     (pure delays of the heating power and of the output)
    /// ```
    ///
    /// The first is exact for a drive that is constant over samples of one length: where the delayed power changes
    /// within a sample, the sample is computed in two parts, because the rod may turn from heating to cooling
    /// there. If more than one change falls into a sample (samples of very different lengths), its parts meet at the largest of
    /// them, and powers within a part count by what they leave at the end of it. Before the first
    /// sample the rod is held at its start: at rest the drive was off, and the output is still. The second is exact for a displacement whose course
    /// within a sample is a parabola; the hysteresis is asked for its middle.
    /// A delay of more than 64 samples acts as one of 64. The displacement alone does not tell b.
    DeadTime {
        /// Delay D, s; 0 to 1.
        dead_time_s: EffectParameter::size("s", 0.05, [0.0, 1.0])
            .unchecked([0.001, 0.1], "logger and amplifier, half a sample and more"),
        /// Share b of it between the rod and the recorded output, 0 to 1; told by a thermometer alone, which sees the
        /// delay of the drive, but not that of the output.
        dead_time_output_share: EffectParameter::partner("1", 0.0, [0.0, 1.0], &[0.0, 0.25, 0.5, 0.75, 1.0])
            .told_by_thermometer()
            // All of the delay may lie behind the rod.
            .up_to_an_end(),
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
    equation: "P(t) = P_drive(t - D), or in part y'(t) = y(t - D)",
    sentence: "what is recorded follows the drive {value} late",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[EffectId::SupplyLag, EffectId::OutputLag],
    needs_in_recording: &[],
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    /// Of the power.
    delay_s: [f64; L],
    shortest_s: f64,
    longest_s: f64,
    /// Of the output.
    output_delay_s: [f64; L],
    tau_s: [f64; L],
    capacity: usize,
}

/// Powers and outputs of the last samples and how long each lasted: a ring.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Past<const L: usize> {
    power_w_per_m: Vec<[f64; L]>,
    /// Displacements in their middles and at their ends, and the last that was shown.
    middles: Vec<[f64; L]>,
    ends: Vec<[f64; L]>,
    shown: [f64; L],
    length_s: Vec<f64>,
    newest: usize,
    /// Share of the current sample before the delayed power last changes, 0 to 1.
    earlier_share: [f64; L],
    /// Power in that part, W/m.
    earlier_w_per_m: [f64; L],
}

impl<const L: usize> Lanes<L> {
    /// True if there is a delay behind the rod.
    pub(crate) fn delays_output(&self) -> bool {
        self.output_delay_s.iter().any(|&delay_s| delay_s > 0.0)
    }
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_in_zones!();
    type Rod = Past<L>;
    const CHANGES_POWER: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let of_output = |lane: &EffectValues| {
            lane.dead_time.dead_time_s * lane.dead_time.dead_time_output_share
        };
        let delay_s = values
            .each_ref()
            .map(|lane| lane.dead_time.dead_time_s - of_output(lane));
        let active = base.setting.active.contains(crate::EffectId::DeadTime);
        Self {
            delay_s,
            shortest_s: delay_s.into_iter().fold(f64::INFINITY, f64::min),
            longest_s: delay_s.into_iter().fold(0.0, f64::max),
            output_delay_s: values.each_ref().map(of_output),
            tau_s: base.tau_s(),
            capacity: if active {
                LONGEST_SAMPLES * base.setting.sub_steps + 1
            } else {
                0
            },
        }
    }

    fn rod(&self) -> Past<L> {
        let shown = if self.delays_output() {
            self.capacity
        } else {
            0
        };
        // Since ever.
        Past {
            power_w_per_m: vec![[0.0; L]; self.capacity],
            middles: vec![[0.0; L]; shown],
            ends: vec![[0.0; L]; shown],
            shown: [0.0; L],
            length_s: vec![f64::INFINITY; self.capacity],
            newest: 0,
            earlier_share: [0.0; L],
            earlier_w_per_m: [0.0; L],
        }
    }

    fn hold(&self, past: &mut Past<L>, power_w_per_m: &[f64; L]) {
        past.power_w_per_m.fill(*power_w_per_m);
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
        let mut rate = [0.0; L];
        let mut arriving = [0; L];
        for l in 0..L {
            rate[l] = unit(moment.dt_s / self.tau_s[l]);
        }
        // Age of the end of a past sample.
        let mut age_s = 0.0;
        for back in 0..count {
            let (k, start_s) = past.sample(back, age_s);
            // What no lane has received yet does not count.
            if start_s <= self.shortest_s {
                age_s = start_s;
                continue;
            }
            let sent = &past.power_w_per_m[k];
            // Both as shares of this sample, counted backward from its end.
            let (mut first, mut last) = ([0.0; L], [0.0; L]);
            let mut older_counts = [0.0; L];
            for l in 0..L {
                last[l] = unit((age_s - self.delay_s[l]) / moment.dt_s);
                first[l] = unit((start_s - self.delay_s[l]) / moment.dt_s);
                arriving[l] += i32::from(last[l] < first[l]);
                let is_newest = (last[l] <= 0.0) & (first[l] > 0.0);
                power_w_per_m[l] = if is_newest { sent[l] } else { power_w_per_m[l] };
                share[l] = if is_newest { 1.0 - first[l] } else { share[l] };
                older_counts[l] = if is_newest { 0.0 } else { 1.0 };
            }
            if older_counts.iter().any(|&counts| counts > 0.0) {
                for l in 0..L {
                    // Share of the earlier part, counted from its start.
                    let per_share = if share[l] > 0.0 { 1.0 / share[l] } else { 0.0 };
                    let a = rate[l] * share[l];
                    let (from, to) = (
                        unit((1.0 - first[l]) * per_share),
                        unit((1.0 - last[l]) * per_share),
                    );
                    let weight = progress(1.0 - from, a) - progress(1.0 - to, a);
                    older[l] += if older_counts[l] > 0.0 {
                        sent[l] * weight
                    } else {
                        0.0
                    };
                }
            }
            age_s = start_s;
            if age_s >= self.longest_s + moment.dt_s {
                break;
            }
        }
        past.earlier_share = share;
        past.earlier_w_per_m = older;
        for l in 0..L {
            if arriving[l] > 2 {
                power_w_per_m[l] = past.part_at_largest(l, self.delay_s[l], moment.dt_s, rate[l]);
            }
        }
    }

    #[inline(always)]
    fn displacement(
        &self,
        past: &mut Past<L>,
        moment: &Moment,
        seen: &Seen<L>,
        displacement: &mut [f64; L],
    ) {
        if past.ends.is_empty() {
            return;
        }
        match seen.instant {
            Instant::Turn => {}
            Instant::Middle => past.middles[past.newest] = *displacement,
            Instant::End => past.ends[past.newest] = *displacement,
        }
        let middle_s = 0.5 * moment.dt_s;
        for l in 0..L {
            let delay_s = self.output_delay_s[l];
            if delay_s <= 0.0 {
                continue;
            }
            displacement[l] = match seen.instant {
                // A corner of what is not shown yet.
                Instant::Turn => past.shown[l],
                Instant::Middle if delay_s < middle_s => {
                    let before = past.moved_at(l, 0.0, 1);
                    displacement[l] + (delay_s / middle_s) * (before - displacement[l])
                }
                Instant::Middle => past.moved_at(l, delay_s - middle_s, 1),
                Instant::End => past.moved_at(l, delay_s, 0),
            };
        }
        if seen.instant == Instant::End {
            past.shown = *displacement;
        }
    }

    fn settle(
        &self,
        past: &mut Past<L>,
        _: &Moment,
        _: &Seen<L>,
        _: &[f64; L],
        displacement: &mut [f64; L],
    ) {
        past.middles.fill(*displacement);
        past.ends.fill(*displacement);
        past.shown = *displacement;
    }
}

impl<const L: usize> Past<L> {
    /// The current sample in two parts, the later one with the power that is on in the end.
    pub(crate) fn turn(&self, later_w_per_m: [f64; L]) -> Turn<L> {
        Turn {
            share: self.earlier_share,
            earlier_w_per_m: self.earlier_w_per_m,
            later_w_per_m,
        }
    }

    /// Place of the sample that was the newest `back` samples ago, and the age of its start, s, if its end is `age_s` old. What is older than
    /// the ring was as its oldest sample.
    #[inline(always)]
    fn sample(&self, back: usize, age_s: f64) -> (usize, f64) {
        let count = self.length_s.len();
        let k = (self.newest + count - back) % count;
        let is_oldest = back + 1 == count;
        let start_s = if is_oldest {
            f64::INFINITY
        } else {
            age_s + self.length_s[k]
        };
        (k, start_s)
    }

    /// Parts the current sample of a lane where the delayed power changes most; returns the power of the later part, W/m. `rate` is the
    /// sample's length over the time constant.
    #[cold]
    fn part_at_largest(&mut self, l: usize, delay_s: f64, dt_s: f64, rate: f64) -> f64 {
        // Power by what it leaves at the end of the sample, and what a power of 1 would: so far, and in the later part.
        let (mut all, mut later) = ([0.0; 2], [0.0; 2]);
        let (mut largest, mut share) = (0.0, 0.0);
        let mut newer = None;
        let mut age_s = 0.0;
        for back in 0..self.length_s.len() {
            let (k, start_s) = self.sample(back, age_s);
            // Shares of the sample, counted backward from its end.
            let last = unit((age_s - delay_s) / dt_s);
            let first = unit((start_s - delay_s) / dt_s);
            if last < first {
                let power = self.power_w_per_m[k][l];
                let change = newer.map_or(0.0, |newer: f64| (newer - power).abs());
                if change > largest {
                    (largest, share, later) = (change, 1.0 - last, all);
                }
                let weight = progress(first, rate) - progress(last, rate);
                all = [all[0] + power * weight, all[1] + weight];
                newer = Some(power);
            }
            if first >= 1.0 {
                break;
            }
            age_s = start_s;
        }
        self.earlier_share[l] = share;
        if largest == 0.0 {
            return newer.unwrap_or(0.0);
        }
        self.earlier_w_per_m[l] = (all[0] - later[0]) / (all[1] - later[1]);
        later[0] / later[1]
    }

    #[inline(always)]
    fn push(&mut self, power_w_per_m: [f64; L], length_s: f64) {
        self.newest = (self.newest + 1) % self.length_s.len();
        self.power_w_per_m[self.newest] = power_w_per_m;
        self.length_s[self.newest] = length_s;
    }

    /// The displacement `age_s` before the end of the sample that was the newest `back` samples ago.
    #[inline(always)]
    fn moved_at(&self, l: usize, mut age_s: f64, back: usize) -> f64 {
        let count = self.length_s.len();
        let place = |back: usize| (self.newest + 2 * count - back) % count;
        for back in back..count - 1 {
            let length_s = self.length_s[place(back)];
            if age_s < length_s {
                let [end, start] = [back, back + 1].map(|back| self.ends[place(back)][l]);
                let bend = self.middles[place(back)][l] - 0.5 * (start + end);
                let share = age_s / length_s;
                return end + share * (start - end) + 4.0 * bend * share * (1.0 - share);
            }
            age_s -= length_s;
        }
        self.ends[place(count - 1)][l]
    }
}
