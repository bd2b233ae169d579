//! `sin`, `atan`, `ln`, `e^y - 1` and `√` as polynomials: equal bits on every host, and plain arithmetic that a compiler
//! turns into vector instructions when many models run in lockstep.
//!
//! No fused multiply-add anywhere: with it the bits would depend on the instruction set, and
//! hardware without it would run it in software.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_8};

/// Coefficients of (sin x / x - 1) / x² in x², near-minimax on \[0, π/2\]; truncation 7e-16.
pub const SIN_COEFFICIENTS: [f64; 7] = [
    -0.1666666666666665,
    0.008333333333325933,
    -0.00019841269836469024,
    2.7557318055685783e-06,
    -2.505197292154555e-08,
    1.6050972244135636e-10,
    -7.40805488954261e-13,
];

/// Coefficients of (atan z / z - 1) / z² in z², near-minimax on |z| ≤ tan(π/8); truncation 6e-17.
pub const ATAN_COEFFICIENTS: [f64; 10] = [
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
pub const TAN_FRAC_PI_8: f64 = 0.41421356237309503;

/// Even and odd powers by Horner's rule apart: two chains of half the length, which the processor runs
/// side by side.
#[inline(always)]
fn polynomial<const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    let square = x * x;
    horner(coefficients, (N - 1) / 2 * 2, square) + x * horner(coefficients, N / 2 * 2 - 1, square)
}

/// Sum of every second coefficient up to the one at `last`. Compilers unroll this loop wherever it stands; one loop over both sums they do not.
#[inline(always)]
fn horner<const N: usize>(coefficients: &[f64; N], last: usize, square: f64) -> f64 {
    let mut k = last;
    let mut sum = coefficients[k];
    while k >= 2 {
        k -= 2;
        sum = sum * square + coefficients[k];
    }
    sum
}

/// sin x for x in \[0, π/2\], absolute error ≤ 2e-15.
///
/// Outside that quarter the polynomial is not the sine; `NaN` gives `NaN`.
#[inline(always)]
#[must_use]
pub fn sin_quarter(x: f64) -> f64 {
    let square = x * x;
    x + x * square * polynomial(&SIN_COEFFICIENTS, square)
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
    let octant = FRAC_PI_8 + (z + z * square * polynomial(&ATAN_COEFFICIENTS, square));
    (if size > b { FRAC_PI_2 - octant } else { octant }).copysign(a)
}

/// 1.5 · 2⁵²: added and taken away again, it rounds to an integer, which stands in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts; the first has so few digits that its product with a small integer is exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// 1/3, 1/5, …: (artanh z / z - 1)/z² in z²; truncation 1e-16 for |z| ≤ 0.172.
const LOGARITHM: [f64; 9] = [
    1.0 / 3.0,
    1.0 / 5.0,
    1.0 / 7.0,
    1.0 / 9.0,
    1.0 / 11.0,
    1.0 / 13.0,
    1.0 / 15.0,
    1.0 / 17.0,
    1.0 / 19.0,
];

/// 1/1!, 1/2!, …: (e^r - 1)/r in r; truncation 1e-17 for |r| ≤ 0.347.
pub const EXPONENTIAL_COEFFICIENTS: [f64; 13] = [
    1.0,
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5_040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
    1.0 / 39_916_800.0,
    1.0 / 479_001_600.0,
    1.0 / 6_227_020_800.0,
];

/// ln x for finite normal x > 0, relative error ≤ 4e-16.
///
/// ```text
/// x = 2^k m,   √½ ≤ m < √2,   z = (m - 1)/(m + 1),   ln x = k ln 2 + 2 (z + z³/3 + z⁵/5 + …)
/// ```
#[inline(always)]
#[must_use]
pub fn ln(x: f64) -> f64 {
    // Bits of √½: what is above in steps of one exponent is k.
    const SQRT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    // 2⁵² + 2⁵¹ as bits: an integer below 2⁵¹ added to them is that integer added to the number.
    const INTEGER: u64 = 0x4338_0000_0000_0000;
    let bits = x.to_bits();
    let raised = bits.wrapping_sub(SQRT_HALF) & 0xfff0_0000_0000_0000;
    let m = f64::from_bits(bits.wrapping_sub(raised));
    let steps = ((raised as i64) >> 52) as u64;
    let k = f64::from_bits(INTEGER.wrapping_add(steps)) - ROUND;
    let z = (m - 1.0) / (m + 1.0);
    let square = z * z;
    let sum = polynomial(&LOGARITHM, square);
    k * LN_2_HIGH + (2.0 * z + (2.0 * z * square * sum + k * LN_2_LOW))
}

/// e^y - 1 for |y| ≤ 700, error ≤ 4e-16 of the larger of result and 1, exactly 0 at 0.
///
/// ```text
/// y = k ln 2 + r,   |r| ≤ ln 2/2,   e^y - 1 = 2^k (r + r²/2! + r³/3! + …) + (2^k - 1)
/// ```
#[inline(always)]
#[must_use]
pub fn expm1(y: f64) -> f64 {
    let rounded = y * core::f64::consts::LOG2_E + ROUND;
    let k = rounded - ROUND;
    let r = (y - k * LN_2_HIGH) - k * LN_2_LOW;
    let sum = polynomial(&EXPONENTIAL_COEFFICIENTS, r);
    // The integer k stands in the lowest bits of `rounded`; moved into the exponent it makes 2^k.
    let power = f64::from_bits((rounded.to_bits() << 52).wrapping_add(1.0f64.to_bits()));
    power * (r * sum) + (power - 1.0)
}

/// 1/√x for 1e-300 ≤ x ≤ 1e300, relative error ≤ 5e-16; finite at 0; `NaN` gives `NaN`.
///
/// ```text
/// y → y (3 - x y²)/2 from half of the bits of x
/// ```
///
/// The hardware's square root is one lane at a time where the standard library is not at hand.
#[inline(always)]
#[must_use]
pub fn inverse_sqrt(x: f64) -> f64 {
    /// Less half of the bits of x: those of 1/√x, to 3.5 %.
    const HALFWAY: u64 = 0x5fe6_ec85_e7de_30da;
    let half = 0.5 * x;
    let mut y = f64::from_bits(HALFWAY.wrapping_sub(x.to_bits() >> 1));
    for _ in 0..4 {
        // In this order nothing overflows at 0.
        y *= 1.5 - half * y * y;
    }
    y
}

/// x^(-1/4) for 1e-300 ≤ x ≤ 1e300, relative error ≤ 5e-16; `NaN` gives `NaN`.
///
/// ```text
/// y → y (5 - x y⁴)/4 from a quarter of the bits of x
/// ```
#[inline(always)]
#[must_use]
pub fn inverse_fourth_root(x: f64) -> f64 {
    /// Less a quarter of the bits of x: those of x^(-1/4), to 3.2 %.
    const FIVE_QUARTERS: u64 = 0x4feb_0c05_c3c6_0c5b;
    let quarter = 0.25 * x;
    let mut y = f64::from_bits(FIVE_QUARTERS.wrapping_sub(x.to_bits() >> 2));
    for _ in 0..4 {
        let square = y * y;
        y *= 1.25 - quarter * (square * square);
    }
    y
}
