use wiener::Drive;

use crate::effect::{Acting, Base, Before, Effect, Flow, Trial, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Need, Presence, Smoothness};
use crate::{EffectParameter, EffectValues};

parameters! {
    /// The resistance changes with the phase, and rises with the temperature as that of every metal.
    ///
    /// ```text
    /// R(p, T) = R (1 + ρ p)(1 + a (T - T_ref)) = R r h
    /// current:        P = i² R r h
    /// duty, voltage:  P = (V/l)² r/(R r̄² h)     (r̄ that of the whole rod: it sets the current)
    /// power:          no effect
    /// behind leads:   P = P_0 r h/((1 - s) r̄ h + s)²     (s their share of the cold circuit; duty, voltage)
    /// ```
    ///
    /// The resistance of the baseline is that of the cold rod, as one measures it; ρ = (R_A - R_M)/R_M. In a rod of one
    /// temperature r = r̄, and a duty heats with 1/r. Shares and temperatures are between those at the ends of the sample. The
    /// sign of ρ is not agreed: resistivity and geometry compete. A rise alone has another name: it acts like a loss of heat.
    PhaseDependentResistance {
        /// Relative change of the resistance over the transformation ρ; -0.9 to 0.9.
        resistance_change: EffectParameter::size("1", 0.1, [-0.9, 0.9])
            .unchecked([0.03, 0.25], "76 (M), 82 (A) µΩ cm, or 80, 100, but also 102, 89; a wire that shortens by 4 % loses 8 %")
            .at_least(0.01),
        /// Temperature coefficient of the resistance a, 1/K; 0 to 1e-3.
        resistance_rise_per_k: EffectParameter::size("1/K", 2.5e-4, [0.0, 1e-3])
            .unchecked([2e-4, 3e-4], "both phases")
            .scaled_by_heat(1),
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
    equation: "R = R_0 (1 + ρ ξ)(1 + a (T - T_ref))",
    sentence: "the rod's resistance changes by {value} of its value while transforming",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[],
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    change: [f64; L],
    rise_per_k: [f64; L],
    reference_degc: f64,
    given: Given,
}

/// Quantity that the drive keeps constant.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Given {
    Current,
    Voltage,
    /// Of rod and leads, which have this share of the cold circuit's resistance.
    VoltageOverLeads(f64),
    Power,
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const FLOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        Self {
            change: values
                .each_ref()
                .map(|lane| lane.phase_dependent_resistance.resistance_change),
            rise_per_k: values
                .each_ref()
                .map(|lane| lane.phase_dependent_resistance.resistance_rise_per_k),
            reference_degc: base.setting.reference_degc,
            given: match base.drive() {
                Drive::Current => Given::Current,
                Drive::Duty { .. } | Drive::Voltage { .. } => match base.setting.lead_share {
                    leads if leads > 0.0 => Given::VoltageOverLeads(leads),
                    _ => Given::Voltage,
                },
                Drive::Power { .. } => Given::Power,
            },
        }
    }

    #[inline(always)]
    fn flow(&self, acting: &Acting<L>, from: &Before<L>, to: &Trial<L>, flow: &mut Flow<L>) {
        let (change, rise) = (&self.change, &self.rise_per_k);
        match self.given {
            Given::Current => {
                for l in 0..L {
                    let power = acting.power_w_per_m[l];
                    let phase = change[l] * from.counted_transformed(to, l);
                    let heat = rise[l] * (from.counted_degc(to, l) - self.reference_degc);
                    flow.w_per_m[l] += power * (phase + heat + phase * heat);
                    let counted = power * from.counted[l];
                    flow.per_transformed[l] += counted * change[l] * (1.0 + heat);
                    flow.per_k[l] += counted * rise[l] * (1.0 + phase);
                }
            }
            Given::Voltage => {
                for l in 0..L {
                    let power = acting.power_w_per_m[l];
                    let own = from.counted_transformed(to, l);
                    let mean = from.counted_mean(to, l);
                    let warm_k = from.counted_degc(to, l) - self.reference_degc;
                    let cooler = 1.0 / (1.0 + rise[l] * warm_k);
                    let conductance = 1.0 / (1.0 + change[l] * mean);
                    let own_ratio = (1.0 + change[l] * own) * conductance;
                    let factor = own_ratio * conductance * cooler;
                    flow.w_per_m[l] += power * (factor - 1.0);
                    let counted = power * from.counted[l];
                    let per_share = counted * change[l] * conductance * conductance * cooler;
                    flow.per_transformed[l] += per_share;
                    flow.per_mean[l] -= 2.0 * per_share * own_ratio;
                    flow.per_k[l] -= counted * rise[l] * cooler * factor;
                }
            }
            Given::VoltageOverLeads(leads) => {
                let of_rod = 1.0 - leads;
                for l in 0..L {
                    let power = acting.power_w_per_m[l];
                    let own = from.counted_transformed(to, l);
                    let mean = from.counted_mean(to, l);
                    let warm_k = from.counted_degc(to, l) - self.reference_degc;
                    let hotter = 1.0 + rise[l] * warm_k;
                    let phases = 1.0 + change[l] * mean;
                    let current = 1.0 / (of_rod * phases * hotter + leads);
                    let per_own = hotter * current * current;
                    let factor = (1.0 + change[l] * own) * per_own;
                    flow.w_per_m[l] += power * (factor - 1.0);
                    let counted = power * from.counted[l];
                    let divided = 2.0 * factor * current * of_rod;
                    flow.per_transformed[l] += counted * change[l] * per_own;
                    flow.per_mean[l] -= counted * divided * change[l] * hotter;
                    flow.per_k[l] += counted * rise[l] * (factor / hotter - divided * phases);
                }
            }
            Given::Power => {}
        }
    }
}
