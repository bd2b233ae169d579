//! Description of a unit: modelDescription.xml.

use wiener::Drive;

use crate::fmu::variables::{FMU_LIBRARY, FMU_TIME, Fmi, FmuVariable, fmu_guid};
use crate::{Exported, Labels};

/// modelDescription.xml for a version of the standard.
pub(super) fn description(exported: &Exported, fmi: Fmi) -> String {
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
    if fmi == Fmi::V3 {
        units.push("s");
    }
    units.sort_unstable();
    units.dedup();
    let units: String = units.into_iter().map(unit).collect();
    let rows: String = variables
        .iter()
        .map(|&(variable, start, unit, about)| {
            let is_duty = variable == FmuVariable::Drive && is_duty;
            row(fmi, variable, start, (unit, is_duty), about)
        })
        .collect();
    let model_name = model_file.rsplit('/').next().unwrap_or(model_file);
    let names = format!(
        r#"modelName="{}" {}="{}" description="{}" version="{}" generationTool="sma {}" variableNamingConvention="flat""#,
        escaped(model_name),
        match fmi {
            Fmi::V2 => "guid",
            Fmi::V3 => "instantiationToken",
        },
        fmu_guid(sha256),
        escaped(&about),
        escaped(&format!("SHA-256 {sha256}")),
        escaped(version),
    );
    let step_s = exported.dt_s;
    match fmi {
        Fmi::V2 => format!(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" {names} numberOfEventIndicators="0">
  <CoSimulation modelIdentifier="{FMU_LIBRARY}" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUstate="true" canNotUseMemoryManagementFunctions="true" canSerializeFMUstate="false" providesDirectionalDerivative="false"/>
  <UnitDefinitions>
{units}  </UnitDefinitions>
  <DefaultExperiment startTime="0.0" stepSize="{step_s}"/>
  <ModelVariables>
{rows}  </ModelVariables>
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
"#
        ),
        // Variables are told by their value references, and not by their places from 1 on.
        Fmi::V3 => format!(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" {names}>
  <CoSimulation modelIdentifier="{FMU_LIBRARY}" canHandleVariableCommunicationStepSize="true" canGetAndSetFMUState="true" canSerializeFMUState="false"/>
  <UnitDefinitions>
{units}  </UnitDefinitions>
  <DefaultExperiment startTime="0.0" stepSize="{step_s}"/>
  <ModelVariables>
{rows}    <Float64 name="time" valueReference="{FMU_TIME}" description="Time of the importer" causality="independent" variability="continuous" unit="s"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="2" dependencies=""/>
    <Output valueReference="3" dependencies=""/>
    <InitialUnknown valueReference="2" dependencies="1 4 5 6"/>
    <InitialUnknown valueReference="3" dependencies="1 5"/>
  </ModelStructure>
</fmiModelDescription>
"#
        ),
    }
}

/// A unit of measurement, by SI units where it is known.
fn unit(name: &str) -> String {
    let base = match name {
        "1" => "<BaseUnit/>",
        "s" => r#"<BaseUnit s="1"/>"#,
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
fn row(
    fmi: Fmi,
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
    let (name, reference, unit) = (variable.name(), variable as u32, escaped(unit));
    let of_it = format!(
        "name=\"{name}\" valueReference=\"{reference}\" description=\"{about}\" causality=\"{causality}\" variability=\"{variability}\"{initial}"
    );
    let of_values = format!("unit=\"{unit}\"{range}{start}");
    match fmi {
        Fmi::V2 => format!(
            "    <ScalarVariable {of_it}>\n      <Real {of_values}/>\n    </ScalarVariable>\n"
        ),
        Fmi::V3 => format!("    <Float64 {of_it} {of_values}/>\n"),
    }
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
    fn texts_do_not_end_an_attribute() {
        assert_eq!(escaped("a\"<&>\u{7}"), "a&quot;&lt;&amp;&gt;?");
    }
}
