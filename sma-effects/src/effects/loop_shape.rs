use crate::effect::{Base, Effect, Mapped, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Presence, Smoothness};
use crate::loop_scale::LoopScale;
use crate::{EffectParameter, EffectValues};

const fn coefficient() -> EffectParameter {
    EffectParameter::size("1", 0.1, [-0.3, 0.3])
}

parameters! {
    /// The curves of the loop are no arc tangents.
    ///
    /// ```text
    /// p' = p + Σ_k c_k φ_k(p),   φ_k' = P_k(1 - 2p)
    /// φ_1 = p(1 - p),   φ_2 = p(1 - p)(1 - 2p),   φ_3 = p(1 - p)(5(1 - 2p)² - 1)/4
    /// ```
    ///
    /// P_k are Legendre's polynomials, at most 1 in magnitude: with Σ|c_k| < 1 the new share rises wherever
    /// the old one does. Both ends stay. All that depends on the fraction sees the new one; in the
    /// displacement alone, c_1 and c_2 are the sensor's nonlinearity under another name.
    LoopShape {
        /// Skew c_1: more of the transformation at the cold end; -0.3 to 0.3.
        loop_shape_1: coefficient(),
        /// Symmetric bend c_2: more of it at both ends; -0.3 to 0.3.
        loop_shape_2: coefficient(),
        /// Third bend c_3; -0.3 to 0.3.
        loop_shape_3: coefficient(),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "loop-shape",
    name: "another shape of the loop",
    block: EffectBlock::Transformation,
    flexible: true,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "ξ' = ξ + c_1 φ_1(ξ) + c_2 φ_2(ξ) + c_3 φ_3(ξ)",
    sentence: "the loop's curves are bent by up to {value} of their slope",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[],
    names_loop_families: true,
    like_loop: true,
    ..EffectInfo::ORDINARY
};

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    bend: [[f64; L]; 3],
    scale: LoopScale<L>,
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();
    const CHANGES_FRACTION: bool = true;

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        Self {
            bend: [
                values.each_ref().map(|lane| lane.loop_shape.loop_shape_1),
                values.each_ref().map(|lane| lane.loop_shape.loop_shape_2),
                values.each_ref().map(|lane| lane.loop_shape.loop_shape_3),
            ],
            scale: LoopScale::new(base.params),
        }
    }

    #[inline(always)]
    fn fraction(&self, _: &(), _: &[f64; L], mapped: &mut Mapped<L>) {
        let [skew, bend, third] = &self.bend;
        for l in 0..L {
            let p = self.scale.transformed(l, mapped.fraction[l]);
            let x = 1.0 - 2.0 * p;
            let square = x * x;
            let bulge = p * (1.0 - p);
            let added = bulge * (skew[l] + bend[l] * x + third[l] * (1.25 * square - 0.25));
            let slope = skew[l] * x
                + bend[l] * (1.5 * square - 0.5)
                + third[l] * (x * (2.5 * square - 1.5));
            mapped.fraction[l] += self.scale.span[l] * added;
            mapped.slope_per_k[l] += mapped.slope_per_k[l] * slope;
        }
    }
}
