//! Two rods that pull against one another, each with its own drive.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::ops::ControlFlow;

use identify::{
    FitConfig, ForwardModel, Identification, IdentifyError, InputFile, Provenance, RigModel,
    SadeghiModel, SavedModel, fit, predict, validate,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Recording, RecordingParts};
use rig_files::model_file;
use wiener::hysteresis::Rule;
use wiener::{Drive, Plant, Profile, Wiener, WienerParams, run};

use crate::common::{ROD, TRUE_TAU_S, rod, steps, triangles, truth};

/// Stroke of the antagonist over that of the first rod.
const STROKE: f64 = 0.7;
const NOISE_MM: f64 = 0.004;

/// The antagonist: it cools slower, and its loop lies higher and is wider.
fn antagonist() -> WienerParams {
    let mut params = truth();
    params.heat.conductance_w_per_m_k *= 0.8;
    params.limiting_loop.loop_center_degc = 76.0;
    params.limiting_loop.loop_half_width_k = 10.0;
    params
}

/// Displacement of a rod over its stroke.
fn pull(params: WienerParams, drive: &[f64]) -> Vec<f64> {
    let params = WienerParams {
        gain: 1.0,
        offset: 0.0,
        ..params
    };
    let model = Wiener::new(Drive::Current, Rule::LastReversal, &[params]).unwrap();
    let profile = Profile::uniform(drive, 0.25, 21.0).unwrap();
    let mut pulled = Vec::new();
    run(&model, &mut model.rest(21.0), &profile, |_, shown| {
        pulled.push(shown.displacement[0])
    });
    pulled
}

/// Recording of a pair, with a sensor's noise.
fn pair(name: &str, drive: Vec<f64>, antagonist_drive: Option<Vec<f64>>) -> Recording {
    let mut noise = ChaCha8Rng::seed_from_u64(name.len() as u64);
    let first = pull(truth(), &drive);
    let second = match &antagonist_drive {
        Some(drive) => pull(antagonist(), drive),
        None => vec![0.0; drive.len()],
    };
    let output = first.iter().zip(second).map(|(first, second)| {
        let noise: f64 = StandardNormal.sample(&mut noise);
        -3.0 * (first - STROKE * second) + 0.5 + NOISE_MM * noise
    });
    Recording::new(RecordingParts {
        name: name.to_owned(),
        time_s: Some((0..drive.len()).map(|k| 0.25 * k as f64).collect()),
        output_unit: "mm".to_owned(),
        output: output.collect(),
        drive,
        antagonist_drive,
        ..RecordingParts::default()
    })
    .unwrap()
}

/// A drive that begins as late as its antagonist has gone once up and down.
fn later(drive: Vec<f64>) -> Vec<f64> {
    let mut later = vec![0.0; 150];
    later.extend_from_slice(&drive[..drive.len() - 150]);
    later
}

fn training() -> [Recording; 1] {
    let drives = (triangles(1500, 5.5), later(triangles(1500, 6.0)));
    [pair("both.csv", drives.0, Some(drives.1))]
}

