//! A rig that is another from run to run: how much heat it loses, how far it moves, and how warm it is around it.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::ops::ControlFlow;

use identify::{Fit, FitConfig, ForwardModel, Prior, WienerModel, fit};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Recording, RecordingParts};
use wiener::hysteresis::Rule;
use wiener::{Drive, Plant, Profile, Wiener, run};

use crate::common::{ROD, TRUE_TAU_S, rod, triangles, truth};

const NOISE_MM: f64 = 0.004;
const DT_S: f64 = 0.25;

/// A run of the true rod in a state: heat loss and stroke over the rig's, surroundings over those that are stated, K.
fn ran(name: &str, drive: Vec<f64>, state: [f64; 3]) -> Recording {
    recorded(name, drive, state, false)
}

/// Such a run, with the temperature of the rod if there is a thermometer on it.
fn recorded(
    name: &str,
    drive: Vec<f64>,
    [heat_loss, gain, level_k]: [f64; 3],
    with_thermometer: bool,
) -> Recording {
    let mut params = truth();
    params.heat.conductance_w_per_m_k *= 1.0 + heat_loss;
    params.gain *= 1.0 + gain;
    let ambient_degc = 21.0 + level_k;
    let model = Wiener::new(Drive::Current, Rule::LastReversal, &[params]).unwrap();
    let profile = Profile::uniform(&drive, DT_S, ambient_degc).unwrap();
    let mut noise = ChaCha8Rng::seed_from_u64(name.len() as u64);
    let (mut output, mut temperature_degc) = (Vec::new(), Vec::new());
    run(
        &model,
        &mut model.rest(ambient_degc),
        &profile,
        |_, shown| {
            let noise: f64 = StandardNormal.sample(&mut noise);
            output.push(shown.displacement[0] + NOISE_MM * noise);
            temperature_degc.push(shown.temperature_degc[0]);
        },
    );
    let temperature_degc = with_thermometer.then_some(temperature_degc);
    Recording::new(RecordingParts {
        name: name.to_owned(),
        time_s: Some((0..drive.len()).map(|k| DT_S * k as f64).collect()),
        drive,
        output_unit: "mm".to_owned(),
        output,
        temperature_degc,
        ..RecordingParts::default()
    })
    .unwrap()
}

