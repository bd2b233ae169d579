//! A blind trial as one page: table, matrix of names, power and calibration, without a network.

use std::fmt::Write;

use blind_trial::scores::{Calibration, Confusion, Power};

use super::trial::{Tried, mark};
use crate::page::escaped;

/// Side of a square of the matrix, and of a curve's frame, px.
const SQUARE: f64 = 22.0;
const FRAME: [f64; 2] = [460.0, 260.0];

/// Room for the labels of the matrix, px.
const LABELS: f64 = 190.0;

/// Highest oracle score of the axis; its lowest is 1.
const HIGHEST_T: f64 = 1000.0;

const HEAD: &str = r#"<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Blind trial</title>
<style>
:root { color-scheme: light dark; --ink: #1b1f24; --soft: #6a7480; --paper: #ffffff; --line: #d5dae0; --good: #1a7f4b;
  --bad: #b3261e; --blue: #1f6feb }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e9ec; --soft: #98a2ad; --paper: #14171a; --line: #363c43;
  --good: #57c78a; --bad: #ff8a80; --blue: #6cb0ff } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 62rem;
  margin: 2rem auto; padding: 0 1rem }
table { border-collapse: collapse; width: 100% } th, td { text-align: left; padding: .3rem .6rem;
  border-bottom: 1px solid var(--line); vertical-align: top } td:nth-child(2), td:nth-child(3) { white-space: nowrap }
.met { color: var(--good) } .not { color: var(--bad) } figure { margin: 2rem 0; overflow-x: auto }
figcaption { color: var(--soft) } svg text { font: 12px system-ui, sans-serif; fill: var(--ink) }
.axis { stroke: var(--line); fill: none } .curve { stroke: var(--blue); fill: none; stroke-width: 2 }
.dot { fill: var(--blue) } .cell { fill: var(--blue) } .off { fill: var(--bad) }
</style></head><body>
"#;

/// The page.
pub(crate) fn page(tried: &Tried<'_>) -> String {
    let mut page = HEAD.to_owned();
    page += "<h1>Blind trial</h1>\n";
    let _ = writeln!(page, "<p>{}</p>", escaped(&tried.head()));
    page += "<table><tr><th>quantity</th><th>figure (95 % interval)</th><th>target</th><th></th></tr>\n";
    for score in &tried.scores.table {
        let mark = mark(score);
        let class = if mark == "met" { "met" } else { "not" };
        let _ = writeln!(
            page,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td class=\"{class}\">{mark}</td></tr>",
            escaped(&score.quantity),
            escaped(&score.figure.to_string()),
            escaped(&score.target_text()),
        );
    }
    page += "</table>\n";
    page += &matrix(&tried.scores.confusion);
    page += &power(&tried.scores.power);
    page += &calibration(&tried.scores.calibration);
    page + "</body></html>\n"
}

fn matrix(confusion: &Confusion) -> String {
    let (rows, columns) = (&confusion.rows, &confusion.columns);
    let width = LABELS + SQUARE * columns.len() as f64 + 10.0;
    let height = LABELS + SQUARE * rows.len() as f64 + 10.0;
    let mut svg = format!(
        "<figure><svg width=\"{width}\" height=\"{height}\" role=\"img\" aria-label=\"Matrix of names\">\n"
    );
    for (j, column) in columns.iter().enumerate() {
        let x = LABELS + SQUARE * (j as f64 + 0.7);
        let _ = writeln!(
            svg,
            "<text transform=\"translate({x:.1} {:.1}) rotate(-60)\">{}</text>",
            LABELS - 6.0,
            escaped(column)
        );
    }
    for (i, (row, counts)) in rows.iter().zip(&confusion.counts).enumerate() {
        let y = LABELS + SQUARE * i as f64;
        let all: usize = counts.iter().sum();
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LABELS - 6.0,
            y + 15.0,
            escaped(row)
        );
        for (j, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let x = LABELS + SQUARE * j as f64;
            let class = if columns[j] == *row { "cell" } else { "off" };
            let share = count as f64 / all as f64;
            let _ = writeln!(
                svg,
                "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{s}\" height=\"{s}\" \
                 fill-opacity=\"{:.2}\"><title>{row} named {}: {count} of {all}</title></rect>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{count}</text>",
                0.15 + 0.6 * share,
                columns[j],
                x + 0.5 * SQUARE,
                y + 15.0,
                s = SQUARE - 2.0,
            );
        }
    }
    svg + "</svg><figcaption>Visible single effects: a row for each that was concealed, a column for the strongest name \
           that was given, or the verdict where there was none. Blue is right.</figcaption></figure>\n"
}

