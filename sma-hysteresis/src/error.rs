use crate::limiting_loop::Branch;

/// Errors in the parameters or the start of a hysteresis operator.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HysteresisError {
    /// A width is zero, negative, infinite or NaN.
    #[error("{name} = {value} K: must be finite and > 0")]
    NotPositive {
        /// Name of the parameter.
        name: &'static str,
        /// Rejected value, K.
        value: f64,
    },
    /// A width of no loop: with such numbers a fraction would be none.
    #[error("{name} = {value:e} K: must be from 1e-30 to 1e30 K")]
    Width {
        /// Name of the parameter.
        name: &'static str,
        /// Rejected value, K.
        value: f64,
    },
    /// A parameter is infinite or NaN.
    #[error("{name} = {value} {unit}: must be finite")]
    NotFinite {
        /// Name of the parameter.
        name: &'static str,
        /// Rejected value, in `unit`.
        value: f64,
        /// Unit of `value`.
        unit: &'static str,
    },
    /// A loop without height: both ends of the transformation would have the same fraction.
    #[error("fraction_swing = {value}: must be finite and not 0 (1/2 for a fraction from 0 to 1)")]
    NoSwing {
        /// Rejected value.
        value: f64,
    },
    /// The rate of a proximity function lies outside the range in which branches are monotone.
    #[error("{name} = {value}: must be > 0 and <= 1, or a branch would run backward")]
    NotMonotone {
        /// Name of the parameter.
        name: &'static str,
        /// Rejected value.
        value: f64,
    },
    /// A relative difference of spreads leaves one branch without any.
    #[error("asymmetry = {value}: must be > -1 and < 1, or a branch would have no spread")]
    Asymmetry {
        /// Rejected value.
        value: f64,
    },
    /// Tails of a loop of relays outside their range.
    #[error("tails = {value}: must be from 0 to 4")]
    Tails {
        /// Rejected value.
        value: f64,
    },
    /// Sharpness of the onset of kinetics outside its range.
    #[error("sharpness of the onset = {value}: must be from 0 to 1")]
    Onset {
        /// Rejected value.
        value: f64,
    },
    /// A number of a second population of relays outside its range.
    #[error("{name} of the second population = {value}: must be from {lower} to {upper}")]
    SecondPopulation {
        /// Name of the number.
        name: &'static str,
        /// Rejected value.
        value: f64,
        /// Least that is accepted.
        lower: f64,
        /// Most that is accepted.
        upper: f64,
    },
    /// Bends of a loop that would make its branches turn back.
    #[error("bends of the loop lower a slope by {value} of it: must be from 0 to 1")]
    Bends {
        /// Rejected sum |c_1| + max(-c_2, c_2/2) + |c_3|.
        value: f64,
    },
    /// A start temperature is infinite or NaN.
    #[error("start temperature = {value} °C: must be finite")]
    StartTemperature {
        /// Rejected value, °C.
        value: f64,
    },
    /// A start fraction lies outside the limiting loop at the start temperature.
    #[error(
        "start fraction = {value} at {temperature_degc} °C: outside the limiting loop, which spans {lower} to {upper} there"
    )]
    OutsideLoop {
        /// Rejected value.
        value: f64,
        /// Start temperature, °C.
        temperature_degc: f64,
        /// Smallest fraction inside the loop at that temperature.
        lower: f64,
        /// Largest fraction inside the loop at that temperature.
        upper: f64,
    },
    /// A fraction that no temperature reaches on the limiting curve.
    #[error(
        "fraction = {value}: the {branch} curve takes values strictly between {lower} and {upper}"
    )]
    Unreachable {
        /// Rejected value.
        value: f64,
        /// The curve that was asked.
        branch: Branch,
        /// Its lower asymptote.
        lower: f64,
        /// Its upper asymptote.
        upper: f64,
    },
}

/// Accepts widths that a loop can have, and more: `NaN` fails the comparison.
pub(crate) fn positive_k(name: &'static str, value: f64) -> Result<f64, HysteresisError> {
    if !(value > 0.0 && value.is_finite()) {
        Err(HysteresisError::NotPositive { name, value })
    } else if (1e-30..=1e30).contains(&value) {
        Ok(value)
    } else {
        Err(HysteresisError::Width { name, value })
    }
}

/// Accepts what is finite.
pub(crate) fn finite(
    name: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, HysteresisError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(HysteresisError::NotFinite { name, value, unit })
    }
}

/// Accepts rates in (0, 1].
pub(crate) fn monotone_rate(name: &'static str, value: f64) -> Result<f64, HysteresisError> {
    if value > 0.0 && value <= 1.0 {
        Ok(value)
    } else {
        Err(HysteresisError::NotMonotone { name, value })
    }
}
