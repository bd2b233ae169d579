use crate::effect::{Base, Before, Effect, Shift, Trial, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Need, Presence, Smoothness};
use crate::{EffectParameter, EffectValues};

parameters! {
    /// The load rises with the stroke and with it the temperatures of transformation.
    ///
    /// ```text
    /// ξ = loop(T - ΔT),   ΔT = s p̄,   s = Δσ/C     (Clausius–Clapeyron, Δσ the rise of stress per stroke)
    /// ```
    ///
    /// A spring stretched by the stroke: the stress is that of the whole rod's transformed share p̄.
    /// The equation is implicit; it is solved with the heat balance in the temperature that drives the
    /// loop, T - ΔT, in which it is explicit. Under slow drives it widens and tilts the loop as
    /// another width and spread would: a second load tells them apart.
    StressCoupling {
        /// Shift of the loop over a full stroke s, K; 0 to 60.
        stress_shift_k: EffectParameter::size("K", 10.0, [0.0, 60.0])
            .unchecked([7.0, 20.0], "computed from a swing of 50 to 150 MPa at 7 MPa/K")
            .scaled_by_heat(-1),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "stress-coupling",
    name: "stress that rises with the stroke",
    block: EffectBlock::Transformation,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[Need::Load],
    parameters: PARAMETERS,
    equation: "ξ = loop(T - s ξ̄),  s = Δσ/C  (Clausius–Clapeyron)",
    sentence: "the load raises the transformation temperatures by {value} over a full stroke",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[],
    like_loop: true,
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    shift_k: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const SHIFTS: bool = true;

    fn new(values: &[EffectValues; L], _: &Base<'_, L>) -> Self {
        Self {
            shift_k: values
                .each_ref()
                .map(|lane| lane.stress_coupling.stress_shift_k),
        }
    }

    #[inline(always)]
    fn shift(&self, _: &(), _: &Before<L>, to: &Trial<L>, shift: &mut Shift<L>) {
        for l in 0..L {
            shift.kelvin[l] += self.shift_k[l] * to.mean[l];
            shift.per_mean[l] += self.shift_k[l];
        }
    }
}
