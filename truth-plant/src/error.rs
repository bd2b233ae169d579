use std::fmt;
use std::ops::RangeInclusive;

/// Fault of a plant or of its drive.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum TruthError {
    /// A parameter is NaN or outside of what the plant can do.
    OutOfRange {
        /// Name as it stands in the code.
        name: &'static str,
        /// Rejected value, in the unit of its name.
        value: f64,
        /// Smallest accepted value.
        lowest: f64,
        /// Largest accepted value.
        highest: f64,
    },
    /// Two parameters stand in the wrong order.
    WrongOrder {
        /// The parameter that must be smaller.
        smaller: &'static str,
        /// Its value.
        smaller_value: f64,
        /// The parameter that must be larger.
        larger: &'static str,
        /// Its value.
        larger_value: f64,
    },
    /// There is no sample.
    EmptyDrive,
    /// A sample of the drive is no number, or out of its range.
    Drive {
        /// Sample, from 0.
        index: usize,
        /// Rejected value, in the unit of the drive.
        value: f64,
        /// Smallest accepted value.
        lowest: f64,
        /// Largest accepted value.
        highest: f64,
    },
    /// An addition acts on a part that the plant has not.
    Needs {
        /// Field of the addition.
        addition: &'static str,
        /// Field that must be set.
        needs: &'static str,
    },
    /// The integration left the numbers.
    Diverged {
        /// Sample in which it did, from 0.
        index: usize,
    },
}

impl fmt::Display for TruthError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange {
                name,
                value,
                lowest,
                highest,
            } => write!(f, "{name} = {value}: must be from {lowest} to {highest}"),
            Self::WrongOrder {
                smaller,
                smaller_value,
                larger,
                larger_value,
            } => write!(
                f,
                "{smaller} = {smaller_value}: must be below {larger} = {larger_value}"
            ),
            Self::EmptyDrive => write!(f, "the drive has no samples: at least 1 is needed"),
            Self::Drive {
                index,
                value,
                lowest,
                highest,
            } => write!(
                f,
                "sample {index} of the drive = {value}: must be from {lowest} to {highest}"
            ),
            Self::Needs { addition, needs } => {
                write!(f, "{addition} is set without {needs}: set {needs} too")
            }
            Self::Diverged { index } => write!(
                f,
                "the integration left the numbers in sample {index}: less power or shorter samples are needed"
            ),
        }
    }
}

impl std::error::Error for TruthError {}

/// `NaN` is in no range.
pub(crate) fn within(
    name: &'static str,
    value: f64,
    accepted: RangeInclusive<f64>,
) -> Result<(), TruthError> {
    if accepted.contains(&value) {
        Ok(())
    } else {
        Err(TruthError::OutOfRange {
            name,
            value,
            lowest: *accepted.start(),
            highest: *accepted.end(),
        })
    }
}

/// Both must be known to be numbers.
pub(crate) fn in_order(
    smaller: (&'static str, f64),
    larger: (&'static str, f64),
) -> Result<(), TruthError> {
    if smaller.1 < larger.1 {
        Ok(())
    } else {
        Err(TruthError::WrongOrder {
            smaller: smaller.0,
            smaller_value: smaller.1,
            larger: larger.0,
            larger_value: larger.1,
        })
    }
}
