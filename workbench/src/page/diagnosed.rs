//! A diagnosis as a page that explains itself.

use missing_physics::{Finding, Mismatch, Run};
use sma_effects::EffectBlock;

use super::{Page, escaped};
use crate::WorkbenchError;
use crate::figure::{Drawn, Figure, Series, Style, ladder, same_drive};
use crate::report::diagnosed::{
    Diagnosed, FROM_RUN_TO_RUN, HOW_TO_READ_CATALOGUE, HOW_TO_READ_REGIMES, WHERE, found,
    in_frequency, regimes, what,
};
use crate::report::number::spoken_percent;
use crate::report::words::block_name;

/// Probability from which a block is marked.
const GUILTY: f64 = 0.5;

/// The page but for notes and how it was made: the verdict first, then what it rests on.
///
/// # Errors
///
/// [`WorkbenchError`] if a figure cannot be drawn.
pub fn diagnosed(
    diagnosed: &Diagnosed<'_>,
    drawn: Option<&Drawn<'_>>,
) -> Result<Page, WorkbenchError> {
    let diagnosis = diagnosed.diagnosis;
    let mut page = Page::new("Diagnosis of an SMA actuator", &diagnosed.verdict());
    if let Some(drawn) = drawn {
        page.section("Error before and after");
        page.note(diagnosed.how_to_read_ladder());
        page.figure(&ladder(drawn))?;
        page.table(&diagnosed.ladder());
        page.section("Recordings and models");
        if diagnosis.extended.is_some() {
            page.note(
                "The extended model is the baseline model with all effects of the table above, suspects included. Unseen runs are calibrated.",
            );
        }
        page.how_to_read();
        if let Some(figure) = same_drive(drawn) {
            page.figure(&figure)?;
        }
        for (k, compared) in drawn.compared.iter().enumerate() {
            if k == 0 {
                for figure in compared.figures() {
                    page.figure(&figure)?;
                }
                continue;
            }
            page.line(&format!(
                "<details><summary>{}</summary>",
                escaped(compared.name)
            ));
            for figure in compared.over_time() {
                page.figure(&figure)?;
            }
            page.line("</details>");
        }
        page.section(WHERE);
        page.line(&blocks(&diagnosis.mismatch, &diagnosis.findings));
        where_it_is(&mut page, diagnosed, &diagnosis.mismatch);
        for (title, findings, estimates) in found(diagnosis) {
            page.section(title);
            page.line(&what_they_do(findings));
            page.table(&estimates);
        }
        if let Some(runs) = diagnosed.runs() {
            page.section(FROM_RUN_TO_RUN);
            page.note(
                "Runs of the same drive do not repeat: what differs is left open in each, held by priors of what is ordinary in a \
                 laboratory.",
            );
            page.table(&runs);
        }
        if let Some(left) = &diagnosis.remainder {
            page.section("Where the rest of the error lies");
            where_it_is(&mut page, diagnosed, &left.mismatch);
        }
        page.section("The catalogue: what these recordings say of each effect");
        page.note(HOW_TO_READ_CATALOGUE);
        page.table(&diagnosed.catalogue());
    }
    if let Some(next) = &diagnosis.next_experiment {
        page.section("What to measure next");
        page.paragraphs(&next.sentence);
        if let Some(run) = &next.run {
            page.figure(&played(run))?;
        }
    }
    Ok(page)
}

/// The cascade, with the blocks of the findings marked; without findings, those that the localizer blames.
fn blocks(mismatch: &Mismatch, findings: &[Finding]) -> String {
    let probability = |block: EffectBlock| {
        let blamed = mismatch.blocks.iter().find(|(one, _)| *one == block);
        blamed.map_or(0.0, |(_, probability)| *probability)
    };
    let is_guilty = |block: EffectBlock| {
        if findings.is_empty() {
            probability(block) >= GUILTY
        } else {
            let mut blocks = findings.iter().map(|finding| finding.effect.info().block);
            blocks.any(|one| one == block)
        }
    };
    let items = [
        (EffectBlock::Drive, "supply and resistance"),
        (EffectBlock::HeatBalance, "power to temperature"),
        (EffectBlock::Transformation, "temperature to fraction"),
        (EffectBlock::Displacement, "fraction to stroke"),
        (EffectBlock::Sensor, "recorded temperature"),
    ]
    .map(|(block, does)| {
        let class = if is_guilty(block) {
            " class=\"guilty\""
        } else {
            ""
        };
        let added = findings.iter().map(|finding| finding.effect.info());
        let added = added.filter(|info| info.block == block);
        format!(
            "<li{class}><b>{}</b><small>{does}</small><small>{}</small>{}</li>",
            block_name(block),
            spoken_percent(probability(block)),
            added
                .map(|info| equation(info.equation))
                .collect::<String>()
        )
    });
    format!(
        "<ol class=\"blocks\">{}</ol>\n<p class=\"soft\">The model from drive to sensor; blocks that something is missing from are \
         marked, with the equation that is added to them. Percentages: {}.</p>",
        items.concat(),
        if findings.is_empty() {
            "how likely the error arises there"
        } else {
            "shares of the findings in the error that they explain"
        }
    )
}

pub(super) fn equation(text: &str) -> String {
    format!("<code>{}</code>", escaped(text))
}

fn where_it_is(page: &mut Page, diagnosed: &Diagnosed<'_>, mismatch: &Mismatch) {
    let tables = [regimes(mismatch), diagnosed.stretches(mismatch)];
    if tables.iter().any(Option::is_some) {
        page.note(HOW_TO_READ_REGIMES);
    }
    for table in tables.iter().flatten() {
        page.table(table);
    }
    page.paragraphs(&in_frequency(mismatch).unwrap_or_default());
}

/// List of the effects found: name, description, equation.
fn what_they_do(findings: &[Finding]) -> String {
    let items = findings.iter().map(|finding| {
        let name = finding.effect.info().name;
        let equation = equation(finding.effect.info().equation);
        format!(
            "<li>{}: {} {equation}</li>",
            escaped(name),
            escaped(what(finding))
        )
    });
    format!("<ul>{}</ul>", items.collect::<String>())
}

/// The run to play, as steps.
pub(super) fn played(run: &Run) -> Figure {
    let points = run.drive.iter().enumerate();
    let points = points.map(|(k, &drive)| [k as f64 * run.dt_s, drive]);
    let from = run.dt_s * run.decisive.start as f64;
    let to = run.dt_s * run.decisive.end as f64;
    Figure {
        name: "next-run",
        caption: format!(
            "The run that would tell more: {}; shaded where it tells most",
            run.name
        ),
        across: "time, s".to_owned(),
        up: "drive".to_owned(),
        series: vec![Series::new("drive", Style::Extended, points)],
        shaded: vec![[from, to]],
        ..Figure::default()
    }
}
