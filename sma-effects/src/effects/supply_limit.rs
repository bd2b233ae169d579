use wiener::Drive;

use crate::effect::{Base, Effect, Moment, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Need, Occurrence, Presence, Smoothness};
use crate::{EffectParameter, EffectValues};

parameters! {
    /// The supply saturates: a current source runs out of voltage, a voltage supply out of current.
    ///
    /// ```text
    /// a' = a - b max(0, a - u_s a_max)
    /// ```
    ///
    /// a is the magnitude of the drive, or the power of a duty, and a_max the largest of the training recordings. b = 1 is
    /// a supply that gives no more, a' = min(a, u_s a_max); less stands for a limit that is not held. The amplitude is linear in b; it does
    /// nothing in a run that does not reach u_s a_max. Where all that is driven stands at one level it acts like another
    /// resistance.
    SupplyLimit {
        /// Share of the drive beyond the limit that does not come b; 0 to 1. A supply changes over from constant current to
        /// constant voltage sharply, within less than a percent: what lets a tenth of the rest through is no limit.
        supply_limit_share: EffectParameter::size("1", 1.0, [0.0, 1.0])
            .at_least(0.9)
            // A supply that gives no more.
            .up_to_an_end(),
        /// Limit over the largest drive u_s; 0.2 to 1. A partner: where nothing is held back it does nothing.
        supply_limit_position: EffectParameter::partner("1", 0.85, [0.2, 1.0], &[0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95]),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "supply-limit",
    name: "limit of the supply",
    block: EffectBlock::Drive,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[Need::LargestDrive],
    parameters: PARAMETERS,
    equation: "a' = a - b max(0, a - u_s a_max),  a the amplitude, or the power of a duty",
    sentence: "from {partner} of the largest drive on, {value} of what the drive adds does not reach the rod",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[Occurrence::FollowedLevels],
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    share: [f64; L],
    /// u_s a_max: the square root of a power, W/m, if the amplitude is limited, else the power.
    limit: [f64; L],
    limits_amplitude: bool,
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const CHANGES_POWER: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let limits_amplitude = matches!(base.drive(), Drive::Current | Drive::Voltage { .. });
        // Without a largest drive the effect is refused where it is active.
        let largest = base.setting.largest_drive.unwrap_or(f64::MAX);
        let resistance_ohm_per_m = base
            .params
            .each_ref()
            .map(|lane| lane.heat.resistance_ohm_per_m);
        let mut limit = base
            .drive()
            .power_w_per_m([largest; L], resistance_ohm_per_m);
        for l in 0..L {
            if limits_amplitude {
                limit[l] = limit[l].sqrt();
            }
            limit[l] *= values[l].supply_limit.supply_limit_position;
        }
        Self {
            share: values
                .each_ref()
                .map(|lane| lane.supply_limit.supply_limit_share),
            limit,
            limits_amplitude,
        }
    }

    #[inline(always)]
    fn power(&self, _: &mut (), _: &Moment, power_w_per_m: &mut [f64; L]) {
        for l in 0..L {
            let power = power_w_per_m[l];
            let asked = if self.limits_amplitude {
                power.sqrt()
            } else {
                power
            };
            let beyond = asked - self.limit[l];
            let cut = self.share[l] * if beyond > 0.0 { beyond } else { 0.0 };
            power_w_per_m[l] -= if self.limits_amplitude {
                // a² - (a - cut)², exactly 0 for no cut.
                (asked + asked - cut) * cut
            } else {
                cut
            };
        }
    }
}
