//! The figures of a diagnosis.

use missing_physics::{Diagnosis, Rung};
use recording::Recording;

use super::{Compared, Figure, Series, Style, axis};
use crate::report::plot::Left;
use crate::report::repeated::both;

/// A diagnosis, and its recordings with what the models say of them.
#[derive(Debug)]
pub struct Drawn<'a> {
    /// Result of the diagnosis.
    pub diagnosis: &'a Diagnosis,
    /// The recordings and the models on them: first the one that the baseline model meets worst.
    pub compared: Vec<Compared<'a>>,
}

impl<'a> Drawn<'a> {
    /// A diagnosis and its recordings, each with its name for people and the models on it; at least one, the worst first.
    #[must_use]
    pub fn new(
        diagnosis: &'a Diagnosis,
        recordings: impl IntoIterator<Item = (&'a Recording, &'a str, &'a [Left])>,
    ) -> Self {
        let compared = recordings.into_iter().map(|(recording, name, models)| {
            let spans = diagnosis.mismatch.spans.iter();
            let own = spans.filter(|span| span.recording == recording.name());
            Compared {
                recording,
                name,
                models,
                spans_s: own.map(|span| [span.start_s, span.end_s]).collect(),
            }
        });
        Self {
            diagnosis,
            compared: compared.collect(),
        }
    }
}

/// The recording that is met worst and the models on it over time, their residuals, the drive, the loops, two runs of the same
/// drive where there are any, and the errors down to the noise.
#[must_use]
pub fn figures(drawn: &Drawn<'_>) -> Vec<Figure> {
    let worst = drawn.compared.first();
    let mut figures = worst.map_or(Vec::new(), Compared::figures);
    figures.extend(same_drive(drawn));
    figures.push(ladder(drawn));
    figures
}

/// All recordings with the models on them as CSV, a file each: name of the file and text.
#[must_use]
pub fn series_csv(drawn: &Drawn<'_>) -> Vec<(String, String)> {
    let numbered = drawn.compared.iter().enumerate();
    numbered
        .map(|(k, one)| {
            let stem = one.name.rsplit_once('.').map_or(one.name, |(stem, _)| stem);
            let safe = |c: char| if c.is_alphanumeric() { c } else { '-' };
            let stem: String = stem.chars().map(safe).collect();
            (format!("series-{}-{stem}.csv", k + 1), one.csv())
        })
        .collect()
}

/// Difference between the longest two runs of the same drive.
#[must_use]
pub fn same_drive(drawn: &Drawn<'_>) -> Option<Figure> {
    let floor = drawn.diagnosis.repeats.as_ref()?;
    let pair = floor.pairs.first()?;
    let outputs = pair.apart.outputs.iter();
    let apart = outputs.map(|[t, first, second]| [*t, second - first]);
    Some(Figure {
        name: "same-drive",
        caption: format!(
            "Two runs of the same drive: their difference, less its mean. With the same parameters in both runs no model can follow it. {}.",
            both(pair, floor)
        ),
        across: "time, s".to_owned(),
        up: axis("second - first", &floor.unit),
        series: vec![Series::new("second - first", Style::Unseen, apart)],
        ..Figure::default()
    })
}

/// Letters of names that stand side by side beneath bars.
const MOST_LETTERS: usize = 48;

/// Errors from the baseline model down to the noise, an effect at a time.
#[must_use]
pub fn ladder(drawn: &Drawn<'_>) -> Figure {
    let diagnosis = drawn.diagnosis;
    let rungs = &diagnosis.ladder;
    let over = |of: fn(&Rung) -> Option<f64>| -> Vec<[f64; 2]> {
        let errors = rungs.iter().map(of).enumerate();
        errors
            .filter_map(|(k, error)| Some([k as f64, error?]))
            .filter(|[_, error]| *error > 0.0)
            .collect()
    };
    let training = over(|rung| Some(rung.train_rmse));
    let unseen = over(|rung| rung.unseen_rmse);
    let noise = diagnosis.noise_floor;
    let floor = noise.upper.unwrap_or(noise.lower);
    let names: Vec<String> = rungs
        .iter()
        .skip(1)
        .map(|rung| {
            let ids: Vec<&str> = rung.added.iter().map(|effect| effect.id()).collect();
            ids.join(", ")
        })
        .collect();
    // Where there is no room for names beneath the bars, they stand in the caption.
    let have_room = names.iter().map(String::len).sum::<usize>() <= MOST_LETTERS;
    let mut words = vec!["baseline".to_owned()];
    words.extend(names.iter().enumerate().map(|(k, name)| {
        if have_room {
            format!("+ {name}")
        } else {
            format!("+ {}", k + 1)
        }
    }));
    let key: Vec<String> = names
        .iter()
        .enumerate()
        .filter(|_| !have_room)
        .map(|(k, name)| format!("{} {name}", k + 1))
        .collect();
    let end = rungs.len() as f64 - 0.5;
    let mut all = vec![Series::new("training", Style::Training, training)];
    if !unseen.is_empty() {
        all.push(Series::new("unseen, calibrated", Style::Unseen, unseen));
    }
    if floor > 0.0 {
        let label = match noise.upper {
            Some(_) => "noise level",
            None => "noise, at least",
        };
        all.push(Series::new(
            label,
            Style::Noise,
            [[-0.5, floor], [end, floor]],
        ));
    }
    Figure {
        name: "ladder",
        caption: format!(
            "RMS error of the baseline model, and with each effect beside those before it, on a logarithmic scale: a bar at the line is noise \
             alone.{}",
            if key.is_empty() {
                String::new()
            } else {
                format!(" {}.", key.join(", "))
            }
        ),
        across: String::new(),
        up: axis("RMS error", &diagnosis.baseline.fit.output_unit),
        series: all,
        words,
        log_up: true,
        ..Figure::default()
    }
}
