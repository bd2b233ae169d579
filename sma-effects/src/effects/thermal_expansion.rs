use crate::EffectValues;
use crate::effect::{Base, Effect, Moment, Seen, without_memory};
use crate::info::{EffectBlock, EffectInfo, EffectParameter, Need, Smoothness};

parameters! {
    /// The rod expands with temperature, against the stroke.
    ///
    /// ```text
    /// y = … - sign(gain) α L (T - T_ref)
    /// ```
    ///
    /// L is the setting's `length_output`: length times lever, in the output's unit. T is the mean over
    /// the rod; T_ref moves only the offset. Left out: that both phases expand differently.
    ThermalExpansion {
        /// Coefficient of expansion α, 1/K; 0 to 3e-5.
        expansion_per_k: EffectParameter::size("1/K", 1e-5, [0.0, 3e-5])
            .literature([6.6e-6, 11e-6], "NiTi: martensite, austenite"),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "thermal-expansion",
    name: "thermal expansion",
    block: EffectBlock::Displacement,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[Need::Length],
    parameters: PARAMETERS,
    sentence: "the rod expands by {value} of its length, against the stroke",
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    /// sign(gain) α L.
    output_per_k: [f64; L],
    reference_degc: f64,
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const SHOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let length = base.setting.length_output.unwrap_or(0.0);
        let mut output_per_k = [0.0; L];
        for l in 0..L {
            let expansion = values[l].thermal_expansion.expansion_per_k;
            output_per_k[l] = (length * expansion).copysign(base.params[l].gain);
        }
        Self {
            output_per_k,
            reference_degc: base.setting.reference_degc,
        }
    }

    #[inline(always)]
    fn displacement(&self, _: &mut (), _: &Moment, seen: &Seen<L>, displacement: &mut [f64; L]) {
        for l in 0..L {
            let warmed_k = seen.temperature_degc[l] - self.reference_degc;
            displacement[l] -= self.output_per_k[l] * warmed_k;
        }
    }
}
