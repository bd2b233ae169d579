use crate::effect::{
    Base, Before, Effect, Shift, Standing, Trial, ZoneStart, without_memory_of_the_rod,
};
use crate::info::{Belongs, EffectBlock, EffectInfo, Occurrence, Presence, Smoothness};
use crate::loop_scale::LoopScale;
use crate::{EffectId, EffectParameter, EffectValues};

parameters! {
    /// The loop drifts with the transformations that the rod has gone through, and the stroke with it, less and less.
    ///
    /// ```text
    /// ξ = loop(T - a s),   u → u (1 - b s),   s = (1 - exp(-k n))/(1 - exp(-k)),   n = ½ ∫|dp|
    /// ```
    ///
    /// n counts full cycles from the start of the recording, partial ones by their path; s is 1 after the first. Earlier
    /// cycles of the rod are contained in a and b: this law knows only the cycles to come. Nothing drifts at rest, which
    /// distinguishes it from ambient drift.
    FunctionalFatigue {
        /// Shift of the loop by the first cycle a, K; -5 to 5.
        fatigue_k: EffectParameter::size("K", 1.0, [-5.0, 5.0])
            .unchecked([0.1, 3.6], "10 to 20 K over 100 to 10,000 cycles: at the typical rate 0.18 of it in the first")
            .scaled_by_heat(-1),
        /// Loss of stroke by the first cycle b, share of it; -0.2 to 0.2.
        fatigue_stroke_loss: EffectParameter::size("1", 0.01, [-0.2, 0.2])
            .unchecked([0.004, 0.045], "0.1 to 1 % of strain, of some 4 %, over these cycles: 0.18 of it in the first"),
        /// Rate at which it fades k, 1/cycle; 0, where it never does, to 1. A partner.
        fatigue_fading: EffectParameter::partner("1/cycle", 0.2, [0.0, 1.0], &[0.0, 0.05, 0.1, 0.2, 0.5]),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "functional-fatigue",
    name: "functional fatigue",
    block: EffectBlock::Transformation,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "ξ = loop(T - a s),  u' = u (1 - b s),  s = (1 - exp(-k n))/(1 - exp(-k)),  n cycles so far",
    sentence: "the loop and its stroke drift with the number of cycles, by {value} in the first, fading at {partner}",
    belongs_to: Belongs::History,
    presence: Presence::Seldom,
    // Where it does not fade and takes no stroke; at rest only the surroundings go on.
    acts_like: &[EffectId::AmbientDrift],
    needs_in_recording: &[Occurrence::SecondCycle],
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    shift_k: [f64; L],
    loss: [f64; L],
    fading: [f64; L],
    /// ds/dn at first: k/(1 - exp(-k)).
    first: [f64; L],
    scale: LoopScale<L>,
}

/// How far the drift of a zone has come.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Come<const L: usize> {
    /// s.
    come: [f64; L],
    /// ds/dn over the first: exp(-k n).
    rate: [f64; L],
}

/// exp(-x) and (1 - exp(-x))/x for 0 ≤ x ≤ ½, error ≤ 1e-7; for the x ≤ 0.1 of a sample ≤ 1e-11 (Padé, of order 3 by 3).
#[inline(always)]
fn decay(x: f64) -> (f64, f64) {
    let even = 120.0 + 12.0 * x * x;
    let odd = 60.0 + x * x;
    let all = even + x * odd;
    ((even - x * odd) / all, 2.0 * odd / all)
}

impl<const L: usize> Lanes<L> {
    /// Increase of s by transformations, and the rate after them.
    #[inline(always)]
    fn added(&self, l: usize, zone: &Come<L>, change: f64) -> (f64, f64) {
        let cycles = 0.5 * change.abs();
        let (rate, mean) = decay(self.fading[l] * cycles);
        let before = self.first[l] * zone.rate[l];
        (before * mean * cycles, zone.rate[l] * rate)
    }
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_of_the_rod!();
    const STANDS_IN_ZONE: bool = true;
    type Zone = Come<L>;
    const SHOWS: bool = true;
    const SHIFTS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let fading = values
            .each_ref()
            .map(|lane| lane.functional_fatigue.fatigue_fading);
        Self {
            shift_k: values
                .each_ref()
                .map(|lane| lane.functional_fatigue.fatigue_k),
            loss: values
                .each_ref()
                .map(|lane| lane.functional_fatigue.fatigue_stroke_loss),
            fading,
            first: fading.map(|k| if k > 0.0 { -k / libm::expm1(-k) } else { 1.0 }),
            scale: LoopScale::new(base.params),
        }
    }

    fn zone(&self, _: &ZoneStart<L>) -> Come<L> {
        Come {
            come: [0.0; L],
            rate: [1.0; L],
        }
    }

    #[inline(always)]
    fn shift(&self, zone: &Come<L>, from: &Before<L>, to: &Trial<L>, shift: &mut Shift<L>) {
        for l in 0..L {
            let change = to.transformed[l] - from.transformed[l];
            let (added, rate) = self.added(l, zone, change);
            shift.kelvin[l] += self.shift_k[l] * (zone.come[l] + added);
            let direction = if change < 0.0 { -0.5 } else { 0.5 };
            shift.per_k[l] +=
                self.shift_k[l] * (direction * to.slope_per_k[l] * self.first[l] * rate);
        }
    }

    #[inline(always)]
    fn commit(&self, zone: &mut Come<L>, from: &Before<L>, to: &Trial<L>) {
        for l in 0..L {
            let change = to.transformed[l] - from.transformed[l];
            let (added, rate) = self.added(l, zone, change);
            zone.come[l] += added;
            zone.rate[l] = rate;
        }
    }

    #[inline(always)]
    fn stroke(&self, zone: &Come<L>, at: &Standing<L>, fraction: &mut [f64; L]) {
        for l in 0..L {
            let lost = self.loss[l] * zone.come[l];
            fraction[l] -= lost * (self.scale.span[l] * at.transformed[l]);
        }
    }
}
