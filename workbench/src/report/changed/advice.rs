//! Advice on what to do after the answer.

use missing_physics::{Change, ChangeEvidence, ChangeVerdict, FEWEST_COOLINGS, FEWEST_RUNS};

use crate::report::number::spoken;
use crate::report::words::named;

/// One paragraph a line; empty where there is nothing to do.
pub(crate) fn advice(change: &Change, evidence: &ChangeEvidence) -> String {
    match (change.verdict, &change.finding) {
        (ChangeVerdict::Unchanged, _) => "Nothing has to be done. A run like those of the reference, with a slow cooling, is the one that \
             shows a change best."
            .to_owned(),
        (ChangeVerdict::ReferenceTooShort, _) => format!(
            "Record the rig as it should be at least {FEWEST_RUNS} times, better four times, with {FEWEST_COOLINGS} slow coolings or more, \
             under the drives that are used today."
        ),
        (ChangeVerdict::Changed, Some(finding)) if finding.could_also_be.is_empty() => {
            "No other effect or law that is known accounts for these runs as well.".to_owned()
        }
        (ChangeVerdict::Changed, Some(_)) => apart(evidence),
        _ => "Compare the drives first: runs that go where the reference did not cannot be judged. If the drives are alike, two things may \
             have changed at once, or something that is not in the catalogue: see where the residual leaves the band below."
            .to_owned(),
    }
}

/// The run that tells what these runs do not.
fn apart(evidence: &ChangeEvidence) -> String {
    let Some(next) = &evidence.next else {
        return "No run was found that tells these changes apart. Runs that differ from these say more than the \
             same again: another speed, a long hold, cycles that turn back half way. Record such a run of the rig as it should be, too."
            .to_owned();
    };
    match &next.run {
        None => next.sentence.clone(),
        Some(run) => format!(
            "Play the run of {} s whose drive the figure below shows, and ask again with its recording beside these in --train: {}. It should put {} standard deviations \
             between {} (these runs again: {}).",
            spoken(run.duration_s()),
            run.name,
            spoken(run.separation),
            named(&next.separates, "and"),
            spoken(run.separation_now)
        ),
    }
}
