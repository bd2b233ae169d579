//! Reasons to distrust a fit: bounds, loops where no recording has been, outputs before their drive.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

use crate::common;

use common::{ROD, fitted, recording, steps, triangles, with_output};
use identify::early_output;
use recording::Recording;

#[test]
fn a_bound_of_the_search_holds_a_fit() {
    let training = [recording("a.csv", triangles(800, 5.8), 0.5)];
    let (_, free) = fitted(ROD, &training);
    assert!(
        free.is_found(),
        "{:?} {} {:?}",
        free.termination,
        free.agreeing_starts,
        free.beyond_reach
    );
    let text = format!("{ROD}[model]\ntau_s = {{ bounds = [1.0, 5.0] }}\n");
    let (_, held) = fitted(&text, &training);
    let names: Vec<&str> = held.held_by_bounds().map(|one| one.info.name).collect();
    assert!(names.contains(&"tau_s"), "{names:?}");
    assert!(!held.is_found());
}

/// The rod of the tests transforms between 62 and 78 °C.
#[test]
fn a_branch_that_was_not_reached_has_no_place() {
    let whole = [recording("a.csv", triangles(1200, 5.8), 0.5)];
    let (_, seen) = fitted(ROD, &whole);
    assert_eq!(seen.beyond_reach, []);
    assert!(seen.parameter("loop_center_degc").unwrap().intervals[0].is_some());
    // Turned back before the middle of the heating branch.
    let partial = [recording("a.csv", triangles(1200, 4.2), 0.5)];
    let (_, unseen) = fitted(ROD, &partial);
    let highest = unseen.recordings[0].peak_temperature_degc;
    assert!(highest < 78.0, "{highest}");
    let beyond = unseen.beyond_reach[0];
    assert!(beyond.is_heating && beyond.branch_degc > beyond.reached_degc);
    assert!((beyond.reached_degc - highest).abs() < 1e-9);
    for name in ["loop_center_degc", "loop_half_width_k"] {
        assert_eq!(unseen.parameter(name).unwrap().intervals, [None], "{name}");
    }
    assert!(!unseen.is_found());
}

/// The recording with its output some samples earlier, or later.
fn shifted(whole: &Recording, samples: usize, earlier: bool) -> Recording {
    let output = whole.output();
    let n = output.len();
    let from = |k: usize| {
        if earlier {
            (k + samples).min(n - 1)
        } else {
            k.saturating_sub(samples)
        }
    };
    with_output(whole, "mm", (0..n).map(|k| output[from(k)]).collect())
}

#[test]
fn an_output_before_its_drive_is_said_and_a_dead_time_is_not() {
    let whole = recording("a.csv", steps(900), 0.5);
    let dt_s = whole.time_s()[1] - whole.time_s()[0];
    let early = [shifted(&whole, 4, true)];
    let (model, fit) = fitted(ROD, &early);
    let found = early_output(&model, &early, &fit).unwrap().unwrap();
    assert!((found.by_s / (4.0 * dt_s) - 1.0).abs() < 0.15, "{found:?}");
    assert!(found.rmse < 0.5 * fit.train_rmse);
    for other in [whole.clone(), shifted(&whole, 4, false)] {
        let training = [other];
        let (model, fit) = fitted(ROD, &training);
        assert_eq!(early_output(&model, &training, &fit).unwrap(), None);
    }
}

/// Of one rate, time constant and loop follow the wrong clock a long way.
#[test]
fn an_output_before_its_drive_is_said_of_one_rate_too() {
    // Up within 14 s, held for 8, down within 6, at rest for 12.
    let cycle = |k: usize| match (0.25 * k as f64) % 40.0 {
        t if t < 14.0 => 4.2 * t / 14.0,
        t if t < 22.0 => 4.2,
        t if t < 28.0 => 4.2 * (28.0 - t) / 6.0,
        _ => 0.0,
    };
    let whole = recording("a.csv", (0..600).map(cycle).collect(), 0.5);
    let noise = |k: usize| 0.004 * ((k * k) as f64 * 0.7).sin();
    let early = shifted(&whole, 4, true);
    let output = early.output().iter().enumerate();
    let noisy = output.map(|(k, y)| y + noise(k)).collect();
    let training = [with_output(&whole, "mm", noisy)];
    let (model, fit) = fitted(ROD, &training);
    let found = early_output(&model, &training, &fit).unwrap();
    assert!(
        found.is_some_and(|found| (0.7..1.4).contains(&found.by_s)),
        "{found:?}, {} of {}",
        fit.train_rmse,
        fit.noise.lag_1
    );
}
