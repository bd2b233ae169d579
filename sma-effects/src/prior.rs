//! Prior of the size of an effect, before any recording is looked at.

use core::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, LN_2};

use crate::{EffectParameter, Role};

/// Standard normal deviation of the 95 % quantile: a range of literature is the central 90 %.
const END_OF_RANGE: f64 = 1.644_853_626_951_472_2;
/// ln 3: one standard deviation where only a typical value is known.
const BY_TYPICAL: f64 = 1.098_612_288_668_109_8;
/// Least standard deviation of a range that was looked up: no size is known better than the specific heat that goes into
/// it, of which the literature of NiTi has 450 to 840 J/(kg K), a central 90 % of ln(840/450)/(2 · 1.645).
const LEAST: f64 = 0.19;
/// Least standard deviation of a range that nobody looked up, or that is in another unit than the value: a factor of two.
const LEAST_UNCHECKED: f64 = LN_2;

/// Prior density of a parameter, of the value itself rather than its logarithm.
///
/// ```text
/// ln p(v) - ln p(0) = 0                       |v| ≤ v_o
///                   = -(u²/2 + 1.645 u)       |v| > v_o,   u = ln(|v|/v_o)/s
///                   = -∞                      out of bounds
/// ```
///
/// Above the ordinary v_o it is the tail of a log-normal of spread s whose 95 % quantile v_o is. A literature range gives
/// v_o, its upper end, and s, since it counts as the central 90 %: s = ln(upper/lower)/(2 · 1.645), but at least 0.19, and
/// ln 2 if the range is unchecked. Without one the median is the typical value and s = ln 3, so that v_o is six times the
/// typical value. v_o is within the bounds.
///
/// Below v_o all values are alike, down to 0: data sheets and papers bound sizes from above ("nonlinearity at most 0.5 %"),
/// and report what was large enough to be measured; a small size is ordinary. Of a two-sided size the magnitude
/// counts. A partner is as likely everywhere within its bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizePrior {
    bounds: [f64; 2],
    ordinary: f64,
    spread: f64,
}

impl SizePrior {
    pub(crate) fn of(parameter: &EffectParameter, is_in_its_unit: bool) -> Self {
        let largest = parameter.largest();
        let (ordinary, spread) = match (parameter.role, parameter.literature) {
            (Role::Partner { .. }, _) => (largest, BY_TYPICAL),
            (Role::Size, Some(literature)) => {
                let [low, high] = literature.range;
                let least = if literature.checked && is_in_its_unit {
                    LEAST
                } else {
                    LEAST_UNCHECKED
                };
                let spread = libm::log(high / low) / (2.0 * END_OF_RANGE);
                (high, spread.max(least))
            }
            (Role::Size, None) => {
                let times = libm::exp(END_OF_RANGE * BY_TYPICAL);
                (times * parameter.typical.abs(), BY_TYPICAL)
            }
        };
        Self {
            bounds: parameter.bounds,
            ordinary: ordinary.min(largest),
            spread,
        }
    }

    /// Magnitude up to which all values are alike, in the parameter's unit.
    #[must_use]
    pub fn ordinary(&self) -> f64 {
        self.ordinary
    }

    /// Standard deviation of the logarithm of a size.
    #[must_use]
    pub fn spread(&self) -> f64 {
        self.spread
    }

    /// Natural logarithm of the density over that of its mode; 0 for what is ordinary, -∞ out of bounds and for NaN.
    #[must_use]
    pub fn ln_relative(&self, value: f64) -> f64 {
        let [lower, upper] = self.bounds;
        if !(lower..=upper).contains(&value) {
            return f64::NEG_INFINITY;
        }
        if value.abs() <= self.ordinary {
            return 0.0;
        }
        // u = beyond
        let beyond = libm::log(value.abs() / self.ordinary) / self.spread;
        -beyond * (0.5 * beyond + END_OF_RANGE)
    }

    /// Natural logarithm of the width that the density would have if it were the mode's throughout, in the parameter's
    /// unit: [`SizePrior::ln_relative`] minus this is the logarithm of the density, and a posterior's width over this
    /// one is an Occam factor.
    #[must_use]
    pub fn ln_width(&self) -> f64 {
        let [lower, upper] = self.bounds;
        let width = if lower > 0.0 || upper < 0.0 {
            (self.up_to(lower.abs()) - self.up_to(upper.abs())).abs()
        } else {
            self.up_to(-lower) + self.up_to(upper)
        };
        libm::log(width)
    }

