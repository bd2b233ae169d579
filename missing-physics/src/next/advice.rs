//! Advice on the next experiment, in words.

use crate::Candidate;
use crate::next::drives::{REST_S, seconds, short};
use crate::next::run::{NextExperiment, Run};

fn names(effects: &[Candidate]) -> String {
    let names: Vec<&str> = effects.iter().map(|effect| effect.info().name).collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

pub(crate) fn play(run: &Run, separates: &[Candidate]) -> String {
    let at_rest = run.drive.iter().take_while(|drive| **drive <= 0.0);
    // A run may begin with a rest of its own.
    let rest_s = (run.dt_s * at_rest.count() as f64).min(REST_S);
    format!(
        "Play this run of {} (--save-next next.csv writes it), and diagnose again with its recording as one more of the training: \
         {} at rest, then {}. It should tell {} apart: {} standard deviations ({} if these recordings are repeated).",
        seconds(run.duration_s()),
        seconds(rest_s),
        run.name,
        names(separates),
        short(run.separation),
        short(run.separation_now),
    )
}

/// Advice to record the temperature of the surroundings. If their drift is or may be part of the model and nobody
/// recorded it, no run is worth as much as their temperature.
pub(crate) fn record_surroundings(separates: Vec<Candidate>) -> NextExperiment {
    NextExperiment {
        sentence: format!(
            "Record the temperature of the surroundings, as a column ambient_degc, before you play any other run: while their \
             drift is only guessed, nothing tells {} apart.",
            names(&separates)
        ),
        separates,
        run: None,
    }
}

pub(crate) fn measure(distance: f64, now: f64, separates: &[Candidate]) -> String {
    format!(
        "Record the rod's temperature in runs like these: that would put {} standard deviations between {}; these \
         recordings again: {}. No run within the limits tells them apart without it.",
        short(distance),
        names(separates),
        short(now),
    )
}

pub(crate) fn give_up(farthest: f64, separates: &[Candidate]) -> String {
    format!(
        "No run within the limits tells {} apart: at most {} standard deviations lie between them, and the rod's \
         temperature does not help.",
        names(separates),
        short(farthest),
    )
}
