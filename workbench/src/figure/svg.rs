//! A figure as SVG text.

use plotters::coord::Shift;
use plotters::prelude::*;
use serde_json::json;

use super::{Figure, Series, Style};
use crate::WorkbenchError;
use crate::page::escaped;

/// Size and margins of a drawing.
#[derive(Debug, Clone, Copy)]
struct Canvas {
    /// Width and height, px.
    size: (u32, u32),
    /// Size of words, px.
    font: u32,
    /// Room for words below and beside the curves, px.
    below: u32,
    beside: u32,
}

/// A file's, for papers and slides.
const FILE: Canvas = Canvas {
    size: (960, 440),
    font: 12,
    below: 44,
    beside: 64,
};

/// A page's: to be read on a phone as well.
const PAGE: Canvas = Canvas {
    size: (680, 400),
    font: 16,
    below: 52,
    beside: 72,
};

/// Letters of a line of a caption in a file.
const CAPTION_COLUMNS: usize = 115;

/// Room around a figure, px.
const MARGIN_PX: u32 = 12;

/// Points of a curve that are drawn: two a pixel.
const MOST_POINTS: usize = 2000;

/// Room that the bars at a word take, of 1.
const BARS: f64 = 0.5;

/// Room above and below the curves, as a share of their range.
const MARGIN: f64 = 0.05;

const SHADE: RGBColor = RGBColor(245, 224, 203);

/// Colors of a file and their names in a page's style, which has others for a dark screen.
const NAMED: [(&str, &str); 9] = [
    ("#FFFFFF", "var(--paper)"),
    ("#000000", "var(--ink)"),
    ("#AAAAAA", "var(--recorded)"),
    ("#D55E00", "var(--plain)"),
    ("#0072B2", "var(--extended)"),
    ("#009E73", "var(--training)"),
    ("#CC79A7", "var(--unseen)"),
    ("#F5E0CB", "var(--shade)"),
    ("#E6E6E6", "var(--grid)"),
];

/// A figure within a page.
#[derive(Debug)]
pub struct Inline {
    pub svg: String,
    /// Where its curves are and what they mean, for a cursor; `None` for bars and for curves of one piece.
    pub plot: Option<serde_json::Value>,
}

/// A figure as a file, its caption in it.
pub(super) fn svg(figure: &Figure) -> Result<String, WorkbenchError> {
    let mut text = String::new();
    drawn(figure, FILE, &figure.caption, &mut text)?;
    Ok(text)
}

/// A figure without its caption, in a page's colors, as wide as there is room.
///
/// # Errors
///
/// [`WorkbenchError`](crate::WorkbenchError) if a figure cannot be drawn.
pub fn inline(figure: &Figure) -> Result<Inline, WorkbenchError> {
    let mut svg = String::new();
    let plot = drawn(figure, PAGE, "", &mut svg)?;
    let (width, height) = PAGE.size;
    let size = format!("width=\"{width}\" height=\"{height}\" ");
    let named = format!("role=\"img\" aria-label=\"{}\" ", escaped(&figure.caption));
    svg = svg.replacen(&size, &named, 1);
    for (color, name) in NAMED {
        svg = svg.replace(color, name);
    }
    let mut series = figure.series.iter();
    let has_cursor = figure.words.is_empty() && series.all(|one| one.points.len() > 2);
    Ok(Inline {
        svg,
        plot: has_cursor.then_some(plot),
    })
}

/// Draws a figure; what a cursor needs to know of it.
fn drawn(
    figure: &Figure,
    canvas: Canvas,
    caption: &str,
    text: &mut String,
) -> Result<serde_json::Value, WorkbenchError> {
    draw(figure, canvas, caption, text).map_err(|error| WorkbenchError::Draw {
        figure: figure.name,
        reason: error.to_string(),
    })
}

