use core::f64::consts::FRAC_PI_2;

use crate::HysteresisError;
use crate::elementary::sin_quarter;
use crate::error::monotone_rate;

/// How the distance to the limiting curve fades along a branch: the proximity function P(x).
///
/// x = 0 at the reversal and grows along the branch in units of the proximity temperature. The
/// operator only needs 1 - P and its derivative, over which it keeps its promises (continuity at a
/// reversal, monotone branches, no branch outside the limiting loop) if, for x ≥ 0,
///
/// ```text
/// 1 - P(0) = 0 exactly,   0 ≤ -P'(x) ≤ 1,   P(x) → 0
/// ```
///
/// Implement it with `#[inline(always)]` and without branches on `x`, or lanes lose their speed.
pub trait Proximity {
    /// 1 - P(x) in lane `lane`; x ≥ 0, ∞ included; `NaN` gives `NaN`.
    fn decay(&self, lane: usize, x: f64) -> f64;
    /// d(1 - P)/dx in lane `lane`; x ≥ 0, ∞ included.
    fn decay_slope(&self, lane: usize, x: f64) -> f64;
}

/// The paper's proximity function.
///
/// ```text
/// P(x) = 1 - sin ζx for ζx < π/2, else 0     [Sadeghi, eq. 12]
/// ```
///
/// # Differs from the source
///
/// Eq. 12 leaves ζx = π/2 undefined; both pieces give 0 there. ζx is clamped to \[0, π/2\], which *is*
/// the second piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineProximity<const L: usize> {
    zeta: [f64; L],
}

impl<const L: usize> SineProximity<L> {
    /// Takes ζ of each lane.
    ///
    /// # Errors
    ///
    /// [`HysteresisError::NotMonotone`] unless 0 < ζ ≤ 1: the slope along a branch is proportional to
    /// 1 - ζ cos ζx.
    pub fn new(zeta: [f64; L]) -> Result<Self, HysteresisError> {
        for &value in &zeta {
            monotone_rate("zeta", value)?;
        }
        Ok(Self { zeta })
    }

    pub(crate) fn zeta(&self) -> [f64; L] {
        self.zeta
    }

    #[inline(always)]
    fn angle(&self, lane: usize, x: f64) -> f64 {
        let angle = self.zeta[lane] * x;
        // Written so that NaN passes through both.
        let angle = if angle < 0.0 { 0.0 } else { angle };
        if angle > FRAC_PI_2 { FRAC_PI_2 } else { angle }
    }
}

impl<const L: usize> Proximity for SineProximity<L> {
    #[inline(always)]
    fn decay(&self, lane: usize, x: f64) -> f64 {
        sin_quarter(self.angle(lane, x))
    }

    #[inline(always)]
    fn decay_slope(&self, lane: usize, x: f64) -> f64 {
        // cos a = sin(π/2 - a): one polynomial serves both, and the slope is exactly 0 at the end.
        self.zeta[lane] * sin_quarter(FRAC_PI_2 - self.angle(lane, x))
    }
}

/// A smooth proximity function without an end: the branch nears the limiting curve and never quite
/// joins it.
///
/// ```text
/// P(x) = exp(-βx)
/// ```
///
/// Not from the paper: for materials whose branches have no corner, and as the model of how to plug
/// in one's own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExponentialProximity<const L: usize> {
    rate: [f64; L],
}

impl<const L: usize> ExponentialProximity<L> {
    /// Takes β of each lane.
    ///
    /// # Errors
    ///
    /// [`HysteresisError::NotMonotone`] unless 0 < β ≤ 1: the slope along a branch is 1 - β exp(-βx).
    pub fn new(rate: [f64; L]) -> Result<Self, HysteresisError> {
        for &value in &rate {
            monotone_rate("rate", value)?;
        }
        Ok(Self { rate })
    }
}

impl<const L: usize> Proximity for ExponentialProximity<L> {
    #[inline(always)]
    fn decay(&self, lane: usize, x: f64) -> f64 {
        -libm::expm1(-self.rate[lane] * x)
    }

    #[inline(always)]
    fn decay_slope(&self, lane: usize, x: f64) -> f64 {
        self.rate[lane] * libm::exp(-self.rate[lane] * x)
    }
}
