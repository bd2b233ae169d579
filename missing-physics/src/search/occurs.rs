//! Occurrences in the recordings, and which effects need them.

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
            Occurrence::FollowedLevels => follows_levels(passages.flat_map(followed)),
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

/// True if a rod follows three levels of its drive or more: its rise comes near the steady one of each. `followed` has
/// pairs of the power and of the steady power that would hold the rise at that moment, both K/s.
///
/// A limit of the supply is seen by two levels above it that heat alike, and by one below it that tells how much they
/// ought to heat. Levels that are too short for that are told by their sum alone.
fn follows_levels(followed: impl Iterator<Item = (f64, f64)> + Clone) -> bool {
    /// Share of the highest power by which the rod may be behind.
    const BEHIND: f64 = 0.2;
    /// Share of the highest power that is between one level and the next.
    const APART: f64 = 0.1;
    /// Share of the samples of heating that a level has.
    const LASTS: f64 = 0.02;
    const LEVELS: usize = 3;
    let highest = followed.clone().map(|(power, _)| power).fold(0.0, f64::max);
    let heats = |power: &f64| *power > APART * highest;
    let heated = followed.clone().filter(|(power, _)| heats(power)).count();
    let mut near: Vec<f64> = followed
        .filter(|(power, steady)| (power - steady).abs() < BEHIND * highest)
        .map(|(power, _)| power)
        .filter(heats)
        .collect();
    near.sort_by(f64::total_cmp);
    let lasts = ((LASTS * heated as f64).ceil() as usize).max(1);
    let (mut levels, mut from) = (0, 0);
    while from < near.len() {
        let level = near[from] + APART * highest;
        let next = near.partition_point(|power| *power < level);
        if next - from < lasts {
            // Too few: a sample between two levels is how a logger sees a step.
            from += 1;
            continue;
        }
        levels += 1;
        from = near.partition_point(|power| *power < level + APART * highest);
    }
    levels >= LEVELS
}

/// Power, K/s, and what would hold the rise, sample by sample.
fn followed(passage: &Passage) -> impl Iterator<Item = (f64, f64)> + Clone + '_ {
    let steady = passage.rise_k.iter().map(|rise_k| rise_k / passage.tau_s);
    passage.power_k_per_s.iter().copied().zip(steady)
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
        Occurrence::FollowedLevels => follows_levels(followed(passage)),
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

    /// True if a rod with a time constant of 10 samples follows the levels.
    fn levels(powers: &[f64]) -> bool {
        let mut steady = 0.0;
        let pairs: Vec<(f64, f64)> = powers
            .iter()
            .map(|power| {
                let pair = (*power, steady);
                steady += (power - steady) * (1.0 - (-0.1_f64).exp());
                pair
            })
            .collect();
        follows_levels(pairs.into_iter())
    }

    fn held(levels: &[f64], samples: usize) -> Vec<f64> {
        let held = levels.iter().map(|level| vec![*level; samples]);
        held.flatten().collect()
    }

    #[test]
    fn two_levels_tell_no_limit_and_three_do() {
        assert!(!levels(&[]));
        assert!(!levels(&[0.0; 20]));
        assert!(!levels(&held(&[0.0, 5.0, 0.0, 5.0], 100)));
        assert!(!levels(&held(&[0.0, 5.0, 2.0, 5.0, 2.0], 100)));
        assert!(levels(&held(&[0.0, 5.0, 2.0, 3.5, 0.0], 100)));
        // A logger sees a step as a sample between two levels.
        let mut steps = held(&[0.0, 5.0, 2.0], 100);
        steps[100] = 3.0;
        assert!(!levels(&steps));
    }

    #[test]
    fn levels_that_the_rod_does_not_follow_are_told_by_their_sum_alone() {
        let falling = [5.0, 4.4, 3.8, 3.2, 2.6, 2.0, 1.4, 0.8];
        assert!(levels(&held(&falling, 50)));
        let mut pulses = held(&[0.0], 100);
        pulses.extend(held(&falling, 1));
        pulses.extend(held(&[0.0], 100));
        assert!(!levels(&pulses));
        let ramp: Vec<f64> = (0..100).map(f64::from).collect();
        assert!(levels(&ramp));
    }
}