#[test]
fn both_rods_are_found_and_what_they_do_together_is_predicted() {
    let training = training();
    let rod = rod(ROD);
    let model = RigModel::new(&rod, Rule::LastReversal, &training).unwrap();
    assert!(matches!(model, RigModel::Antagonist(_)));
    let fit = fit(&model, &training, &FitConfig::default(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap();
    assert!(fit.is_found());
    assert!(fit.train_rmse < 1.1 * NOISE_MM, "{}", fit.train_rmse);
    let expected = [
        ("tau_s", TRUE_TAU_S, 0.01),
        ("antagonist_tau_s", TRUE_TAU_S / 0.8, 0.01),
        ("loop_center_degc", 70.0, 0.01),
        ("antagonist_center_degc", 76.0, 0.01),
        ("loop_half_width_k", 8.0, 0.03),
        ("antagonist_half_width_k", 10.0, 0.03),
        ("antagonist_stroke", STROKE, 0.01),
        ("gain", -3.0, 0.01),
    ];
    for (name, truth, within) in expected {
        let found = fit.parameter(name).unwrap();
        let value = found.values[0];
        assert!((value / truth - 1.0).abs() < within, "{name} {value}");
        assert!(found.intervals[0].is_some(), "{name}");
    }

    // Both are driven otherwise in what it has not seen, and at once.
    let unseen = pair("unseen.csv", steps(900), Some(later(steps(900))));
    let validated = validate(&model, &fit, &unseen).unwrap();
    assert!(validated.rmse < 1.2 * NOISE_MM, "{}", validated.rmse);

    // As a file, too.
    let identification = Identification {
        rod: &rod,
        model: &model,
        effects: None,
        rule: Rule::LastReversal,
        fit: &fit,
        training: &training,
        unseen: std::slice::from_ref(&unseen),
        validated: &[validated],
    };
    let made = Provenance {
        version: "0".to_owned(),
        command: String::new(),
        seed: 1,
        input: Vec::<InputFile>::new(),
    };
    let text = model_file::to_toml(&SavedModel::of(&identification, made)).unwrap();
    let saved = model_file::parse("model.toml", &text).unwrap();
    assert_eq!(model_file::to_toml(&saved).unwrap(), text);
    assert!(saved.wiener_params().is_none());
    let again = saved.validate(&unseen).unwrap();
    assert!(again.rmse < 1.2 * NOISE_MM, "{}", again.rmse);
}

#[test]
fn with_a_cold_antagonist_the_first_rod_is_as_it_is_alone() {
    let drive = triangles(600, 5.5);
    let [rest, alone] = [Some(vec![0.0; 600]), None]
        .map(|antagonist_drive| pair("one.csv", drive.clone(), antagonist_drive));
    let rod = rod(ROD);
    let models = [&rest, &alone]
        .map(|one| RigModel::new(&rod, Rule::LastReversal, std::slice::from_ref(one)).unwrap());
    let middle = |info: &identify::ParameterInfo| match info.state {
        identify::ParameterState::Fixed(value) => value,
        identify::ParameterState::Free if info.name == "gain" => 2.0,
        identify::ParameterState::Free if info.name == "offset" => 0.3,
        identify::ParameterState::Free => (info.bounds.lower * info.bounds.upper).sqrt(),
    };
    let [with, without] = [(&models[0], &rest), (&models[1], &alone)].map(|(model, recording)| {
        let point: Vec<f64> = model.parameters().iter().map(middle).collect();
        predict(model, &point, recording).unwrap()
    });
    // A rod at rest has a displacement of its own, which is the offset's.
    let off = with.output[0] - without.output[0];
    for (with, without) in with.output.iter().zip(&without.output) {
        assert!((with - without - off).abs() < 1e-12);
    }
    assert_eq!(with.temperature_degc, without.temperature_degc);
    let missing = predict(&models[0], &[0.0; 17], &alone);
    assert!(matches!(missing, Err(IdentifyError::NoAntagonist { .. })));
}

#[test]
fn a_pair_has_no_unknowns_of_the_paper_and_two_starts() {
    let training = training();
    let rod = rod(ROD);
    let refused = SadeghiModel::new(&rod, Rule::LastReversal, &training);
    assert!(matches!(refused, Err(IdentifyError::TwoRods { .. })));

    let drive: Vec<f64> = triangles(600, 5.5).into_iter().skip(60).collect();
    let warm = [pair("warm.csv", vec![0.0; 540], Some(drive))];
    let model = RigModel::new(&rod, Rule::LastReversal, &warm).unwrap();
    let free = |model: &RigModel| -> Vec<&str> {
        let infos = model.parameters().iter();
        let free = infos.filter(|info| info.state == identify::ParameterState::Free);
        let names = free.map(|info| info.name);
        names.filter(|name| name.contains("start")).collect()
    };
    assert!(free(&model).is_empty());
    let open = model.with_open_starts(&warm);
    assert_eq!(
        free(&open),
        [
            "start_rise_k",
            "start_share",
            "antagonist_start_rise_k",
            "antagonist_start_share"
        ]
    );
}
