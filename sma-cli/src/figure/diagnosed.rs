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
    /// Errors of the models, and the noise.
    fn ladder(&self) -> Figure {
        let diagnosis = self.diagnosis;
        let extended = diagnosis.extended.as_ref().map(|one| &one.stage);
        let stages: Vec<_> = std::iter::once(&diagnosis.baseline)
            .chain(extended)
            .collect();
        let over = |error: &dyn Fn(usize) -> Option<f64>| -> Vec<[f64; 2]> {
            let errors = (0..stages.len()).map(error).enumerate();
            errors
                .filter_map(|(k, error)| Some([k as f64, error?]))
                .collect()
        };
        let training = over(&|k| Some(stages[k].fit.train_rmse));
        let unseen = over(&|k| Validated::rmse_of_all(&stages[k].validated));
        let noise = diagnosis.noise_floor;
        let floor = noise.upper.unwrap_or(noise.lower);
        let found: Vec<&str> = diagnosis
            .extended
            .iter()
            .flat_map(|one| &one.effects)
            .map(|effect| effect.info().name)
            .collect();
        let mut words = vec!["plain model"];
        let mut caption = "Error of the plain model".to_owned();
        if !found.is_empty() {
            words.push("extended model");
            caption += &format!(", and with {}", found.join(", "));
        }
        let end = stages.len() as f64 - 0.5;
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
            words: words.into_iter().map(str::to_owned).collect(),
            ..Figure::default()
        }
    }
}
