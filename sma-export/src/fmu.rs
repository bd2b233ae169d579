//! A model as a functional mock-up unit: FMI 2.0, co-simulation.

use wiener::Drive;

use crate::archive::archive;
use crate::{ExportError, Exported, Labels};

/// Name of the library in all units, and its identifier there.
pub const FMU_LIBRARY: &str = "sma_fmu";

/// Words that every library of these units has in it, with the version that it was built as.
pub const FMU_MARK: &str = concat!("sma-fmu ", env!("CARGO_PKG_VERSION"), " for FMI 2.0");

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

/// The unit: its description, the library, and the model as it was kept. All effects and loops leave with it.
///
/// # Errors
///
/// [`ExportError::SampleTime`], [`ExportError::Library`] for a library that is not of this program's version, [`ExportError::TooLarge`].
pub fn fmu(exported: &Exported, model_toml: &str, library: &[u8]) -> Result<Vec<u8>, ExportError> {
    if !(exported.dt_s > 0.0 && exported.dt_s.is_finite()) {
        return Err(ExportError::SampleTime {
            value: exported.dt_s,
        });
    }
    let platform = platform(library).map_err(|found| ExportError::Library { found })?;
    let description = description(exported);
    let binary = format!("binaries/{platform}/{FMU_LIBRARY}.so");
    archive(&[
        ("modelDescription.xml", description.as_bytes()),
        (&binary, library),
        ("resources/model.toml", model_toml.as_bytes()),
    ])
    .ok_or(ExportError::TooLarge)
}

/// Folder of the platform that a library is for, or what it is.
fn platform(library: &[u8]) -> Result<&'static str, &'static str> {
    const MACHINE: std::ops::Range<usize> = 18..20;
    const X86_64: [u8; 2] = [62, 0];
    if !library.starts_with(b"\x7fELF\x02\x01") {
        return Err("no 64-bit ELF file");
    }
    let mark = FMU_MARK.as_bytes();
    if !library.windows(mark.len()).any(|part| part == mark) {
        return Err("another library, or one of another version");
    }
    match library.get(MACHINE) {
        Some(machine) if machine == X86_64 => Ok("linux64"),
        _ => Err("a library of a processor for which FMI 2.0 has no folder"),
    }
}

/// modelDescription.xml.
fn description(exported: &Exported) -> String {
    let Labels {
        model_file,
        sha256,
        version,
        drive_unit,
        output_unit,
        recording,
        left_out,
        ..
    } = &exported.labels;
    let is_duty = matches!(exported.setting.drive, Drive::Duty { .. });
    let drive_unit = if is_duty { "1" } else { drive_unit.as_str() };
    let member = &exported.member;
    let effects: Vec<&str> = exported.setting.active.iter().map(|one| one.id()).collect();
    let mut about = format!("Shape-memory-alloy actuator; offset and start of {recording}");
    if !effects.is_empty() {
        about += &format!("; effects: {}", effects.join(", "));
    }
    if !left_out.is_empty() {
        about += &format!("; left out: {}", left_out.join("; "));
    }
    let ambient_degc = exported.labels.ambient_degc.unwrap_or(20.0);
    let variables = [
        (
            FmuVariable::Drive,
            Some(0.0),
            drive_unit,
            "Drive of the sample that follows",
        ),
        (
            FmuVariable::AmbientDegc,
            Some(ambient_degc),
            "degC",
            "Temperature of the surroundings",
        ),
        (
            FmuVariable::Displacement,
            None,
            output_unit,
            "Displacement as the sensor reads it",
        ),
        (
            FmuVariable::TemperatureDegc,
            None,
            "degC",
            "Temperature of the rod as recorded",
        ),
        (
            FmuVariable::Offset,
            Some(member.params.offset),
            output_unit,
            "Displacement at fraction 0",
        ),
        (
            FmuVariable::StartRiseK,
            Some(member.start.temperature_degc),
            "K",
            "Temperature at the start above the surroundings",
        ),
        (
            FmuVariable::StartShare,
            Some(member.start.share),
            "1",
            "Place at the start between the limiting curves, 0 (heating) to 1 (cooling)",
        ),
    ];
    let mut units: Vec<&str> = variables.iter().map(|one| one.2).collect();
    units.sort_unstable();
    units.dedup();
    let units: String = units.into_iter().map(unit).collect();
    let scalars: String = variables
        .iter()
        .map(|&(variable, start, unit, about)| {
            let is_duty = variable == FmuVariable::Drive && is_duty;
            scalar(variable, start, (unit, is_duty), about)
        })
        .collect();
    let model_name = model_file.rsplit('/').next().unwrap_or(model_file);
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{}" guid="{}" description="{}" version="{}" generationTool="sma {}" variableNamingConvention="flat" numberOfEventIndicators="0">
  <CoSimulation modelIdentifier="{FMU_LIBRARY}" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUstate="true" canNotUseMemoryManagementFunctions="true" canSerializeFMUstate="false" providesDirectionalDerivative="false"/>
  <UnitDefinitions>
{units}  </UnitDefinitions>
  <DefaultExperiment startTime="0.0" stepSize="{}"/>
  <ModelVariables>
{scalars}  </ModelVariables>
  <ModelStructure>
    <Outputs>
      <Unknown index="3" dependencies=""/>
      <Unknown index="4" dependencies=""/>
    </Outputs>
    <InitialUnknowns>
      <Unknown index="3" dependencies="2 5 6 7"/>
      <Unknown index="4" dependencies="2 6"/>
    </InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"#,
        escaped(model_name),
        fmu_guid(sha256),
        escaped(&about),
        escaped(&format!("SHA-256 {sha256}")),
        escaped(version),
        exported.dt_s,
    )
}

