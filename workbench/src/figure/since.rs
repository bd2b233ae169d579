//! Runs since a reference beside what its laws predict.

use missing_physics::{Change, ChangeVerdict, TracedRun};
use recording::Recording;

use super::{Figure, Series, Style, axis};

/// Half width of the band, standard deviations.
pub const BAND_DEVIATIONS: f64 = 2.0;

/// One run of a comparison, and its name for people.
#[derive(Debug)]
pub struct Since<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Predictions of it.
    pub traced: &'a TracedRun,
    /// Its name for people.
    pub name: &'a str,
    /// Name of the likeliest change in the legend; `None` where it is not to be drawn.
    pub with: Option<&'static str>,
}

/// Name in legends of the likeliest change; `None` if nothing has changed, or nothing can be said of it.
#[must_use]
pub fn with_change(change: &Change) -> Option<&'static str> {
    match change.verdict {
        ChangeVerdict::Changed => Some("with the change"),
        ChangeVerdict::Unexplained => Some("with the likeliest change"),
        _ => None,
    }
}

impl Since<'_> {
    /// The predictions, each with its name and style.
    fn predicted(&self) -> Vec<(&'static str, Style, &[f64])> {
        let laws = "laws of the reference";
        let mut all = vec![(laws, Style::Plain, self.traced.unchanged_output.as_slice())];
        if let (Some(with), Some(output)) = (self.with, &self.traced.changed_output) {
            all.push((with, Style::Extended, output.as_slice()));
        }
        all
    }

    /// The run as it was recorded and as it is predicted.
    #[must_use]
    pub fn traces(&self) -> Figure {
        let time_s = self.recording.time_s();
        let recorded = Series::over("recorded", Style::Recorded, time_s, self.recording.output());
        let predicted = self.predicted().into_iter();
        let predicted =
            predicted.map(|(name, style, values)| Series::over(name, style, time_s, values));
        Figure {
            name: "since",
            caption: format!(
                "{}: the recording, the broad gray line, and the laws of the reference.",
                self.name
            ),
            across: "time, s".to_owned(),
            up: axis("output", self.recording.output_unit()),
            series: std::iter::once(recorded).chain(predicted).collect(),
            ..Figure::default()
        }
    }

    /// Residuals of the run, and the band in which runs of the reference stand.
    #[must_use]
    pub fn residuals(&self) -> Figure {
        let time_s = self.recording.time_s();
        let recorded = self.recording.output();
        let series = self.predicted().into_iter().map(|(name, style, values)| {
            let left = recorded.iter().zip(values).map(|(own, model)| own - model);
            let points = time_s.iter().zip(left).map(|(&t, left)| [t, left]);
            Series::new(format!("recorded - {name}"), style, points)
        });
        let band = self.traced.deviation_over_time_s.iter();
        Figure {
            name: "since-residual",
            caption: format!(
                "{}: the residual. The band is ± {BAND_DEVIATIONS} standard deviations of what a rig that has not changed is expected to \
                 leave. A change shows where the curve is outside for long.",
                self.name
            ),
            across: "time, s".to_owned(),
            up: axis("recorded - predicted", self.recording.output_unit()),
            series: series.collect(),
            band: band
                .map(|[t, deviation]| {
                    let half = BAND_DEVIATIONS * deviation;
                    [*t, -half, half]
                })
                .collect(),
            ..Figure::default()
        }
    }
}
