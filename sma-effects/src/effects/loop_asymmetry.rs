use crate::EffectValues;
use crate::effect::{Base, Before, Effect, Shift, Trial, ZoneStart, without_memory_of_the_rod};
use crate::info::{EffectBlock, EffectInfo, EffectParameter, Smoothness};
use crate::play::{play, play_at};

parameters! {
    /// The transformation takes a wider range of temperatures on cooling than on heating.
    ///
    /// ```text
    /// ξ = loop(T - ΔT),   ΔT = a c g,   c = w (3 - w²)/2,   w = (v - θ)/T_c
    /// g = x/√(1 + (a x/(0.6 T_c))²),   x = v - T_r
    /// ```
    ///
    /// v is the play of half width T_c on θ = T - ΔT: the place in the middle between the branches. c is -1 on the
    /// heating curve and +1 on the cooling curve, and moves smoothly between them after a reversal. The spread is
    /// h_0 (1 - a) on heating and h_0 (1 + a) on cooling; far outside of the loop, from T_c/|a|, the branches run
    /// parallel. So dT/dθ > 0, and every branch is continuous and monotone. Not so together with a
    /// `loop-shape` that makes the loop steeper: it may fold, and the end of a sample is then one of several, with what
    /// [`ExtendedState::residual_k`](crate::ExtendedState::residual_k) tells.
    LoopAsymmetry {
        /// Relative difference of the spreads a; -0.6 to 0.6.
        loop_asymmetry: EffectParameter::size("1", 0.2, [-0.6, 0.6]),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "loop-asymmetry",
    name: "asymmetry of heating and cooling",
    block: EffectBlock::Transformation,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    sentence: "the transformation is spread {value} wider on cooling, and as much narrower on heating, than assumed",
};

/// How far the shift may go, share of T_c: below 2/3, or branches would fold.
const REACH: f64 = 0.6;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    asymmetry: [f64; L],
    /// (a/(0.6 T_c))².
    bend_per_k2: [f64; L],
    center_degc: [f64; L],
    half_width_k: [f64; L],
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_of_the_rod!();
    const STANDS_IN_ZONE: bool = true;
    type Zone = [f64; L];
    const IMPLICIT: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let half_width_k = base.params.map(|lane| lane.limiting_loop.loop_half_width_k);
        let asymmetry = values.map(|lane| lane.loop_asymmetry.loop_asymmetry);
        let bend_per_k: [f64; L] =
            core::array::from_fn(|l| asymmetry[l] / (REACH * half_width_k[l]));
        Self {
            asymmetry,
            bend_per_k2: bend_per_k.map(|bend| bend * bend),
            center_degc: base.params.map(|lane| lane.limiting_loop.loop_center_degc),
            half_width_k,
        }
    }

    fn zone(&self, start: &ZoneStart<L>) -> [f64; L] {
        core::array::from_fn(|l| {
            play_at(start.driving_degc[l], self.half_width_k[l], start.share[l])
        })
    }

    #[inline(always)]
    fn shift(&self, zone: &[f64; L], _: &Before<L>, to: &Trial<L>, shift: &mut Shift<L>) {
        for l in 0..L {
            let middle_degc = play(zone[l], to.driving_degc[l], self.half_width_k[l]);
            let w = (middle_degc - to.driving_degc[l]) / self.half_width_k[l];
            let x = middle_degc - self.center_degc[l];
            let root = 1.0 / (1.0 + self.bend_per_k2[l] * (x * x)).sqrt();
            let g = x * root;
            let c = 0.5 * w * (3.0 - w * w);
            // Inside the play the driven side rests; on a branch the place does.
            let per_k = if w.abs() < 1.0 {
                -1.5 * (1.0 - w * w) * g / self.half_width_k[l]
            } else {
                c * (root * root * root)
            };
            shift.kelvin[l] += self.asymmetry[l] * (c * g);
            shift.per_k[l] += self.asymmetry[l] * per_k;
        }
    }

    #[inline(always)]
    fn commit(&self, zone: &mut [f64; L], _: &Before<L>, to: &Trial<L>) {
        for l in 0..L {
            zone[l] = play(zone[l], to.driving_degc[l], self.half_width_k[l]);
        }
    }
}
