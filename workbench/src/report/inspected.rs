//! Report of `sma inspect`: text for people, JSON for programs.

use std::fmt::Write;

use recording::{Channel, Gap, Inspection, NoiseFloor, Sampling};
use serde_json::{Value, json};

use super::number::{count, significant};

/// Gaps that are listed; more are summed up.
pub(crate) const MOST_GAPS: usize = 3;

/// Many gaps in a line.
pub(crate) fn gaps_at_once(gaps: &[Gap]) -> String {
    let longest = gaps.iter().max_by(|a, b| a.dt_s.total_cmp(&b.dt_s));
    let sum_s: f64 = gaps.iter().map(|gap| gap.dt_s).sum();
    longest.map_or(String::new(), |longest| {
        format!(
            "{}, {} s in all, the longest of {} s from {} s on",
            gaps.len(),
            significant(sum_s),
            significant(longest.dt_s),
            significant(longest.start_s)
        )
    })
}

/// For people: what is there, then what stands in the way.
#[must_use]
pub fn text(inspection: &Inspection) -> String {
    let mut text = format!("{}\n", inspection.name);
    let mut line = |what: &str, said: String| {
        let _ = writeln!(text, "  {what:<12}{said}");
    };
    for adaptation in &inspection.adaptations {
        line("read as", adaptation.to_string());
    }
    line("samples", samples(inspection));
    for channel in channels(inspection) {
        line(channel.role, described(channel));
    }
    line(
        "noise",
        inspection
            .noise_floor
            .as_ref()
            .map_or("not estimated".to_owned(), |floor| {
                noise(floor, &inspection.output.unit)
            }),
    );
    line("cycles", cycles(inspection));
    if inspection.gaps.len() > MOST_GAPS {
        line("gaps", gaps_at_once(&inspection.gaps));
    }
    let few = match inspection.gaps.len() {
        0..=MOST_GAPS => &inspection.gaps[..],
        _ => &[],
    };
    for gap in few {
        line(
            "gap",
            format!(
                "{} s from {} s on",
                significant(gap.dt_s),
                significant(gap.start_s)
            ),
        );
    }
    let warnings = inspection.warnings();
    if warnings.is_empty() {
        text.push_str("Nothing stands in the way of identification.\n");
    }
    for warning in warnings {
        let _ = writeln!(text, "- {warning}");
    }
    text
}

fn channels(inspection: &Inspection) -> impl Iterator<Item = &Channel> {
    std::iter::once(&inspection.drive)
        .chain(&inspection.antagonist)
        .chain([&inspection.output])
        .chain(&inspection.temperature)
        .chain(&inspection.ambient)
        .chain(&inspection.stress)
        .chain(&inspection.resistance)
}

fn samples(inspection: &Inspection) -> String {
    let n = count(inspection.n_samples);
    let lasts = inspection
        .duration_s
        .map_or(String::new(), |s| format!(" over {} s", significant(s)));
    let steps = match inspection.sampling {
        Sampling::Uniform { dt_s } => format!("every {} s", significant(dt_s)),
        Sampling::Jittered {
            median_dt_s,
            min_dt_s,
            max_dt_s,
        } => format!(
            "every {} s in the median, from {} to {} s",
            significant(median_dt_s),
            significant(min_dt_s),
            significant(max_dt_s)
        ),
        Sampling::Untimed => "without time".to_owned(),
    };
    format!("{n}{lasts}, {steps}")
}

fn described(channel: &Channel) -> String {
    let unit = &channel.unit;
    let mut said = format!(
        "{} to {} {unit}",
        significant(channel.lowest),
        significant(channel.highest)
    );
    if let Some(step) = channel.quantization_step {
        let _ = write!(said, ", in steps of {} {unit}", significant(step));
    }
    for flat in &channel.flat {
        let _ = write!(
            said,
            "; flat at {} in {} samples",
            significant(flat.at),
            count(flat.samples)
        );
    }
    said
}

fn noise(floor: &NoiseFloor, unit: &str) -> String {
    match floor.upper() {
        Some(upper) => {
            format!(
                "{} to {} {unit}, standard deviation",
                significant(floor.lower()),
                significant(upper)
            )
        }
        None => format!(
            "at least {} {unit}, standard deviation",
            significant(floor.lower())
        ),
    }
}

fn cycles(inspection: &Inspection) -> String {
    let repeated =
        inspection
            .repeats
            .as_ref()
            .map_or("none of them repeated".to_owned(), |repeats| {
                format!(
                    "{} repeated every {} s",
                    repeats.cycles.len(),
                    significant(repeats.period_s)
                )
            });
    format!(
        "{} whole ones of the drive, {repeated}; {} samples of rest before",
        inspection.cycles.len(),
        count(inspection.rest_samples)
    )
}

/// For programs.
pub fn json(inspection: &Inspection) -> Value {
    let sampling = match inspection.sampling {
        Sampling::Uniform { dt_s } => json!({"kind": "uniform", "dt_s": dt_s}),
        Sampling::Jittered {
            median_dt_s,
            min_dt_s,
            max_dt_s,
        } => json!({
            "kind": "jittered", "median_dt_s": median_dt_s, "min_dt_s": min_dt_s, "max_dt_s": max_dt_s,
        }),
        Sampling::Untimed => json!({"kind": "untimed"}),
    };
    let channels: Vec<Value> = channels(inspection)
        .map(|channel| {
            json!({
                "role": channel.role,
                "unit": channel.unit,
                "lowest": channel.lowest,
                "highest": channel.highest,
                "quantization_step": channel.quantization_step,
                "flat_at": channel.flat.iter().map(|flat| flat.at).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "name": inspection.name,
        "adaptations": inspection.adaptations.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "n_samples": inspection.n_samples,
        "duration_s": inspection.duration_s,
        "sampling": sampling,
        "gaps": inspection.gaps.iter().map(|gap| json!({"start_s": gap.start_s, "dt_s": gap.dt_s})).collect::<Vec<_>>(),
        "channels": channels,
        "noise_floor": inspection.noise_floor.as_ref().map(|floor| json!({
            "lower": floor.lower(), "upper": floor.upper(), "unit": inspection.output.unit,
        })),
        "cycles": inspection.cycles.len(),
        "repeated_cycles": inspection.repeats.as_ref().map_or(0, |repeats| repeats.cycles.len()),
        "rest_samples": inspection.rest_samples,
        "warnings": inspection.warnings().iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}
