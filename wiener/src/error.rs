use sma_hysteresis::HysteresisError;
use sma_thermal::ThermalError;

/// Errors in a Wiener model or in the profile that drives it.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WienerError {
    /// The heat balance refuses its parameters.
    #[error("heat balance")]
    Thermal(#[from] ThermalError),
    /// The hysteresis refuses its parameters or its start.
    #[error("hysteresis")]
    Hysteresis(#[from] HysteresisError),
    /// A value of the drive's wiring is zero, negative, infinite or NaN.
    #[error("{name} = {value} {unit}: must be finite and > 0")]
    NotPositive {
        /// Name of the value.
        name: &'static str,
        /// Rejected value, in `unit`.
        value: f64,
        /// Unit of `value`.
        unit: &'static str,
    },
    /// Gain or offset is infinite or NaN.
    #[error("{name} = {value}: must be finite, in the unit of the displacement")]
    Readout {
        /// `gain` or `offset`.
        name: &'static str,
        /// Rejected value.
        value: f64,
    },
    /// A profile has no samples.
    #[error("the profile has no samples; at least 1 is needed")]
    EmptyProfile,
    /// The slices of a profile, or of its output, are not of one length.
    #[error("{name} has {found} values where the drive has {expected}: lengths must be equal")]
    UnequalLength {
        /// Name of the slice.
        name: &'static str,
        /// Its length.
        found: usize,
        /// Length of the drive.
        expected: usize,
    },
    /// A value of a profile is infinite or NaN.
    #[error("{name}[{index}] = {value}: must be finite")]
    NotFinite {
        /// Name of the slice.
        name: &'static str,
        /// Index, from 0.
        index: usize,
        /// Rejected value.
        value: f64,
    },
    /// The sample time is zero, negative, infinite or NaN.
    #[error("dt_s = {value}: the sample time must be finite and > 0")]
    SampleTime {
        /// Rejected value, s.
        value: f64,
    },
    /// Time falls or stands still.
    #[error("time_s[{index}] = {value} after {before}: time must rise")]
    FallingTime {
        /// Index, from 0.
        index: usize,
        /// Rejected value, s.
        value: f64,
        /// Time of the sample before, s.
        before: f64,
    },
}
