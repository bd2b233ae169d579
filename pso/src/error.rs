/// Errors in a setting, a start, a batch of costs or a checkpoint.
///
/// Every text names the field as the caller wrote it, the value, and the accepted values. Running
/// into a limit or finding no finite cost is a result ([`crate::Termination`], [`crate::Report`]),
/// not an error.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SwarmError {
    /// A number that must be positive is zero, negative, infinite or NaN.
    #[error("{name} = {value}: must be finite and > 0")]
    NotPositive {
        /// Field.
        name: &'static str,
        /// Rejected value.
        value: f64,
    },
    /// A number that may be zero is negative, infinite or NaN.
    #[error("{name} = {value}: must be finite and >= 0")]
    Negative {
        /// Field.
        name: &'static str,
        /// Rejected value.
        value: f64,
    },
    /// A factor lies outside (0, 1] or is NaN.
    #[error("{name} = {value}: must be > 0 and <= 1")]
    NotAFraction {
        /// Field.
        name: &'static str,
        /// Rejected value.
        value: f64,
    },
    /// A number is infinite or NaN.
    #[error("{name} = {value}: must be finite")]
    NotFinite {
        /// Field.
        name: &'static str,
        /// Rejected value.
        value: f64,
    },
    /// A count is zero.
    #[error("{name} = 0: must be at least 1")]
    ZeroCount {
        /// Field.
        name: &'static str,
    },
    /// A time limit is zero.
    #[error("{name} = 0 s: must be > 0 s")]
    ZeroTime {
        /// Field.
        name: &'static str,
    },
    /// The constriction coefficient is undefined: its root needs a sum above 4.
    #[error("phi_cognitive + phi_social = {sum}: must be finite and > 4")]
    ConstrictionSum {
        /// Rejected sum.
        sum: f64,
    },
    /// There is nothing to search.
    #[error("bounds = []: must hold at least 1 coordinate")]
    NoCoordinates,
    /// A bound is infinite, NaN or so large that steps would overflow.
    #[error("bounds[{coordinate}].{side} = {value}: must be finite and within ±{limit:e}")]
    BoundNotFinite {
        /// Index into the bounds.
        coordinate: usize,
        /// `lower` or `upper`.
        side: &'static str,
        /// Rejected value.
        value: f64,
        /// Largest accepted magnitude.
        limit: f64,
    },
    /// A lower bound lies above its upper bound.
    #[error("bounds[{coordinate}]: lower = {lower}, upper = {upper}: lower must be <= upper")]
    BoundsInverted {
        /// Index into the bounds.
        coordinate: usize,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// More start points were given than there are particles.
    #[error("start: {count} points: must be at most {particles}, the number of particles")]
    TooManyStarts {
        /// Given points.
        count: usize,
        /// Number of particles.
        particles: usize,
    },
    /// A start point has another number of coordinates than the bounds.
    #[error("start[{point}]: {length} coordinates: must be {coordinates}, as the bounds have")]
    StartLength {
        /// Index into the given points.
        point: usize,
        /// Its length.
        length: usize,
        /// Number of bounds.
        coordinates: usize,
    },
    /// A start point lies outside the bounds or is NaN.
    #[error("start[{point}][{coordinate}] = {value}: must lie in {lower}..={upper}")]
    StartOutside {
        /// Index into the given points.
        point: usize,
        /// Index into the point.
        coordinate: usize,
        /// Rejected value.
        value: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// The number of costs is not the number of particles.
    #[error("costs: {count} values: must be {particles}, one for each particle")]
    CostCount {
        /// Costs told.
        count: usize,
        /// Number of particles.
        particles: usize,
    },
    /// The limit on evaluations does not even allow the starts.
    #[error(
        "stop.evaluations = {evaluations}: must be at least {particles}, the number of particles"
    )]
    EvaluationsTooFew {
        /// Rejected limit.
        evaluations: u64,
        /// Number of particles.
        particles: usize,
    },
    /// A checkpoint does not fit the configuration or the bounds.
    #[error("checkpoint.{name}: length {length}: must be {expected}")]
    CheckpointLength {
        /// Field of the checkpoint.
        name: &'static str,
        /// Its length.
        length: usize,
        /// Accepted length.
        expected: usize,
    },
    /// A checkpoint holds a value that no run can have left there.
    #[error("checkpoint.{name}: particle {particle} has {value}: must be {accepted}")]
    CheckpointValue {
        /// Field of the checkpoint.
        name: &'static str,
        /// Particle, or entry of the history.
        particle: usize,
        /// Rejected value.
        value: f64,
        /// Accepted values.
        accepted: &'static str,
    },
}

/// `value` if it is finite and > 0.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, SwarmError> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(SwarmError::NotPositive { name, value })
    }
}

/// `value` if it is finite and >= 0.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<f64, SwarmError> {
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(SwarmError::Negative { name, value })
    }
}
