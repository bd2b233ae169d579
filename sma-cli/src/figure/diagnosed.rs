//! The figures of a diagnosis.

use identify::Validated;
use missing_physics::Diagnosis;
use recording::Recording;

use super::{Figure, Series, Style};
use crate::report::plot::{Left, left, time};

/// A diagnosis, and the recording that the plain model meets worst with what the models say of it.
#[derive(Debug)]
pub(crate) struct Drawn<'a> {
    pub(crate) diagnosis: &'a Diagnosis,
    pub(crate) recording: &'a Recording,
    /// Its name for people.
    pub(crate) name: &'a str,
    /// The plain model, then the one with effects, if there is one.
    pub(crate) models: &'a [Left],
}

/// Recording and models over time, what they leave, the loop, and the errors down to the noise.
pub(crate) fn figures(drawn: &Drawn<'_>) -> Vec<Figure> {
    let mut figures = vec![drawn.traces(), drawn.what_is_left()];
    figures.extend(drawn.loops());
    figures.push(drawn.ladder());
    figures
}

const STYLES: [Style; 2] = [Style::Plain, Style::Extended];

impl Drawn<'_> {
    fn output(&self) -> String {
        format!("output, {}", self.recording.output_unit())
    }

    fn traces(&self) -> Figure {
        let (time, unit) = time(self.recording);
        let models = self.models.iter().zip(STYLES).map(|(one, style)| {
            let label = format!("{} model", one.model);
            series(label, style, &time, &one.prediction.output)
        });
        let recorded = series(
            "recorded".to_owned(),
            Style::Recorded,
            &time,
            self.recording.output(),
        );
        let shaded = self.spans();
        let where_shaded = if shaded.is_empty() {
            ""
        } else {
            "; shaded where the plain model errs most"
        };
        Figure {
            name: "recording",
            caption: format!(
                "{}: recorded, and what the models say{where_shaded}",
                self.name
            ),
            across: format!("time, {unit}"),
            up: self.output(),
            series: std::iter::once(recorded).chain(models).collect(),
            shaded,
            words: Vec::new(),
        }
    }

    fn what_is_left(&self) -> Figure {
        let (time, unit) = time(self.recording);
        let series = self.models.iter().zip(STYLES).map(|(one, style)| {
            let label = format!("recorded - {} model", one.model);
            series(label, style, &time, &left(self.recording, &one.prediction))
        });
        Figure {
            name: "what-is-left",
            caption: format!("{}: what the models leave; noise has no shape", self.name),
            across: format!("time, {unit}"),
            up: format!("recorded - model, {}", self.recording.output_unit()),
            series: series.collect(),
            shaded: self.spans(),
            words: Vec::new(),
        }
    }

    /// Each model's loop, over its own temperature.
    fn loops(&self) -> impl Iterator<Item = Figure> {
        let names = ["loop-before", "loop-after"];
        let models = self.models.iter().zip(STYLES).zip(names);
        models.map(|((one, style), name)| {
            let degc = &one.prediction.temperature_degc;
            let model = series(
                format!("{} model", one.model),
                style,
                degc,
                &one.prediction.output,
            );
            let recorded = series(
                "recorded".to_owned(),
                Style::Recorded,
                degc,
                self.recording.output(),
            );
            Figure {
                name,
                caption: format!(
                    "{}: the loop over the temperature of the {} model",
                    self.name, one.model
                ),
                across: "temperature of the rod, °C".to_owned(),
                up: self.output(),
                series: vec![recorded, model],
                shaded: Vec::new(),
                words: Vec::new(),
            }
        })
    }

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
        let curve = |label: &str, style, points| Series {
            label: label.to_owned(),
            style,
            points,
        };
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
        let mut all = vec![curve("training", Style::Training, training)];
        if !unseen.is_empty() {
            all.push(curve("unseen", Style::Unseen, unseen));
        }
        all.push(curve(
            "noise",
            Style::Noise,
            vec![[-0.5, floor], [end, floor]],
        ));
        Figure {
            name: "ladder",
            caption,
            across: String::new(),
            up: format!("RMSE, {}", self.recording.output_unit()),
            series: all,
            shaded: Vec::new(),
            words: words.into_iter().map(str::to_owned).collect(),
        }
    }

    fn spans(&self) -> Vec<[f64; 2]> {
        let spans = &self.diagnosis.mismatch.spans;
        let own = spans
            .iter()
            .filter(|span| span.recording == self.recording.name());
        own.map(|span| [span.start_s, span.end_s]).collect()
    }
}

fn series(label: String, style: Style, across: &[f64], up: &[f64]) -> Series {
    Series {
        label,
        style,
        points: across.iter().zip(up).map(|(&x, &y)| [x, y]).collect(),
    }
}