fn draw(
    figure: &Figure,
    canvas: Canvas,
    caption: &str,
    text: &mut String,
) -> Result<serde_json::Value, Box<dyn std::error::Error>> {
    let whole = SVGBackend::with_string(text, canvas.size).into_drawing_area();
    whole.fill(&WHITE)?;
    let area = headed(&whole, figure, canvas, caption)?;
    let [across, up] = [range(figure, 0), range(figure, 1)];
    let margin = MARGIN * (up[1] - up[0]);
    let up = [up[0] - margin, up[1] + margin];
    let place_up = |value: f64| {
        if figure.log_up { value.log10() } else { value }
    };
    let mut chart = ChartBuilder::on(&area)
        .margin(MARGIN_PX)
        .x_label_area_size(canvas.below)
        .y_label_area_size(canvas.beside)
        .build_cartesian_2d(across[0]..across[1], up[0]..up[1])?;
    let words = |at: &f64| word(&figure.words, *at);
    let mut mesh = chart.configure_mesh();
    let words_in = ("sans-serif", canvas.font);
    mesh.label_style(words_in)
        .axis_desc_style(words_in)
        .x_desc(&figure.across)
        .y_desc(&figure.up)
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(230, 230, 230));
    mesh.x_label_formatter(&tick).y_label_formatter(&tick);
    if figure.log_up {
        mesh.y_label_formatter(&power_tick);
    }
    if !figure.words.is_empty() {
        mesh.x_label_formatter(&words)
            .x_labels(2 * figure.words.len() + 1);
    }
    mesh.draw()?;
    let shaded = figure.shaded.iter().map(|[from, to]| {
        let ends = [(from.max(across[0]), up[0]), (to.min(across[1]), up[1])];
        Rectangle::new(ends, SHADE.filled())
    });
    chart.draw_series(shaded)?;
    if !figure.band.is_empty() {
        let outline = outline(&figure.band);
        chart.draw_series([Polygon::new(outline, SHADE.filled())])?;
    }
    let is_bar = |series: &&Series| !figure.words.is_empty() && series.style != Style::Noise;
    let n_bars = figure.series.iter().filter(is_bar).count();
    let bottom = if figure.log_up { up[0] } else { 0.0 };
    for (number, series) in figure.series.iter().enumerate() {
        let color = color(series.style);
        let points = thinned(series);
        if is_bar(&series) {
            let (width, first) = (BARS / n_bars as f64, number as f64 - 0.5 * n_bars as f64);
            let bars = points.into_iter().map(|(x, y)| {
                let left = x + width * first;
                let ends = [(left, bottom), (left + 0.9 * width, place_up(y))];
                Rectangle::new(ends, color.filled())
            });
            chart.draw_series(bars)?;
        } else {
            let stroke = color.stroke_width(width(series.style));
            let points = points.into_iter().map(|(x, y)| (x, place_up(y)));
            chart.draw_series(LineSeries::new(points, stroke))?;
        }
    }
    let (columns, rows) = chart.plotting_area().get_pixel_range();
    let labels: Vec<&str> = figure.series.iter().map(|one| one.label.as_str()).collect();
    let plot = json!({
        "left": columns.start, "right": columns.end, "top": rows.start, "bottom": rows.end,
        "across": across, "up": up, "labels": labels, "axes": [figure.across, figure.up],
    });
    whole.present()?;
    Ok(plot)
}

/// Writes caption and legend above a figure, where they hide no curve; the area that is left.
fn headed<'a>(
    whole: &DrawingArea<SVGBackend<'a>, Shift>,
    figure: &Figure,
    canvas: Canvas,
    caption: &str,
) -> Result<DrawingArea<SVGBackend<'a>, Shift>, Box<dyn std::error::Error>> {
    let line_px = canvas.font as i32 + 6;
    let words = ("sans-serif", canvas.font).into_text_style(whole);
    let mut y = MARGIN_PX as i32;
    if !caption.is_empty() {
        let style = ("sans-serif", 15).into_text_style(whole);
        for line in textwrap::wrap(caption, CAPTION_COLUMNS) {
            whole.draw_text(&line, &style, (canvas.beside as i32 + MARGIN_PX as i32, y))?;
            y += 20;
        }
        y += 2;
    }
    let left = (canvas.beside + MARGIN_PX) as i32;
    let mut x = left;
    for series in &figure.series {
        let (width, _) = whole.estimate_text_size(&series.label, &words)?;
        let end = x + 22 + width as i32;
        if end > canvas.size.0 as i32 && x > left {
            x = left;
            y += line_px;
        }
        let middle = y + line_px / 2;
        let sample = [(x, middle - 4), (x + 16, middle + 4)];
        whole.draw(&Rectangle::new(sample, color(series.style).filled()))?;
        whole.draw_text(&series.label, &words, (x + 22, y + 3))?;
        x += 22 + width as i32 + 20;
    }
    let (_, area) = whole.split_vertically(y + line_px);
    Ok(area)
}

