use crate::effect::{Acting, Base, Before, Effect, Flow, Trial, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Need, Presence, Smoothness};
use crate::{EffectId, EffectParameter, EffectValues};

/// Stefan–Boltzmann constant, W/(m² K⁴), CODATA 2018.
const STEFAN_BOLTZMANN: f64 = 5.670_374_419e-8;
/// 0 °C on the absolute scale, K.
const ZERO_CELSIUS_K: f64 = 273.15;

parameters! {
    /// The rod radiates.
    ///
    /// ```text
    /// m C_p dT/dt = … - ε σ A ((T + 273.15)⁴ - (T_a + 273.15)⁴)     (Stefan–Boltzmann)
    /// ```
    ///
    /// Beside the convection of the baseline, at a temperature between those at the ends of the sample.
    /// Surroundings of one temperature, much larger than the rod.
    Radiation {
        /// Emissivity ε; 0 to 1, and to 1.25 for what surface and specific heat are known to: a value there is beyond
        /// the physical end.
        emissivity: EffectParameter::size("1", 0.5, [0.0, 1.25])
            .unchecked([0.2, 0.7], "oxidized NiTi")
            .in_watts()
            // What radiation adds to the linear loss grows with the square of the temperature difference.
            .scaled_by_heat(2),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "radiation",
    name: "radiation",
    block: EffectBlock::HeatBalance,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[Need::AbsoluteTemperature, Need::SurfacePerMeter],
    parameters: PARAMETERS,
    equation: "m C_p dT/dt = … - ε σ A (T⁴ - T_a⁴),  absolute temperatures",
    sentence: "the rod radiates with an emissivity of {value}",
    belongs_to: Belongs::Rig,
    presence: Presence::EveryRod,
    acts_like: &[EffectId::NaturalConvection],
    needs_in_recording: &[],
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    /// ε σ A.
    w_per_m_k4: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const FLOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let surface = base.setting.surface_m2_per_m.unwrap_or(0.0);
        Self {
            w_per_m_k4: values
                .each_ref()
                .map(|lane| STEFAN_BOLTZMANN * surface * lane.radiation.emissivity),
        }
    }

    #[inline(always)]
    fn flow(&self, acting: &Acting<L>, from: &Before<L>, to: &Trial<L>, flow: &mut Flow<L>) {
        for l in 0..L {
            let middle_degc = from.counted_degc(to, l);
            let rod_k = middle_degc + ZERO_CELSIUS_K;
            let ambient_k = acting.ambient_degc[l] + ZERO_CELSIUS_K;
            let difference = (middle_degc - acting.ambient_degc[l])
                * (rod_k + ambient_k)
                * (rod_k * rod_k + ambient_k * ambient_k);
            flow.w_per_m[l] -= self.w_per_m_k4[l] * difference;
            let slope = 4.0 * rod_k * rod_k * rod_k;
            flow.per_k[l] -= self.w_per_m_k4[l] * (from.counted[l] * slope);
        }
    }
}
