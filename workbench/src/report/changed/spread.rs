//! Table of how the runs of the reference differ from one another, with the runs since beside them.

use comfy_table::{Cell, Table};
use missing_physics::{ChangeEvidence, StateSpread};

use crate::report::number::spoken;
use crate::report::table::{right, table};

/// Size up to which a value counts as 0: surroundings that were recorded do not deviate.
const NOTHING: f64 = 1e-9;

/// Instructions for the table.
pub(crate) const HOW_TO_READ_SPREAD: &str = "Each run has values of its own, beside laws that all runs share: another state of a run is no finding. All are fitted \
     under laws that do not know the run. Ordinary: the standard deviation that is expected in a laboratory, about 0, with which these values \
     enter the judgement. Where something has changed, the values of the runs since may have taken a part of it.";

/// A row for each quantity: mean and standard deviation over the reference, and where the runs since stand.
pub(crate) fn spread(evidence: &ChangeEvidence) -> Table {
    let header = [
        "of each run",
        "unit",
        "reference: mean",
        "standard deviation",
        "ordinary deviation",
        "runs since",
        "farthest, ordinary deviations",
    ];
    let mut table = table(header);
    for state in evidence.states.iter().filter(|state| deviates(state)) {
        let scale = scale(state);
        let shown = |value: f64| spoken(scale * value);
        let or_unknown = |value: Option<f64>| right(value.map_or("-".to_owned(), shown));
        let farthest = |ordinary: f64| {
            let mean = state.mean()?;
            let far = state.since.iter().map(|value| (value - mean) / ordinary);
            far.max_by(|a, b| a.abs().total_cmp(&b.abs()))
        };
        table.add_row([
            Cell::new(title(state.parameter)),
            Cell::new(unit(state)),
            or_unknown(state.mean()),
            or_unknown(state.deviation()),
            or_unknown(state.prior_deviation),
            right(range(&state.since, shown)),
            right(
                state
                    .prior_deviation
                    .and_then(farthest)
                    .map_or("-".to_owned(), |far| format!("{far:+.1}")),
            ),
        ]);
    }
    table
}

fn deviates(state: &StateSpread) -> bool {
    let mut values = state.of_reference.iter().chain(&state.since);
    values.any(|value| value.abs() > NOTHING)
}

/// Name of a quantity for people.
pub(super) fn title(parameter: &str) -> &str {
    match parameter {
        "ambient_level_k" => "surroundings, over those of rod.toml",
        "run_heat_loss" => "heat loss, over the laws",
        "run_gain" => "stroke (gain), over the laws",
        "offset" => "output at the start (start strain)",
        "start_rise_k" => "start, over the surroundings",
        "start_share" => "start, share of the way to the cooling branch",
        "start_since_reversal_k" => "start, heated since the last reversal",
        other => other,
    }
}

/// True for a share, which is shown in percent.
fn is_share(state: &StateSpread) -> bool {
    state.unit == "1"
}

fn scale(state: &StateSpread) -> f64 {
    if is_share(state) { 100.0 } else { 1.0 }
}

fn unit(state: &StateSpread) -> &str {
    if is_share(state) { "%" } else { &state.unit }
}

/// The lowest and the highest of some values.
fn range(values: &[f64], shown: impl Fn(f64) -> String) -> String {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    match [low, high].map(shown) {
        [low, high] if low == high => low,
        [low, high] => format!("{low} … {high}"),
    }
}
