//! A model as a C99 header.

use sma_effects::EffectId;
use wiener::Drive;
use wiener::hysteresis::{ATAN_COEFFICIENTS, EXPONENTIAL_COEFFICIENTS, Rule, SIN_COEFFICIENTS};

use crate::constants::Constants;
use crate::number::hexadecimal;
use crate::template::Filling;
use crate::{Controller, ExportError, Exported};

const PLANT: &str = include_str!("../templates/plant.h");

/// Type of the numbers in a header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CNumbers {
    /// double: the bits of the program.
    #[default]
    Double,
    /// float: for processors that have nothing wider.
    Float,
}

/// First word of all names in a header, so that several models stand in one program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CPrefix(String);

impl CPrefix {
    /// Checks a prefix.
    ///
    /// # Errors
    ///
    /// [`ExportError::Prefix`] unless it is a lower-case letter followed by at most 30 lower-case letters, digits or
    /// underscores.
    pub fn new(text: &str) -> Result<Self, ExportError> {
        let is_inner = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        let starts = text.starts_with(|c: char| c.is_ascii_lowercase());
        if starts && text.len() <= 31 && text.chars().all(is_inner) {
            Ok(Self(text.to_owned()))
        } else {
            Err(ExportError::Prefix {
                text: text.to_owned(),
            })
        }
    }
}

impl Default for CPrefix {
    fn default() -> Self {
        Self("sma".to_owned())
    }
}

/// The model as a C99 header: plant and, if it has one, controller.
///
/// # Errors
///
/// As [`Exported::checked`]; [`ExportError::Range`] for a constant that is no finite number of the wanted type.
pub fn c_header(
    exported: &Exported,
    numbers: CNumbers,
    prefix: &CPrefix,
) -> Result<String, ExportError> {
    exported.checked()?;
    let constants = Constants::of(exported);
    let is_float = numbers == CNumbers::Float;
    let mut filling = Filling {
        flags: constants.flags.clone(),
        ..Filling::default()
    };
    filling.flags.insert("float", is_float);
    let has_backlash = exported.setting.active.contains(EffectId::Backlash);
    let own_expm1 = has_backlash && !is_float;
    filling.flags.insert("own_expm1", own_expm1);
    for (&name, &value) in &constants.numbers {
        filling.texts.insert(name, constant(name, value, numbers));
    }
    for (&name, count) in &constants.counts {
        filling.texts.insert(name, count.to_string());
    }
    let upper = prefix.0.to_ascii_uppercase();
    for (count, name, coefficients) in [
        ("n_sin", "sin_coefficients", &SIN_COEFFICIENTS[..]),
        ("n_atan", "atan_coefficients", &ATAN_COEFFICIENTS[..]),
        ("n_exp", "exp_coefficients", &EXPONENTIAL_COEFFICIENTS[..]),
    ] {
        let line = |&value: &f64| {
            let number = constant(name, value, numbers);
            format!("        {upper}_R({number})")
        };
        let lines: Vec<String> = coefficients.iter().map(line).collect();
        filling.texts.insert(name, lines.join(",\n"));
        filling.texts.insert(count, coefficients.len().to_string());
    }
    let flat = if is_float { "1e30" } else { "1e300" };
    let fallen = match constants.flags["falls_on_heating"] {
        true => format!("{upper}_R(1.0) - share"),
        false => "share".to_owned(),
    };
    let tolerance = match numbers {
        CNumbers::Double => DOUBLE,
        CNumbers::Float => FLOAT,
    };
    for (name, text) in [
        ("p", prefix.0.clone()),
        ("P", upper),
        ("flat", flat.to_owned()),
        ("fallen", fallen),
        ("tolerance_text", tolerance.to_owned()),
    ] {
        filling.texts.insert(name, text);
    }
    for (name, text) in texts(exported) {
        filling.texts.insert(name, in_comment(&text));
    }
    let header = filling.fill(PLANT, "//");
    // Constants of effects that the model does not have stand nowhere, and may be anything.
    match constants
        .numbers
        .iter()
        .find(|&(name, _)| header.contains(&beyond(name)))
    {
        None => Ok(header),
        Some((&name, &value)) => Err(ExportError::Range {
            name,
            value,
            precision: match numbers {
                CNumbers::Double => "double",
                CNumbers::Float => "float",
            },
        }),
    }
}

/// Text in place of a constant that is beyond the range of its type.
fn beyond(name: &str) -> String {
    format!("beyond the range: {name};")
}