/// A frame with labelled ticks; `x` and `y` are places from 0 to 1 with their labels.
fn frame(label: &str, x: &[(f64, String)], y: &[(f64, String)]) -> String {
    let [width, height] = FRAME;
    let mut svg = format!(
        "<figure><svg width=\"{:.0}\" height=\"{:.0}\" role=\"img\" aria-label=\"{label}\">\n\
         <rect class=\"axis\" x=\"50\" y=\"10\" width=\"{width}\" height=\"{height}\"/>\n",
        width + 80.0,
        height + 50.0
    );
    for (place, text) in x {
        let [px, _] = place_of([*place, 0.0]);
        let _ = writeln!(
            svg,
            "<text x=\"{px:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{text}</text>",
            height + 28.0
        );
    }
    for (place, text) in y {
        let [_, py] = place_of([0.0, *place]);
        let _ = writeln!(
            svg,
            "<text x=\"44\" y=\"{:.1}\" text-anchor=\"end\">{text}</text>",
            py + 4.0
        );
    }
    svg
}

fn place_of([x, y]: [f64; 2]) -> [f64; 2] {
    [50.0 + FRAME[0] * x, 10.0 + FRAME[1] * (1.0 - y)]
}

fn dot(at: [f64; 2], radius: f64, title: &str) -> String {
    let [x, y] = place_of(at);
    format!(
        "<circle class=\"dot\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"><title>{}</title></circle>\n",
        escaped(title)
    )
}

fn percents() -> Vec<(f64, String)> {
    [0.0, 0.25, 0.5, 0.75, 1.0]
        .map(|share| (share, format!("{:.0} %", 100.0 * share)))
        .to_vec()
}

fn power(power: &Power) -> String {
    let place = |t: f64| (t.max(1.0).ln() / HIGHEST_T.ln()).min(1.0);
    let ticks: Vec<(f64, String)> = [1.0, 10.0, 100.0, 1000.0]
        .map(|t| (place(t), format!("{t}")))
        .to_vec();
    let mut svg = frame("Power", &ticks, &percents());
    let points: Vec<[f64; 2]> = power
        .bins
        .iter()
        .enumerate()
        .filter(|(_, bin)| bin.stated.n > 0)
        .map(|(k, bin)| {
            let end = power.bins.get(k + 1).map_or(HIGHEST_T, |next| next.from_t);
            let middle = (bin.from_t.max(1.0) * end).sqrt();
            svg += &dot(
                [place(middle), bin.stated.share()],
                4.0,
                &format!("from {}: {}", bin.from_t, bin.stated),
            );
            [place(middle), bin.stated.share()]
        })
        .collect();
    svg += &line(&points);
    svg + "</svg><figcaption>Share of single effects that are in the stated set, over the score of an oracle that knows the \
           effect's trace and the noise (standard deviations, logarithmic).</figcaption></figure>\n"
}

fn calibration(calibration: &Calibration) -> String {
    let mut svg = frame("Calibration", &percents(), &percents());
    svg += &line(&[[0.0, 0.0], [1.0, 1.0]]).replace("curve", "axis");
    for bin in &calibration.bins {
        let text = format!(
            "stated {:.2}, right {:.2}, {} names",
            bin.stated, bin.right, bin.n
        );
        svg += &dot([bin.stated, bin.right], 3.0 + (bin.n as f64).ln(), &text);
    }
    svg + "</svg><figcaption>Names by their stated probability (across), and the share of them that is right (up); a larger \
           dot is more names. On the diagonal a probability means what it says.</figcaption></figure>\n"
}

fn line(points: &[[f64; 2]]) -> String {
    let path: Vec<String> = points
        .iter()
        .map(|&point| {
            let [x, y] = place_of(point);
            format!("{x:.1},{y:.1}")
        })
        .collect();
    format!(
        "<polyline class=\"curve\" points=\"{}\"/>\n",
        path.join(" ")
    )
}
