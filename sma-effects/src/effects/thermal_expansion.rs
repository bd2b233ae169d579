use crate::effect::{Base, Effect, Moment, Seen, Standing, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Presence, Smoothness};
use crate::{EffectParameter, EffectValues};

parameters! {
    /// The rod expands with temperature, against the stroke.
    ///
    /// ```text
    /// y = … - sign(gain) α L (r + (1 - r) p)(T - T_ref),   r = 0.6
    /// ```
    ///
    /// L is the setting's `length_output`: length times lever, in the output's unit; where that is not known, the length of
    /// a rod that strains by 4 %, |gain|/0.04. p is the transformed share; martensite expands r times as much as austenite,
    /// 6.6 to 11e-6 /K. The mean over the rod counts; T_ref moves only offset and gain.
    ThermalExpansion {
        /// Coefficient of expansion of the austenite α, 1/K; 0 to 3e-5.
        expansion_per_k: EffectParameter::size("1/K", 1e-5, [0.0, 3e-5])
            .literature([6.6e-6, 11e-6], "NiTi: martensite, austenite")
            .without_length("1/K at a strain of 4 %")
            .scaled_by_heat(1),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "thermal-expansion",
    name: "thermal expansion",
    block: EffectBlock::Displacement,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "y' = y - α L (0.6 + 0.4 ξ)(T - T_ref)",
    sentence: "the rod expands by {value} of its length, against the stroke",
    belongs_to: Belongs::Rig,
    presence: Presence::EveryRod,
    acts_like: &[],
    needs_in_recording: &[],
    like_loop: true,
    ..EffectInfo::ORDINARY
};

/// Expansion of martensite over that of austenite r.
const OF_MARTENSITE: f64 = 0.6;

/// Stroke over the length of a rod that does not say its length: a common strain of the transformation.
const STRAIN: f64 = 0.04;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    /// sign(gain) α L.
    output_per_k: [f64; L],
    reference_degc: f64,
}

impl<const L: usize> Lanes<L> {
    /// Warming by which a zone expands, K: as if it were austenite.
    #[inline(always)]
    pub(crate) fn expanded_k(&self, at: &Standing<L>) -> [f64; L] {
        core::array::from_fn(|l| {
            let warmed_k = at.temperature_degc[l] - self.reference_degc;
            (OF_MARTENSITE + (1.0 - OF_MARTENSITE) * at.transformed[l]) * warmed_k
        })
    }
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const SHOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let mut output_per_k = [0.0; L];
        for l in 0..L {
            let gain = base.params[l].gain;
            let length = base.setting.length_output.unwrap_or(gain.abs() / STRAIN);
            let expansion = values[l].thermal_expansion.expansion_per_k;
            output_per_k[l] = (length * expansion).copysign(gain);
        }
        Self {
            output_per_k,
            reference_degc: base.setting.reference_degc,
        }
    }

    #[inline(always)]
    fn displacement(&self, _: &mut (), _: &Moment, seen: &Seen<L>, displacement: &mut [f64; L]) {
        for l in 0..L {
            displacement[l] -= self.output_per_k[l] * seen.expanded_k[l];
        }
    }
}
