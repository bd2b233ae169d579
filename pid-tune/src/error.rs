use wiener::WienerError;
use wiener::thermal::ThermalError;

/// Errors of a controller, a reference, a closed loop, a cost or a search.
///
/// Names end in their unit where they have one of their own; the rest is in the units of the output and the
/// drive.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TuneError {
    /// A value that must be positive is zero, negative, infinite or NaN.
    #[error("{name} = {value}: must be finite and > 0")]
    NotPositive {
        /// Name of the value.
        name: &'static str,
        /// Rejected value.
        value: f64,
    },
    /// A value that may be zero is negative, infinite or NaN.
    #[error("{name} = {value}: must be finite and >= 0")]
    Negative {
        /// Name of the value.
        name: &'static str,
        /// Rejected value.
        value: f64,
    },
    /// A value is infinite or NaN.
    #[error("{name} = {value}: must be finite")]
    NotFinite {
        /// Name of the value.
        name: &'static str,
        /// Rejected value.
        value: f64,
    },
    /// A value of a series is infinite or NaN.
    #[error("{name}[{index}] = {value}: must be finite")]
    NotFiniteAt {
        /// Name of the series.
        name: &'static str,
        /// Index, from 0.
        index: usize,
        /// Rejected value.
        value: f64,
    },
    /// The limits of the drive leave nothing between them.
    #[error(
        "the drive is limited to {lower} .. {upper}: both must be finite, the lower below the upper"
    )]
    Limits {
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
    /// Back-calculation would overcorrect within one sample.
    #[error("tracking_s = {value}: must be finite and at least the sample time of {dt_s} s")]
    Tracking {
        /// Rejected value, s.
        value: f64,
        /// Sample time, s.
        dt_s: f64,
    },
    /// No share of a reference.
    #[error("setpoint_weight = {value}: must lie in 0 .. 1")]
    SetpointWeight {
        /// Rejected value.
        value: f64,
    },
    /// Levels of a gain schedule leave nothing between them.
    #[error(
        "a gain schedule from an output of {lower} to {upper}: both must be finite, the first below the second"
    )]
    ScheduleOutputs {
        /// First level.
        lower: f64,
        /// Last level.
        upper: f64,
    },
    /// A factor of a gain schedule is below 1, infinite or NaN.
    #[error("{branch}[{index}] = {value}: a factor of a gain schedule must be finite and >= 1")]
    ScheduleFactor {
        /// Its branch.
        branch: &'static str,
        /// Number of its level, from 0.
        index: usize,
        /// Rejected value.
        value: f64,
    },
    /// No exponent of a gain schedule.
    #[error("exponent of a gain schedule = {value}: must lie in 0 .. 1")]
    Exponent {
        /// Rejected value.
        value: f64,
    },
    /// No limit of the factors of a gain schedule.
    #[error("largest factor of a gain schedule = {value}: must be finite and > 1")]
    ScheduleLimit {
        /// Rejected value.
        value: f64,
    },
    /// A series has no values.
    #[error("{name} has no values; at least 1 is needed")]
    Empty {
        /// Name of the series.
        name: &'static str,
    },
    /// A run of no samples.
    #[error("n_samples = 0: must be at least 1")]
    NoSamples,
    /// A series is not as long as the run.
    #[error("{name} has {found} values where the run has {expected} samples: must be equal")]
    UnequalLength {
        /// Name of the series.
        name: &'static str,
        /// Its length.
        found: usize,
        /// Samples of the run.
        expected: usize,
    },
    /// More dead time than a loop has room for.
    #[error("dead_time_samples = {value}: must be at most {most}")]
    DeadTime {
        /// Rejected number of samples.
        value: usize,
        /// Largest number accepted.
        most: usize,
    },
    /// The heat balance refuses what the feed-forward asks of it.
    #[error("heat balance")]
    Thermal(#[from] ThermalError),
    /// A range in which a gain is looked for ends before it begins.
    #[error(
        "{name} is looked for in {lower} .. {upper}: both must be finite and >= 0, the lower at most the upper"
    )]
    Bounds {
        /// Name of the gain.
        name: &'static str,
        /// Lower end.
        lower: f64,
        /// Upper end.
        upper: f64,
    },
    /// Not a place between gentle and fast.
    #[error("pace = {value}: must lie in 0 .. 1")]
    Pace {
        /// Rejected value.
        value: f64,
    },
    /// A search without any start.
    #[error("starts = 0: must be at least 1")]
    NoStarts,
    /// All weights that count for the reference are 0.
    #[error("no weight is > 0 on a term that responses to this reference have: at least 1 must be")]
    NoWeight,
    /// No gains within the bounds meet what is required.
    #[error(
        "no gains within the bounds meet what is required of margins and of the sensor's jumps"
    )]
    Unmet,
    /// No gains within the bounds let the loop come to rest.
    #[error(
        "no gains that were tried let the loop come to rest from every side on every rod: larger margins, a gentler pace, a finer sensor, a longer filter or a slower sample time would"
    )]
    NoRest,
    /// No response within the bounds has a finite cost.
    #[error(
        "no gains within the bounds have a finite cost: the plant's output must be a finite number"
    )]
    NoFiniteCost,
    /// The swarm refuses its settings.
    #[cfg(feature = "std")]
    #[error("swarm")]
    Swarm(#[source] pso::SwarmError),
    /// The optimizer that gives a second opinion failed.
    #[cfg(feature = "std")]
    #[error("second opinion: {said}")]
    SecondOpinion {
        /// Its message.
        said: std::string::String,
    },
    /// The rod refuses its parameters or its drive.
    #[error("rod")]
    Rod(#[from] WienerError),
}

/// Accepts what is finite and > 0: `NaN` fails the comparison.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), TuneError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(TuneError::NotPositive { name, value })
    }
}

/// Accepts what is finite and >= 0.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<(), TuneError> {
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(TuneError::Negative { name, value })
    }
}

/// Accepts what is finite.
pub(crate) fn finite(name: &'static str, value: f64) -> Result<(), TuneError> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(TuneError::NotFinite { name, value })
    }
}

/// Accepts a series of finite values.
pub(crate) fn all_finite(name: &'static str, values: &[f64]) -> Result<(), TuneError> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(TuneError::NotFiniteAt {
            name,
            index,
            value: values[index],
        }),
    }
}

/// Accepts a series of at least one value, all finite.
pub(crate) fn some_finite(name: &'static str, values: &[f64]) -> Result<(), TuneError> {
    if values.is_empty() {
        Err(TuneError::Empty { name })
    } else {
        all_finite(name, values)
    }
}
