//! Facts about one parameter of an effect.

use crate::SizePrior;

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectParameter {
    /// Name, with its unit where it has one.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Ordinary value; of a two-sided size, its magnitude.
    pub typical: f64,
    /// Physical bounds, both accepted.
    pub bounds: [f64; 2],
    /// True if the upper bound is a physical limit, or if a recording would show no further change beyond it: a value may
    /// lie on it. Otherwise the bound is the limit of a search, and a value on it indicates that the effect is another.
    pub upper_is_physical: bool,
    /// Magnitude of a size below which the name does not fit, whatever it is that the recordings show; 0 where all do.
    pub least: f64,
    /// Role in the baseline: a size is zero there, a partner without influence.
    pub role: Role,
    /// Range in the literature, if known.
    pub literature: Option<Literature>,
    /// True if only a recorded temperature determines it. Without one, no value fits better than another, and it is best
    /// held as in the baseline.
    pub needs_thermometer: bool,
    /// Unit where the setting has no [`Setting::length_output`](crate::Setting::length_output), if that is another: see
    /// [`Setting::unit_of`](crate::Setting::unit_of).
    pub unit_without_length: Option<&'static str>,
    /// Power of the specific heat with which its value scales at the same displacement: all temperature differences
    /// divided by c = C_p/C_p0 give the same.
    pub power_of_specific_heat: i32,
    /// True if its value is counted in watts, and so scales with the power of the drive at the same displacement.
    pub scales_with_power: bool,
}

/// Role of a parameter in the baseline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Role {
    /// Zero in the baseline. With all sizes of an effect 0 the plant has the bits of the baseline.
    Size,
    /// Without influence where the size is zero, and so without a value there: screening tries these.
    Partner {
        /// Values to try; none but for the first partner.
        grid: &'static [f64],
    },
}

/// Permitted signs of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sign {
    /// Zero or more: tests against zero are one-sided.
    NonNegative,
    /// Both signs make sense.
    Either,
}

/// A range found in the literature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Literature {
    /// Its ends, in the parameter's unit; magnitudes for a two-sided size.
    pub range: [f64; 2],
    /// Where it comes from.
    pub source: &'static str,
    /// True if somebody looked it up for this project. Do not quote an unchecked range.
    pub checked: bool,
}

impl EffectParameter {
    pub(crate) const fn size(unit: &'static str, typical: f64, bounds: [f64; 2]) -> Self {
        Self {
            name: "",
            unit,
            typical,
            bounds,
            upper_is_physical: false,
            least: 0.0,
            role: Role::Size,
            literature: None,
            needs_thermometer: false,
            unit_without_length: None,
            power_of_specific_heat: 0,
            scales_with_power: false,
        }
    }

    pub(crate) const fn partner(
        unit: &'static str,
        typical: f64,
        bounds: [f64; 2],
        grid: &'static [f64],
    ) -> Self {
        Self {
            role: Role::Partner { grid },
            ..Self::size(unit, typical, bounds)
        }
    }

    pub(crate) const fn literature(self, range: [f64; 2], source: &'static str) -> Self {
        Self {
            literature: Some(Literature {
                range,
                source,
                checked: true,
            }),
            ..self
        }
    }

    pub(crate) const fn unchecked(self, range: [f64; 2], source: &'static str) -> Self {
        Self {
            literature: Some(Literature {
                range,
                source,
                checked: false,
            }),
            ..self
        }
    }

    pub(crate) const fn at_least(self, least: f64) -> Self {
        Self { least, ..self }
    }

    pub(crate) const fn told_by_thermometer(self) -> Self {
        Self {
            needs_thermometer: true,
            ..self
        }
    }

    pub(crate) const fn without_length(self, unit: &'static str) -> Self {
        Self {
            unit_without_length: Some(unit),
            ..self
        }
    }

    pub(crate) const fn up_to_an_end(self) -> Self {
        Self {
            upper_is_physical: true,
            ..self
        }
    }

    pub(crate) const fn scaled_by_heat(self, power_of_specific_heat: i32) -> Self {
        Self {
            power_of_specific_heat,
            ..self
        }
    }

    pub(crate) const fn in_watts(self) -> Self {
        Self {
            scales_with_power: true,
            ..self
        }
    }

    pub(crate) const fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// Permitted signs of its value.
    #[must_use]
    pub const fn sign(&self) -> Sign {
        if self.bounds[0] < 0.0 {
            Sign::Either
        } else {
            Sign::NonNegative
        }
    }

    /// Value in the baseline: 0 for a size, the typical one for a partner.
    #[must_use]
    pub const fn neutral(&self) -> f64 {
        match self.role {
            Role::Size => 0.0,
            Role::Partner { .. } => self.typical,
        }
    }

    /// True if a value is a number within the bounds.
    #[must_use]
    pub fn accepts(&self, value: f64) -> bool {
        (self.bounds[0]..=self.bounds[1]).contains(&value)
    }

    /// Largest magnitude that it can have, in its [`unit`](EffectParameter::unit); ≥ 0.
    #[must_use]
    pub fn largest(&self) -> f64 {
        let [lower, upper] = self.bounds;
        lower.abs().max(upper.abs())
    }

    /// Prior of its value, in its [`unit`](EffectParameter::unit). For another unit see
    /// [`Setting::prior_of`](crate::Setting::prior_of).
    #[must_use]
    pub fn prior(&self) -> SizePrior {
        SizePrior::of(self, true)
    }

    /// [`SizePrior::ln_relative`] of its prior: at most 0, and -∞ out of bounds.
    #[must_use]
    pub fn ln_prior(&self, value: f64) -> f64 {
        self.prior().ln_relative(value)
    }

    /// [`SizePrior::ln_width`] of its prior.
    #[must_use]
    pub fn ln_prior_width(&self) -> f64 {
        self.prior().ln_width()
    }
}
