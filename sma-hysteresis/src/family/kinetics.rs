//! Cosine kinetics.

use core::f64::consts::FRAC_PI_2;

use super::{Along, Bends, Transforms, Way, of};
use crate::elementary::sin_quarter;
use crate::limiting_loop::LimitingLoop;

/// Half of the range of a transformation over h_0.
const HALF_RANGE: f64 = 2.25;
/// Logarithm of 1 + k over ζ - ½ of kinetics.
const LOG_SKEW: f64 = 6.0;

/// Cosine kinetics of lanes side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Kinetics<const L: usize> {
    /// δ T̂ of start and finish of the transformation on heating and on cooling, K.
    start_k: [[f64; L]; 2],
    finish_k: [[f64; L]; 2],
    /// k.
    skew: [f64; L],
    /// s.
    sharpness: [f64; L],
    bends: Bends<L>,
}

impl<const L: usize> Kinetics<L> {
    pub(super) fn new(limits: &LimitingLoop<L>, zeta: [f64; L]) -> Self {
        let lanes = |sign: f64, side: f64| {
            core::array::from_fn(|lane| {
                let half_k = HALF_RANGE * limits.spread_k(lane) * limits.widening(lane, sign);
                limits.half_width_k(lane) + side * half_k
            })
        };
        Self {
            start_k: [lanes(1.0, -1.0), lanes(-1.0, -1.0)],
            finish_k: [lanes(1.0, 1.0), lanes(-1.0, 1.0)],
            skew: zeta.map(|zeta| libm::expm1(LOG_SKEW * (zeta - 0.5))),
            sharpness: [0.0; L],
            bends: Bends::NONE,
        }
    }

    pub(super) fn with_onset(self, sharpness: [f64; L]) -> Self {
        Self { sharpness, ..self }
    }

    pub(super) fn with_bends(self, bends: Bends<L>) -> Self {
        Self { bends, ..self }
    }
}

impl<const L: usize> Transforms<L> for Kinetics<L> {
    #[inline(always)]
    fn along(&self, lane: usize, sign: f64, start_k: f64) -> Along {
        /// Inverse of no range at all, 1/K: all happens at once.
        const AT_ONCE: f64 = 1e300;
        let onset_k = of(&self.start_k, sign, lane).max(sign * start_k);
        let range_k = of(&self.finish_k, sign, lane) - onset_k;
        Along {
            fixed: onset_k,
            scale: if range_k > 0.0 {
                1.0 / range_k
            } else {
                AT_ONCE
            },
            further: 0.0,
        }
    }

    #[inline(always)]
    fn way(&self, lane: usize, sign: f64, along: &Along, temperature_k: f64) -> Way {
        let progress = (sign * temperature_k - along.fixed) * along.scale;
        // Written so that NaN passes.
        let progress = if progress < 0.0 { 0.0 } else { progress };
        let progress = if progress > 1.0 { 1.0 } else { progress };
        let skew = self.skew[lane];
        let per = 1.0 / (1.0 + skew * progress);
        let skewed = (1.0 + skew) * progress * per;
        let angle = FRAC_PI_2 * skewed;
        let (sine, cosine) = (sin_quarter(angle), sin_quarter(FRAC_PI_2 - angle));
        let sharpness = self.sharpness[lane];
        let risen = sine * (sine + sharpness * (1.0 - sine));
        let steepness = sine + sharpness * (0.5 - sine);
        // Beyond the finish the cosine is 0 to rounding, times any scale; before a sharp onset the formula has a slope.
        let is_idle = (progress <= 0.0) | (progress >= 1.0);
        let stretched = (1.0 + skew) * per * per;
        let slope_per_k = 2.0 * FRAC_PI_2 * along.scale * stretched * steepness * cosine;
        let (share, slope) = self.bends.bent(lane, 1.0, risen);
        (share, if is_idle { 0.0 } else { slope_per_k * slope })
    }
}
