use crate::effect::{Acting, Base, Before, Effect, Flow, Trial, without_memory};
use crate::elementary::{expm1, ln};
use crate::info::{Belongs, EffectBlock, EffectInfo, Presence, Smoothness};
use crate::part::progress;
use crate::{EffectId, EffectParameter, EffectValues};

/// Rise above the surroundings at which the conductance is that of the baseline, K.
const REFERENCE_RISE_K: f64 = 50.0;
/// Distance of Gauss's two points from the middle of the sample, as a share of it: √3/6.
const GAUSS: f64 = 0.288_675_134_594_812_9;
/// Smallest rise over [`REFERENCE_RISE_K`] that is told from none.
const SMALLEST_RISE: f64 = 1e-12;

parameters! {
    /// Air convects the better the hotter the rod is.
    ///
    /// ```text
    /// loss = hA (T - T_a) (|T - T_a|/50 K)^n     (free convection, Nu ∝ Ra^n; Morgan)
    /// ```
    ///
    /// The conductance of the baseline holds at 50 K above the surroundings; what is added to its loss is
    /// hA (T - T_a) (e^(n ln(|T - T_a|/50 K)) - 1), at two
    /// temperatures of the sample (Gauss).
    NaturalConvection {
        /// Exponent n; 0 (forced) to 1/3 (turbulent), and to 0.45 for what noise adds.
        convection_exponent: EffectParameter::size("1", 0.2, [0.0, 0.45])
            .unchecked([0.058, 0.25], "Morgan's correlations for horizontal cylinders"),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "natural-convection",
    name: "temperature-dependent convection",
    block: EffectBlock::HeatBalance,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "loss = hA (T - T_a) (|T - T_a|/50 K)^n",
    sentence: "heat loss grows faster than the temperature, with an extra exponent of {value}",
    belongs_to: Belongs::Rig,
    presence: Presence::EveryRod,
    acts_like: &[EffectId::Radiation],
    needs_in_recording: &[],
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    exponent: [f64; L],
    conductance_w_per_m_k: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const FLOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        Self {
            exponent: values
                .each_ref()
                .map(|lane| lane.natural_convection.convection_exponent),
            conductance_w_per_m_k: base.conductance_w_per_m_k(),
        }
    }

    #[inline(always)]
    fn flow(&self, acting: &Acting<L>, from: &Before<L>, to: &Trial<L>, flow: &mut Flow<L>) {
        for l in 0..L {
            let start_k = from.temperature_degc[l] - acting.ambient_degc[l];
            let change_k = to.temperature_degc[l] - from.temperature_degc[l];
            let exponent = self.exponent[l];
            for side in [-GAUSS, GAUSS] {
                // What comes late is less cooled away by the end of the sample.
                let weight = 0.5 + 0.5 * from.rate[l] * side;
                let done = progress(0.5 + side, from.rate[l]);
                let rise_k = start_k + change_k * done;
                let relative = rise_k.abs() * (1.0 / REFERENCE_RISE_K);
                let relative = if relative > SMALLEST_RISE {
                    relative
                } else {
                    SMALLEST_RISE
                };
                let excess = expm1(exponent * ln(relative));
                let conductance = weight * self.conductance_w_per_m_k[l];
                flow.w_per_m[l] -= conductance * rise_k * excess;
                flow.per_k[l] -= conductance * done * (exponent + (1.0 + exponent) * excess);
            }
        }
    }
}
