use crate::effect::{Acting, Base, Before, Effect, Flow, Trial, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Need, Presence, Smoothness};
use crate::{EffectParameter, EffectValues};

parameters! {
    /// The transformation takes up heat on heating and gives it back on cooling.
    ///
    /// ```text
    /// m C_p dT/dt = … - m ΔH dp/dt            (enthalpy of a first-order transformation)
    /// mean over a sample: -m ΔH (p_1 - p_0)/dt
    /// ```
    ///
    /// p is the transformed share, 0 cold to 1 hot. The heat of a path is ΔH times the difference of p
    /// at its ends, whatever the branch: over a closed cycle nothing is left. Left out: that the heat of
    /// partial transformation may differ between heating and cooling.
    LatentHeat {
        /// Latent heat ΔH, J/kg; 0 to 60,000. No calorimetry of a rod that transforms came near 1,000.
        latent_heat_j_per_kg: EffectParameter::size("J/kg", 12e3, [0.0, 60e3])
            .literature([4e3, 37e3], "calorimetry of NiTi wires and springs; 24.2 kJ/kg with 837 J/(kg K) is unchecked")
            .at_least(1e3)
            .in_watts(),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "latent-heat",
    name: "latent heat",
    block: EffectBlock::HeatBalance,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[Need::MassPerMeter],
    parameters: PARAMETERS,
    equation: "m C_p dT/dt = … - m ΔH dξ/dt",
    sentence: "the rod takes up {value} while transforming, and gives it back on cooling",
    belongs_to: Belongs::Rig,
    presence: Presence::EveryRod,
    acts_like: &[],
    needs_in_recording: &[],
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    /// m ΔH.
    heat_j_per_m: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const FLOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let mass_kg_per_m = base.setting.mass_kg_per_m.unwrap_or(0.0);
        Self {
            heat_j_per_m: values
                .each_ref()
                .map(|lane| mass_kg_per_m * lane.latent_heat.latent_heat_j_per_kg),
        }
    }

    #[inline(always)]
    fn flow(&self, acting: &Acting<L>, from: &Before<L>, to: &Trial<L>, flow: &mut Flow<L>) {
        for l in 0..L {
            let per_transformed = self.heat_j_per_m[l] * acting.per_s[l];
            flow.w_per_m[l] -= per_transformed * (to.transformed[l] - from.transformed[l]);
            flow.per_transformed[l] -= per_transformed;
        }
    }
}
