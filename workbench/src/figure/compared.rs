//! A recording beside what models say of it.

use recording::{Quantity, Recording};

use super::{Figure, Series, Style};
use crate::report::plot::{Left, has_loop, left, time};

/// A recording and what models say of it.
#[derive(Debug)]
pub struct Compared<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Its name for people.
    pub name: &'a str,
    /// The plain model, then the one with effects, if there is one.
    pub models: &'a [Left],
    /// Stretches of time that are shaded, s.
    pub spans_s: Vec<[f64; 2]>,
}

const STYLES: [Style; 2] = [Style::Plain, Style::Extended];

impl Compared<'_> {
    /// Recording and models over time, what they leave, and the loop of each model, if it has one.
    #[must_use]
    pub fn figures(&self) -> Vec<Figure> {
        let mut figures = vec![self.traces(), self.what_is_left()];
        if has_loop(self.recording) {
            figures.extend(self.loops());
        }
        figures
    }

    fn output(&self) -> String {
        format!("output, {}", self.recording.output_unit())
    }

    fn traces(&self) -> Figure {
        let (time, unit) = time(self.recording);
        let models = self.models.iter().zip(STYLES).map(|(one, style)| {
            let label = format!("{} model", one.model);
            Series::over(label, style, &time, &one.prediction.output)
        });
        let recorded = Series::over("recorded", Style::Recorded, &time, self.recording.output());
        let says = if self.models.len() > 1 {
            "what the models say"
        } else {
            "what the model says"
        };
        let where_shaded = if self.spans_s.is_empty() {
            ""
        } else {
            "; shaded where the plain model errs most"
        };
        Figure {
            name: "recording",
            caption: format!("{}: recorded, and {says}{where_shaded}", self.name),
            across: format!("time, {unit}"),
            up: self.output(),
            series: std::iter::once(recorded).chain(models).collect(),
            shaded: self.spans_s.clone(),
            ..Figure::default()
        }
    }

    fn what_is_left(&self) -> Figure {
        let (time, unit) = time(self.recording);
        let series = self.models.iter().zip(STYLES).map(|(one, style)| {
            let label = format!("recorded - {} model", one.model);
            Series::over(label, style, &time, &left(self.recording, &one.prediction))
        });
        let leaves = if self.models.len() > 1 {
            "the models leave"
        } else {
            "the model leaves"
        };
        Figure {
            name: "what-is-left",
            caption: format!(
                "{}: what {leaves}; where nothing is missing that is noise, without shape",
                self.name
            ),
            across: format!("time, {unit}"),
            up: format!("recorded - model, {}", self.recording.output_unit()),
            series: series.collect(),
            shaded: self.spans_s.clone(),
            ..Figure::default()
        }
    }

    /// Each model's loop, over its own temperature, or over what was put in.
    fn loops(&self) -> impl Iterator<Item = Figure> {
        let names = ["loop-before", "loop-after"];
        let models = self.models.iter().zip(STYLES).zip(names);
        models.map(|((one, style), name)| {
            let is_static = self.recording.drive_quantity() == Quantity::Temperature;
            let (over, across, input) = if is_static {
                let across = format!("input, {}", self.recording.drive_unit());
                ("the input".to_owned(), across, self.recording.drive())
            } else {
                (
                    format!("the temperature that the {} model computes", one.model),
                    "computed temperature of the rod, °C".to_owned(),
                    one.prediction.temperature_degc.as_slice(),
                )
            };
            let label = format!("{} model", one.model);
            let model = Series::over(label, style, input, &one.prediction.output);
            let recorded =
                Series::over("recorded", Style::Recorded, input, self.recording.output());
            Figure {
                name,
                caption: format!("{}: the loop over {over}", self.name),
                across,
                up: self.output(),
                series: vec![recorded, model],
                ..Figure::default()
            }
        })
    }
}
