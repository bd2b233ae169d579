use crate::EffectValues;
use crate::effect::{Base, Effect, without_memory_in_zones};
use crate::elementary::expm1;
use crate::info::{EffectBlock, EffectInfo, EffectParameter, Smoothness};

parameters! {
    /// The ends of the rod lose heat to the clamps.
    ///
    /// ```text
    /// C dT_m/dt = P - hA (T_m - T_a) - κ hA φ/(1 - φ) (T_m - T_e) + …     middle, share 1 - φ
    /// C dT_e/dt = P - hA (T_e - T_a) - κ hA (T_e - T_c) + κ hA (T_m - T_e) + …     both ends, share φ
    /// τ_c d(T_c - T_a)/dt = w (T_e - T_a) - (T_c - T_a)     clamps, at T_a before the run
    /// ```
    ///
    /// The rod in three zones: the middle, and two ends that are alike. An end
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
        /// Rise of the clamps in the end over that of the rod's ends w; 0 (they stay at ambient) to 0.95. A partner.
        clamp_warming: EffectParameter::partner("1", 0.2, [0.0, 0.95], &[]),
        /// Time constant of the clamps τ_c, s; 0 to 20,000. A partner: with w = 0 it does nothing either.
        clamp_s: EffectParameter::partner("s", 200.0, [0.0, 20_000.0], &[]),
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

/// dt/τ_c from which nothing is left of where the clamps were.
const LONG: f64 = 700.0;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    /// φ.
    pub(crate) share: [f64; L],
    /// κ hA, W/(m K): from an end zone to the clamp, and to the middle.
    pub(crate) to_clamp_w_per_m_k: [f64; L],
    /// κ hA φ/(1 - φ): the same for a meter of the middle.
    pub(crate) to_ends_w_per_m_k: [f64; L],
    warming: [f64; L],
    per_clamp_s: [f64; L],
}

/// The clamps above the surroundings, K.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Clamps<const L: usize> {
    above_k: [f64; L],
}

impl<const L: usize> Lanes<L> {
    /// What warm clamps save a meter of the ends, W/m: that of the middle of a time `length_s` at whose start the ends
    /// are `ends_k` above the surroundings.
    #[inline(always)]
    pub(crate) fn saved_w_per_m(
        &self,
        clamps: &Clamps<L>,
        ends_k: &[f64; L],
        length_s: &[f64; L],
    ) -> [f64; L] {
        core::array::from_fn(|l| {
            self.to_clamp_w_per_m_k[l] * self.followed(clamps, l, ends_k[l], 0.5 * length_s[l])
        })
    }

    /// The clamps at the end of a time in which the ends are `ends_k` above the surroundings on the average.
    #[inline(always)]
    pub(crate) fn follow(&self, clamps: &mut Clamps<L>, ends_k: &[f64; L], length_s: &[f64; L]) {
        for l in 0..L {
            clamps.above_k[l] = self.followed(clamps, l, ends_k[l], length_s[l]);
        }
    }

    #[inline(always)]
    fn followed(&self, clamps: &Clamps<L>, l: usize, ends_k: f64, time_s: f64) -> f64 {
        let past = time_s * self.per_clamp_s[l];
        let past = if past < LONG { past } else { LONG };
        let above_k = clamps.above_k[l];
        above_k - (self.warming[l] * ends_k - above_k) * expm1(-past)
    }
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_in_zones!();
    type Rod = Clamps<L>;
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
            warming: values.map(|lane| lane.end_conduction.clamp_warming),
            per_clamp_s: values.map(|lane| 1.0 / lane.end_conduction.clamp_s),
        }
    }

    fn rod(&self) -> Clamps<L> {
        Clamps { above_k: [0.0; L] }
    }
}
