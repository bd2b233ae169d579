//! Whoever watches a diagnosis may end it at any time.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it makes its data"
)]

use crate::common;

use std::ops::ControlFlow;
use std::time::Duration;

use common::{DT_S, current_a, noisy, output_mm, recording, setting};
use fixtures::wire::ROD;
use identify::{IdentifyError, WienerModel};
use missing_physics::{DiagnoseConfig, DiagnoseProgress, Effort, Part, diagnose};
use recording::Recording;
use rig_files::rod_file;
use sma_effects::{EffectId, EffectSet, EffectValues, Setting};
use wiener::hysteresis::Rule;

/// A recording of a rod with latent heat, and the baseline model of it.
fn rig() -> ([Recording; 1], WienerModel) {
    let concealed = Setting {
        active: EffectSet::of(EffectId::LatentHeat),
        ..setting()
    };
    let output = noisy(output_mm(
        concealed,
        EffectValues::typical(EffectId::LatentHeat, 1.0),
    ));
    let training = [recording("made-up.csv", current_a(), output, DT_S)];
    let rod = rod_file::parse("rod.toml", ROD).unwrap();
    let base = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap();
    (training, base)
}

/// Progress that is told until `ends` holds, and how the diagnosis ends.
fn told_until(
    ends: impl Fn(&DiagnoseProgress) -> bool + Send + Sync,
) -> (Vec<DiagnoseProgress>, Result<(), IdentifyError>) {
    let (training, base) = rig();
    let config = DiagnoseConfig {
        setting: setting(),
        ..DiagnoseConfig::default()
    };
    let mut told = Vec::new();
    let found = diagnose(&base, &training, &[], &config, &mut |progress| {
        let is_over = ends(&progress);
        told.push(progress);
        if is_over {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    (told, found.map(|_| ()))
}

#[test]
fn it_ends_while_the_baseline_is_fitted() {
    let (told, found) = told_until(|progress| matches!(progress, DiagnoseProgress::Baseline(_)));
    let is_baseline =
        |progress: &&DiagnoseProgress| matches!(progress, DiagnoseProgress::Baseline(_));
    assert_eq!(told.iter().filter(is_baseline).count(), 1);
    assert!(told.last().as_ref().is_some_and(is_baseline), "{told:?}");
    let error = found.unwrap_err();
    assert!(matches!(error, IdentifyError::Stopped));
    assert_eq!(error.to_string(), "ended before there was a result");
}

#[test]
fn it_ends_while_effects_are_tried_and_nothing_more_is_told() {
    let (told, found) = told_until(
        |progress| matches!(progress, DiagnoseProgress::Search { simulations, .. } if *simulations > 0),
    );
    let Some(DiagnoseProgress::Search { simulations, .. }) = told.last() else {
        unreachable!("{:?}", told.last());
    };
    assert!(*simulations > 0);
    assert!(matches!(found, Err(IdentifyError::Stopped)));
}

#[test]
fn stages_are_told_in_their_order() {
    let (told, found) = told_until(|_| false);
    assert!(found.is_ok());
    let rank = |progress: &DiagnoseProgress| match progress {
        DiagnoseProgress::Baseline(_) => 0,
        DiagnoseProgress::Search { step, .. } => 1 + *step as usize,
        DiagnoseProgress::Refit => 5,
        DiagnoseProgress::Locate => 6,
    };
    let mut ranks: Vec<usize> = told.iter().map(rank).collect();
    assert!(ranks.is_sorted(), "{ranks:?}");
    ranks.dedup();
    assert_eq!(ranks, [0, 1, 2, 3, 4, 5, 6]);
}

#[test]
fn it_ends_before_the_last_stage() {
    let (told, found) = told_until(|progress| *progress == DiagnoseProgress::Locate);
    assert_eq!(told.last(), Some(&DiagnoseProgress::Locate));
    assert!(matches!(found, Err(IdentifyError::Stopped)));
}

#[test]
fn where_the_time_is_over_the_best_so_far_is_judged_and_the_rest_is_listed() {
    let (training, base) = rig();
    let with = |effort, time_limit| {
        let config = DiagnoseConfig {
            setting: setting(),
            effort,
            time_limit,
            ..DiagnoseConfig::default()
        };
        let go_on = &mut |_| ControlFlow::Continue(());
        diagnose(&base, &training, &[], &config, go_on).unwrap()
    };
    let whole = with(Effort::Normal, None);
    assert_eq!(whole.left_out, []);
    // No time at all: single effects are tried all the same, and one of them is the one.
    let cut = with(Effort::Normal, Some(Duration::ZERO));
    assert!(
        cut.left_out.contains(&Part::MoreEffects),
        "{:?}",
        cut.left_out
    );
    // A single explanation needs no run that tells it from others.
    assert!(!cut.left_out.contains(&Part::NextRun));
    assert!(cut.simulations.total() < whole.simulations.total());
    let quick = with(Effort::Quick, None);
    assert_eq!(quick.left_out, [Part::OtherLoops, Part::OtherStarts]);
    for found in [&whole, &cut, &quick] {
        assert_eq!(found.findings.len(), 1, "{:?}", found.findings);
        assert_eq!(found.findings[0].effect.id(), "latent-heat");
    }
}
