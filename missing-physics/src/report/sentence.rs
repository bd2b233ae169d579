//! Findings in words.

use std::fmt::Write;

use crate::next::drives::short;
use crate::report::diagnosis::Estimate;
use crate::{EffectInfo, EffectParameter, LoopFamily, Role};

/// A quantity as people say it: value, half of its interval, unit.
struct Said {
    value: f64,
    half: Option<f64>,
    unit: String,
    factor: f64,
}

impl Said {
    /// `is_share` says whether a pure number is a share of something.
    fn of(estimate: &Estimate, is_share: bool) -> Self {
        let (factor, unit) = match estimate.unit {
            "1" if is_share => (100.0, "%".to_owned()),
            "1" => (1.0, String::new()),
            "of the stroke" => (100.0, "% of the stroke".to_owned()),
            "J/kg" => (1e-3, "kJ/kg".to_owned()),
            unit if unit.starts_with("1/K") => (1e6, "·10⁻⁶/K".to_owned()),
            unit => (1.0, unit.to_owned()),
        };
        Self {
            value: factor * estimate.value,
            half: estimate
                .ci95
                .map(|[lower, upper]| 0.5 * factor * (upper - lower)),
            unit,
            factor,
        }
    }
}

/// Value, half of the interval and unit, with as many digits as the interval leaves.
fn quantity(said: &Said) -> String {
    let coarse = said
        .half
        .filter(|half| *half > 0.0)
        .unwrap_or(said.value.abs() / 100.0);
    let decimals = if coarse > 0.0 {
        // One digit of the uncertainty, two where it begins with 1.
        (-(coarse * 0.5).log10().floor()).clamp(0.0, 6.0) as usize
    } else {
        0
    };
    let mut text = format!("{:.decimals$}", said.value);
    if let Some(half) = said.half {
        let _ = write!(text, " ± {half:.decimals$}");
    }
    if said.unit.starts_with('·') {
        if said.half.is_some() {
            text = format!("({text})");
        }
        return text + &said.unit;
    }
    if !said.unit.is_empty() {
        text.push(' ');
    }
    text + &said.unit
}

/// True if a template's pure number is a share: "{value} of the stroke", "up to {value}".
fn is_share(template: &str, place: &str) -> bool {
    let after = template.split(place).nth(1).unwrap_or("");
    after.starts_with(" of")
        || after.starts_with(" wider")
        || template.contains(&format!("up to {place}"))
}

/// Sentence of a finding: that of its effect, with its numbers and their range in the literature.
pub(crate) fn finding(info: &EffectInfo, estimates: &[Estimate]) -> String {
    let sizes = info
        .parameters
        .iter()
        .zip(estimates)
        .filter(|(parameter, _)| parameter.role == Role::Size);
    // What the name rests on, or the largest.
    let carries = |parameter: &EffectParameter| parameter.least > 0.0;
    let largest = sizes
        .map(|(parameter, estimate)| {
            (
                estimate.value.abs() / parameter.typical,
                parameter,
                estimate,
            )
        })
        .max_by(|a, b| carries(a.1).cmp(&carries(b.1)).then(a.0.total_cmp(&b.0)));
    let partner = info
        .parameters
        .iter()
        .zip(estimates)
        .find(|(parameter, _)| parameter.role != Role::Size);
    let mut text = capitalized(info.name) + " is missing: " + info.sentence;
    if let Some((_, parameter, size)) = largest {
        let said = Said::of(size, is_share(info.sentence, "{value}"));
        text = text.replace("{value}", &quantity(&said));
        if let Some([lower, upper]) = size.literature {
            let ends = [lower, upper].map(|end| short(said.factor * end));
            let unit = if said.unit.is_empty() || said.unit.starts_with('·') {
                said.unit
            } else {
                format!(" {}", said.unit)
            };
            let _ = write!(text, " (literature {} to {}{unit})", ends[0], ends[1]);
        }
        let beyond = size.unit.strip_prefix(parameter.unit);
        if let Some(condition) = beyond.and_then(|rest| rest.strip_prefix(" at ")) {
            let _ = write!(text, ", for {condition}");
        }
    }
    if let Some((_, partner)) = partner {
        let said = Said::of(partner, is_share(info.sentence, "{partner}"));
        text = text.replace("{partner}", &quantity(&said));
    }
    text + "."
}

/// Sentence of a finding of a loop of another family.
pub(crate) fn of_family(info: &EffectInfo, family: LoopFamily) -> String {
    let curves = match family {
        LoopFamily::Proximity => "the paper's",
        LoopFamily::Relays => {
            "those of many independent relays (Preisach), each with its own pair of temperatures"
        }
        LoopFamily::Kinetics => {
            "those of cosine kinetics (Liang and Rogers), with a plateau after each reversal"
        }
    };
    format!(
        "{} is missing: the loop's curves are {curves}.",
        capitalized(info.name)
    )
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().to_string() + letters.as_str()
    })
}
