//! A fleet as a page.

use std::fmt::Write;

use super::{Page, escaped};
use crate::report::fleet::{FleetReport, Found, Row, RowStatus, named};
use crate::report::number::{behind, spoken};

/// Width of the picture, its words included, in its own units.
const WIDTH: f64 = 680.0;

/// Room for words beside the rows, and height of a row.
const BESIDE: f64 = 190.0;
const ROW: f64 = 18.0;

/// The page but for how it was made: which physics is in how many rigs, a picture of the fleet, its rigs.
#[must_use]
pub fn fleet(report: &FleetReport<'_>) -> Page {
    let mut page = Page::new("A fleet of SMA actuators", &report.head());
    if report.of(RowStatus::Done).next().is_some() {
        page.section("The verdicts");
        page.table(&report.verdict_table());
    }
    if !report.physics().is_empty() {
        page.section("Which physics in how many rigs");
        page.table(&report.physics_table());
        page.line(&picture(report));
    }
    if !report.spreads().is_empty() {
        page.section("The parameters over the fleet");
        page.table(&report.spread_table());
    }
    if report.of(RowStatus::Done).next().is_some() {
        page.section("The rigs");
        page.table(&report.rig_table());
    }
    if report.without_result().next().is_some() {
        page.section("Rigs without a result");
        page.table(&report.failure_table());
    }
    if !report.left_out.is_empty() {
        page.section("Files that were left out");
        page.paragraphs(&report.left_out.join("\n"));
    }
    page
}

/// A column a rig in the order of the table, a row an effect.
fn picture(report: &FleetReport<'_>) -> String {
    let physics = report.physics();
    let rows: Vec<&str> = physics.iter().map(|one| one.effect.as_str()).collect();
    let last = ["nothing named", "no result to be used"];
    let step = (WIDTH - BESIDE) / report.rows.len() as f64;
    // Columns touch where there are many, so that a rig alone still shows.
    let width = (0.85 * step).max(1.0);
    let height = ROW * (rows.len() + last.len()) as f64;
    let mut svg = format!(
        "<figure><svg role=\"img\" viewBox=\"0 0 {WIDTH} {height}\" aria-label=\"physics over rigs\" font-size=\"12\">"
    );
    for (k, word) in rows.iter().chain(&last).enumerate() {
        // Writing to a string does not fail.
        let _ = write!(
            svg,
            "<text x=\"0\" y=\"{}\" fill=\"var(--ink)\">{}</text>",
            ROW * (k as f64 + 0.75),
            escaped(word)
        );
    }
    for (column, rig) in report.rows.iter().enumerate() {
        let x = BESIDE + step * column as f64;
        for (k, color, said) in cells(rig, &rows) {
            let y = ROW * k as f64 + 2.0;
            let _ = write!(
                svg,
                "<rect x=\"{x:.2}\" y=\"{y}\" width=\"{width:.2}\" height=\"{}\" fill=\"var(--{color})\"><title>{}</title></rect>",
                ROW - 4.0,
                escaped(&named(&rig.rig, &said))
            );
        }
    }
    svg + "</svg>\n<figcaption>Each column is a rig, in the order of the table; hold the pointer over one to read its name. Dark: \
           the only name of a finding. Light: one of several names that cannot be told apart.</figcaption></figure>"
}

/// Rows in which a rig has a mark, with its color and words.
fn cells(rig: &Row, effects: &[&str]) -> Vec<(usize, &'static str, String)> {
    if rig.status != RowStatus::Done {
        return vec![(effects.len() + 1, "plain", rig.sentence().to_owned())];
    }
    if !rig.is_sound() {
        let why = rig.implausible.join(", ");
        let why = format!("{} {why}", rig.verdict.as_deref().unwrap_or_default());
        return vec![(effects.len() + 1, "shade", why.trim_end().to_owned())];
    }
    let mut cells = Vec::new();
    for found in &rig.findings {
        let names = std::iter::once(&found.effect).chain(&found.could_also_be);
        let color = if found.could_also_be.is_empty() {
            "extended"
        } else {
            "recorded"
        };
        for name in names {
            let row = effects.iter().position(|effect| effect == name);
            cells.extend(row.map(|row| (row, color, size(name, found))));
        }
    }
    if cells.is_empty() {
        let verdict = rig.verdict.clone().unwrap_or_default();
        cells.push((effects.len(), "training", verdict));
    }
    cells
}

fn size(name: &str, found: &Found) -> String {
    match found.parameters.first() {
        Some(size) if *name == found.effect => {
            format!("{name} {}{}", spoken(size.value), behind(&size.unit))
        }
        _ => format!("{name}, or another"),
    }
}
