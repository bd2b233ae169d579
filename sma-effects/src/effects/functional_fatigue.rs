use crate::EffectValues;
use crate::effect::{
    Base, Before, Effect, Shift, Standing, Trial, ZoneStart, without_memory_of_the_rod,
};
use crate::info::{EffectBlock, EffectInfo, EffectParameter, Smoothness};
use crate::loop_scale::LoopScale;

parameters! {
    /// The loop drifts with the transformations that the rod has gone through, and the stroke with it.
    ///
    /// ```text
    /// ξ = loop(T - a s),   u → u (1 - b s),   s = ln((1 + n)/(1 + n_0)),   n = n_0 + ½ ∫|dp|
    /// ```
    ///
    /// n counts full cycles, partial ones by their path; n_0 is the setting's `cycles_before`. Nothing
    /// drifts at rest, which tells it from ambient drift.
    FunctionalFatigue {
        /// Shift of the loop per natural logarithm of the cycle count a, K; -8 to 8.
        fatigue_k: EffectParameter::size("K", 1.0, [-8.0, 8.0])
            .unchecked([1.0, 4.0], "10 to 20 K over 100 to 10,000 cycles"),
        /// Loss of stroke b, share of it per natural logarithm of the cycle count; -0.2 to 0.2.
        fatigue_stroke_loss: EffectParameter::size("1", 0.01, [-0.2, 0.2]),
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
    equation: "ξ = loop(T - a s),  u' = u (1 - b s),  s = ln((1 + n)/(1 + n_0)),  n cycles so far",
    sentence: "the loop and its stroke drift with the number of cycles, by {value} for each factor of 2.7",
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    per_log_k: [f64; L],
    loss_per_log: [f64; L],
    scale: LoopScale<L>,
    cycles_before: f64,
}

/// How often the rod has transformed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Path<const L: usize> {
    /// 1 + n.
    cycles: [f64; L],
    /// ln((1 + n)/(1 + n_0)).
    log: [f64; L],
}

/// ln(1 + x) for 0 ≤ x ≤ ½, error ≤ 1e-14 for the x ≤ 0.1 of a sample.
///
/// ```text
/// ln(1 + x) = 2 (z + z³/3 + z⁵/5 + …),   z = x/(2 + x)
/// ```
#[inline(always)]
fn log_step(x: f64) -> f64 {
    let z = x / (2.0 + x);
    let square = z * z;
    let sum = 1.0 / 3.0
        + square * (1.0 / 5.0 + square * (1.0 / 7.0 + square * (1.0 / 9.0 + square / 11.0)));
    2.0 * (z + z * square * sum)
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory_of_the_rod!();
    const STANDS_IN_ZONE: bool = true;
    type Zone = Path<L>;
    const IMPLICIT: bool = true;
    const SHOWS: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        Self {
            per_log_k: values.map(|lane| lane.functional_fatigue.fatigue_k),
            loss_per_log: values.map(|lane| lane.functional_fatigue.fatigue_stroke_loss),
            scale: LoopScale::new(base.params),
            cycles_before: base.setting.cycles_before,
        }
    }

    fn zone(&self, _: &ZoneStart<L>) -> Path<L> {
        Path {
            cycles: [1.0 + self.cycles_before; L],
            log: [0.0; L],
        }
    }

    #[inline(always)]
    fn shift(&self, zone: &Path<L>, from: &Before<L>, to: &Trial<L>, shift: &mut Shift<L>) {
        for l in 0..L {
            let change = to.transformed[l] - from.transformed[l];
            let added = 0.5 * change.abs();
            let log = zone.log[l] + log_step(added / zone.cycles[l]);
            shift.kelvin[l] += self.per_log_k[l] * log;
            let direction = if change < 0.0 { -0.5 } else { 0.5 };
            shift.per_k[l] +=
                self.per_log_k[l] * (direction * to.slope_per_k[l] / (zone.cycles[l] + added));
        }
    }

    #[inline(always)]
    fn commit(&self, zone: &mut Path<L>, from: &Before<L>, to: &Trial<L>) {
        for l in 0..L {
            let added = 0.5 * (to.transformed[l] - from.transformed[l]).abs();
            zone.log[l] += log_step(added / zone.cycles[l]);
            zone.cycles[l] += added;
        }
    }

    #[inline(always)]
    fn stroke(&self, zone: &Path<L>, at: &Standing<L>, fraction: &mut [f64; L]) {
        for l in 0..L {
            let lost = self.loss_per_log[l] * zone.log[l];
            fraction[l] -= lost * (self.scale.span[l] * at.transformed[l]);
        }
    }
}
