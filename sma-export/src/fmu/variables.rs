//! Versions, names and variables of units.

/// Name of the library in all units, and its identifier there.
pub const FMU_LIBRARY: &str = "sma_fmu";

/// Words that every library of these units has in it, with the version that it was built as.
pub const FMU_MARK: &str = concat!(
    "sma-fmu ",
    env!("CARGO_PKG_VERSION"),
    " for FMI 2.0 and 3.0"
);

/// Version of the standard that a unit is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fmi {
    /// FMI 2.0.
    V2,
    /// FMI 3.0.
    V3,
}

/// Value reference of the time in units of FMI 3.0, which asks for one.
pub const FMU_TIME: u32 = FmuVariable::ALL.len() as u32;

/// A variable of a unit; its number is its value reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FmuVariable {
    /// Drive, in its unit: an input.
    Drive,
    /// Temperature of the surroundings, °C: an input.
    AmbientDegc,
    /// Displacement, in the unit of the output: an output.
    Displacement,
    /// Temperature of the rod as recorded, °C: an output.
    TemperatureDegc,
    /// Displacement at fraction 0: a parameter.
    Offset,
    /// Temperature at the start above the surroundings, K: a parameter.
    StartRiseK,
    /// Place between the limiting curves at the start, 0 to 1: a parameter.
    StartShare,
}

impl FmuVariable {
    /// All of them, in the order of their value references.
    pub const ALL: [Self; 7] = [
        Self::Drive,
        Self::AmbientDegc,
        Self::Displacement,
        Self::TemperatureDegc,
        Self::Offset,
        Self::StartRiseK,
        Self::StartShare,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Drive => "drive",
            Self::AmbientDegc => "ambient_degc",
            Self::Displacement => "displacement",
            Self::TemperatureDegc => "temperature_degc",
            Self::Offset => "offset",
            Self::StartRiseK => "start_rise_k",
            Self::StartShare => "start_share",
        }
    }

    /// True for an output.
    #[must_use]
    pub const fn is_output(self) -> bool {
        matches!(self, Self::Displacement | Self::TemperatureDegc)
    }

    /// True for a parameter.
    #[must_use]
    pub const fn is_parameter(self) -> bool {
        matches!(self, Self::Offset | Self::StartRiseK | Self::StartShare)
    }
}

/// Identity of a unit, from the SHA-256 of its `model.toml` in hexadecimal: the library refuses another model.
#[must_use]
pub fn fmu_guid(sha256: &str) -> String {
    let part = |range: std::ops::Range<usize>| sha256.get(range).unwrap_or_default();
    format!(
        "{{{}-{}-{}-{}-{}}}",
        part(0..8),
        part(8..12),
        part(12..16),
        part(16..20),
        part(20..32)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn value_references_are_places() {
        for (place, variable) in FmuVariable::ALL.into_iter().enumerate() {
            assert_eq!(variable as usize, place);
        }
    }

    #[test]
    fn an_identity_has_the_form_of_one() {
        let sha256 = "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef";
        assert_eq!(fmu_guid(sha256), "{01234567-89ab-cdef-0123-456789abcdef}");
    }
}
