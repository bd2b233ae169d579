//! A model as source text: its constants, its choices and what is said of it, in a template.

use pid_tune::{AntiWindup, DerivativeOf};
use sma_effects::EffectId;
use wiener::Drive;
use wiener::hysteresis::{ATAN_COEFFICIENTS, EXPONENTIAL_COEFFICIENTS, Rule, SIN_COEFFICIENTS};

use crate::constants::Constants;
use crate::template::Filling;
use crate::{Controller, ExportError, Exported, Labels};

/// A language, and the template of a model in it.
pub(crate) struct Source<'a> {
    pub(crate) template: &'static str,
    /// Begins the template's own lines: what begins a comment.
    pub(crate) mark: &'static str,
    /// A number as the language reads it; `None` for one beyond the range of its type.
    pub(crate) number: &'a dyn Fn(f64) -> Option<String>,
    /// A line of a table of coefficients.
    pub(crate) coefficient: &'a dyn Fn(&str) -> String,
    /// A text that neither ends a comment nor begins one.
    pub(crate) harmless: fn(&str) -> String,
    /// Type of the numbers.
    pub(crate) precision: &'static str,
}

impl Source<'_> {
    /// A model that was checked, in this language, with more choices and texts.
    pub(crate) fn of(
        &self,
        exported: &Exported,
        flags: &[(&'static str, bool)],
        more: &[(&'static str, String)],
    ) -> Result<String, ExportError> {
        let constants = Constants::of(exported);
        let mut filling = Filling {
            flags: constants.flags,
            ..Filling::default()
        };
        filling.flags.extend(flags.iter().copied());
        for (&name, &value) in &constants.numbers {
            filling.put(name, self.constant(name, value));
            // For people.
            filling.put(&format!("{name}_decimal"), value.to_string());
        }
        for (&name, count) in &constants.counts {
            filling.put(name, count.to_string());
        }
        for (count, name, coefficients) in [
            ("n_sin", "sin_coefficients", &SIN_COEFFICIENTS[..]),
            ("n_atan", "atan_coefficients", &ATAN_COEFFICIENTS[..]),
            ("n_exp", "exp_coefficients", &EXPONENTIAL_COEFFICIENTS[..]),
        ] {
            let line = |&value: &f64| (self.coefficient)(&self.constant(name, value)) + ",\n";
            let lines: String = coefficients.iter().map(line).collect();
            filling.put(name, lines.trim_end().to_owned());
            filling.put(count, coefficients.len().to_string());
        }
        let controller = exported.controller.as_ref();
        if let Some(schedule) = controller.and_then(|one| one.params.gain_schedule) {
            for (name, factors) in [
                ("schedule_heating", schedule.params().heating),
                ("schedule_cooling", schedule.params().cooling),
            ] {
                let line = |&value: &f64| (self.coefficient)(&self.constant(name, value)) + ",\n";
                let lines: String = factors.iter().map(line).collect();
                filling.put(name, lines.trim_end().to_owned());
            }
        }
        for (name, text) in texts(exported) {
            filling.put(name, (self.harmless)(&text));
        }
        for (name, text) in more {
            filling.put(name, text.clone());
        }
        let text = filling.fill(self.template, self.mark);
        // Constants of effects that the model does not have stand nowhere, and may be anything.
        let mut numbers = constants.numbers.iter();
        match numbers.find(|&(name, _)| text.contains(&beyond(name))) {
            None => Ok(text),
            Some((&name, &value)) => Err(ExportError::Range {
                name,
                value,
                precision: self.precision,
            }),
        }
    }

    fn constant(&self, name: &str, value: f64) -> String {
        (self.number)(value).unwrap_or_else(|| beyond(name))
    }
}

/// Text in place of a constant that is beyond the range of its type.
fn beyond(name: &str) -> String {
    format!("beyond the range: {name};")
}

/// Texts of a header or a module.
fn texts(exported: &Exported) -> Vec<(&'static str, String)> {
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
        (
            "ambient_degc",
            labels.ambient_degc.unwrap_or(20.0).to_string(),
        ),
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

fn controller_text(controller: &Controller, labels: &Labels) -> String {
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
    let scheduled = params.gain_schedule.map_or_else(String::new, |schedule| {
        let [lower, upper] = schedule.params().outputs;
        let sign = if controller.is_turned { -1.0 } else { 1.0 };
        format!(
            "; gains by level and branch of the output, {} to {} {}, times 1 to {}",
            sign * lower,
            sign * upper,
            labels.output_unit,
            schedule.largest()
        )
    });
    format!(
        "kp {}, ki {}, kd {} ({} per {}, s); drive {} to {}; derivative of the {watched}, filter {} s; anti-windup {windup}; set-point weight {}{scheduled}",
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
