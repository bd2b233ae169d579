//! A fit of generated recordings returns what generated them.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

mod common;

use common::{ROD, TRUE_TAU_S, recording, rod, steps, triangles};
use identify::{Fit, FitConfig, IdentifyError, OffsetSource, WienerModel, fit, validate};
use recording::{Recording, RecordingParts};
use wiener::hysteresis::Rule;

fn fitted(rod_text: &str, training: &[Recording], seed: u64) -> (WienerModel, Fit) {
    let model = WienerModel::new(&rod(rod_text), Rule::LastReversal, training).unwrap();
    let config = FitConfig {
        seed,
        ..FitConfig::default()
    };
    let fit = fit(&model, training, &config, &mut |_, _| ()).unwrap();
    (model, fit)
}

fn value(fit: &Fit, name: &str) -> f64 {
    fit.parameter(name).unwrap().values[0]
}

#[test]
fn two_recordings_with_their_own_offsets_return_the_truth() {
    let training = [
        recording("a.csv", triangles(1200, 4.2), 0.5),
        recording("b.csv", steps(900), -1.25),
    ];
    let (model, fit) = fitted(ROD, &training, 1);
    assert!(fit.train_rmse < 1e-6, "{}", fit.train_rmse);
    assert!(fit.termination.is_minimum());
    for (name, truth) in [
        ("tau_s", TRUE_TAU_S),
        ("loop_center_degc", 70.0),
        ("loop_half_width_k", 8.0),
        ("loop_spread_k", 6.0),
        ("zeta", 0.8),
        ("gain", -3.0),
        ("offset", 0.5),
    ] {
        let found = value(&fit, name);
        assert!(
            (found - truth).abs() < 1e-4 * truth.abs(),
            "{name}: {found} {truth}"
        );
    }
    assert!((fit.parameter("offset").unwrap().values[1] + 1.25).abs() < 1e-5);
    // Nothing of the unseen recording but its rest decides its offset.
    let unseen = recording("unseen.csv", triangles(700, 3.9), 2.0);
    let validated = validate(&model, &fit, &unseen).unwrap();
    assert_eq!(
        validated.offset_source,
        OffsetSource::BeforeDrive { n_samples: 22 }
    );
    assert!(validated.rmse < 1e-5, "{}", validated.rmse);
    assert!((validated.offset - 2.0).abs() < 1e-5);
}

#[test]
fn a_recording_that_starts_driven_takes_its_offset_from_the_whole() {
    let training = [recording("a.csv", triangles(1200, 4.2), 0.5)];
    let (model, fit) = fitted(ROD, &training, 1);
    let unseen = recording("unseen.csv", triangles(700, 3.9)[25..].to_vec(), 2.0);
    let validated = validate(&model, &fit, &unseen).unwrap();
    assert_eq!(validated.offset_source, OffsetSource::WholeRecording);
    assert!(validated.rmse < 1e-5, "{}", validated.rmse);
}

#[test]
fn same_seed_same_bits_on_any_number_of_threads() {
    let training = [
        recording("a.csv", triangles(600, 4.2), 0.5),
        recording("b.csv", steps(500), -1.25),
    ];
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| fitted(ROD, &training, 7).1)
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(7));
}

#[test]
fn without_heat_capacity_only_ratios_are_found() {
    // Any factor on all temperature differences gives the same output: with λ assumed, the ratios
    // that remain are those of the truth.
    let training = [recording("a.csv", triangles(1200, 4.2), 0.5)];
    let text = ROD.replace("specific_heat_j_per_kg_k = 500.0\n", "");
    let (model, fit) = fitted(&text, &training, 1);
    assert!(!model.knows_temperature());
    assert!(fit.train_rmse < 1e-6);
    assert!((value(&fit, "tau_s") - TRUE_TAU_S).abs() < 1e-4 * TRUE_TAU_S);
    let width = value(&fit, "loop_half_width_k");
    assert!((width / value(&fit, "loop_spread_k") - 8.0 / 6.0).abs() < 1e-4);
    assert!(((value(&fit, "loop_center_degc") - 21.0) / width - 49.0 / 8.0).abs() < 1e-3);
}

#[test]
fn fixed_parameters_stay_and_bounds_hold() {
    let training = [recording("a.csv", triangles(600, 4.2), 0.5)];
    let text =
        format!("{ROD}[model]\nzeta = {{ fixed = 0.5 }}\ntau_s = {{ bounds = [1.0, 5.0] }}\n");
    let (_, fit) = fitted(&text, &training, 1);
    assert_eq!(value(&fit, "zeta").to_bits(), 0.5_f64.to_bits());
    let tau = fit.parameter("tau_s").unwrap();
    assert!(
        tau.at_bound && (1.0..=5.0).contains(&tau.values[0]),
        "{tau:?}"
    );
    assert!(fit.train_rmse > 1e-3);
}

#[test]
fn everything_fixed_is_nothing_to_identify() {
    let training = [recording("a.csv", triangles(600, 4.2), 0.5)];
    let names = [
        "tau_s",
        "loop_center_degc",
        "loop_half_width_k",
        "loop_spread_k",
        "zeta",
    ];
    let fixed: String = names
        .map(|name| format!("{name} = {{ fixed = 0.7 }}\n"))
        .concat();
    let model = WienerModel::new(
        &rod(&format!("{ROD}[model]\n{fixed}")),
        Rule::LastReversal,
        &training,
    )
    .unwrap();
    let error = fit(&model, &training, &FitConfig::default(), &mut |_, _| ()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "every parameter is fixed: nothing to identify"
    );
}

#[test]
fn recordings_must_share_a_unit_and_move() {
    let refused = |training: &[Recording]| {
        WienerModel::new(&rod(ROD), Rule::LastReversal, training)
            .unwrap_err()
            .to_string()
    };
    let first = recording("a.csv", steps(300), 0.0);
    let parts = |unit: &str, output: Vec<f64>| {
        Recording::new(RecordingParts {
            name: "b.csv".to_owned(),
            time_s: Some(first.time_s().to_vec()),
            drive: first.drive().to_vec(),
            output_unit: unit.to_owned(),
            output,
            ..RecordingParts::default()
        })
        .unwrap()
    };
    let in_degrees = parts("deg", first.output().to_vec());
    assert_eq!(
        refused(&[first.clone(), in_degrees]),
        "b.csv: output in deg, but a.csv is in mm: one unit is needed"
    );
    let still = refused(&[first.clone(), parts("mm", vec![1.0; 300])]);
    assert!(still.starts_with("b.csv: output is 1 mm"), "{still}");
    assert_eq!(refused(&[]), "no training recording; at least 1 is needed");
}

#[test]
fn recordings_need_time() {
    let timed = recording("a.csv", steps(300), 0.0);
    let untimed = Recording::new(RecordingParts {
        name: "static.csv".to_owned(),
        drive: timed.drive().to_vec(),
        output_unit: "mm".to_owned(),
        output: timed.output().to_vec(),
        ..RecordingParts::default()
    })
    .unwrap();
    let error = WienerModel::new(&rod(ROD), Rule::LastReversal, &[untimed]).unwrap_err();
    assert!(matches!(error, IdentifyError::Untimed { .. }));
    assert_eq!(
        error.to_string(),
        "static.csv: no time; a heat balance can only be identified from timed samples"
    );
}
