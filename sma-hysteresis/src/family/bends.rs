//! Bends of the course of a transformation.

use super::Way;

/// Bends of the course of a transformation, of lanes side by side.
///
/// ```text
/// p' = p + Σ_k c_k φ_k(p),   φ_k' = P_k(1 - 2p)
/// φ_1 = p(1 - p),   φ_2 = p(1 - p)(1 - 2p),   φ_3 = p(1 - p)(5(1 - 2p)² - 1)/4
/// ```
///
/// P_k are Legendre's polynomials, from -1 to 1, and P_2 from -½: with |c_1| + max(-c_2, c_2/2) + |c_3| ≤ 1 a course that rises goes
/// on rising.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bends<const L: usize>(pub(super) [[f64; L]; 3]);

impl<const L: usize> Bends<L> {
    pub(super) const NONE: Self = Self([[0.0; L]; 3]);

    /// p' of a course p that rises (`sign` = 1) or falls (-1) while a transformation goes on, and dp'/dp.
    #[inline(always)]
    pub(super) fn bent(&self, lane: usize, sign: f64, p: f64) -> Way {
        // A lane's own by its place: copied out as an array they would keep the lanes from being computed side by side.
        let Self([skew, bend, third]) = self;
        // Of a course that falls, 1 - p is what has been gone: odd terms change their sign.
        let (skew, bend, third) = (sign * skew[lane], bend[lane], sign * third[lane]);
        let x = 1.0 - 2.0 * p;
        let square = x * x;
        let added = p * (1.0 - p) * (skew + bend * x + third * (1.25 * square - 0.25));
        let slope = skew * x + bend * (1.5 * square - 0.5) + third * (x * (2.5 * square - 1.5));
        (p + added, 1.0 + slope)
    }
}
