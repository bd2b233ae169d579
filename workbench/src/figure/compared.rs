//! A recording beside what models say of it.

use std::fmt::Write;

use recording::{Quantity, Recording};

use super::{Figure, Series, Style, axis};
use crate::report::plot::{Left, has_loop, left, time};

/// A recording and what models say of it.
#[derive(Debug)]
pub struct Compared<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Its name for people.
    pub name: &'a str,
    /// The baseline model, then the one with effects, if there is one.
    pub models: &'a [Left],
    /// Stretches of time that are shaded, s.
    pub spans_s: Vec<[f64; 2]>,
}

const STYLES: [Style; 2] = [Style::Plain, Style::Extended];

impl Compared<'_> {
    /// Recording and models over time, their residuals, the drive, and the loop of each model, if it has one.
    #[must_use]
    pub fn figures(&self) -> Vec<Figure> {
        let mut figures = self.over_time();
        if has_loop(self.recording) {
            figures.extend(self.loops());
        }
        figures
    }

    /// Recording and models over time, their residuals, and the drive.
    #[must_use]
    pub fn over_time(&self) -> Vec<Figure> {
        let mut figures = vec![self.traces(), self.what_is_left()];
        if self.recording.drive_quantity() != Quantity::Temperature {
            figures.push(self.drive());
        }
        figures
    }

    /// The samples and the models on them, a line each: `time_s,drive,recorded_mm,baseline_mm,extended_mm`.
    pub(super) fn csv(&self) -> String {
        let (time, unit) = time(self.recording);
        let output_unit = self.recording.output_unit();
        let of = |name: &str| match output_unit {
            "1" => name.to_owned(),
            unit => format!("{name}_{unit}"),
        };
        let mut csv = match unit {
            "s" => "time_s,drive,".to_owned(),
            _ => "sample,drive,".to_owned(),
        };
        csv += &of("recorded");
        for one in self.models {
            csv += &format!(",{}", of(one.model));
        }
        csv.push('\n');
        let samples = time.iter().zip(self.recording.drive());
        for (k, ((t, drive), output)) in samples.zip(self.recording.output()).enumerate() {
            // Writing to a string does not fail.
            let _ = write!(csv, "{t},{drive},{output}");
            for one in self.models {
                let _ = write!(csv, ",{}", one.prediction.output[k]);
            }
            csv.push('\n');
        }
        csv
    }

    fn drive(&self) -> Figure {
        let (time, unit) = time(self.recording);
        Figure {
            name: "drive",
            caption: format!("{}: the drive.", self.name),
            across: format!("time, {unit}"),
            up: match self.recording.drive_unit() {
                "1" => "drive (duty, 0 to 1)".to_owned(),
                unit => format!("drive, {unit}"),
            },
            series: vec![Series::over(
                "drive",
                Style::Noise,
                &time,
                self.recording.drive(),
            )],
            shaded: self.spans_s.clone(),
            ..Figure::default()
        }
    }

    fn output(&self) -> String {
        axis("output", self.recording.output_unit())
    }

    fn traces(&self) -> Figure {
        let (time, unit) = time(self.recording);
        let models = self.models.iter().zip(STYLES).map(|(one, style)| {
            let label = format!("{} model", one.model);
            Series::over(label, style, &time, &one.prediction.output)
        });
        let recorded = Series::over("recorded", Style::Recorded, &time, self.recording.output());
        let last = self.models.last().map_or("model", |one| one.model);
        let where_shaded = if self.spans_s.is_empty() {
            ""
        } else {
            " Shaded: where the baseline model errs most."
        };
        Figure {
            name: "recording",
            caption: format!(
                "{}: the {last} model should lie on the recording, the broad gray line.{where_shaded}",
                self.name
            ),
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
        Figure {
            name: "what-is-left",
            caption: format!(
                "{}: the residual. Of a model that lacks nothing it is noise, without a shape.",
                self.name
            ),
            across: format!("time, {unit}"),
            up: axis("recorded - model", self.recording.output_unit()),
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
                caption: format!(
                    "{}: the output over {over}. The branches of the recording should lie on those of the model.",
                    self.name
                ),
                across,
                up: self.output(),
                series: vec![recorded, model],
                ..Figure::default()
            }
        })
    }
}
