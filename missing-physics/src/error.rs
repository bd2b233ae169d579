use wiener::WienerError;
use wiener::hysteresis::HysteresisError;

/// What can be wrong with an extended plant.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PhysicsError {
    /// The baseline refuses its parameters.
    #[error("baseline")]
    Baseline(#[from] WienerError),
    /// The hysteresis refuses its parameters.
    #[error("hysteresis")]
    Hysteresis(#[from] HysteresisError),
    /// A parameter of an active effect is NaN or outside its physical bounds.
    #[error(
        "{effect}: {name} = {value}{}: must be in [{lower}, {upper}]",
        spaced(unit)
    )]
    OutOfBounds {
        /// Id of the effect.
        effect: &'static str,
        /// Name of the parameter.
        name: &'static str,
        /// Rejected value, in `unit`.
        value: f64,
        /// Unit of `value`.
        unit: &'static str,
        /// Smallest value accepted.
        lower: f64,
        /// Largest value accepted.
        upper: f64,
    },
    /// An effect has a size, but the setting does not list it as active.
    #[error(
        "{effect}: {name} = {value}{}: must be 0 while the effect is not active",
        spaced(unit)
    )]
    Inactive {
        /// Id of the effect.
        effect: &'static str,
        /// Name of the parameter.
        name: &'static str,
        /// Rejected value, in `unit`.
        value: f64,
        /// Unit of `value`.
        unit: &'static str,
    },
    /// An active effect needs what the setting leaves out.
    #[error("{effect} needs {what}, which the setting leaves out")]
    Missing {
        /// Id of the effect.
        effect: &'static str,
        /// Name of the missing value.
        what: &'static str,
    },
    /// A value of the setting is zero, negative, infinite or NaN.
    #[error("{name} = {value} {unit}: must be finite and > 0")]
    NotPositive {
        /// Name of the value.
        name: &'static str,
        /// Rejected value, in `unit`.
        value: f64,
        /// Unit of `value`.
        unit: &'static str,
    },
    /// A value of the setting is negative, infinite or NaN.
    #[error("{name} = {value} {unit}: must be finite and >= 0")]
    Negative {
        /// Name of the value.
        name: &'static str,
        /// Rejected value, in `unit`.
        value: f64,
        /// Unit of `value`.
        unit: &'static str,
    },
    /// A temperature of the setting is infinite or NaN.
    #[error("{name} = {value} °C: must be finite")]
    NotFinite {
        /// Name of the temperature.
        name: &'static str,
        /// Rejected value, °C.
        value: f64,
    },
    /// A number of iterations or sub-steps is zero or absurdly large.
    #[error("{name} = {value}: must be in 1..={largest}")]
    Count {
        /// Name of the number.
        name: &'static str,
        /// Rejected value.
        value: usize,
        /// Largest number accepted.
        largest: usize,
    },
    /// No effect has this id.
    #[error("effect '{id}': unknown; known are {known}")]
    UnknownEffect {
        /// Rejected id.
        id: String,
        /// All ids, separated by blanks.
        known: String,
    },
}

/// A unit after its value; that of a pure number is not written.
fn spaced(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        _ => format!(" {unit}"),
    }
}
