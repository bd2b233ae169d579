//! `sin` and `atan` as polynomials: equal bits on every host, and plain arithmetic that a compiler
//! turns into vector instructions when many models run in lockstep.
//!
//! No fused multiply-add anywhere: with it the bits would depend on the instruction set, and
//! hardware without it would run it in software.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_8};

/// Coefficients of (sin x / x - 1) / x² in x², near-minimax on \[0, π/2\]; truncation 7e-16.
const SIN: [f64; 7] = [
    -0.1666666666666665,
    0.008333333333325933,
    -0.00019841269836469024,
    2.7557318055685783e-06,
    -2.505197292154555e-08,
    1.6050972244135636e-10,
    -7.40805488954261e-13,
];

/// Coefficients of (atan z / z - 1) / z² in z², near-minimax on |z| ≤ tan(π/8); truncation 6e-17.
const ATAN: [f64; 10] = [
    -0.3333333333333325,
    0.19999999999898407,
    -0.1428571426609662,
    0.11111109636534361,
    -0.09090852557176049,
    0.0769105515839315,
    -0.06649613695291669,
    0.05736332165907643,
    -0.04483334622272886,
    0.02275052699336167,
];

/// tan(π/8), the middle of the octant that [`atan`] reduces to.
const TAN_FRAC_PI_8: f64 = 0.41421356237309503;

/// Even and odd powers by Horner's rule apart: two chains of half the length, which the processor runs
/// side by side.
#[inline(always)]
fn polynomial<const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    let square = x * x;
    let mut sums = [0.0, 0.0];
    let mut k = N;
    while k > 0 {
        k -= 1;
        sums[k % 2] = if k + 2 < N {
            sums[k % 2] * square + coefficients[k]
        } else {
            coefficients[k]
        };
    }
    sums[0] + x * sums[1]
}

/// sin x for x in \[0, π/2\], absolute error ≤ 2e-15.
///
/// Outside that quarter the polynomial is not the sine; `NaN` gives `NaN`.
#[inline(always)]
#[must_use]
pub fn sin_quarter(x: f64) -> f64 {
    let square = x * x;
    x + x * square * polynomial(&SIN, square)
}

/// atan x for every x, infinities included, absolute error ≤ 2e-15; `NaN` gives `NaN`.
#[inline(always)]
#[must_use]
pub fn atan(x: f64) -> f64 {
    atan_quotient(x, 1.0)
}

/// atan(a/b) for b > 0 with the quotient never formed: one division instead of two.
///
/// Folded to p/q ≤ 1 and turned by π/8:
///
/// ```text
/// p/q = |a|/b or b/|a|,   z = (p - q tan(π/8)) / (q + p tan(π/8)),   atan(p/q) = π/8 + atan z
/// ```
#[inline(always)]
pub(crate) fn atan_quotient(a: f64, b: f64) -> f64 {
    // Keeps ∞/∞ out; atan is π/2 to the last bit from far below this.
    const FLAT: f64 = 1e300;
    let size = if a.abs() > FLAT { FLAT } else { a.abs() };
    // Three plain selections: a common branch would be compiled into two divisions.
    let p = if size < b { size } else { b };
    let q = if size < b { b } else { size };
    let z = (p - TAN_FRAC_PI_8 * q) / (q + TAN_FRAC_PI_8 * p);
    let square = z * z;
    let octant = FRAC_PI_8 + (z + z * square * polynomial(&ATAN, square));
    (if size > b { FRAC_PI_2 - octant } else { octant }).copysign(a)
}
