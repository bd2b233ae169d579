use crate::effect::{Base, Effect, Instant, Moment, Seen, without_memory_in_zones};
use crate::info::{Belongs, EffectBlock, EffectInfo, Presence, Smoothness};
use crate::part::{Turn, progress, unit};
use crate::past::{Arriving, Past};
use crate::{EffectId, EffectParameter, EffectValues};

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
    /// within a sample is a parabola; the hysteresis is asked for its middle. The displacement alone does not tell b.
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
    is_active: bool,
    /// Of the power.
    delay_s: [f64; L],
    output_delay_s: [f64; L],
    tau_s: [f64; L],
}

/// Powers that are under way to the rod, and displacements from it to the record.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Late<const L: usize> {
    sent_w_per_m: Past<L, [f64; L]>,
    moved: Past<L, Moved<L>>,
    /// The last displacement that was shown.
    shown: [f64; L],
    /// Share of the current sample before the delayed power changes, 0 to 1; 0 if it does not.
    earlier_share: [f64; L],
    /// Power in that part, W/m.
    earlier_w_per_m: [f64; L],
}

/// Displacement in the middle and at the end of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Moved<const L: usize> {
    middle: [f64; L],
    end: [f64; L],
}

impl<const L: usize> Lanes<L> {
    /// True if there is a delay behind the rod.
    pub(crate) fn delays_output(&self) -> bool {
        self.output_delay_s.iter().any(|&delay_s| delay_s > 0.0)
    }
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_in_zones!();
    type Rod = Option<Box<Late<L>>>;
    const CHANGES_POWER: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let of_output = |lane: &EffectValues| {
            lane.dead_time.dead_time_s * lane.dead_time.dead_time_output_share
        };
        Self {
            is_active: base.setting.active.contains(EffectId::DeadTime),
            delay_s: values
                .each_ref()
                .map(|lane| lane.dead_time.dead_time_s - of_output(lane)),
            output_delay_s: values.each_ref().map(of_output),
            tau_s: base.tau_s(),
        }
    }

    fn rod(&self) -> Self::Rod {
        self.is_active.then(|| Box::new(Late::still()))
    }

    fn hold(&self, late: &mut Self::Rod, power_w_per_m: &[f64; L]) {
        if let Some(late) = late {
            late.sent_w_per_m = Past::since_ever(*power_w_per_m);
        }
    }

    #[inline(always)]
    fn power(&self, late: &mut Self::Rod, moment: &Moment, power_w_per_m: &mut [f64; L]) {
        let Some(late) = late else {
            return;
        };
        // In no time nothing arrives.
        late.earlier_share = [0.0; L];
        if moment.dt_s <= 0.0 {
            return;
        }
        late.sent_w_per_m.push(*power_w_per_m, moment.dt_s);
        for l in 0..L {
            let arriving = late.sent_w_per_m.go_on(l, self.delay_s[l]);
            power_w_per_m[l] = if arriving.last <= arriving.first + 1 {
                late.change_once(l, &arriving, self.delay_s[l], moment.dt_s)
            } else {
                let rate = unit(moment.dt_s / self.tau_s[l]);
                late.change_at_largest(l, &arriving, self.delay_s[l], moment.dt_s, rate)
            };
        }
    }

    #[inline(always)]
    fn displacement(
        &self,
        late: &mut Self::Rod,
        moment: &Moment,
        seen: &Seen<L>,
        displacement: &mut [f64; L],
    ) {
        if let Some(late) = late
            && self.delays_output()
        {
            late.displacement(&self.output_delay_s, moment, seen, displacement);
        }
    }

    fn settle(
        &self,
        late: &mut Self::Rod,
        _: &Moment,
        _: &Seen<L>,
        _: &[f64; L],
        displacement: &mut [f64; L],
    ) {
        if let Some(late) = late {
            late.moved = Past::since_ever(Moved {
                middle: *displacement,
                end: *displacement,
            });
            late.shown = *displacement;
        }
    }
}

impl<const L: usize> Late<L> {
    fn still() -> Self {
        Self {
            sent_w_per_m: Past::since_ever([0.0; L]),
            moved: Past::since_ever(Moved {
                middle: [0.0; L],
                end: [0.0; L],
            }),
            shown: [0.0; L],
            earlier_share: [0.0; L],
            earlier_w_per_m: [0.0; L],
        }
    }

