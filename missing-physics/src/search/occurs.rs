//! What happens in the recordings, and which effects need it.

use identify::IdentifyError;

use crate::model::case::{Case, Node};
use crate::model::tangent::sensitivities;
use crate::pullback::scene::{Passage, Scene};
use crate::{CandidateSet, Occurrence};

/// Those of some effects for which what they act on happens in the recordings: a play needs a reversal.
pub(crate) fn testable(
    case: &Case<'_>,
    node: &Node,
    among: CandidateSet,
) -> Result<CandidateSet, IdentifyError> {
    let scene = Scene::of(case, node, &sensitivities(case, node)?)?;
    let happens = |occurrence: &Occurrence| {
        let mut passages = scene.passages.iter();
        passages.any(|passage| occurs(passage, *occurrence))
    };
    Ok(among
        .iter()
        .filter(|effect| effect.info().needs_in_recording.iter().all(happens))
        .collect())
}

/// Share of the transformation below which the rod does not transform.
const MOVES: f64 = 0.01;

fn occurs(passage: &Passage, occurrence: Occurrence) -> bool {
    // How much it transforms on each branch, in whole transformations.
    let [mut heats, mut cools] = [0.0; 2];
    for (k, pair) in passage.fraction.windows(2).enumerate() {
        let moved = (pair[1] - pair[0]).abs();
        if passage.heating[k + 1] {
            heats += moved;
        } else {
            cools += moved;
        }
    }
    let turns = passage.heating.windows(2);
    let reversals = turns.filter(|pair| pair[0] != pair[1]).count();
    match occurrence {
        Occurrence::Cooling => cools > MOVES,
        Occurrence::BothBranches => heats > MOVES && cools > MOVES,
        Occurrence::Reversal => reversals > 0 && heats > MOVES && cools > MOVES,
        Occurrence::InnerReversals => reversals > 1,
        Occurrence::SecondCycle => heats + cools > 2.0,
    }
}
