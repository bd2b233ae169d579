//! What differs from run to run of a rig that does not repeat.

use comfy_table::{Cell, Table};
use identify::{FittedParameter, ParameterState};
use missing_physics::{Diagnosis, Stage};
use serde_json::{Value, json};

use super::label::label;
use super::number::{percent, spoken};
use super::table::{right, table};

/// A column: the parameter, what stands over it, and how its values are shown.
const COLUMNS: [(&str, &str, fn(f64) -> String); 3] = [
    ("ambient_level_k", "surroundings, K", spoken),
    ("run_heat_loss", "heat loss", percent),
    ("run_gain", "stroke", percent),
];

/// By how much recordings differ, in a sentence; `None` where all runs are taken for alike.
#[must_use]
pub fn said(diagnosis: &Diagnosis) -> Option<String> {
    let last = last(diagnosis);
    place(last, COLUMNS[1].0)?;
    let parts: Vec<String> = [
        "the surroundings by up to {} K",
        "the heat loss by {}",
        "the stroke by {}",
    ]
    .into_iter()
    .zip(COLUMNS)
    .filter_map(|(said, (name, _, shown))| {
        let place = place(last, name)?;
        let trained = last.fit.parameters[place].values.iter().skip(1);
        let unseen = last.validated.iter().map(|one| &one.point[place]);
        let largest = trained
            .chain(unseen)
            .fold(0.0, |largest: f64, value| largest.max(value.abs()));
        Some(said.replace("{}", &shown(largest)))
    })
    .collect();
    let recording = &last.fit.recordings[0].name;
    let first = label(recording, std::iter::once(recording.as_str()));
    Some(format!(
        "Against {first} runs differ: {}.",
        parts.join(", ")
    ))
}

fn last(diagnosis: &Diagnosis) -> &Stage {
    diagnosis
        .extended
        .as_ref()
        .map_or(&diagnosis.baseline, |extended| &extended.stage)
}

/// Place of a parameter that is open.
fn place(stage: &Stage, name: &str) -> Option<usize> {
    let infos = stage.fit.parameters.iter();
    let mut open = infos
        .enumerate()
        .filter(|(_, one)| one.info.state == ParameterState::Free);
    open.find(|(_, one)| one.info.name == name)
        .map(|(place, _)| place)
}

/// What each recording has over the first of the training, by the last model; `None` where all runs are taken for alike. `shortened` is
/// the name of a recording for people.
#[must_use]
pub fn runs<'d>(diagnosis: &'d Diagnosis, shortened: impl Fn(&'d str) -> &'d str) -> Option<Table> {
    let last = last(diagnosis);
    let infos = &last.fit.parameters;
    place(last, COLUMNS[1].0)?;
    let columns = COLUMNS.map(|(name, title, shown)| (place(last, name), title, shown));
    let open = || {
        let open = columns.iter();
        open.filter_map(|(place, title, shown)| Some(((*place)?, *title, *shown)))
    };
    let mut header = vec!["recording"];
    header.extend(open().map(|(_, title, _)| title));
    let mut table = table(header);
    for (r, recording) in last.fit.recordings.iter().enumerate() {
        let mut row = vec![Cell::new(shortened(&recording.name))];
        row.extend(open().map(|(place, _, shown)| {
            right(match r {
                0 => "-".to_owned(),
                r => known(&infos[place], r, shown),
            })
        }));
        table.add_row(row);
    }
    for validated in &last.validated {
        let name = format!("{} (unseen)", shortened(&validated.name));
        let mut row = vec![Cell::new(name)];
        row.extend(open().map(|(place, _, shown)| right(shown(validated.point[place]))));
        table.add_row(row);
    }
    Some(table)
}

/// A value in a recording, with the half of its interval.
fn known(parameter: &FittedParameter, r: usize, shown: fn(f64) -> String) -> String {
    let value = parameter.values[r];
    match parameter.intervals[r] {
        Some(own) => format!(
            "{} ± {}",
            shown(value),
            shown(0.5 * (own.upper - own.lower))
        ),
        None => shown(value),
    }
}

/// For programs: what [`runs`] has; null where all runs are taken for alike.
#[must_use]
pub fn json(diagnosis: &Diagnosis) -> Value {
    let last = last(diagnosis);
    if place(last, COLUMNS[1].0).is_none() {
        return Value::Null;
    }
    let run = |name: &str, is_unseen: bool, value: &dyn Fn(usize) -> f64| {
        let mut run = json!({"recording": name, "unseen": is_unseen});
        for (parameter, ..) in COLUMNS {
            run[parameter] = json!(place(last, parameter).map(value));
        }
        run
    };
    let trained = last.fit.recordings.iter().enumerate();
    let trained = trained.map(|(r, one)| {
        run(&one.name, false, &|place| {
            last.fit.parameters[place].values[r]
        })
    });
    let unseen = last.validated.iter();
    let unseen = unseen.map(|one| run(&one.name, true, &|place| one.point[place]));
    trained.chain(unseen).collect()
}
