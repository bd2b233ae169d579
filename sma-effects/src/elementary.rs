//! `ln` and `e^y - 1` as polynomials: plain arithmetic for lanes, equal bits on every host.

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
const EXPONENTIAL: [f64; 13] = [
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
pub(crate) fn ln(x: f64) -> f64 {
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
    let mut sum = LOGARITHM[LOGARITHM.len() - 1];
    for k in (0..LOGARITHM.len() - 1).rev() {
        sum = sum * square + LOGARITHM[k];
    }
    k * LN_2_HIGH + (2.0 * z + (2.0 * z * square * sum + k * LN_2_LOW))
}

/// e^y - 1 for |y| ≤ 700, error ≤ 4e-16 of the larger of result and 1, exactly 0 at 0.
///
/// ```text
/// y = k ln 2 + r,   |r| ≤ ln 2/2,   e^y - 1 = 2^k (r + r²/2! + r³/3! + …) + (2^k - 1)
/// ```
#[inline(always)]
pub(crate) fn expm1(y: f64) -> f64 {
    let rounded = y * core::f64::consts::LOG2_E + ROUND;
    let k = rounded - ROUND;
    let r = (y - k * LN_2_HIGH) - k * LN_2_LOW;
    let mut sum = EXPONENTIAL[EXPONENTIAL.len() - 1];
    for k in (0..EXPONENTIAL.len() - 1).rev() {
        sum = sum * r + EXPONENTIAL[k];
    }
    // The integer k stands in the lowest bits of `rounded`; moved into the exponent it makes 2^k.
    let power = f64::from_bits((rounded.to_bits() << 52).wrapping_add(1.0f64.to_bits()));
    power * (r * sum) + (power - 1.0)
}

/// (e^x - 1)/x, 1 at x = 0 and 0 at -∞: the mean of e^(xs) over s from 0 to 1.
pub(crate) fn mean_exponential(x: f64) -> f64 {
    // Below, the quotient is 1 + x/2 to the last bit.
    const TINY: f64 = 1e-9;
    if x.abs() < TINY {
        1.0 + 0.5 * x
    } else {
        libm::expm1(x) / x
    }
}

#[cfg(test)]
mod tests {
    use super::{expm1, ln};

    #[test]
    fn ln_and_expm1_agree_with_the_library() {
        for k in -4000..4000 {
            let x = libm::exp(f64::from(k) * 0.01);
            let error = (ln(x) - libm::log(x)).abs();
            assert!(
                error <= 4e-16 * libm::log(x).abs().max(1e-300),
                "{x} {error}"
            );
        }
        for k in -40_000..40_000 {
            let y = f64::from(k) * 5e-4;
            let error = (expm1(y) - libm::expm1(y)).abs();
            assert!(
                error <= 4e-16 * libm::expm1(y).abs().max(1.0),
                "{y} {error}"
            );
        }
        for y in [1e-3, 1e-9, 1e-15, -1e-12] {
            let error = (expm1(y) - libm::expm1(y)).abs();
            assert!(error <= 4e-16 * y.abs(), "{y} {error}");
        }
        assert_eq!(expm1(0.0).to_bits(), 0);
        assert_eq!(ln(1.0).abs().to_bits(), 0);
    }
}