fn fitted(training: &[Recording], prior: Prior) -> Fit {
    let model = WienerModel::new(&rod(ROD), Rule::LastReversal, training)
        .unwrap()
        .with_unknowns(training)
        .with_state_of_runs();
    let config = FitConfig {
        prior,
        ..FitConfig::default()
    };
    fit(&model, training, &config, &mut |_: &_| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

#[test]
fn the_state_of_each_run_is_found_beside_the_rig() {
    let states = [[0.0, 0.0, 0.0], [0.06, -0.012, 1.5], [-0.04, 0.015, -1.0]];
    let training: Vec<Recording> = states
        .into_iter()
        .zip(["a.csv", "bb.csv", "ccc.csv"])
        .map(|(state, name)| ran(name, triangles(900, 5.8), state))
        .collect();
    let n: usize = training.iter().map(Recording::len).sum();
    let found = fitted(&training, Prior::Profiled(n as f64));
    assert!(found.train_rmse < 1.1 * NOISE_MM, "{}", found.train_rmse);
    let tau_s = found.parameter("tau_s").unwrap().values[0];
    assert!((tau_s / TRUE_TAU_S - 1.0).abs() < 5e-3, "{tau_s}");
    let names = ["run_heat_loss", "run_gain", "ambient_level_k"];
    for (place, name) in names.into_iter().enumerate() {
        let parameter = found.parameter(name).unwrap();
        for (r, state) in states.iter().enumerate().skip(1) {
            let (value, own) = (parameter.values[r], parameter.intervals[r].unwrap());
            // Wide enough for one in a hundred, not for anything.
            let half = 0.5 * (own.upper - own.lower);
            assert!(
                (value - state[place]).abs() < 1.4 * half,
                "{name} {r}: {value} {own:?}"
            );
            let ordinary = parameter.info.ordinary.unwrap().deviation;
            assert!(half < 0.5 * ordinary, "{name} {r}: {own:?}");
        }
    }
}

#[test]
fn what_a_run_does_not_tell_stays_ordinary() {
    let driven = ran("a.csv", triangles(900, 5.8), [0.0; 3]);
    // Too little to reach the loop: nothing moves but the noise.
    let cold = ran("bb.csv", triangles(300, 1.0), [0.06, 0.01, 1.0]);
    let training = [driven, cold];
    let n: usize = training.iter().map(Recording::len).sum();
    let found = fitted(&training, Prior::Profiled(n as f64));
    for name in ["run_heat_loss", "run_gain"] {
        let parameter = found.parameter(name).unwrap();
        let ordinary = parameter.info.ordinary.unwrap().deviation;
        let own = parameter.intervals[1].unwrap();
        assert!(parameter.values[1].abs() < 0.2 * ordinary);
        // 95 % of what is ordinary.
        let half = 0.5 * (own.upper - own.lower);
        assert!(
            (half / (1.96 * ordinary) - 1.0).abs() < 0.1,
            "{name}: {own:?}"
        );
    }
}

#[test]
fn against_a_known_error_what_is_expected_pulls_by_as_much() {
    let states = [[0.0; 3], [0.06, 0.0, 0.0]];
    let training: Vec<Recording> = states
        .into_iter()
        .zip(["a.csv", "bb.csv"])
        .map(|(state, name)| ran(name, triangles(900, 5.8), state))
        .collect();
    let loss = |prior| {
        fitted(&training, prior)
            .parameter("run_heat_loss")
            .unwrap()
            .values[1]
    };
    let by_noise = loss(Prior::Variance(NOISE_MM * NOISE_MM));
    assert!((by_noise - 0.06).abs() < 0.006, "{by_noise}");
    // Errors a thousand times as large: nothing is known of the run.
    let by_nothing = loss(Prior::Variance(1e6 * NOISE_MM * NOISE_MM));
    assert!(by_nothing.abs() < 0.02, "{by_nothing}");
}

#[test]
fn a_state_that_is_stated_stays() {
    let training = [ran("a.csv", triangles(900, 5.8), [0.0; 3])];
    let text = format!("{ROD}[model]\nrun_gain = {{ fixed = 0.02 }}\n");
    let model = WienerModel::new(&rod(&text), Rule::LastReversal, &training)
        .unwrap()
        .with_state_of_runs();
    let state = |name: &str| {
        let mut infos = model.parameters().iter();
        infos.find(|info| info.name == name).unwrap().state
    };
    assert_eq!(state("run_gain"), identify::ParameterState::Fixed(0.02));
    assert_eq!(state("run_heat_loss"), identify::ParameterState::Free);
}

#[test]
fn surroundings_that_are_known_of_a_run_are_not_guessed() {
    // The second run in a room 4 K warmer: twice what is ordinary.
    let runs = [
        ran("a.csv", triangles(900, 5.8), [0.0; 3]),
        ran("bb.csv", triangles(900, 5.8), [0.0, 0.0, 4.0]),
    ];
    let open = |training: &[Recording]| {
        let model = WienerModel::new(&rod(ROD), Rule::LastReversal, training).unwrap();
        let model = model.with_unknowns(training);
        let infos = model.parameters().iter();
        let levels = infos.filter(|info| info.name == "ambient_level_k");
        let is_open = levels
            .map(|info| info.state == identify::ParameterState::Free)
            .collect::<Vec<_>>()
            == [true];
        let config = FitConfig::default();
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        (is_open, fit(&model, training, &config, go_on).unwrap())
    };
    let (is_open, guessed) = open(&runs);
    assert!(is_open);
    let level_k = guessed.parameter("ambient_level_k").unwrap().values[1];
    assert!((level_k - 4.0).abs() < 0.2, "{level_k}");
    let [first, second] = runs;
    let stated = [first, second.surrounded_by(25.0).unwrap()];
    let (is_open, known) = open(&stated);
    assert!(!is_open);
    assert!(known.train_rmse < 1.02 * guessed.train_rmse);
    assert_eq!(
        stated[1].surrounded_by(24.0).unwrap_err().to_string(),
        "bb.csv: ambient_degc = 24 °C is stated of it under [recordings], and it has a column of that; expected one of the two"
    );
}

#[test]
fn a_thermometer_on_the_rod_tells_how_warm_the_first_run_was() {
    let level_of_first = |with_thermometer: bool| {
        let training = [recorded(
            "a.csv",
            triangles(900, 5.8),
            [0.0, 0.0, 0.8],
            with_thermometer,
        )];
        let model = WienerModel::new(&rod(ROD), Rule::LastReversal, &training).unwrap();
        let model = model.with_unknowns(&training);
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let fit = fit(&model, &training, &FitConfig::default(), go_on).unwrap();
        let level = fit.parameter("ambient_level_k").unwrap();
        let center_degc = fit.parameter("loop_center_degc").unwrap().values[0];
        (level.values[0], center_degc, fit.temperature_rmse_k)
    };
    let true_center_degc = truth().limiting_loop.loop_center_degc;
    // Without one a loop that lies lower is the same.
    let (level_k, center_degc, _) = level_of_first(false);
    assert!(level_k.abs() <= 0.0 && (center_degc - true_center_degc + 0.8).abs() < 0.05);
    let (level_k, center_degc, rmse_k) = level_of_first(true);
    assert!((level_k - 0.8).abs() < 0.02, "{level_k}");
    assert!(
        (center_degc - true_center_degc).abs() < 0.05,
        "{center_degc}"
    );
    assert!(rmse_k.unwrap() < 0.02, "{rmse_k:?}");
}

#[test]
fn recorded_surroundings_tell_the_scale_of_temperature() {
    // Nothing is known of heat capacity and resistance: the rod warms by an assumed amount.
    let unknown = rod(
        "[columns]\ndrive = \"i\"\noutput = { name = \"y\", unit = \"mm\" }\n[drive]\nkind = \"current\"\n",
    );
    let [cold, warm] = [("a.csv", 0.0), ("bb.csv", 6.0)].map(|(name, level_k)| {
        let run = ran(name, triangles(900, 5.8), [0.0, 0.0, level_k]);
        run.surrounded_by(21.0 + level_k).unwrap()
    });
    let fitted = |told: bool, training: &[Recording]| {
        let model = WienerModel::new(&unknown, Rule::LastReversal, training).unwrap();
        let model = if told {
            model.with_scale_told_by(training)
        } else {
            model
        };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let fit = fit(&model, training, &FitConfig::default(), go_on).unwrap();
        (model.knows_temperature(), fit)
    };
    let training = [cold, warm];
    let (is_known, assumed) = fitted(false, &training);
    assert!(!is_known && assumed.train_rmse > 2.0 * NOISE_MM);
    let (is_known, told) = fitted(true, &training);
    assert!(
        is_known && told.train_rmse < 1.02 * NOISE_MM,
        "{}",
        told.train_rmse
    );
    let half_width_k = told.parameter("loop_half_width_k").unwrap();
    let expected_k = truth().limiting_loop.loop_half_width_k;
    assert!(
        (half_width_k.values[0] / expected_k - 1.0).abs() < 0.02,
        "{half_width_k:?}"
    );
    // Recordings of one temperature tell none.
    let model = WienerModel::new(&unknown, Rule::LastReversal, &training[..1]).unwrap();
    assert!(!model.with_scale_told_by(&training[..1]).knows_temperature());
}