    /// The current sample in two parts, the later one with the power that is on in the end; none if the power changes in no lane.
    pub(crate) fn turn(&self, later_w_per_m: [f64; L]) -> Option<Turn<L>> {
        let turns = self.earlier_share.iter().any(|&share| share > 0.0);
        turns.then_some(Turn {
            share: self.earlier_share,
            earlier_w_per_m: self.earlier_w_per_m,
            later_w_per_m,
        })
    }

    /// Parts the current sample of a lane where the second of two powers arrives; returns that, W/m.
    #[inline(always)]
    fn change_once(&mut self, l: usize, arriving: &Arriving, delay_s: f64, dt_s: f64) -> f64 {
        let later = self.sent_w_per_m.sample(arriving.last).of[l];
        if arriving.first < arriving.last {
            let earlier = self.sent_w_per_m.sample(arriving.first);
            let first = self.sent_w_per_m.sample(arriving.last).length_s + arriving.age_s;
            if (later - earlier.of[l]).abs() > 0.0 {
                self.earlier_share[l] = 1.0 - unit((first - delay_s) / dt_s);
                self.earlier_w_per_m[l] = earlier.of[l];
            }
        }
        later
    }

    /// Parts the current sample of a lane where the delayed power changes most; returns the power of the later part, W/m. `rate` is the
    /// sample's length over the time constant.
    #[cold]
    fn change_at_largest(
        &mut self,
        l: usize,
        arriving: &Arriving,
        delay_s: f64,
        dt_s: f64,
        rate: f64,
    ) -> f64 {
        // Power by what it leaves at the end of the sample, and what a power of 1 would: so far, and in the later part.
        let (mut all, mut later) = ([0.0; 2], [0.0; 2]);
        let (mut largest, mut share) = (0.0, 0.0);
        let mut newer = None;
        let mut age_s = arriving.age_s;
        for k in (arriving.first..=arriving.last).rev() {
            let sent = self.sent_w_per_m.sample(k);
            let start_s = age_s + sent.length_s;
            // Shares of the sample, counted backward from its end.
            let last = unit((age_s - delay_s) / dt_s);
            let first = unit((start_s - delay_s) / dt_s);
            if last < first {
                let power = sent.of[l];
                let change = newer.map_or(0.0, |newer: f64| (newer - power).abs());
                if change > largest {
                    (largest, share, later) = (change, 1.0 - last, all);
                }
                let weight = progress(first, rate) - progress(last, rate);
                all = [all[0] + power * weight, all[1] + weight];
                newer = Some(power);
            }
            age_s = start_s;
        }
        if largest == 0.0 {
            return newer.unwrap_or(0.0);
        }
        self.earlier_share[l] = share;
        self.earlier_w_per_m[l] = (all[0] - later[0]) / (all[1] - later[1]);
        later[0] / later[1]
    }

    fn displacement(
        &mut self,
        delay_s: &[f64; L],
        moment: &Moment,
        seen: &Seen<L>,
        displacement: &mut [f64; L],
    ) {
        let middle_s = 0.5 * moment.dt_s;
        let now = *displacement;
        match seen.instant {
            Instant::Turn => {}
            Instant::Middle if moment.dt_s > 0.0 => {
                let moved = Moved {
                    middle: now,
                    end: now,
                };
                self.moved.push(moved, moment.dt_s);
            }
            Instant::Middle => {}
            Instant::End => self.moved.newest_mut().end = now,
        }
        let newest = self.moved.newest();
        for l in 0..L {
            if delay_s[l] <= 0.0 {
                continue;
            }
            displacement[l] = match seen.instant {
                // A corner of what is not shown yet.
                Instant::Turn => self.shown[l],
                Instant::Middle if delay_s[l] < middle_s => {
                    let before = self.moved.sample(newest - 1).of.end[l];
                    now[l] + (delay_s[l] / middle_s) * (before - now[l])
                }
                Instant::Middle => self.moved_by(l, delay_s[l] + middle_s),
                Instant::End => self.moved_by(l, delay_s[l]),
            };
        }
        if seen.instant == Instant::End {
            self.shown = *displacement;
        }
    }

    /// The displacement `age_s` before the end of the newest sample.
    fn moved_by(&mut self, l: usize, age_s: f64) -> f64 {
        let Arriving {
            last, age_s: end_s, ..
        } = self.moved.go_on(l, age_s);
        let sample = self.moved.sample(last);
        let end = sample.of.end[l];
        if last == 0 {
            return end;
        }
        let start = self.moved.sample(last - 1).of.end[l];
        let bend = sample.of.middle[l] - 0.5 * (start + end);
        let share = (age_s - end_s) / sample.length_s;
        end + share * (start - end) + 4.0 * bend * share * (1.0 - share)
    }
}
