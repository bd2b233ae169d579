//! Recordings whose output is the temperature: the heat balance alone.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

#[allow(dead_code, reason = "tests use different parts of what they share")]
use crate::common;

use std::ops::ControlFlow;

use common::rod;
use identify::{
    Fit, FitConfig, ForwardModel, Identification, IdentifyError, OffsetSource, ParameterState,
    Provenance, RigModel, Rod, SadeghiModel, SavedModel, fit, predict, validate,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use recording::{Quantity, Recording, RecordingParts, read_csv};
use rig_files::model_file;
use wiener::hysteresis::Rule;

const DT_S: f64 = 0.2;
const TAU_S: f64 = 3.0;
/// Steady rise at the largest drive, K.
const RISE_K: f64 = 90.0;
const AMBIENT_DEGC: f64 = 23.0;
const NOISE_K: f64 = 0.1;

/// A rod that is made up, and its sensor.
#[derive(Debug, Clone, Copy)]
struct Made {
    quantity: Quantity,
    ambient_degc: f64,
    start_rise_k: f64,
    lag_s: f64,
    noise_k: f64,
    seed: u64,
    /// Samples at rest before the first step.
    rest: usize,
}

const COLD: Made = Made {
    quantity: Quantity::Current,
    ambient_degc: AMBIENT_DEGC,
    start_rise_k: 0.0,
    lag_s: 0.0,
    noise_k: NOISE_K,
    seed: 0,
    rest: 40,
};

impl Made {
    /// Steps of different heights, the last one off: shares of the largest drive.
    fn drive(&self) -> Vec<f64> {
        let levels = [1.0, 0.0, 0.6, 0.9, 0.0];
        let steps = levels.iter().flat_map(|level| [*level; 60]);
        std::iter::repeat_n(0.0, self.rest).chain(steps).collect()
    }

    /// By another route than the model: both exponentials over parts of a sample, the sensor led by the middle of each.
    fn degc(&self) -> Vec<f64> {
        const PARTS: usize = 40;
        let h = DT_S / PARTS as f64;
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut rod = self.ambient_degc + self.start_rise_k;
        let mut sensor = rod;
        let drive = self.drive();
        drive
            .iter()
            .map(|&drive| {
                let shown = sensor + self.noise_k * noise();
                let power = match self.quantity {
                    Quantity::Current => drive * drive,
                    _ => drive,
                };
                let end = self.ambient_degc + RISE_K * power;
                for _ in 0..PARTS {
                    let middle = end + (rod - end) * (-0.5 * h / TAU_S).exp();
                    rod = end + (rod - end) * (-h / TAU_S).exp();
                    sensor = match self.lag_s > 0.0 {
                        true => middle + (sensor - middle) * (-h / self.lag_s).exp(),
                        false => rod,
                    };
                }
                shown
            })
            .collect()
    }

    fn recording(&self, name: &str) -> Recording {
        self.shown(name, "degC", |degc| degc)
    }

    fn shown(&self, name: &str, unit: &str, shown: impl Fn(f64) -> f64) -> Recording {
        let drive = self.drive();
        Recording::new(RecordingParts {
            name: name.to_owned(),
            time_s: Some((0..drive.len()).map(|k| DT_S * k as f64).collect()),
            drive_quantity: self.quantity,
            drive,
            output_unit: unit.to_owned(),
            output: self.degc().into_iter().map(shown).collect(),
            ..RecordingParts::default()
        })
        .unwrap()
    }
}

/// As `sma identify` goes about it: without a lag, and with one where it shows.
fn identified(rod: &Rod, training: &[Recording], unseen: &[Recording]) -> (RigModel, Fit) {
    let config = FitConfig {
        starts: 2,
        ..FitConfig::default()
    };
    let model = RigModel::new(rod, Rule::LastReversal, training)
        .unwrap()
        .seeing(unseen);
    assert!(matches!(model, RigModel::Thermal(_)));
    let mut go_on = |_: &_| ControlFlow::Continue(());
    let without = fit(&model, training, &config, &mut go_on).unwrap();
    let Some((lagging, from)) = model.with_lag(&without) else {
        return (model, without);
    };
    let config = FitConfig {
        from,
        starts: 0,
        ..config
    };
    let with = fit(&lagging, training, &config, &mut go_on).unwrap();
    if lagging.lag_shows(&without, &with) {
        (lagging, with)
    } else {
        (model, without)
    }
}

fn holds(fit: &Fit, name: &str, truth: f64) -> bool {
    let interval = fit.parameter(name).unwrap().intervals[0];
    interval.is_some_and(|one| (one.lower..=one.upper).contains(&truth))
}

fn is_free(fit: &Fit, name: &str) -> bool {
    fit.parameter(name).unwrap().info.state == ParameterState::Free
}

const STATED: &str = "surroundings.ambient_degc = 23.0\n";

#[test]
fn intervals_hold_the_truth_and_no_lag_is_made_up() {
    let held: Vec<[bool; 4]> = (0..24)
        .into_par_iter()
        .map(|seed| {
            let training = [Made { seed, ..COLD }.recording("a.csv")];
            let (_, fit) = identified(&rod(""), &training, &[]);
            assert!(fit.converged() && !is_free(&fit, "start_rise_k"));
            [
                holds(&fit, "tau_s", TAU_S),
                holds(&fit, "lambda_k_per_a2", RISE_K),
                holds(&fit, "ambient_degc", AMBIENT_DEGC),
                !is_free(&fit, "thermocouple_lag_s"),
            ]
        })
        .collect();
    for k in 0..4 {
        let count = held.iter().filter(|one| one[k]).count();
        // 23 of 24 are to be expected; three standard deviations below.
        assert!(count >= 20, "{k}: {count}");
    }
}

#[test]
fn a_duty_needs_no_supply() {
    let made = Made {
        quantity: Quantity::Duty,
        ..COLD
    };
    let rig = rod(&format!("drive.kind = \"duty\"\n{STATED}"));
    let (_, fit) = identified(&rig, &[made.recording("a.csv")], &[]);
    assert!(
        holds(&fit, "rise_k_per_duty", RISE_K),
        "{:?}",
        fit.parameters
    );
    assert!(holds(&fit, "tau_s", TAU_S));
    assert!(!is_free(&fit, "ambient_degc"));
    // Of the loop there is nothing.
    assert!(fit.parameter("loop_center_degc").is_none() && fit.parameter("gain").is_none());
}

#[test]
fn a_warm_start_is_found() {
    let warm = Made {
        start_rise_k: 30.0,
        ..COLD
    };
    for text in ["", STATED] {
        let training = [COLD.recording("a.csv"), warm.recording("b.csv")];
        let (_, fit) = identified(&rod(text), &training, &[]);
        let start = fit.parameter("start_rise_k").unwrap();
        assert!((start.values[1] - 30.0).abs() < 0.2, "{start:?}");
        let interval = start.intervals[1].unwrap();
        assert!((interval.lower..=interval.upper).contains(&30.0));
        assert!(start.values[0].abs() < 0.2, "{start:?}");
        assert!((fit.parameter("tau_s").unwrap().values[0] - TAU_S).abs() < 0.02);
    }
}

#[test]
fn surroundings_that_are_not_as_stated_are_seen_at_rest() {
    let (_, fit) = identified(
        &rod("surroundings.ambient_degc = 20.0\n"),
        &[COLD.recording("a.csv")],
        &[],
    );
    assert!(holds(&fit, "ambient_level_k", 3.0), "{:?}", fit.parameters);
    assert!(holds(&fit, "tau_s", TAU_S));
}

#[test]
fn a_recorded_ambient_is_followed() {
    let clean = Made {
        noise_k: 0.0,
        ..COLD
    }
    .recording("a.csv");
    let n = clean.len();
    // Slowly enough for the rod to follow, late by its time constant.
    let slope_k = |k: usize| 0.01 * k as f64;
    let late_k = |k: usize| 0.01 / DT_S * TAU_S * (1.0 - (-(k as f64) * DT_S / TAU_S).exp());
    let training = [Recording::new(RecordingParts {
        name: "a.csv".to_owned(),
        time_s: Some(clean.time_s().to_vec()),
        drive: clean.drive().to_vec(),
        output_unit: "degC".to_owned(),
        output: (0..n)
            .map(|k| clean.output()[k] + slope_k(k) - late_k(k))
            .collect(),
        ambient_degc: Some((0..n).map(|k| AMBIENT_DEGC + slope_k(k)).collect()),
        ..RecordingParts::default()
    })
    .unwrap()];
    let (_, fit) = identified(&rod(""), &training, &[]);
    assert!((fit.parameter("tau_s").unwrap().values[0] - TAU_S).abs() < 0.01);
    // What the column holds for a sample is half a sample old on average.
    assert!(fit.train_rmse < 0.01, "{}", fit.train_rmse);
    let mixed = [training[0].clone(), COLD.recording("b.csv")];
    let error = RigModel::new(&rod(""), Rule::LastReversal, &mixed).unwrap_err();
    assert_eq!(
        error.to_string(),
        "rod.toml: surroundings.ambient_degc is missing: some recordings have a column for it, others do not"
    );
}

#[test]
fn a_sensor_that_lags_shows() {
    let held: Vec<[bool; 3]> = (0..12)
        .into_par_iter()
        .map(|seed| {
            let made = Made {
                lag_s: 0.5,
                seed,
                ..COLD
            };
            let (model, fit) = identified(&rod(STATED), &[made.recording("a.csv")], &[]);
            let RigModel::Thermal(thermal) = model else {
                panic!("no heat balance");
            };
            [
                thermal.has_lag(),
                holds(&fit, "thermocouple_lag_s", 0.5),
                holds(&fit, "tau_s", TAU_S),
            ]
        })
        .collect();
    assert!(held.iter().all(|one| one[0]));
    for k in 1..3 {
        let count = held.iter().filter(|one| one[k]).count();
        assert!(count >= 9, "{k}: {count}");
    }
}

/// A rod whose heat capacity and resistance give that rise at 1 A with that time constant: λ = R τ/C.
fn known() -> Rod {
    let section_m2 = std::f64::consts::PI * 1e-6 / 4.0;
    let capacity_j_per_m_k = 6450.0 * section_m2 * 500.0;
    let resistance_ohm_per_m = RISE_K * capacity_j_per_m_k / TAU_S;
    rod(&format!(
        "{STATED}[rod]\ndiameter_mm = 1.0\ndensity_kg_per_m3 = 6450.0\nspecific_heat_j_per_kg_k = 500.0\n\
         resistance_ohm_per_m = {resistance_ohm_per_m}\n"
    ))
}

#[test]
fn heat_capacity_and_resistance_leave_the_time_constant_alone() {
    let (_, fit) = identified(&known(), &[COLD.recording("a.csv")], &[]);
    assert!(fit.parameter("lambda_k_per_a2").is_none());
    assert!(holds(&fit, "tau_s", TAU_S), "{:?}", fit.parameters);
    // They also tell the rod from a slower sensor.
    let slow = Made { lag_s: 8.0, ..COLD };
    let (model, fit) = identified(&known(), &[slow.recording("a.csv")], &[]);
    assert!(matches!(&model, RigModel::Thermal(one) if one.has_lag() && one.tells_which_lags()));
    assert!(holds(&fit, "tau_s", TAU_S), "{:?}", fit.parameters);
    assert!(holds(&fit, "thermocouple_lag_s", 8.0));
}

#[test]
fn units_do_not_change_the_rod() {
    let found = [
        COLD.recording("a.csv"),
        COLD.shown("a.csv", "K", |degc| degc + 273.15),
        COLD.shown("a.csv", "°F", |degc| 1.8 * degc + 32.0),
    ]
    .map(|recording| identified(&rod(""), &[recording], &[]).1);
    for name in ["tau_s", "lambda_k_per_a2", "ambient_degc"] {
        let [degc, kelvin, degf] =
            [0, 1, 2].map(|k: usize| found[k].parameter(name).unwrap().values[0]);
        assert!(
            (kelvin / degc - 1.0).abs() < 1e-6,
            "{name}: {degc} {kelvin}"
        );
        assert!((degf / degc - 1.0).abs() < 1e-6, "{name}: {degc} {degf}");
    }
    assert!((found[2].train_rmse / found[0].train_rmse - 1.8).abs() < 1e-6);
}

#[test]
fn unseen_recordings_have_their_own_start_and_surroundings() {
    let unseen = [Made {
        start_rise_k: 30.0,
        ambient_degc: 26.0,
        seed: 5,
        ..COLD
    }
    .recording("c.csv")];
    let (model, fit) = identified(&rod(""), &[COLD.recording("a.csv")], &unseen);
    let validated = validate(&model, &fit, &unseen[0]).unwrap();
    assert!(validated.rmse < 1.1 * NOISE_K, "{}", validated.rmse);
    // Rest alone would not tell how warm the room is that the rod cools to.
    assert_eq!(
        validated.offset_source,
        OffsetSource::WholeRecording { at_rest: 41 }
    );
    let cold = Made { seed: 6, ..COLD }.recording("d.csv");
    let (model, fit) = identified(&rod(""), &[COLD.recording("a.csv")], &[]);
    let validated = validate(&model, &fit, &cold).unwrap();
    assert_eq!(
        validated.offset_source,
        OffsetSource::BeforeDrive { n_samples: 41 }
    );
    assert!(validated.rmse < 1.1 * NOISE_K, "{}", validated.rmse);
}

fn saved(rod: &Rod, made: Made) -> (SavedModel, Recording, Fit) {
    let training = [made.recording("a.csv")];
    let (model, fit) = identified(rod, &training, &[]);
    let identification = Identification {
        rod,
        model: &model,
        effects: None,
        rule: Rule::LastReversal,
        fit: &fit,
        training: &training,
        unseen: &[],
        validated: &[],
    };
    let provenance = Provenance {
        version: "0.1.0".to_owned(),
        command: "sma identify rod.toml --train a.csv".to_owned(),
        seed: 1,
        input: Vec::new(),
    };
    let saved = SavedModel::of(&identification, provenance);
    let [recording] = training;
    (saved, recording, fit)
}

#[test]
fn what_is_written_is_read_back_and_predicts_as_it_was_fitted() {
    let lagging = Made { lag_s: 0.5, ..COLD };
    for (rod, made) in [(rod(""), COLD), (rod(STATED), lagging), (known(), COLD)] {
        let (saved, recording, fit) = saved(&rod, made);
        let written = model_file::to_toml(&saved).unwrap();
        assert!(written.contains("model = \"thermal\""));
        let read = model_file::parse("model.toml", &written).unwrap();
        assert_eq!(model_file::to_toml(&read).unwrap(), written);
        assert!(read.wiener_params().is_none() && read.model.knows_temperature());
        let prediction = predict(&read.model, &read.point(0), &recording).unwrap();
        let squares = prediction.output.iter().zip(recording.output());
        let squares: f64 = squares.map(|(a, b)| (a - b) * (a - b)).sum();
        let rmse = (squares / recording.len() as f64).sqrt();
        assert!((rmse - fit.train_rmse).abs() < 1e-9, "{rmse}");
    }
}

#[test]
fn what_is_no_heat_balance_is_refused() {
    let (saved, recording, _) = saved(&rod(""), COLD);
    let written = model_file::to_toml(&saved).unwrap();
    let other = written.replace("output_unit = \"degC\"", "output_unit = \"mm\"");
    assert_eq!(
        model_file::parse("model.toml", &other)
            .unwrap_err()
            .to_string(),
        "model.toml: output in mm: a thermal model needs a temperature, in degC, K or degF"
    );
    let tau = "name = \"tau_s\"\nvalue = ";
    let (before, after) = written.split_once(tau).unwrap();
    let (_, after) = after.split_once('\n').unwrap();
    let error = model_file::parse("model.toml", &format!("{before}{tau}nan\n{after}"));
    let error = error.unwrap_err().to_string();
    assert!(error.contains("tau_s = NaN: must lie from"), "{error}");
    for k in [0, 5] {
        let mut point = saved.point(0);
        point[k] = f64::NAN;
        let error = predict(&saved.model, &point, &recording).unwrap_err();
        assert!(matches!(error, IdentifyError::Simulation(_)), "{error:?}");
    }
    let rig = common::rod(common::ROD);
    let error = SadeghiModel::new(&rig, Rule::LastReversal, &[recording]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a.csv: the output is the temperature: it shows the heat balance and no loop; use `sma identify` without a preset"
    );
}

#[test]
fn the_rod_file_has_a_say() {
    let training = [COLD.recording("a.csv")];
    let of = |text: &str| RigModel::new(&rod(text), Rule::LastReversal, &training);
    let error = of("[model]\nloop_center_degc = { fixed = 70.0 }\n").unwrap_err();
    assert_eq!(
        error.to_string(),
        "rod.toml:2:1: [model] loop_center_degc: no such parameter; this rig has tau_s, ambient_degc, ambient_level_k, \
         start_rise_k, thermocouple_lag_s, lambda_k_per_a2"
    );
    let model = of("[model]\nthermocouple_lag_s = { fixed = 0.4 }\n").unwrap();
    let lag = model
        .parameters()
        .iter()
        .find(|one| one.name == "thermocouple_lag_s");
    assert_eq!(lag.unwrap().state, ParameterState::Fixed(0.4));
}

#[test]
fn a_fabric_that_a_computer_polls() {
    let Some(path) = fixtures::shared::path("recordings/dongsus/0331-test1.csv") else {
        return;
    };
    let rig = rod(
        "drive.kind = \"duty\"\n[columns]\ntime = \"Time(sec)\"\ndrive = \"PWM(%)\"\noutput = \"Temperature(C)\"\n",
    );
    let training = [read_csv(&path, &rig.read_options()).unwrap()];
    let (_, fit) = identified(&rig, &training, &[]);
    assert!(fit.converged());
    assert!(
        fit.parameters.iter().all(|one| !one.at_bound),
        "{:?}",
        fit.parameters
    );
    // Steps of a quarter of a kelvin; half of one is met.
    assert!(fit.train_rmse < 0.15, "{}", fit.train_rmse);
    // Cold at 28.75 °C for half a minute.
    let ambient = fit.parameter("ambient_degc").unwrap();
    assert!((ambient.values[0] - 28.75).abs() < 0.1, "{ambient:?}");
}
