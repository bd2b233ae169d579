use wiener::Drive;

use crate::EffectValues;
use crate::effect::{Acting, Base, Before, Effect, Flow, Trial, without_memory};
use crate::info::{EffectBlock, EffectInfo, EffectParameter, Need, Smoothness};

parameters! {
    /// The resistance changes with the phase.
    ///
    /// ```text
    /// R(p) = R (1 + ρ p) = R r
    /// current:        P = i² R r
    /// duty, voltage:  P = (V/l)² r/(R r̄²)     (r̄ that of the whole rod: it sets the current)
    /// power:          no effect
    /// ```
    ///
    /// The resistance of the baseline is that of the cold rod, as one measures it; ρ = (R_A - R_M)/R_M. In a rod of one
    /// temperature r = r̄, and a duty heats with 1/r. Shares are between those at the ends of the sample. The sign is not
    /// agreed: resistivity, its temperature coefficient and the geometry compete.
    PhaseDependentResistance {
        /// Relative change of the resistance over the transformation ρ; -0.9 to 0.9.
        resistance_change: EffectParameter::size("1", 0.1, [-0.9, 0.9])
            .unchecked([0.08, 0.15], "76 (M), 82 (A) µΩ cm, but also 102 (M), 89 (A)"),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "phase-dependent-resistance",
    name: "phase-dependent resistance",
    block: EffectBlock::HeatBalance,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[Need::ElectricalDrive],
    parameters: PARAMETERS,
    equation: "R = R_0 (1 + ρ ξ)",
    sentence: "the rod's resistance changes by {value} of its value while transforming",
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    change: [f64; L],
    given: Given,
}

/// What the drive keeps constant.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Given {
    Current,
    Voltage,
    Power,
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const IMPLICIT: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        Self {
            change: values.map(|lane| lane.phase_dependent_resistance.resistance_change),
            given: match base.drive() {
                Drive::Current => Given::Current,
                Drive::Duty { .. } | Drive::Voltage { .. } => Given::Voltage,
                Drive::Power { .. } => Given::Power,
            },
        }
    }

    #[inline(always)]
    fn flow(&self, acting: &Acting<L>, from: &Before<L>, to: &Trial<L>, flow: &mut Flow<L>) {
        let change = &self.change;
        match self.given {
            Given::Current => {
                for l in 0..L {
                    let power = acting.power_w_per_m[l];
                    let own = from.counted_transformed(to, l);
                    flow.w_per_m[l] += power * (change[l] * own);
                    flow.per_transformed[l] += power * (from.counted[l] * change[l]);
                }
            }
            Given::Voltage => {
                for l in 0..L {
                    let power = acting.power_w_per_m[l];
                    let own = from.counted_transformed(to, l);
                    let mean = from.counted_mean(to, l);
                    let conductance = 1.0 / (1.0 + change[l] * mean);
                    let own_ratio = (1.0 + change[l] * own) * conductance;
                    flow.w_per_m[l] += power * (own_ratio * conductance - 1.0);
                    let per_share = from.counted[l] * change[l] * conductance * conductance;
                    flow.per_transformed[l] += power * per_share;
                    flow.per_mean[l] -= power * (2.0 * per_share * own_ratio);
                }
            }
            Given::Power => {}
        }
    }
}