/// A unit of measurement, by SI units where it is known.
fn unit(name: &str) -> String {
    let base = match name {
        "1" => "<BaseUnit/>",
        "A" => r#"<BaseUnit A="1"/>"#,
        "V" => r#"<BaseUnit kg="1" m="2" s="-3" A="-1"/>"#,
        "W" => r#"<BaseUnit kg="1" m="2" s="-3"/>"#,
        "K" => r#"<BaseUnit K="1"/>"#,
        "degC" => r#"<BaseUnit K="1" offset="273.15"/>"#,
        "m" => r#"<BaseUnit m="1"/>"#,
        "mm" => r#"<BaseUnit m="1" factor="0.001"/>"#,
        "um" | "µm" => r#"<BaseUnit m="1" factor="0.000001"/>"#,
        "N" => r#"<BaseUnit kg="1" m="1" s="-2"/>"#,
        "rad" => r#"<BaseUnit rad="1"/>"#,
        "deg" => r#"<BaseUnit rad="1" factor="0.017453292519943295"/>"#,
        _ => "",
    };
    format!("    <Unit name=\"{}\">{base}</Unit>\n", escaped(name))
}

/// A variable. `is_share` says that its values lie from 0 to 1.
fn scalar(
    variable: FmuVariable,
    start: Option<f64>,
    (unit, is_share): (&str, bool),
    about: &str,
) -> String {
    let (causality, variability, initial) = if variable.is_output() {
        ("output", "continuous", "calculated")
    } else if variable.is_parameter() {
        ("parameter", "fixed", "exact")
    } else {
        ("input", "continuous", "")
    };
    let initial = match initial {
        "" => String::new(),
        initial => format!(" initial=\"{initial}\""),
    };
    let start = start.map_or_else(String::new, |start| format!(" start=\"{start:?}\""));
    let range = if is_share {
        " min=\"0.0\" max=\"1.0\""
    } else {
        ""
    };
    format!(
        "    <ScalarVariable name=\"{}\" valueReference=\"{}\" description=\"{about}\" causality=\"{causality}\" variability=\"{variability}\"{initial}>\n      <Real unit=\"{}\"{range}{start}/>\n    </ScalarVariable>\n",
        variable.name(),
        variable as u32,
        escaped(unit)
    )
}

/// A text as an attribute of XML.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            c if c.is_control() => escaped.push('?'),
            c => escaped.push(c),
        }
    }
    escaped
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

    #[test]
    fn texts_do_not_end_an_attribute() {
        assert_eq!(escaped("a\"<&>\u{7}"), "a&quot;&lt;&amp;&gt;?");
    }

    #[test]
    fn only_libraries_of_this_version_leave() {
        let mut library = b"\x7fELF\x02\x01".to_vec();
        library.resize(18, 0);
        library.extend([62, 0]);
        assert_eq!(
            platform(&library),
            Err("another library, or one of another version")
        );
        library.extend(FMU_MARK.as_bytes());
        assert_eq!(platform(&library), Ok("linux64"));
        library[18] = 183;
        assert!(platform(&library).is_err());
        assert_eq!(platform(b"MZ"), Err("no 64-bit ELF file"));
    }
}
