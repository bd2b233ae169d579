use wiener::WienerError;
use wiener::hysteresis::HysteresisError;

/// Errors in the values, the setting or the hypotheses of an extended plant.
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
    /// A share of the setting is none.
    #[error("{name} = {value}: must be from 0 to 1")]
    Share {
        /// Name of the share.
        name: &'static str,
        /// Rejected value.
        value: f64,
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
    /// A setting has more hypotheses than a plant can hold.
    #[error("{count} hypotheses: must be at most {largest}")]
    TooManyHypotheses {
        /// Rejected number.
        count: usize,
        /// Largest number accepted.
        largest: usize,
    },
    /// A value is given for a parameter that no hypothesis of the setting has.
    #[error(
        "own[{hypothesis}][{parameter}] = {value}: must be 0: the setting has no such parameter"
    )]
    NoOwnParameter {
        /// Number of the hypothesis, from 0.
        hypothesis: usize,
        /// Number of the parameter, from 0.
        parameter: usize,
        /// Rejected value.
        value: f64,
    },
    /// A file of hypotheses cannot be read.
    #[error("{file}: cannot be read: {why}")]
    Unreadable {
        /// File.
        file: String,
        /// Message of the operating system.
        why: String,
    },
    /// A file of hypotheses is none: syntax, unknown key, wrong type.
    #[error("{file}:{line}:{column}: {message}")]
    Toml {
        /// File.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Message of the parser: its finding, and the text that it would have accepted.
        message: String,
    },
    /// A value in a file of hypotheses is not accepted.
    #[error("{file}:{line}:{column}: {key}: {accepted}")]
    Hypothesis {
        /// File.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Rejected entry: a key, and its value if it has one.
        key: String,
        /// Error in it, or the accepted values.
        accepted: String,
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
