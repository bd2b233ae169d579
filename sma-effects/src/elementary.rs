//! Functions that effects need beside the polynomials of the hysteresis.

pub(crate) use wiener::hysteresis::{expm1, ln};

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
