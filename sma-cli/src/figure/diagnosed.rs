//! The figures of a diagnosis.

use identify::Validated;
use missing_physics::Diagnosis;
use recording::Recording;

use super::{Compared, Figure, Series, Style};
use crate::report::plot::Left;

/// A diagnosis, and the recording that the plain model meets worst with what the models say of it.
#[derive(Debug)]
pub(crate) struct Drawn<'a> {
    pub(crate) diagnosis: &'a Diagnosis,
    pub(crate) compared: Compared<'a>,
}

impl<'a> Drawn<'a> {
    pub(crate) fn new(
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

/// Recording and models over time, what they leave, the loop, and the errors down to the noise.
pub(crate) fn figures(drawn: &Drawn<'_>) -> Vec<Figure> {
    let mut figures = drawn.compared.figures();
    figures.push(drawn.ladder());
    figures
}

impl Drawn<'_> {
    /// Errors from the plain model down to the noise, an effect at a time.
    fn ladder(&self) -> Figure {
        let Diagnosis {
            baseline, ladder, ..
        } = self.diagnosis;
        let plain = [(
            baseline.fit.train_rmse,
            Validated::rmse_of_all(&baseline.validated),
        )];
        let rungs = ladder
            .iter()
            .map(|rung| (rung.train_rmse, rung.unseen_rmse));
        let errors: Vec<(f64, Option<f64>)> = plain.into_iter().chain(rungs).collect();
        let over = |of: fn(&(f64, Option<f64>)) -> Option<f64>| -> Vec<[f64; 2]> {
            let errors = errors.iter().map(of).enumerate();
            errors
                .filter_map(|(k, error)| Some([k as f64, error?]))
                .collect()
        };
        let (training, unseen) = (over(|one| Some(one.0)), over(|one| one.1));
        let noise = self.diagnosis.noise_floor;
        let floor = noise.upper.unwrap_or(noise.lower);
        let mut words = vec!["plain model".to_owned()];
        words.extend((1..errors.len()).map(|rung| format!("+ {rung}")));
        let names = ladder.iter().zip(1..);
        let names = names.map(|(rung, number)| format!("{number} {}", rung.effect.info().name));
        let mut caption = "Error of the plain model".to_owned();
        if !ladder.is_empty() {
            let names: Vec<String> = names.collect();
            let beside = if names.len() > 1 {
                ": each beside those before"
            } else {
                ""
            };
            caption += &format!(", and with {}{beside}", names.join(", "));
        }
        let end = errors.len() as f64 - 0.5;
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