const DOUBLE: &str = "Outputs have the bits of the program; with supply-lag they agree to 1e-12 of the\n * stroke, since logarithms are those of the C library.";
const FLOAT: &str = "Outputs agree with the program to 1e-4 of the stroke for time constants of up\n * to 1000 samples.";

/// Texts of a header or a module.
pub(crate) fn texts(exported: &Exported) -> Vec<(&'static str, String)> {
    let labels = &exported.labels;
    let rule = match exported.setting.rule {
        Rule::LastReversal => "the last reversal (minor loops do not close)",
        Rule::Nested => "all reversals that enclose the branch (minor loops close)",
    };
    let kind = match exported.setting.drive {
        Drive::Current => "current, A",
        Drive::Duty { .. } => "duty, 0 to 1",
        Drive::Voltage { .. } => "voltage, V",
        Drive::Power { .. } => "power, W",
    };
    let limit = exported.drive_limit.map_or_else(String::new, |limit| {
        format!("; beyond {limit} the supply gives no more")
    });
    let effects: Vec<&str> = exported.setting.active.iter().map(EffectId::id).collect();
    let or_none = |words: String| {
        if words.is_empty() {
            "none".to_owned()
        } else {
            words
        }
    };
    let start = &exported.member.start;
    vec![
        (
            "title",
            "Model of a shape-memory-alloy actuator: drive to displacement.".to_owned(),
        ),
        ("model_file", labels.model_file.clone()),
        ("sha256", labels.sha256.clone()),
        ("version", labels.version.clone()),
        ("command", labels.command.clone()),
        ("dt_s", exported.dt_s.to_string()),
        ("output_unit", labels.output_unit.clone()),
        ("drive_text", format!("{kind}{limit}")),
        (
            "start_text",
            format!(
                "{} starts {} K above its surroundings, at a share of {}.",
                labels.recording, start.temperature_degc, start.share
            ),
        ),
        (
            "offset_text",
            format!(
                "{} {}, that of {}; change OFFSET to the reading of your own sensor",
                exported.member.params.offset, labels.output_unit, labels.recording
            ),
        ),
        ("rule_text", rule.to_owned()),
        ("effects_text", or_none(effects.join(", "))),
        ("left_out_text", or_none(labels.left_out.join("; "))),
        (
            "pid_text",
            exported
                .controller
                .as_ref()
                .map_or_else(String::new, |one| controller_text(one, labels)),
        ),
    ]
}

fn controller_text(controller: &Controller, labels: &crate::Labels) -> String {
    use pid_tune::{AntiWindup, DerivativeOf};
    let Controller { params, gains, .. } = controller;
    let windup = match params.anti_windup {
        AntiWindup::Off => "none",
        AntiWindup::Clamping => "clamping",
        AntiWindup::BackCalculation { .. } => "back-calculation",
    };
    let watched = match params.derivative_of {
        DerivativeOf::Error => "error",
        DerivativeOf::Measurement => "measurement",
    };
    format!(
        "kp {}, ki {}, kd {} ({} per {}, s); drive {} to {}; derivative of the {watched}, filter {} s; anti-windup {windup}; set-point weight {}",
        gains.kp,
        gains.ki,
        gains.kd,
        labels.drive_unit,
        labels.output_unit,
        params.limits.lower,
        params.limits.upper,
        params.derivative_filter_s,
        params.setpoint_weight
    )
}

/// A constant as C reads it.
fn constant(name: &str, value: f64, numbers: CNumbers) -> String {
    let held = match numbers {
        CNumbers::Double => value,
        CNumbers::Float => f64::from(value as f32),
    };
    if held.is_finite() {
        hexadecimal(held)
    } else {
        beyond(name)
    }
}

/// A text that neither ends a comment nor begins one.
fn in_comment(text: &str) -> String {
    let text = text.replace("*/", "* /").replace("/*", "/ *");
    text.chars()
        .map(|c| if c.is_control() { '?' } else { c })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_do_not_end_the_comment() {
        assert_eq!(
            in_comment("runs/*.csv */ int x\n"),
            "runs/ *.csv * / int x?"
        );
    }

    #[test]
    fn prefixes_are_identifiers() {
        assert!(CPrefix::new("rod_2").is_ok());
        let long = "a".repeat(32);
        for text in ["", "2rod", "Rod", "rod-2", "_rod", long.as_str()] {
            let error = CPrefix::new(text).unwrap_err().to_string();
            assert!(error.contains("must be a lower-case letter"), "{error}");
        }
    }
}
