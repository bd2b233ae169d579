use core::f64::consts::FRAC_1_PI;

use wiener::hysteresis::atan;

use crate::effect::{Base, Before, Effect, Standing, Trial, ZoneStart, without_memory_of_the_rod};
use crate::info::{Belongs, EffectBlock, EffectInfo, Occurrence, Presence, Smoothness};
use crate::loop_scale::LoopScale;
use crate::play::{play, play_at};
use crate::{EffectParameter, EffectValues};

/// Half of the width of the R-phase's own loop, K: 3 K in all, of 1.5 to 5 K in the literature (unchecked).
const HALF_WIDTH_K: f64 = 1.5;
parameters! {
    /// Austenite first becomes R-phase on cooling, and gives back a part of the stroke.
    ///
    /// ```text
    /// stroke share = p (1 - r (1 - ρ(v))),   v = play of ±1.5 K on T
    /// ρ = ½ + atan((v - T_R)/h)/π,   T_R = T_mid - T_c + d
    /// ```
    ///
    /// Only what is austenite can be R-phase, so the step shows where austenite is cold: on cooling, d
    /// above the middle of the martensite curve. On heating it shows only so far as austenite forms below
    /// T_R, hardly at all while d is below 2 T_c. Its loop is narrow, smooth and without memory of inner
    /// reversals. Left out: its heat, its resistance, its own dependence on stress.
    RPhase {
        /// Share of the stroke that the R-phase gives back r; 0 to 0.5. Its strain is 0.5 to 1 % where it forms: a quarter
        /// of the rod is the least that is worth the name.
        r_phase_share: EffectParameter::size("1", 0.1, [0.0, 0.5])
            .unchecked([0.1, 0.25], "0.5 to 1 % of strain, of some 4 %")
            .at_least(0.03),
        /// Its temperature above the middle of the cooling curve d, K; -10 to 60. A partner: without a
        /// share it does nothing.
        r_phase_above_k: EffectParameter::partner("K", 15.0, [-10.0, 60.0], &[2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 40.0])
            .scaled_by_heat(-1),
        /// Spread of its loop h, K, as that of the main one in eq. 4; 0.3 to 4. A partner: without a share it does nothing.
        r_phase_spread_k: EffectParameter::partner("K", 1.5, [0.3, 4.0], &[])
            .scaled_by_heat(-1),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "r-phase",
    name: "R-phase",
    block: EffectBlock::Transformation,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "y = gain ξ (1 - r (1 - ρ(T))),  ρ = ½ + atan((T - T_R)/h)/π",
    sentence: "on cooling, {value} of the stroke is given back early, {partner} above the main transformation",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    // On heating alone it is hardly to be told from the loop's own curve.
    needs_in_recording: &[Occurrence::Cooling],
    like_loop: true,
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    share: [f64; L],
    middle_degc: [f64; L],
    spread_k: [f64; L],
    scale: LoopScale<L>,
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_of_the_rod!();
    const STANDS_IN_ZONE: bool = true;
    type Zone = [f64; L];
    const SHOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let mut middle_degc = [0.0; L];
        for l in 0..L {
            let of_loop = &base.params[l].limiting_loop;
            middle_degc[l] = of_loop.loop_center_degc - of_loop.loop_half_width_k
                + values[l].r_phase.r_phase_above_k;
        }
        Self {
            share: values.each_ref().map(|lane| lane.r_phase.r_phase_share),
            middle_degc,
            spread_k: values.each_ref().map(|lane| lane.r_phase.r_phase_spread_k),
            scale: LoopScale::new(base.params),
        }
    }

    fn zone(&self, start: &ZoneStart<L>) -> [f64; L] {
        core::array::from_fn(|l| play_at(start.driving_degc[l], HALF_WIDTH_K, start.share[l]))
    }

    #[inline(always)]
    fn commit(&self, zone: &mut [f64; L], _: &Before<L>, to: &Trial<L>) {
        for l in 0..L {
            zone[l] = play(zone[l], to.temperature_degc[l], HALF_WIDTH_K);
        }
    }

    #[inline(always)]
    fn stroke(&self, zone: &[f64; L], at: &Standing<L>, fraction: &mut [f64; L]) {
        for l in 0..L {
            let driven_degc = play(zone[l], at.temperature_degc[l], HALF_WIDTH_K);
            let above = (driven_degc - self.middle_degc[l]) / self.spread_k[l];
            let given_back = 0.5 - atan(above) * FRAC_1_PI;
            fraction[l] -= self.share[l] * (self.scale.span[l] * at.transformed[l] * given_back);
        }
    }
}
