use crate::EffectValues;
use crate::effect::{Base, Effect, without_memory};
use crate::info::{EffectBlock, EffectInfo, EffectParameter, Smoothness};

parameters! {
    /// The ends of the rod lose heat to the clamps.
    ///
    /// ```text
    /// C dT_m/dt = P - hA (T_m - T_a) - κ hA φ/(1 - φ) (T_m - T_e) + …     middle, share 1 - φ
    /// C dT_e/dt = P - hA (T_e - T_a) - κ hA (T_e - T_a) + κ hA (T_m - T_e) + …     both ends, share φ
    /// ```
    ///
    /// The rod in three zones: the middle, and two ends that are alike. Clamps stay at ambient. An end
    /// zone of length b reaches its neighbors over half of it, κ = 2 (ℓ/b)² with the length
    /// ℓ = √(k D/(4 h)) over which a fin cools: with b = ℓ, κ = 2 and φ = 2ℓ/L. Each zone has its own
    /// hysteresis memory and takes part in every other effect; what the rod shows is the mean over its
    /// length, but for the recorded temperature, which is that of the middle. The heat exchanged is that
    /// of the mean temperatures at both ends of the sample.
    EndConduction {
        /// Share of the length in the end zones φ; 0 to 0.8.
        end_share: EffectParameter::size("1", 0.2, [0.0, 0.8])
            .literature([0.01, 0.6], "computed: 2 × 5.7 mm (D = 0.5 mm, h = 70) of 1 m to 2 × 34 mm (3 mm, 12) of 110 mm"),
        /// Conductance to the clamp over that to the air κ; 0.1 to 20. A partner: without end zones it
        /// does nothing.
        end_loss_ratio: EffectParameter::partner("1", 2.0, [0.1, 20.0], &[0.5, 1.0, 2.0, 4.0, 8.0]),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "end-conduction",
    name: "heat conduction into the clamps",
    block: EffectBlock::HeatBalance,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    sentence: "the ends, {value} of the length, lose heat to the clamps, {partner} times what they lose to the air",
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    /// φ.
    pub(crate) share: [f64; L],
    /// κ hA, W/(m K): from an end zone to the clamp, and to the middle.
    pub(crate) to_clamp_w_per_m_k: [f64; L],
    /// κ hA φ/(1 - φ): the same for a meter of the middle.
    pub(crate) to_ends_w_per_m_k: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const IMPLICIT: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let share = values.map(|lane| lane.end_conduction.end_share);
        let mut to_clamp_w_per_m_k = base.conductance_w_per_m_k();
        let mut to_ends_w_per_m_k = [0.0; L];
        for l in 0..L {
            to_clamp_w_per_m_k[l] *= values[l].end_conduction.end_loss_ratio;
            to_ends_w_per_m_k[l] = to_clamp_w_per_m_k[l] * (share[l] / (1.0 - share[l]));
        }
        Self {
            share,
            to_clamp_w_per_m_k,
            to_ends_w_per_m_k,
        }
    }
}
