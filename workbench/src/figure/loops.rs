//! Loops over frequencies: Bode and Nyquist.

use super::{Figure, Series, Style};
use crate::report::tuned::{LoopPicture, TunedReport};

/// Half of the width of a Nyquist plot, at least and at most: as much as shows the curve of the hysteresis, and no more,
/// because farther out nothing tells how near a loop comes to -1.
const HALF_WIDTHS: [f64; 2] = [3.0, 10.0];
/// Half of the size of the cross at -1.
const CROSS: f64 = 0.06;
/// Smallest magnitude that a Bode plot shows, dB.
const LOWEST_DB: f64 = -60.0;

/// Magnitude, phase and locus of the loops of a report, where they are steepest.
#[must_use]
pub fn loops(tuned: &TunedReport<'_>) -> Vec<Figure> {
    if tuned.loops.is_empty() {
        return Vec::new();
    }
    let over_frequency = |name, caption: &str, up: &str, of: fn(f64, f64) -> f64| {
        let curves = tuned.loops.iter().map(|picture| {
            let points = picture.response.iter().map(|(hz, response)| {
                let value = of(response.magnitude(), response.angle_rad());
                [hz.log10(), value]
            });
            Series::new(format!("{} gains", picture.name), style(picture), points)
        });
        Figure {
            name,
            caption: caption.to_owned(),
            across: "frequency, powers of ten of 1 Hz".to_owned(),
            up: up.to_owned(),
            series: curves.collect(),
            ..Figure::default()
        }
    };
    vec![
        over_frequency(
            "bode-magnitude",
            "Bode, magnitude: where it crosses 0 dB the loop is fast enough no longer; there the phase must be well above -180°",
            "|L|, dB",
            |magnitude, _| (20.0 * magnitude.log10()).max(LOWEST_DB),
        ),
        over_frequency(
            "bode-phase",
            "Bode, phase: where it crosses -180° the magnitude must be well below 0 dB",
            "arg L, °",
            |_, angle_rad| {
                // From -360 to 0: a loop with delay turns on and on.
                let degrees = angle_rad.to_degrees();
                if degrees > 0.0 {
                    degrees - 360.0
                } else {
                    degrees
                }
            },
        ),
        nyquist(tuned),
    ]
}

/// The locus near -1, and -1/N of the hysteresis: where they cross, harmonic balance has a limit cycle.
fn nyquist(tuned: &TunedReport<'_>) -> Figure {
    let distances = tuned
        .describing_curve
        .iter()
        .map(|(_, value)| value.magnitude());
    let nearest = distances.fold(f64::INFINITY, f64::min);
    let [least, most] = HALF_WIDTHS;
    let half_width = if nearest.is_finite() {
        (1.5 * nearest).clamp(least, most)
    } else {
        least
    };
    let near = |re: f64, im: f64| re.abs() <= half_width && im.abs() <= half_width;
    let loops = tuned.loops.iter().map(|picture| {
        let points = picture
            .response
            .iter()
            .map(|(_, response)| [response.re, response.im]);
        let shown = points.filter(|&[re, im]| near(re, im));
        Series::new(
            format!("L under {} gains", picture.name),
            style(picture),
            shown,
        )
    });
    let curve = tuned
        .describing_curve
        .iter()
        .map(|(_, value)| [value.re, value.im]);
    let describing = Series::new(
        "-1/N of the hysteresis",
        Style::Noise,
        curve.filter(|&[re, im]| near(re, im)),
    );
    let cross = [
        [-CROSS, 0.0],
        [CROSS, 0.0],
        [0.0, 0.0],
        [0.0, CROSS],
        [0.0, -CROSS],
    ];
    let minus_one = Series::new("-1", Style::Unseen, cross.map(|[re, im]| [-1.0 + re, im]));
    Figure {
        name: "nyquist",
        caption: "Nyquist: a loop that passes -1 on its right is stable; where the baseline part's loop crosses -1/N the \
                  first harmonic foresees a limit cycle"
            .to_owned(),
        across: "real part of L".to_owned(),
        up: "imaginary part of L".to_owned(),
        series: loops.chain([describing, minus_one]).collect(),
        ..Figure::default()
    }
}

fn style(picture: &LoopPicture) -> Style {
    if picture.name == "tuned" {
        Style::Extended
    } else {
        Style::Plain
    }
}