    /// Integral of the relative density over magnitudes from 0 to one within the bounds.
    ///
    /// ```text
    /// v_o + ∫ e^{-u²/2 - z u} v_o s e^{s u} du = v_o + v_o s √(π/2) e^{c²/2} (erfc(c/√2) - erfc((c + u)/√2)),  c = z - s
    /// ```
    fn up_to(&self, magnitude: f64) -> f64 {
        if magnitude <= self.ordinary {
            return magnitude;
        }
        let beyond = libm::log(magnitude / self.ordinary) / self.spread;
        let c = END_OF_RANGE - self.spread;
        let share = libm::erfc(c * FRAC_1_SQRT_2) - libm::erfc((c + beyond) * FRAC_1_SQRT_2);
        let tail = self.spread * libm::sqrt(FRAC_PI_2) * libm::exp(0.5 * c * c) * share;
        self.ordinary * (1.0 + tail)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::EffectId;

    fn sizes() -> impl Iterator<Item = &'static EffectParameter> {
        let all = EffectId::ALL.into_iter();
        all.flat_map(|effect| effect.info().parameters)
            .filter(|parameter| parameter.role == Role::Size)
    }

    /// `exp(ln_relative)` by the rule of the middles, on steps that grow with the value.
    fn by_sum(prior: &SizePrior, magnitude: f64) -> f64 {
        const STEPS: usize = 200_000;
        let place = |k: f64| magnitude * (k / STEPS as f64).powi(3);
        let of_step = |k: usize| {
            let middle = place(k as f64 + 0.5);
            prior.ln_relative(middle).exp() * (place(k as f64 + 1.0) - place(k as f64))
        };
        (0..STEPS).map(of_step).sum()
    }

    #[test]
    fn the_width_is_the_integral_of_the_density() {
        for parameter in sizes() {
            let prior = parameter.prior();
            let [lower, upper] = parameter.bounds;
            let sides = if lower < 0.0 { 2.0 } else { 1.0 };
            let (sum, width) = (sides * by_sum(&prior, upper), prior.ln_width().exp());
            let name = parameter.name;
            assert!((sum / width - 1.0).abs() < 1e-6, "{name} {sum} {width}");
        }
    }

    #[test]
    fn the_width_of_bounds_beside_zero_is_that_between_them() {
        let partner = EffectParameter::partner("K", 2.0, [0.5, 4.0], &[]);
        assert!((partner.ln_prior_width() - 3.5_f64.ln()).abs() < 1e-12);
        let below = EffectParameter::partner("K", -2.0, [-4.0, -0.5], &[]);
        assert!((below.ln_prior_width() - 3.5_f64.ln()).abs() < 1e-12);
    }

    #[test]
    fn a_range_is_the_central_90_percent() {
        // Median 2, one standard deviation a factor of two.
        let reach = 2.0_f64.powf(END_OF_RANGE);
        let range = [2.0 / reach, 2.0 * reach];
        let parameter = EffectParameter::size("K", 1.0, [-100.0, 100.0]).literature(range, "test");
        let prior = parameter.prior();
        assert!((prior.spread() - LN_2).abs() < 1e-12);
        assert!((prior.ordinary() - range[1]).abs() < 1e-12);
        // Four standard deviations above the median against the end of the range.
        let expected = -0.5 * (16.0 - END_OF_RANGE * END_OF_RANGE);
        assert!((prior.ln_relative(-32.0) - expected).abs() < 1e-12);
    }

    #[test]
    fn what_was_not_looked_up_is_believed_less() {
        let size = EffectParameter::size("K", 1.0, [0.0, 100.0]);
        let range = [0.9, 1.1];
        let spread = |parameter: EffectParameter| parameter.prior().spread();
        assert!((spread(size.literature(range, "test")) - LEAST).abs() < 1e-12);
        assert!((spread(size.unchecked(range, "test")) - LN_2).abs() < 1e-12);
        assert!((spread(size) - BY_TYPICAL).abs() < 1e-12);
        assert!((size.prior().ordinary() - 6.09).abs() < 0.01);
    }
}
