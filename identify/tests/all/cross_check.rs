//! Somebody else's optimizers on the same cost.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it reads its data"
)]

#[allow(dead_code, reason = "tests use different parts of what they share")]
use crate::common;

use std::ops::ControlFlow;

use common::{ROD, recording, rod, triangles, with_output};
use identify::{
    CrossVerdict, Fit, FitConfig, LeastSquaresConfig, Loss, RigModel, cross_check, fit,
};
use recording::Recording;
use wiener::hysteresis::Rule;

/// A recording with a ripple that no model of this kind follows: its floor is not zero.
fn rippled() -> Recording {
    // Through the whole loop: of one that was not reached a fit prefers another.
    let clean = recording("a.csv", triangles(900, 5.4), 0.5);
    let ripple = |k: usize| 0.02 * (1.7 * k as f64).sin();
    let output = clean.output().iter().enumerate();
    with_output(&clean, "mm", output.map(|(k, y)| y + ripple(k)).collect())
}

fn fitted(model: &RigModel, training: &[Recording], config: &FitConfig) -> Fit {
    fit(model, training, config, &mut |_| ControlFlow::Continue(())).unwrap()
}

#[test]
fn argmin_ends_at_the_same_floor() {
    let training = [rippled()];
    let model = RigModel::new(&rod(ROD), Rule::LastReversal, &training).unwrap();
    for loss in [Loss::Squares, Loss::Huber] {
        let config = FitConfig {
            loss,
            ..FitConfig::default()
        };
        let fit = fitted(&model, &training, &config);
        let check = cross_check(&model, &training, &fit).unwrap();
        assert_eq!(check.verdict, CrossVerdict::Agrees, "{check:?}");
        assert!((check.rmse / fit.train_rmse - 1.0).abs() < 0.005);
        let (name, tau_s, unit) = &check.shared[0];
        assert_eq!((*name, unit.as_str()), ("tau_s", "s"));
        let ours = fit.parameter("tau_s").unwrap().values[0];
        assert!((tau_s / ours - 1.0).abs() < 0.05, "{tau_s} {ours}");
        assert!(check.simulations > 1000);
        assert_eq!(check, cross_check(&model, &training, &fit).unwrap());
    }
}

#[test]
fn argmin_ends_below_a_search_that_was_cut_short() {
    let training = [rippled()];
    let model = RigModel::new(&rod(ROD), Rule::LastReversal, &training).unwrap();
    let config = FitConfig {
        swarm_iterations: 1,
        starts: 1,
        least_squares: LeastSquaresConfig {
            iterations: 0,
            ..LeastSquaresConfig::default()
        },
        ..FitConfig::default()
    };
    let fit = fitted(&model, &training, &config);
    let check = cross_check(&model, &training, &fit).unwrap();
    assert_eq!(check.verdict, CrossVerdict::EndedLower, "{check:?}");
    assert!(check.ratio < 0.9 && check.rmse < fit.train_rmse);
}
