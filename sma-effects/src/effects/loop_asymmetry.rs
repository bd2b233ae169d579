use core::f64::consts::FRAC_PI_2;

use crate::EffectValues;
use crate::effect::{Base, Before, Effect, Shift, Trial, ZoneStart, without_memory_of_the_rod};
use crate::info::{EffectBlock, EffectInfo, EffectParameter, Smoothness};
use crate::play::{play, play_at};

parameters! {
    /// The transformation takes a wider range of temperatures on cooling than on heating.
    ///
    /// ```text
    /// ξ = loop(T - ΔT),   ΔT = A c (2p - 1),   A = a min(π h_0/2, T_c)
    /// c = (v - θ)/T_c,   v = play of half width T_c on θ = T - ΔT
    /// ```
    ///
    /// c is -1 on the heating curve and +1 on the cooling curve, and moves between them without a step after
    /// a reversal. Around the middle of the loop the spread is h_0 (1 - a) on heating and h_0 (1 + a) on
    /// cooling, where h_0 is not above 2 T_c/π. The factor of a keeps dT/dθ > 0, so every branch stays
    /// continuous and monotone. Not so together with a `loop-shape` that makes the loop steeper: it may fold, and
    /// the end of a sample is then one of several, with what
    /// [`ExtendedState::residual_k`](crate::ExtendedState::residual_k) tells.
    LoopAsymmetry {
        /// Relative difference of the spreads a; -0.9 to 0.9.
        loop_asymmetry: EffectParameter::size("1", 0.2, [-0.9, 0.9]),
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

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    /// A/T_c.
    shift_per_k: [f64; L],
    half_width_k: [f64; L],
}

impl<const L: usize> Lanes<L> {
    /// c T_c.
    #[inline(always)]
    fn place_k(&self, lane: usize, before: f64, driving_degc: f64) -> f64 {
        play(before, driving_degc, self.half_width_k[lane]) - driving_degc
    }
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_of_the_rod!();
    const STANDS_IN_ZONE: bool = true;
    type Zone = [f64; L];
    const IMPLICIT: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let mut shift_per_k = [0.0; L];
        for l in 0..L {
            let of_loop = &base.params[l].limiting_loop;
            let spread = FRAC_PI_2 * of_loop.loop_spread_k / of_loop.loop_half_width_k;
            shift_per_k[l] = values[l].loop_asymmetry.loop_asymmetry * spread.min(1.0);
        }
        Self {
            shift_per_k,
            half_width_k: base.params.map(|lane| lane.limiting_loop.loop_half_width_k),
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
            let place_k = self.place_k(l, zone[l], to.driving_degc[l]);
            // Inside the play the driven side rests.
            let moves = place_k.abs() < self.half_width_k[l];
            let place_per_k = if moves { -1.0 } else { 0.0 };
            let side = 2.0 * to.transformed[l] - 1.0;
            shift.kelvin[l] += self.shift_per_k[l] * (place_k * side);
            shift.per_k[l] +=
                self.shift_per_k[l] * (place_per_k * side + place_k * (2.0 * to.slope_per_k[l]));
        }
    }

    #[inline(always)]
    fn commit(&self, zone: &mut [f64; L], _: &Before<L>, to: &Trial<L>) {
        for l in 0..L {
            zone[l] = play(zone[l], to.driving_degc[l], self.half_width_k[l]);
        }
    }
}
