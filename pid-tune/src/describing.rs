use core::f64::consts::{FRAC_1_PI, FRAC_PI_2};

use crate::DriveLimits;
use crate::TuneError;
use crate::error::{finite, not_negative};

/// A sine about a bias, U0 + U1 sin θ, in the drive's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BiasedSine {
    /// U0; finite.
    pub bias: f64,
    /// U1; finite and ≥ 0.
    pub amplitude: f64,
}

/// Response of a static characteristic to a [`BiasedSine`].
///
/// It is even about θ = π/2, so that the first harmonic is in phase with the sine: the describing function is
/// `first`/U1, a real number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineResponse {
    /// Mean over a cycle.
    pub mean: f64,
    /// Amplitude of sin θ.
    pub first: f64,
}

impl DriveLimits {
    /// Mean and first harmonic of a saturated sine, in the drive's unit.
    ///
    /// ```text
    /// α = asin((lower - U0)/U1),  β = asin((upper - U0)/U1),  arguments brought into [-1, 1]
    /// π mean = lower (α + π/2) + U0 (β - α) + U1 (cos α - cos β) + upper (π/2 - β)
    /// ½π first = -lower cos α + U0 (cos α - cos β) + ½U1 (β - α - ½(sin 2β - sin 2α)) + upper cos β
    /// ```
    ///
    /// the dual-input describing function of a limiter with unequal limits `[Gelb1968, chapter 6]`, one-sided
    /// where `lower` = 0.
    ///
    /// # Errors
    ///
    /// [`TuneError::Limits`], [`TuneError::NotFinite`] for the bias, [`TuneError::Negative`] for the amplitude.
    pub fn saturated_sine(self, sine: BiasedSine) -> Result<SineResponse, TuneError> {
        self.checked(sine)?;
        Ok(self.sine_response(sine))
    }

    /// Mean and first harmonic of the square of a saturated sine, in the drive's unit squared: of the
    /// heating power of a current or a voltage, up to a factor.
    ///
    /// ```text
    /// π mean = lower² (α + π/2) + U0² (β - α) + 2 U0 U1 C + U1² S + upper² (π/2 - β)
    /// ½π first = -lower² cos α + U0² C + 2 U0 U1 S + U1² K + upper² cos β
    /// C = cos α - cos β,   S = ½(β - α) - ¼(sin 2β - sin 2α),   K = C - (cos³α - cos³β)/3
    /// ```
    ///
    /// with the α and β of [`DriveLimits::saturated_sine`]: C, S and K are the integrals of sin, sin² and sin³
    /// between them.
    ///
    /// # Errors
    ///
    /// Those of [`DriveLimits::saturated_sine`].
    pub fn saturated_sine_squared(self, sine: BiasedSine) -> Result<SineResponse, TuneError> {
        self.checked(sine)?;
        Ok(self.squared_sine_response(sine))
    }

    fn checked(self, sine: BiasedSine) -> Result<(), TuneError> {
        let DriveLimits { lower, upper } = self;
        if !(lower < upper && lower.is_finite() && upper.is_finite()) {
            return Err(TuneError::Limits { lower, upper });
        }
        finite("bias", sine.bias)?;
        not_negative("amplitude", sine.amplitude)
    }

    pub(crate) fn sine_response(self, sine: BiasedSine) -> SineResponse {
        let BiasedSine { bias, amplitude } = sine;
        let arc = self.linear_arc(sine);
        SineResponse {
            mean: FRAC_1_PI
                * (self.lower * (arc.from_rad + FRAC_PI_2)
                    + bias * (arc.to_rad - arc.from_rad)
                    + amplitude * arc.sin
                    + self.upper * (FRAC_PI_2 - arc.to_rad)),
            first: 2.0
                * FRAC_1_PI
                * (bias * arc.sin + amplitude * arc.sin2 - self.lower * arc.from_cos
                    + self.upper * arc.to_cos),
        }
    }

    pub(crate) fn squared_sine_response(self, sine: BiasedSine) -> SineResponse {
        let BiasedSine { bias, amplitude } = sine;
        let [lower2, upper2] = [self.lower * self.lower, self.upper * self.upper];
        let arc = self.linear_arc(sine);
        SineResponse {
            mean: FRAC_1_PI
                * (lower2 * (arc.from_rad + FRAC_PI_2)
                    + bias * bias * (arc.to_rad - arc.from_rad)
                    + 2.0 * bias * amplitude * arc.sin
                    + amplitude * amplitude * arc.sin2
                    + upper2 * (FRAC_PI_2 - arc.to_rad)),
            first: 2.0
                * FRAC_1_PI
                * (bias * bias * arc.sin
                    + 2.0 * bias * amplitude * arc.sin2
                    + amplitude * amplitude * arc.sin3
                    - lower2 * arc.from_cos
                    + upper2 * arc.to_cos),
        }
    }

    fn linear_arc(self, sine: BiasedSine) -> LinearArc {
        let [from_sin, to_sin] = [self.lower, self.upper].map(|limit| sine.sine_at(limit));
        let [from_rad, to_rad] = [libm::asin(from_sin), libm::asin(to_sin)];
        // Exactly 0 at the ends, where a large limit would else multiply the cosine's rounding.
        let cos = |sin: f64| libm::sqrt((1.0 - sin) * (1.0 + sin));
        let [from_cos, to_cos] = [cos(from_sin), cos(to_sin)];
        let sin = from_cos - to_cos;
        LinearArc {
            from_rad,
            to_rad,
            from_cos,
            to_cos,
            sin,
            // sin 2φ = 2 sin φ cos φ
            sin2: 0.5 * (to_rad - from_rad - to_sin * to_cos + from_sin * from_cos),
            sin3: sin - (from_cos * from_cos * from_cos - to_cos * to_cos * to_cos) / 3.0,
        }
    }
}

impl BiasedSine {
    /// sin θ where the sine passes a level, the nearer end of [-1, 1] if it does not.
    pub(crate) fn sine_at(self, level: f64) -> f64 {
        let distance = level - self.bias;
        if distance.abs() < self.amplitude {
            distance / self.amplitude
        } else {
            1.0_f64.copysign(distance)
        }
    }
}

/// The part of half a cycle, -π/2 to π/2, in which the drive is not saturated, and integrals over it.
struct LinearArc {
    /// α.
    from_rad: f64,
    /// β.
    to_rad: f64,
    from_cos: f64,
    to_cos: f64,
    /// ∫ sin.
    sin: f64,
    /// ∫ sin².
    sin2: f64,
    /// ∫ sin³.
    sin3: f64,
}
