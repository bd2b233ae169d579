//! How far a rig repeats, in words.

use std::fmt::Write;

use recording::{Difference, Part, RepeatFloor, RepeatedDrive};
use serde_json::{Value, json};

use super::label::label;
use super::number::{behind, percent, significant, spoken};

/// Pairs that a person reads; JSON has all.
const ROWS: usize = 5;

/// For people: what runs of the same drive differ by, pair for pair.
#[must_use]
pub fn text(floor: &RepeatFloor) -> String {
    let unit = behind(&floor.unit);
    let mut text = "Runs of the same drive\n".to_owned();
    let pairs = || floor.pairs.iter().chain(&floor.first_cycles);
    for (number, pair) in pairs().take(ROWS).enumerate() {
        let is_first = number >= floor.pairs.len();
        let _ = writeln!(
            text,
            "  {}{}: {}{unit} apart beside an offset of {}{unit}{}",
            if is_first {
                "after another beginning, "
            } else {
                ""
            },
            both(pair, floor),
            significant(pair.apart.rms),
            significant(pair.apart.offset),
            of_what(pair, &unit)
        );
    }
    if pairs().count() > ROWS {
        let _ = writeln!(text, "  and {} more", pairs().count() - ROWS);
    }
    text + &said(floor).map_or(String::new(), |said| said + "\n")
}

/// Conclusion from the repeats, in a sentence or two. `None` if only a first cycle is repeated, before which the rod was in
/// another state.
#[must_use]
pub fn said(floor: &RepeatFloor) -> Option<String> {
    let unit = behind(&floor.unit);
    let which = match floor.pairs.as_slice() {
        [one] => both(one, floor),
        several => format!("{} pairs", several.len()),
    };
    let apart = format!(
        "they are {}{unit} RMS apart ({which}), and noise makes {}{unit}",
        spoken(floor.rms()?),
        spoken(floor.by_noise()?)
    );
    Some(if floor.is_noise() {
        format!("Runs of the same drive repeat: {apart}.")
    } else {
        format!(
            "Runs of the same drive do not repeat: {apart}. With the same parameters in both, no model can be nearer than half of that, {}{unit}, to \
             both. Record the surroundings of each run, to see if they are the cause.",
            spoken(floor.nearest()?)
        )
    })
}

/// For programs.
#[must_use]
pub fn json(floor: &RepeatFloor) -> Value {
    let pair = |pair: &RepeatedDrive| {
        let part = |part: &Part| json!({"recording": part.recording, "start_s": part.start_s, "end_s": part.end_s});
        let differences: Vec<Value> = pair
            .apart
            .differences
            .iter()
            .map(|difference| match difference {
                Difference::Gain(share) => json!({"is": "gain", "share": share}),
                Difference::HeatingLater(by_s) => json!({"is": "heating_later", "by_s": by_s}),
                Difference::CoolingLater(by_s) => json!({"is": "cooling_later", "by_s": by_s}),
                Difference::Slower(share) => json!({"is": "slower", "share": share}),
            })
            .collect();
        json!({
            "first": part(&pair.first),
            "second": part(&pair.second),
            "samples": pair.samples,
            "offset": pair.apart.offset,
            "rms": pair.apart.rms,
            "by_noise": pair.by_noise,
            "differences": differences,
            "left": pair.apart.left,
        })
    };
    json!({
        "rms": floor.rms(),
        "nearest": floor.nearest(),
        "by_noise": floor.by_noise(),
        "unit": floor.unit,
        "pairs": floor.pairs.iter().map(pair).collect::<Vec<_>>(),
        "first_cycles": floor.first_cycles.iter().map(pair).collect::<Vec<_>>(),
    })
}

/// Both stretches of a pair.
#[must_use]
pub fn both(pair: &RepeatedDrive, floor: &RepeatFloor) -> String {
    let [first, second] = [&pair.first, &pair.second];
    let at = |part: &Part| format!("{} to {} s", spoken_s(part.start_s), spoken_s(part.end_s));
    if first.recording == second.recording {
        format!(
            "{}, {} and {}",
            of_part(first, floor),
            at(first),
            at(second)
        )
    } else if (first.start_s - second.start_s).abs() < 1e-3 * (first.end_s - first.start_s) {
        format!(
            "{} and {}, {}",
            of_part(first, floor),
            of_part(second, floor),
            at(first)
        )
    } else {
        format!(
            "{}, {}, and {}, {}",
            of_part(first, floor),
            at(first),
            of_part(second, floor),
            at(second)
        )
    }
}

fn spoken_s(time_s: f64) -> String {
    format!("{:.1}", time_s)
}

/// Components of a difference beside an offset: gain, speed, delays; empty if there are none.
fn of_what(pair: &RepeatedDrive, unit: &str) -> String {
    if pair.apart.differences.is_empty() {
        return String::new();
    }
    let size = |share: f64, [more, less]: [&str; 2]| {
        format!(
            "{} {}",
            percent(share.abs()),
            if share > 0.0 { more } else { less }
        )
    };
    let later = |by_s: f64, what: &str| {
        format!(
            "{} s {} {what}",
            spoken(by_s.abs()),
            if by_s > 0.0 { "later" } else { "earlier" }
        )
    };
    let said: Vec<String> = pair
        .apart
        .differences
        .iter()
        .map(|difference| match *difference {
            Difference::Gain(share) => format!("moves {}", size(share, ["further", "less far"])),
            Difference::Slower(share) => format!("is {}", size(share, ["slower", "faster"])),
            Difference::HeatingLater(by_s) => format!("is {}", later(by_s, "when heated")),
            Difference::CoolingLater(by_s) => format!("is {}", later(by_s, "when it cools")),
        })
        .collect();
    format!(
        "; the second {}: without that {}{unit}",
        said.join(" and "),
        significant(pair.apart.left)
    )
}

fn of_part<'n>(part: &'n Part, floor: &'n RepeatFloor) -> &'n str {
    let pairs = floor.pairs.iter().chain(&floor.first_cycles);
    let mut names: Vec<&str> = pairs
        .flat_map(|pair| [&pair.first, &pair.second])
        .map(|part| part.recording.as_str())
        .collect();
    names.sort_unstable();
    names.dedup();
    label(&part.recording, names.into_iter())
}
