use wiener::Drive;

use crate::effect::{Base, Effect, Moment, without_memory_in_zones};
use crate::elementary::mean_exponential;
use crate::info::{Belongs, EffectBlock, EffectInfo, Presence, Smoothness};
use crate::part::Turn;
use crate::{EffectId, EffectParameter, EffectValues};

parameters! {
    /// The supply follows the drive with a time constant.
    ///
    /// ```text
    /// θ da/dt + a = a_drive,   P = P_drive (a/a_drive)²   current, voltage: the amplitude lags
    /// θ dP/dt + P = P_drive                               duty, power: the power lags
    /// ```
    ///
    /// Exact for a drive that is constant over each sample: within it the amplitude is
    /// a_1 + (a_0 - a_1) e^(-t/θ), so the power is a constant and two fading exponentials. A power
    /// that fades with the rate k leaves at the end of the sample what this share of it would if constant:
    ///
    /// ```text
    /// W(k) = φ(a - k dt)/φ(a),   φ(x) = (e^x - 1)/x,   a = dt/τ
    /// ```
    ///
    /// Where the fading power passes what the rod loses, the rod turns from heating to cooling or back: such a sample is
    /// computed in two parts. Before the first sample the supply holds the rod at its start: at rest it was off.
    SupplyLag {
        /// Time constant θ, s; 0 to 2.
        supply_lag_s: EffectParameter::size("s", 0.02, [0.0, 2.0])
            .unchecked([0.001, 0.2], "current amplifiers: milliseconds; bench supplies program down in some 100 ms"),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "supply-lag",
    name: "lag of the supply",
    block: EffectBlock::Drive,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "θ da/dt + a = a_drive,  a the amplitude, or the power of a duty",
    sentence: "the supply follows the drive with a time constant of {value}",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[EffectId::DeadTime, EffectId::OutputLag],
    needs_in_recording: &[],
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    lag_s: [f64; L],
    tau_s: [f64; L],
    amplitude_lags: bool,
}

/// Where the supply was and is, and what fades over a sample.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Supply<const L: usize> {
    /// Square root of the power if the amplitude lags, else the power: at the end of the sample, at its start, and
    /// toward what it goes.
    level: [f64; L],
    started: [f64; L],
    wanted: [f64; L],
    retained: [f64; L],
    /// W(1/θ), W(2/θ).
    weight: [f64; L],
    double_weight: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_in_zones!();
    type Rod = Supply<L>;
    const CHANGES_POWER: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        Self {
            lag_s: values.each_ref().map(|lane| lane.supply_lag.supply_lag_s),
            tau_s: base.tau_s(),
            amplitude_lags: matches!(base.drive(), Drive::Current | Drive::Voltage { .. }),
        }
    }

    fn rod(&self) -> Supply<L> {
        Supply {
            level: [0.0; L],
            started: [0.0; L],
            wanted: [0.0; L],
            retained: [0.0; L],
            weight: [0.0; L],
            double_weight: [0.0; L],
        }
    }

    fn over(&self, supply: &mut Supply<L>, dt_s: f64) {
        for l in 0..L {
            // Not 0/0: in no time nothing fades, but without a lag all does.
            let faded = dt_s.max(f64::MIN_POSITIVE) / self.lag_s[l];
            let a = dt_s / self.tau_s[l];
            supply.retained[l] = libm::exp(-faded);
            supply.weight[l] = mean_exponential(a - faded) / mean_exponential(a);
            supply.double_weight[l] = mean_exponential(a - 2.0 * faded) / mean_exponential(a);
        }
    }

    fn hold(&self, supply: &mut Supply<L>, power_w_per_m: &[f64; L]) {
        supply.level = power_w_per_m.map(|power_w_per_m| self.level(power_w_per_m));
    }

    #[inline(always)]
    fn power(&self, supply: &mut Supply<L>, _: &Moment, power_w_per_m: &mut [f64; L]) {
        supply.started = supply.level;
        for l in 0..L {
            let wanted = self.level(power_w_per_m[l]);
            let behind = supply.level[l] - wanted;
            supply.wanted[l] = wanted;
            supply.level[l] = wanted + behind * supply.retained[l];
            power_w_per_m[l] += if self.amplitude_lags {
                2.0 * wanted * behind * supply.weight[l] + behind * behind * supply.double_weight[l]
            } else {
                behind * supply.weight[l]
            };
        }
    }
}

impl<const L: usize> Lanes<L> {
    /// Lagging quantity of a power: its square root if the amplitude lags, else the power.
    #[inline(always)]
    fn level(&self, power_w_per_m: f64) -> f64 {
        if self.amplitude_lags {
            power_w_per_m.sqrt()
        } else {
            power_w_per_m
        }
    }

    /// The sample that the supply was just asked for in two parts, if in any lane the fading power passes what the rod loses,
    /// `lost_w_per_m` at the start of it. The other lanes have no earlier part.
    #[inline(always)]
    pub(crate) fn turn(
        &self,
        supply: &Supply<L>,
        lost_w_per_m: &[f64; L],
        power_w_per_m: &[f64; L],
        dt_s: f64,
    ) -> Option<Turn<L>> {
        let mut turns = false;
        for l in 0..L {
            let lost = self.level(lost_w_per_m[l]);
            turns |= (supply.started[l] - lost) * (supply.level[l] - lost) < 0.0;
        }
        turns.then(|| self.parted(supply, lost_w_per_m, power_w_per_m, dt_s))
    }

    #[inline(never)]
    fn parted(
        &self,
        supply: &Supply<L>,
        lost_w_per_m: &[f64; L],
        power_w_per_m: &[f64; L],
        dt_s: f64,
    ) -> Turn<L> {
        let mut turn = Turn {
            share: [0.0; L],
            earlier_w_per_m: [0.0; L],
            later_w_per_m: *power_w_per_m,
        };
        for l in 0..L {
            let wanted = supply.wanted[l];
            let behind = supply.started[l] - wanted;
            let power = |level: f64| {
                if self.amplitude_lags {
                    level * level
                } else {
                    level
                }
            };
            // When the supply is at a level, s.
            let at_s = |level: f64| -self.lag_s[l] * libm::log((level - wanted) / behind);
            let lost = lost_w_per_m[l];
            // Until then the rod goes on, and loses more: half of what its first pace would make of it.
            let first_s = at_s(self.level(lost));
            let beyond = power(supply.started[l]) - lost;
            let grown = lost + 0.5 * beyond * first_s / self.tau_s[l];
            let share = at_s(self.level(grown)) / dt_s;
            if !(share > 0.0 && share < 1.0) {
                continue;
            }
            let part = |behind: f64, share: f64| {
                let faded = share * dt_s / self.lag_s[l];
                let a = share * dt_s / self.tau_s[l];
                let weight = |rate: f64| mean_exponential(a - rate) / mean_exponential(a);
                power(wanted)
                    + if self.amplitude_lags {
                        2.0 * wanted * behind * weight(faded)
                            + behind * behind * weight(2.0 * faded)
                    } else {
                        behind * weight(faded)
                    }
            };
            let left = behind * libm::exp(-share * dt_s / self.lag_s[l]);
            turn.share[l] = share;
            turn.earlier_w_per_m[l] = part(behind, share);
            turn.later_w_per_m[l] = part(left, 1.0 - share);
        }
        turn
    }
}