fn color(style: Style) -> RGBColor {
    // Okabe and Ito's, which color-blind people tell apart.
    match style {
        Style::Recorded => RGBColor(170, 170, 170),
        Style::Plain => RGBColor(213, 94, 0),
        Style::Extended => RGBColor(0, 114, 178),
        Style::Training => RGBColor(0, 158, 115),
        Style::Unseen => RGBColor(204, 121, 167),
        Style::Noise => BLACK,
    }
}

fn width(style: Style) -> u32 {
    match style {
        Style::Recorded => 5,
        Style::Noise => 1,
        Style::Plain | Style::Extended | Style::Training | Style::Unseen => 2,
    }
}

/// The lowest and the highest of one coordinate, some room where there is no range; bars stand on 0, on a logarithmic axis on the
/// power of ten below.
fn range(figure: &Figure, coordinate: usize) -> [f64; 2] {
    let points = figure.series.iter().flat_map(|series| &series.points);
    let of_band = figure
        .band
        .iter()
        .flat_map(|[x, lower, upper]| [[*x, *lower], [*x, *upper]]);
    let values = points.map(|point| point[coordinate]);
    let values = values.chain(of_band.map(|point| point[coordinate]));
    let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        [low.min(value), high.max(value)]
    });
    if figure.log_up && coordinate == 1 {
        let [low, high] = [low, high].map(f64::log10);
        // A bar as high as the lowest is still seen.
        return [(low - 0.3).floor(), high];
    }
    match (figure.words.is_empty(), coordinate) {
        (false, 0) => [-0.5, figure.words.len() as f64 - 0.5],
        (false, _) => [0.0, high],
        (true, _) if low < high => [low, high],
        (true, _) if low.is_finite() => [low - 0.5, low + 0.5],
        (true, _) => [0.0, 1.0],
    }
}

/// The word at a whole number; none beside it.
fn word(words: &[String], at: f64) -> String {
    let nearest = at.round();
    let is_whole = (at - nearest).abs() < 1e-6 && nearest >= 0.0;
    let word = is_whole.then(|| words.get(nearest as usize)).flatten();
    word.cloned().unwrap_or_default()
}

/// A value on an axis, without zeros that say nothing.
fn tick(at: &f64) -> String {
    let text = format!("{at:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    match text {
        "0" | "-0" if at.abs() > 1e-12 => format!("{at:.1e}"),
        "-0" => "0".to_owned(),
        text => text.to_owned(),
    }
}

/// A value on a logarithmic axis.
fn power_tick(at: &f64) -> String {
    let value = 10.0_f64.powf(*at);
    let decimals = (1.0 - at.floor()).clamp(0.0, 9.0) as usize;
    tick(&format!("{value:.decimals$}").parse().unwrap_or(value))
}

/// The edge of a band, forth above and back below; not all points of a long one.
fn outline(band: &[[f64; 3]]) -> Vec<(f64, f64)> {
    let step = band.len().div_ceil(MOST_POINTS).max(1);
    let kept = || band.iter().step_by(step);
    let above = kept().map(|[x, _, upper]| (*x, *upper));
    let below = kept().rev().map(|[x, lower, _]| (*x, *lower));
    above.chain(below).collect()
}

/// Not all of a long curve.
fn thinned(series: &Series) -> Vec<(f64, f64)> {
    let step = series.points.len().div_ceil(MOST_POINTS).max(1);
    let kept = series.points.iter().step_by(step);
    kept.map(|[x, y]| (*x, *y)).collect()
}
