//! Physical quantities of a drive column.

use serde::Deserialize;

/// Quantity of the drive of a recording; the physics behind it belongs to the model.
///
/// Deserializes from `"current"`, `"duty"`, `"voltage"`, `"power"`, `"temperature"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quantity {
    /// Current through the actuator, A.
    #[default]
    Current,
    /// Duty of a PWM bridge, 0..1.
    Duty,
    /// Voltage, V.
    Voltage,
    /// Electric power, W.
    Power,
    /// Temperature of the actuator itself, °C: static data, where time is optional.
    Temperature,
}

impl Quantity {
    /// Name, as in `kind = "duty"`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Current => "current",
            Self::Duty => "duty",
            Self::Voltage => "voltage",
            Self::Power => "power",
            Self::Temperature => "temperature",
        }
    }

    /// Unit in which [`Recording::drive`](crate::Recording::drive) holds the quantity; `"1"` for a
    /// duty.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Current => "A",
            Self::Duty => "1",
            Self::Voltage => "V",
            Self::Power => "W",
            Self::Temperature => "degC",
        }
    }

    /// Column name of the quantity in its own unit: the default when reading, and what
    /// [`write_csv`](crate::write_csv) writes.
    #[must_use]
    pub const fn column(self) -> &'static str {
        match self {
            Self::Current => "current_a",
            Self::Duty => "duty",
            Self::Voltage => "voltage_v",
            Self::Power => "power_w",
            Self::Temperature => "temperature_degc",
        }
    }

    /// How strongly a drive of this quantity heats, rising with it: the magnitude of a current or a
    /// voltage, which heat by their square; any other drive as it is.
    pub(crate) fn level(self, drive: f64) -> f64 {
        match self {
            Self::Current | Self::Voltage => drive.abs(),
            Self::Duty | Self::Power | Self::Temperature => drive,
        }
    }
}
