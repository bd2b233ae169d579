//! What differs from run to run of a rig that does not repeat.

use comfy_table::{Cell, Table};
use identify::{FittedParameter, ParameterState};
use missing_physics::{Diagnosis, Stage};

use super::number::{percent, spoken};
use super::table::{right, table};

/// A column: the parameter, what stands over it, and how its values are shown.
const COLUMNS: [(&str, &str, fn(f64) -> String); 3] = [
    ("ambient_level_k", "surroundings, K", spoken),
    ("run_heat_loss", "heat loss", percent),
    ("run_gain", "stroke", percent),
];

/// What each recording has over the first of the training, by the last model; `None` where all runs are taken for alike. `label` shortens
/// the name of a recording.
#[must_use]
pub fn runs<'d>(diagnosis: &'d Diagnosis, label: impl Fn(&'d str) -> &'d str) -> Option<Table> {
    let last: &Stage = diagnosis
        .extended
        .as_ref()
        .map_or(&diagnosis.baseline, |extended| &extended.stage);
    let infos = &last.fit.parameters;
    let is_open = |name: &str| {
        let found = infos.iter().position(|one| one.info.name == name)?;
        (infos[found].info.state == ParameterState::Free).then_some(found)
    };
    is_open(COLUMNS[1].0)?;
    let columns = COLUMNS.map(|(name, title, shown)| (is_open(name), title, shown));
    let open = || {
        let open = columns.iter();
        open.filter_map(|(place, title, shown)| Some(((*place)?, *title, *shown)))
    };
    let mut header = vec!["recording"];
    header.extend(open().map(|(_, title, _)| title));
    let mut table = table(header);
    for (r, recording) in last.fit.recordings.iter().enumerate() {
        let mut row = vec![Cell::new(label(&recording.name))];
        row.extend(open().map(|(place, _, shown)| {
            right(match r {
                0 => "-".to_owned(),
                r => known(&infos[place], r, shown),
            })
        }));
        table.add_row(row);
    }
    for validated in &last.validated {
        let name = format!("{} (unseen)", label(&validated.name));
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
