//! Differences from run to run of a rig that does not repeat.

use comfy_table::{Cell, Table};
use identify::{FittedParameter, ParameterState, RUN_PARAMETERS};
use missing_physics::{Diagnosis, Stage};
use serde_json::{Value, json};

use super::headline::last;
use crate::report::label::label;
use crate::report::number::{percent, spoken};
use crate::report::table::{right, table};

/// A quantity that may differ from run to run.
struct Column {
    /// Its parameter.
    name: &'static str,
    /// Title of its column.
    title: &'static str,
    /// Words for the largest difference.
    said: &'static str,
    shown: fn(f64) -> String,
}

const SURROUNDINGS: Column = Column {
    name: "ambient_level_k",
    title: "surroundings, K",
    said: "{} K in ambient temperature",
    shown: spoken,
};

const HEAT_LOSS: Column = Column {
    name: "run_heat_loss",
    title: "heat loss",
    said: "{} in heat loss",
    shown: percent,
};

const STROKE: Column = Column {
    name: "run_gain",
    title: "stroke",
    said: "{} in stroke",
    shown: percent,
};

const COLUMNS: [Column; 3] = [SURROUNDINGS, HEAT_LOSS, STROKE];

/// By how much recordings differ, in a sentence; `None` where all runs are taken for alike.
#[must_use]
pub(super) fn said(diagnosis: &Diagnosis) -> Option<String> {
    let last = last(diagnosis);
    if !differ(last) {
        return None;
    }
    let largest = |column: &Column| {
        let place = place(last, column.name)?;
        let trained = last.fit.parameters[place].values.iter().skip(1);
        let unseen = last.validated.iter().map(|one| &one.point[place]);
        let sizes = trained.chain(unseen).map(|value| value.abs());
        Some(
            column
                .said
                .replace("{}", &(column.shown)(sizes.fold(0.0, f64::max))),
        )
    };
    let parts: Vec<String> = COLUMNS.iter().filter_map(largest).collect();
    let trained = last.fit.recordings.iter().map(|one| one.name.as_str());
    let unseen = last.validated.iter().map(|one| one.name.as_str());
    let first = label(&last.fit.recordings[0].name, trained.chain(unseen));
    Some(format!(
        "Each run therefore has a state of its own: beside {first} up to {}{}.",
        parts.join(", "),
        if is_told(last) {
            ""
        } else {
            "; no difference in training is told from zero by itself"
        }
    ))
}

/// True if the interval of a difference between training runs leaves zero out.
fn is_told(stage: &Stage) -> bool {
    let places = COLUMNS
        .iter()
        .filter_map(|column| place(stage, column.name));
    places
        .flat_map(|place| {
            stage.fit.parameters[place]
                .intervals
                .iter()
                .skip(1)
                .flatten()
        })
        .any(|interval| interval.lower > 0.0 || interval.upper < 0.0)
}

/// True if a parameter of the single runs is free.
fn differ(stage: &Stage) -> bool {
    RUN_PARAMETERS
        .iter()
        .any(|name| place(stage, name).is_some())
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

/// Differences of each recording from the first training recording, by the last model; `None` if all runs are taken for
/// alike. `shortened` gives the name of a recording for people.
#[must_use]
pub(super) fn runs<'d>(
    diagnosis: &'d Diagnosis,
    shortened: impl Fn(&'d str) -> &'d str,
) -> Option<Table> {
    let last = last(diagnosis);
    let infos = &last.fit.parameters;
    if !differ(last) {
        return None;
    }
    let open = || {
        let open = COLUMNS.iter();
        open.filter_map(|column| Some((place(last, column.name)?, column)))
    };
    let mut header = vec!["recording"];
    header.extend(open().map(|(_, column)| column.title));
    let mut table = table(header);
    for (r, recording) in last.fit.recordings.iter().enumerate() {
        let mut row = vec![Cell::new(shortened(&recording.name))];
        row.extend(open().map(|(place, column)| {
            right(match r {
                0 => "-".to_owned(),
                r => known(&infos[place], r, column.shown),
            })
        }));
        table.add_row(row);
    }
    for validated in &last.validated {
        let name = format!("{} (unseen)", shortened(&validated.name));
        let mut row = vec![Cell::new(name)];
        row.extend(open().map(|(place, column)| right((column.shown)(validated.point[place]))));
        table.add_row(row);
    }
    Some(table)
}

/// Size up to which a value counts as 0.
const NOTHING: f64 = 1e-9;

/// A value in a recording, with the half of its interval.
fn known(parameter: &FittedParameter, r: usize, shown: fn(f64) -> String) -> String {
    let value = parameter.values[r];
    // What does nothing in a recording, since it is recorded or stated of it, stands where its prior has it.
    if value.abs() < NOTHING {
        return "-".to_owned();
    }
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
pub(super) fn json(diagnosis: &Diagnosis) -> Value {
    let last = last(diagnosis);
    if !differ(last) {
        return Value::Null;
    }
    let run = |name: &str, is_unseen: bool, value: &dyn Fn(usize) -> f64| {
        let mut run = json!({"recording": name, "unseen": is_unseen});
        for column in COLUMNS {
            run[column.name] = json!(place(last, column.name).map(value));
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
