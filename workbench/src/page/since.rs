//! An answer on changes since a reference as a page.

use missing_physics::{ChangeEvidence, ChangeVerdict, TracedRun};
use recording::Recording;

use super::diagnosed::{equation, played};
use super::{Page, escaped};
use crate::WorkbenchError;
use crate::figure::{Since, with_change};
use crate::report::changed::{
    HOW_TO_READ_SPREAD, SinceReference, advice, how_to_read, reasons, runs_used, spread,
};
use crate::report::number::spoken;
use crate::report::words::capitalized;

/// The page but for how it was made: the verdict first, then the runs, then what the verdict rests on. `reference` and `today` are the
/// runs in the order in which they were asked about.
///
/// # Errors
///
/// [`WorkbenchError`] if a figure cannot be drawn.
pub fn since(
    since: &SinceReference<'_>,
    evidence: &ChangeEvidence,
    [reference, today]: [&[Recording]; 2],
) -> Result<Page, WorkbenchError> {
    let change = since.change;
    let errors = if change.left_out.is_empty() {
        format!("Laws fitted to the reference leave {}", since.errors())
    } else {
        since.errors()
    };
    let said = format!("{}\n{errors}", since.headline());
    let mut page = Page::new("Changes of an SMA actuator", &said);
    what_changed(&mut page, since);
    page.section("What to do next");
    page.paragraphs(&advice(change, evidence));
    let next = evidence.next.as_ref();
    if let Some(run) = next.and_then(|next| next.run.as_ref()) {
        page.figure(&played(run))?;
    }
    page.section("The runs since");
    page.how_to_read();
    let shown = Shown {
        since,
        with: with_change(change),
    };
    for (k, (run, traced)) in worst_first(since, today, &evidence.since)
        .into_iter()
        .enumerate()
    {
        shown.run(&mut page, k > 0, run, traced)?;
    }
    page.section("The runs of the reference");
    page.note(&band(evidence));
    let shown = Shown {
        with: None,
        ..shown
    };
    for (run, traced) in reference.iter().zip(&evidence.left_out) {
        shown.run(&mut page, true, run, traced)?;
    }
    page.section("How the runs of the reference differ from one another");
    page.note(HOW_TO_READ_SPREAD);
    page.table(&spread(evidence));
    if !change.considered.is_empty() {
        page.section("Changes that were considered, the likeliest first");
        page.note(&how_to_read(change));
        let [first, others] = reasons(change);
        page.table(&first);
        if !others.is_empty() {
            let n = others.row_count();
            page.line(&format!("<details><summary>{n} less likely</summary>"));
            page.table(&others);
            page.line("</details>");
        }
    }
    page.section("The runs that were compared");
    page.table(&runs_used(since, [reference, today]));
    if !since.notes.is_empty() {
        page.notes(&since.notes);
    }
    Ok(page)
}

/// The finding in a table, with its equation.
fn what_changed(page: &mut Page, since: &SinceReference<'_>) {
    let change = since.change;
    page.section("What has changed");
    match &change.finding {
        Some(finding) => {
            page.table(&since.found(finding));
            if let Some(effect) = finding.leading.what.effect() {
                page.line(&format!(
                    "<p>{}: {}</p>",
                    escaped(&capitalized(effect.info().name)),
                    equation(effect.info().equation)
                ));
            }
        }
        None => page.paragraphs(match change.verdict {
            ChangeVerdict::Unchanged => "Nothing that these runs could show.",
            ChangeVerdict::ReferenceTooShort => "No name can be given from so short a reference.",
            _ => "Something that has no name here.",
        }),
    }
    if change.verdict != ChangeVerdict::ReferenceTooShort {
        page.note(&format!(
            "Probability that nothing has changed: {}. Mean square that these runs leave, over the largest of a run of the reference: {} \
             without a change, {} with the likeliest.",
            since.unchanged(),
            spoken(change.excess[0]),
            spoken(change.excess[1])
        ));
    }
}

/// How the figures of a run are made.
struct Shown<'a> {
    since: &'a SinceReference<'a>,
    with: Option<&'static str>,
}

impl Shown<'_> {
    fn run(
        &self,
        page: &mut Page,
        is_folded: bool,
        recording: &Recording,
        traced: &TracedRun,
    ) -> Result<(), WorkbenchError> {
        let run = Since {
            recording,
            traced,
            name: self.since.label(recording.name()),
            with: self.with,
        };
        if is_folded {
            let name = escaped(run.name);
            page.line(&format!("<details><summary>{name}</summary>"));
        }
        page.figure(&run.traces())?;
        page.figure(&run.residuals())?;
        if is_folded {
            page.line("</details>");
        }
        Ok(())
    }
}

/// The runs that were asked about: first the one that the laws meet worst, the others in their order.
fn worst_first<'a>(
    since: &SinceReference<'_>,
    today: &'a [Recording],
    traced: &'a [TracedRun],
) -> Vec<(&'a Recording, &'a TracedRun)> {
    let mut runs: Vec<_> = today.iter().zip(traced).collect();
    let errors = since.change.runs.iter().map(|(_, [before, _])| *before);
    let worst = errors.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((worst, _)) = worst.filter(|(worst, _)| *worst < runs.len()) {
        runs[..=worst].rotate_right(1);
    }
    runs
}

/// How the band was measured.
fn band(evidence: &ChangeEvidence) -> String {
    let mut said = if evidence.left_out.is_empty() {
        "The reference is one run: the band in the figures above is what its own fit leaves."
            .to_owned()
    } else {
        "Each run of the reference is predicted by laws fitted to the others; what is left measures the band.".to_owned()
    };
    if evidence.enlarged > 1.0 {
        said += &format!(
            " The band is {} times as wide as that measure: otherwise changes would be found in the reference itself, or in the sum over \
             several runs.",
            spoken(evidence.enlarged.sqrt())
        );
    }
    said
}
