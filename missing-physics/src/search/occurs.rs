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
        match occurrence {
            Occurrence::DriveLevels => has_levels(passages.map(|one| one.power_k_per_s.as_slice())),
            other => passages.any(|passage| occurs(passage, *other)),
        }
    };
    Ok(among
        .iter()
        .filter(|effect| effect.info().needs_in_recording.iter().all(happens))
        .collect())
}

/// Share of the transformation below which the rod does not transform.
const MOVES: f64 = 0.01;

/// Whether a rod is heated at more levels than one; `powers` are those of recordings.
fn has_levels<'a>(powers: impl Iterator<Item = &'a [f64]> + Clone) -> bool {
    /// Share of the highest power below which a rod is not heated.
    const HEATS: f64 = 0.01;
    /// Share of the highest power between which and the highest all counts as one level: a drive within a tenth.
    const LEVEL: f64 = 0.8;
    /// Share of the samples of heating that a level has.
    const LASTS: f64 = 0.02;
    let all = powers.flatten().copied();
    let highest = all.clone().fold(0.0, f64::max);
    let share_above =
        |share: f64| all.clone().filter(|power| *power > share * highest).count() as f64;
    let (heated, high) = (share_above(HEATS), share_above(LEVEL));
    heated > 0.0 && high >= LASTS * heated && heated - high >= LASTS * heated
}

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
        Occurrence::DriveLevels => has_levels(std::iter::once(passage.power_k_per_s.as_slice())),
        Occurrence::Cooling => cools > MOVES,
        Occurrence::BothBranches => heats > MOVES && cools > MOVES,
        Occurrence::Reversal => reversals > 0 && heats > MOVES && cools > MOVES,
        Occurrence::InnerReversals => reversals > 1,
        Occurrence::SecondCycle => heats + cools > 2.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn levels(powers: &[&[f64]]) -> bool {
        has_levels(powers.iter().copied())
    }

    #[test]
    fn a_rod_that_is_heated_at_one_level_has_no_levels() {
        assert!(!levels(&[]));
        assert!(!levels(&[&[0.0; 20]]));
        assert!(!levels(&[&[0.0, 5.0, 5.0, 4.9, 0.0, 5.0]]));
        assert!(!levels(&[&[0.0, 5.0], &[5.0, 0.0]]));
        // A sample between two levels is how a logger sees a step.
        let step: Vec<f64> = (0..200)
            .map(|k| f64::from(u8::from(k > 99)) * 5.0)
            .collect();
        let seen: Vec<f64> = step
            .iter()
            .enumerate()
            .map(|(k, power)| if k == 99 { 2.0 } else { *power })
            .collect();
        assert!(!levels(&[&seen]));
    }

    #[test]
    fn levels_of_two_recordings_count_together() {
        assert!(levels(&[&[0.0, 5.0, 2.0, 5.0]]));
        assert!(levels(&[&[0.0, 5.0], &[0.0, 2.0]]));
        let ramp: Vec<f64> = (0..100).map(f64::from).collect();
        assert!(levels(&[&ramp]));
    }
}
