/// Errors in a heat balance, or in a request to it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ThermalError {
    /// A parameter is zero, negative, infinite or NaN.
    #[error("{name} = {value} {unit}: must be finite and > 0")]
    NotPositive {
        /// Name of the parameter.
        name: &'static str,
        /// Rejected value, in `unit`.
        value: f64,
        /// Unit of `value`.
        unit: &'static str,
    },
    /// A temperature is infinite or NaN.
    #[error("{name} = {value} °C: must be finite")]
    NotFinite {
        /// Name of the temperature.
        name: &'static str,
        /// Rejected value, °C.
        value: f64,
    },
    /// A temperature that is too low to be reached in time: current only heats.
    #[error(
        "{to_degc} °C within {within_s} s: the rod cannot cool that fast; without any current it is still at {coolest_degc} °C then, so ask for at least that or change the time allowed"
    )]
    CannotCool {
        /// Temperature asked for, °C.
        to_degc: f64,
        /// Time allowed, s.
        within_s: f64,
        /// Temperature after that time without current, °C.
        coolest_degc: f64,
    },
    /// A temperature below the surroundings: no time is long enough.
    #[error(
        "{to_degc} °C: below the ambient temperature of {ambient_degc} °C, which no rod reaches by heating"
    )]
    BelowAmbient {
        /// Temperature asked for, °C.
        to_degc: f64,
        /// Ambient temperature, °C.
        ambient_degc: f64,
    },
}

/// Accepts what is finite and > 0: `NaN` fails the comparison.
pub(crate) fn positive(
    name: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, ThermalError> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(ThermalError::NotPositive { name, value, unit })
    }
}

/// Accepts what is finite.
pub(crate) fn finite_degc(name: &'static str, value: f64) -> Result<f64, ThermalError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(ThermalError::NotFinite { name, value })
    }
}
