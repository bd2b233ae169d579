//! Small pictures for a terminal: what was recorded and what the model says of it.

use std::fmt::Write;

use identify::{Prediction, ThermalModel};
use recording::{Quantity, Recording};
use textplots::{Chart, LabelBuilder, LabelFormat, Plot, Shape};

use super::number::significant;

/// Dots of a picture: two a column and four a line of text.
const WIDTH: u32 = 132;
const HEIGHT: u32 = 48;
const STRIP_HEIGHT: u32 = 20;

/// Points of a curve that are drawn: several a column.
const MOST_POINTS: usize = 2000;

/// The recording over time with the model through it, what is left between them, and the loop, if it has one.
#[must_use]
pub fn pictures(name: &str, recording: &Recording, prediction: &Prediction) -> String {
    let output = recording.output();
    let unit = recording.output_unit();
    let left = left(recording, prediction);
    let (time, time_unit) = time(recording);
    let time = time.as_slice();
    let (input, input_unit) = match recording.drive_quantity() {
        Quantity::Temperature => (recording.drive(), recording.drive_unit()),
        _ => (
            prediction.temperature_degc.as_slice(),
            "°C of the model's rod",
        ),
    };
    let both = [Curve::Dots(output), Curve::Line(&prediction.output)];
    let mut text = format!("\nMet worst: {name}, recorded (dots) and model (line)\n");
    let mut draw = |what: &str, height, x, curves: &[Curve<'_>], x_unit| {
        let picture = picture(height, x, curves, range(curves));
        let _ = write!(text, "{what}: {unit} over {x_unit}\n{picture}\n");
    };
    draw("both", HEIGHT, time, &both, time_unit);
    let difference = [Curve::Line(&left)];
    draw(
        "recorded - model",
        STRIP_HEIGHT,
        time,
        &difference,
        time_unit,
    );
    if has_loop(recording) {
        draw("the loop", HEIGHT, input, &both, input_unit);
    }
    text
}

/// True if the output over the input is a loop; false if the output is the temperature of a heated rod.
pub(crate) fn has_loop(recording: &Recording) -> bool {
    recording.drive_quantity() == Quantity::Temperature
        || !ThermalModel::is_for(recording.output_unit())
}

/// A model's name and what it says of a recording.
#[derive(Debug)]
pub struct Left {
    /// Its name.
    pub model: &'static str,
    /// Its prediction of the recording.
    pub prediction: Prediction,
}

/// Residuals of models on a recording over time, each on the scale of the first.
#[must_use]
pub fn what_is_left(name: &str, recording: &Recording, models: &[Left]) -> String {
    let (time, time_unit) = time(recording);
    let lefts: Vec<Vec<f64>> = models
        .iter()
        .map(|one| left(recording, &one.prediction))
        .collect();
    let curves: Vec<Curve<'_>> = lefts.iter().map(|left| Curve::Line(left)).collect();
    let range = range(&curves);
    let mut text = format!("\nMet worst by the baseline model: {name}\n");
    for (one, curve) in models.iter().zip(curves) {
        let picture = picture(STRIP_HEIGHT, &time, &[curve], range);
        let _ = write!(
            text,
            "recorded - {} model: {} over {time_unit}\n{picture}\n",
            one.model,
            recording.output_unit()
        );
    }
    text
}

/// Residual of a model on a recording: recorded - model.
#[must_use]
pub fn left(recording: &Recording, prediction: &Prediction) -> Vec<f64> {
    recording
        .output()
        .iter()
        .zip(&prediction.output)
        .map(|(recorded, model)| recorded - model)
        .collect()
}

/// Time and its unit, or the number of the sample.
#[must_use]
pub fn time(recording: &Recording) -> (Vec<f64>, &'static str) {
    match recording.time_s() {
        [] => ((0..recording.len()).map(|k| k as f64).collect(), "samples"),
        time_s => (time_s.to_vec(), "s"),
    }
}

/// The lowest and the highest value of curves.
fn range(curves: &[Curve<'_>]) -> [f64; 2] {
    let values = curves.iter().flat_map(Curve::values);
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| {
        [low.min(value), high.max(value)]
    })
}

/// A curve and how it is drawn.
enum Curve<'a> {
    Dots(&'a [f64]),
    Line(&'a [f64]),
}

impl Curve<'_> {
    fn values(&self) -> &[f64] {
        match self {
            Self::Dots(values) | Self::Line(values) => values,
        }
    }

    fn shape<'a>(&self, points: &'a [(f32, f32)]) -> Shape<'a> {
        match self {
            Self::Dots(_) => Shape::Points(points),
            Self::Line(_) => Shape::Lines(points),
        }
    }
}

fn picture(height: u32, x: &[f64], curves: &[Curve<'_>], [low, high]: [f64; 2]) -> String {
    let points: Vec<Vec<(f32, f32)>> = curves
        .iter()
        .map(|curve| thinned(x, curve.values()))
        .collect();
    let shapes: Vec<Shape<'_>> = curves
        .iter()
        .zip(&points)
        .map(|(curve, points)| curve.shape(points))
        .collect();
    let lowest = x.iter().copied().fold(f64::INFINITY, f64::min);
    let highest = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let label = || LabelFormat::Custom(Box::new(|value| significant(f64::from(value))));
    let (lowest, highest) = (lowest as f32, highest as f32);
    let mut chart =
        Chart::new_with_y_range(WIDTH, height, lowest, highest, low as f32, high as f32);
    let mut plot = chart.x_label_format(label()).y_label_format(label());
    for shape in &shapes {
        plot = plot.lineplot(shape);
    }
    plot.axis();
    plot.figures();
    plot.to_string()
}

/// Not all of a long curve.
fn thinned(x: &[f64], y: &[f64]) -> Vec<(f32, f32)> {
    let step = x.len().div_ceil(MOST_POINTS).max(1);
    x.iter()
        .zip(y)
        .step_by(step)
        .map(|(&x, &y)| (x as f32, y as f32))
        .collect()
}
