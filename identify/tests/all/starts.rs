//! Recordings that start warm, of which nothing was written down.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

use std::ops::ControlFlow;

use crate::common;

use common::{ROD, TRUE_TAU_S, recording, rod, triangles, with_output};
use identify::{
    Fit, FitConfig, ForwardModel, ParameterState, ParameterVector, RigModel, fit, validate,
};
use recording::Recording;
use wiener::hysteresis::Rule;

/// The model that `sma identify` fits, and its fit.
fn fitted(text: &str, training: &[Recording]) -> (RigModel, Fit) {
    let model = RigModel::new(&rod(text), Rule::LastReversal, training)
        .unwrap()
        .with_open_starts(training);
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let fit = fit(&model, training, &FitConfig::default(), go_on).unwrap();
    (model, fit)
}

/// A recording without its first samples: of the way up, hot.
fn cut(whole: &Recording, first: usize) -> Recording {
    whole.slice(first..whole.len()).unwrap()
}

/// A recording whose first samples are as where the rod is hottest.
fn saturated(whole: &Recording, first: usize) -> Recording {
    let hottest = whole.output().iter().copied().fold(f64::MAX, f64::min);
    let mut output = whole.output().to_vec();
    output[..first].fill(hottest);
    with_output(whole, "mm", output)
}

fn value(fit: &Fit, name: &str) -> f64 {
    fit.parameter(name).unwrap().values[0]
}

#[test]
fn a_warm_start_is_found_with_the_rest() {
    let whole = recording("a.csv", triangles(1200, 5.8), 0.5);
    for first in [150, 330] {
        let training = [cut(&whole, first)];
        let (_, fit) = fitted(ROD, &training);
        // What went before leaves more than a place between the curves: by less than a thousandth of the stroke.
        assert!(fit.train_rmse < 3e-3, "{first}: {}", fit.train_rmse);
        assert!((value(&fit, "tau_s") / TRUE_TAU_S - 1.0).abs() < 5e-3);
        assert!((value(&fit, "loop_half_width_k") / 8.0 - 1.0).abs() < 5e-3);
        assert!(value(&fit, "start_rise_k") > 5.0);
    }
}

#[test]
fn the_last_reversal_before_a_recording_is_found() {
    let whole = recording("a.csv", triangles(1200, 5.8), 0.5);
    // On branches within the loop, down and up.
    for (first, sign) in [(280, -1.0), (380, 1.0)] {
        let training = [cut(&whole, first)];
        let (model, without) = fitted(ROD, &training);
        let RigModel::Wiener(model) = model else {
            unreachable!("a heated rod with a loop")
        };
        let open = model.with_open_reversals();
        let vector = ParameterVector::new(open.parameters(), 1);
        let config = FitConfig {
            from: vec![without.coordinates(&vector)],
            ..FitConfig::default()
        };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let with = fit(&open, &training, &config, go_on).unwrap();
        let found = [&with, &without].map(|fit| fit.train_rmse);
        assert!(
            found[1] > 5e-4 && found[0] < 1e-4 * found[1],
            "{first}: {found:?}"
        );
        let since_k = value(&with, "start_since_reversal_k");
        assert!(sign * since_k > 1.0, "{first}: {since_k}");
    }
}

#[test]
fn what_is_at_rest_begins_at_rest_and_what_is_said_stays() {
    let whole = recording("a.csv", triangles(1200, 5.8), 0.5);
    let state = |text: &str, training: &[Recording]| {
        let model = RigModel::new(&rod(text), Rule::LastReversal, training)
            .unwrap()
            .with_open_starts(training);
        let mut infos = model.parameters().iter();
        infos
            .find(|info| info.name == "start_rise_k")
            .unwrap()
            .state
    };
    assert_eq!(
        state(ROD, std::slice::from_ref(&whole)),
        ParameterState::Fixed(0.0)
    );
    let warm = [cut(&whole, 150)];
    assert_eq!(state(ROD, &warm), ParameterState::Free);
    // Hot, and heated again before it has moved back.
    let pause = [vec![0.0; 40], triangles(300, 5.8)].concat();
    let driven = recording("b.csv", pause, 0.5);
    let saturated = [saturated(&driven, 40)];
    assert_eq!(state(ROD, &saturated), ParameterState::Free);
    assert_eq!(state(ROD, &[driven]), ParameterState::Fixed(0.0));
    let said = format!("{ROD}[model]\nstart_rise_k = {{ fixed = 0.0 }}\n");
    assert_eq!(state(&said, &warm), ParameterState::Fixed(0.0));
}

#[test]
fn an_unseen_recording_may_start_warm_where_the_training_did_not_and_the_other_way_round() {
    let whole = recording("a.csv", triangles(1200, 5.8), 0.5);
    let other = recording("b.csv", triangles(900, 5.4), -1.0);
    let (model, fit) = fitted(ROD, std::slice::from_ref(&whole));
    let warm = validate(&model, &fit, &cut(&other, 200)).unwrap();
    assert!(warm.rmse < 1e-3, "{}", warm.rmse);
    let (model, fit) = fitted(ROD, &[cut(&whole, 150)]);
    let at_rest = validate(&model, &fit, &other).unwrap();
    assert!(at_rest.rmse < 1e-2, "{}", at_rest.rmse);
}
