//! The figures of a diagnosis.

use missing_physics::{Diagnosis, Rung};
use recording::{Recording, RepeatFloor};

use super::{Compared, Figure, Series, Style};
use crate::report::plot::Left;
use crate::report::repeated::both;
use crate::report::verdict::named;

/// A diagnosis, and the recording that the plain model meets worst with what the models say of it.
#[derive(Debug)]
pub struct Drawn<'a> {
    /// Result of the diagnosis.
    pub diagnosis: &'a Diagnosis,
    /// The recording that is met worst, and the models on it.
    pub compared: Compared<'a>,
}

impl<'a> Drawn<'a> {
    /// The figures of a diagnosis, with a recording under the name that it is given, and what each model leaves of it.
    #[must_use]
    pub fn new(
        diagnosis: &'a Diagnosis,
        (recording, name): (&'a Recording, &'a str),
        models: &'a [Left],
    ) -> Self {
        let spans = diagnosis.mismatch.spans.iter();
        let own = spans.filter(|span| span.recording == recording.name());
        Self {
            diagnosis,
            compared: Compared {
                recording,
                name,
                models,
                spans_s: own.map(|span| [span.start_s, span.end_s]).collect(),
            },
        }
    }
}

/// Recording and models over time, what they leave, the loop, two runs of the same drive where there are any, and the errors down to
/// the noise.
#[must_use]
pub fn figures(drawn: &Drawn<'_>) -> Vec<Figure> {
    let mut figures = drawn.compared.figures();
    let repeats = drawn.diagnosis.repeats.as_ref();
    figures.extend(repeats.and_then(same_drive));
    figures.push(drawn.ladder());
    figures
}

/// Difference between the longest two runs of the same drive.
fn same_drive(floor: &RepeatFloor) -> Option<Figure> {
    let pair = floor.pairs.first()?;
    let outputs = pair.apart.outputs.iter();
    let apart = outputs.map(|[t, first, second]| [*t, second - first]);
    Some(Figure {
        name: "same-drive",
        caption: format!(
            "What two runs of the same drive differ by, an offset taken out: {}",
            both(pair, floor)
        ),
        across: "time, s".to_owned(),
        up: format!("second - first, {}", floor.unit),
        series: vec![Series::new("second - first", Style::Unseen, apart)],
        ..Figure::default()
    })
}

impl Drawn<'_> {
    /// Errors from the plain model down to the noise, an effect at a time.
    fn ladder(&self) -> Figure {
        let rungs = &self.diagnosis.ladder;
        let over = |of: fn(&Rung) -> Option<f64>| -> Vec<[f64; 2]> {
            let errors = rungs.iter().map(of).enumerate();
            errors
                .filter_map(|(k, error)| Some([k as f64, error?]))
                .collect()
        };
        let training = over(|rung| Some(rung.train_rmse));
        let unseen = over(|rung| rung.unseen_rmse);
        let noise = self.diagnosis.noise_floor;
        let floor = noise.upper.unwrap_or(noise.lower);
        let mut words = vec!["plain model".to_owned()];
        words.extend((1..rungs.len()).map(|number| format!("+ {number}")));
        let added = rungs.iter().enumerate().skip(1);
        let names: Vec<String> = added
            .map(|(number, rung)| format!("{number} {}", named(&rung.added, "and")))
            .collect();
        let mut caption = "Error of the plain model".to_owned();
        if !names.is_empty() {
            caption += &format!(", and with {}", names.join(", "));
        }
        if names.len() > 1 {
            caption += ": each beside those before";
        }
        let end = rungs.len() as f64 - 0.5;
        let mut all = vec![Series::new("training", Style::Training, training)];
        if !unseen.is_empty() {
            all.push(Series::new("unseen", Style::Unseen, unseen));
        }
        all.push(Series::new(
            "noise",
            Style::Noise,
            [[-0.5, floor], [end, floor]],
        ));
        Figure {
            name: "ladder",
            caption,
            across: String::new(),
            up: format!("RMSE, {}", self.compared.recording.output_unit()),
            series: all,
            words,
            ..Figure::default()
        }
    }
}
