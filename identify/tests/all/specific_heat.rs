//! An uncertain specific heat widens what is said of temperatures, and nothing else.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it reads its data"
)]

#[allow(dead_code, reason = "tests use different parts of what they share")]
use crate::common;

use common::{ROD, fitted, recording, triangles, with_output};
use identify::Fit;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::Recording;

#[test]
fn a_range_of_specific_heat_is_carried_into_the_intervals() {
    let training = [noisy(&recording("a.csv", triangles(1200, 5.5), 0.5), 0.005)];
    let with_heat = |heat: &str| {
        let text = ROD.replace(
            "specific_heat_j_per_kg_k = 500.0",
            &format!("specific_heat_j_per_kg_k = {heat}"),
        );
        let (model, mut fit) = fitted(&text, &training);
        (model.carry_specific_heat(&mut fit), fit)
    };
    let (carried, wide) = with_heat("{ value = 500.0, range = [450.0, 840.0] }");
    assert!(carried);
    let (none, light) = with_heat("450.0");
    assert!(!none);
    let (_, heavy) = with_heat("840.0");
    // What a fit with either end of the range says is the end of the interval.
    for name in ["loop_center_degc", "loop_half_width_k", "loop_spread_k"] {
        let interval = |fit: &Fit| fit.parameter(name).unwrap().intervals[0].unwrap();
        let (wide, light, heavy) = (interval(&wide), interval(&light), interval(&heavy));
        assert!(
            (wide.lower / heavy.lower - 1.0).abs() < 2e-3,
            "{wide:?} {heavy:?}"
        );
        assert!(
            (wide.upper / light.upper - 1.0).abs() < 2e-3,
            "{wide:?} {light:?}"
        );
    }
    // The time constant does not rest on it.
    let tau = |fit: &Fit| fit.parameter("tau_s").unwrap().intervals[0].unwrap();
    assert!((tau(&wide).upper / tau(&light).upper - 1.0).abs() < 1e-3);

    let fixed = format!("{ROD}[model]\nloop_spread_k = {{ fixed = 6.0 }}\n").replace(
        "specific_heat_j_per_kg_k = 500.0",
        "specific_heat_j_per_kg_k = { value = 500.0, range = [450.0, 840.0] }",
    );
    let (model, mut fit) = fitted(&fixed, &training);
    assert!(!model.carry_specific_heat(&mut fit));
}

/// Adds white noise of a standard deviation, mm, to a recording.
fn noisy(like: &Recording, deviation: f64) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
    let output = like.output().iter().map(|y| y + deviation * noise());
    with_output(like, "mm", output.collect())
}
