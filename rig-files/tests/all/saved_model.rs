//! A model that is written is the model that is read.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it reads its data"
)]

#[allow(dead_code, reason = "tests use different parts of what they share")]
use crate::common;

use std::ops::ControlFlow;

use common::{ROD, recording, rod, steps, triangles};
use identify::{
    Bounds, Fit, FitConfig, Identification, InputFile, ParameterInfo, Provenance, RigModel, Role,
    SavedModel, Scale, fit, predict, validate,
};
use recording::{ColumnSpec, DriveResolution, Recording};
use rig_files::{model_file, rod_file};
use wiener::hysteresis::Rule;

struct Saved {
    model: RigModel,
    training: Vec<Recording>,
    fit: Fit,
    saved: SavedModel,
}

fn fitted(model: &RigModel, training: &[Recording], config: &FitConfig) -> Fit {
    fit(model, training, config, &mut |_| ControlFlow::Continue(())).unwrap()
}

fn saved(text: &str) -> Saved {
    let training = vec![
        recording("a.csv", triangles(900, 4.2), 0.5),
        recording("b \"2\".csv", steps(500), -1.25),
    ];
    saved_of(text, training)
}

fn saved_of(text: &str, training: Vec<Recording>) -> Saved {
    let rod = rod(text);
    let unseen = [recording("c.csv", triangles(600, 3.9), 2.0)];
    let model = RigModel::new(&rod, Rule::Nested, &training).unwrap();
    let fit = fitted(&model, &training, &FitConfig::default());
    let validated = [validate(&model, &fit, &unseen[0]).unwrap()];
    let identification = Identification {
        rod: &rod,
        model: &model,
        effects: None,
        rule: Rule::Nested,
        fit: &fit,
        training: &training,
        unseen: &unseen,
        validated: &validated,
    };
    let provenance = Provenance {
        version: "0.1.0".to_owned(),
        command: "sma identify rod.toml --train a.csv \"b \\\"2\\\".csv\"".to_owned(),
        seed: 1,
        input: vec![InputFile {
            file: "rod.toml".to_owned(),
            sha256: "00ff".to_owned(),
        }],
    };
    let saved = SavedModel::of(&identification, provenance);
    Saved {
        model,
        training,
        fit,
        saved,
    }
}

#[test]
fn what_is_written_is_read_back() {
    let free = "[model]\nstart_rise_k = { bounds = [0.0, 20.0] }\nzeta = { fixed = 0.8 }\n";
    let static_heat = ROD.replace("specific_heat_j_per_kg_k = 500.0\n", "");
    let uses = "[recordings.\"a.csv\"]\nwindow_s = [0, 900]\nexclude_s = [[3, 4], [7.5, 8]]\n";
    for text in [
        ROD,
        &format!("{ROD}{free}"),
        &format!("{ROD}{uses}"),
        &static_heat,
    ] {
        let Saved {
            fit,
            saved,
            training,
            model,
        } = saved(text);
        let written = model_file::to_toml(&saved).unwrap();
        let read = model_file::parse("model.toml", &written).unwrap();
        assert_eq!(model_file::to_toml(&read).unwrap(), written);
        assert_eq!(read.rod.uses, saved.rod.uses);
        assert_eq!(read.rod.uses.is_empty(), !text.contains(uses));
        assert_eq!(read.parameters, fit.parameters);
        assert_eq!(&read.covariance, &fit.covariance);
        assert_eq!(read.rule, Rule::Nested);
        assert_eq!(read.model.knows_temperature(), model.knows_temperature());
        assert_eq!(&read.provenance, &saved.provenance);
        let of_reading: Vec<_> = read.recordings.iter().map(|one| one.role).collect();
        assert_eq!(of_reading, [Role::Train, Role::Train, Role::Validate]);
        for (r, recording) in training.iter().enumerate() {
            assert_eq!(
                predict(&read.model, &read.point(r), recording).unwrap(),
                predict(&model, &fit.point(r), recording).unwrap()
            );
        }
    }
}

#[test]
fn the_steps_of_a_supply_are_kept() {
    assert_eq!(
        saved(ROD).saved.drive_resolution(),
        DriveResolution::default()
    );
    // Of 50 mA, and nothing below 0.4 A.
    let supply = |drive: f64| {
        if drive < 0.4 {
            0.0
        } else {
            (20.0 * drive).round() / 20.0
        }
    };
    let ramps = |k: usize| 4.0 * (1.0 - ((k % 600) as f64 / 300.0 - 1.0).abs());
    let coarse = recording("a.csv", (0..1800).map(ramps).map(supply).collect(), 0.5);
    let Saved { saved, .. } = saved_of(ROD, vec![coarse]);
    let written = model_file::to_toml(&saved).unwrap();
    let mut read = model_file::parse("model.toml", &written).unwrap();
    let found = read.drive_resolution();
    assert_eq!(found, saved.drive_resolution());
    let [step, dead_zone] = [found.step.unwrap(), found.dead_zone.unwrap()];
    assert!(
        (step - 0.05).abs() < 1e-12 && (dead_zone - 0.4).abs() < 1e-12,
        "{found:?}"
    );
    // Counts say their step themselves.
    let mut pwm = ColumnSpec::name("pwm").in_unit("counts");
    pwm.full_scale = Some(255.0);
    read.rod.columns.drive = Some(pwm);
    assert_eq!(read.drive_resolution().step, Some(1.0 / 255.0));
}

#[test]
fn a_prediction_is_what_the_fit_met() {
    let Saved {
        model,
        training,
        fit,
        ..
    } = saved(ROD);
    for (r, recording) in training.iter().enumerate() {
        let prediction = predict(&model, &fit.point(r), recording).unwrap();
        let pairs = prediction.output.iter().zip(recording.output());
        let squares: f64 = pairs.map(|(a, b)| (a - b) * (a - b)).sum();
        let rmse = (squares / recording.len() as f64).sqrt();
        assert!((rmse - fit.recordings[r].rmse).abs() < 1e-9);
    }
}

#[test]
fn a_saved_model_is_a_start() {
    let Saved {
        model,
        training,
        fit,
        saved,
    } = saved(ROD);
    let from = saved.coordinates(&model, &training).unwrap();
    let config = FitConfig {
        swarm_iterations: 1,
        starts: 1,
        from: vec![from],
        ..FitConfig::default()
    };
    let again = fitted(&model, &training, &config);
    assert_eq!(again.starts, 2);
    assert!(again.train_rmse <= fit.train_rmse * (1.0 + 1e-6) + 1e-9);

    let other = rod_file::parse("rod.toml", "[surroundings]\nambient_degc = 21.0\n").unwrap();
    let other = RigModel::new(&other, Rule::Nested, &training).unwrap();
    let names = "tau_s, loop_center_degc, loop_half_width_k, loop_spread_k, zeta, gain, offset, start_rise_k, \
                 start_share, start_since_reversal_k, ambient_level_k, run_heat_loss, run_gain";
    assert_eq!(
        saved
            .coordinates(&other, &training)
            .unwrap_err()
            .to_string(),
        format!("rod.toml: a model of {names}; this rig has {names}, lambda_k_per_a2")
    );
    let wrong = FitConfig {
        from: vec![vec![0.0; 3]],
        ..FitConfig::default()
    };
    let refused = fit_error(&model, &training, &wrong);
    assert_eq!(refused, "a start of 3 coordinates; this problem has 5");
}

fn fit_error(model: &RigModel, training: &[Recording], config: &FitConfig) -> String {
    fit(model, training, config, &mut |_| ControlFlow::Continue(()))
        .unwrap_err()
        .to_string()
}

#[test]
fn what_a_model_file_may_not_say() {
    let written = model_file::to_toml(&saved(ROD).saved).unwrap();
    let said = |from: &str, to: &str| {
        assert!(written.contains(from), "{from}\n{written}");
        let text = written.replacen(from, to, 1);
        model_file::parse("model.toml", &text)
            .unwrap_err()
            .to_string()
    };
    let tau = {
        let start = written.find("value = ").unwrap();
        written[start..].lines().next().unwrap().to_owned()
    };
    let line_of = |what: &str| {
        let at = written.find(what).unwrap();
        written[..at].matches('\n').count() + 1
    };
    let parameter = line_of("[[parameter]]");
    for (from, to, expected) in [
        (
            "schema_version = 1",
            "schema_version = 2",
            "model.toml:4:18: schema_version = 2: must be 1".to_owned(),
        ),
        (
            "effects = []",
            "effects = [\"latent-heat\"]",
            format!(
                "model.toml:{}:12: effects: \"latent-heat\": must be empty: only baseline models are read here",
                line_of("effects")
            ),
        ),
        (
            tau.as_str(),
            "value = nan",
            format!(
                "model.toml:{parameter}:1: parameter tau_s = NaN: must lie from 1e-12 to 1e12 s"
            ),
        ),
        (
            "memory = \"nested\"",
            "memory = \"none\"",
            format!(
                "model.toml:{}:10: unknown variant `none`, expected `last-reversal` or `nested`",
                line_of("memory")
            ),
        ),
        (
            "diameter_mm = 1.0",
            "diameter_mm = -1.0",
            format!(
                "model.toml:{}:15: rod.diameter_mm = -1: must be finite and > 0",
                line_of("diameter_mm")
            ),
        ),
    ] {
        assert_eq!(said(from, to), expected);
    }
    let untrained = written.replace("role = \"train\"", "role = \"validate\"");
    let fault = model_file::parse("model.toml", &untrained).unwrap_err();
    assert_eq!(
        fault.to_string(),
        "model.toml: recording: none has role = \"train\"; expected the recordings that the model was fitted to, as --save-model writes them"
    );
    // These name a fitted value too.
    let unknown = said("name = \"zeta\"", "name = \"zetta\"");
    let known = ": no such parameter; this model has tau_s, loop_center_degc, loop_half_width_k, \
                 loop_spread_k, zeta, gain, offset, start_rise_k, start_share, start_since_reversal_k, ambient_level_k, run_heat_loss, run_gain";
    assert!(
        unknown.contains("parameter zetta = 0.") && unknown.ends_with(known),
        "{unknown}"
    );
    let twice = said("name = \"loop_spread_k\"", "name = \"loop_half_width_k\"");
    assert_eq!(
        twice,
        "model.toml:1:1: parameter loop_half_width_k: must be there once"
    );
    let shared = said(
        "name = \"tau_s\"",
        "name = \"tau_s\"\nrecording = \"a.csv\"",
    );
    assert!(
        shared.ends_with(": is shared: must not name a recording"),
        "{shared}"
    );
    let stranger = said("recording = \"a.csv\"", "recording = \"z.csv\"");
    assert!(
        stranger.ends_with(": must name its recording: a.csv or b \"2\".csv"),
        "{stranger}"
    );
    let none = model_file::parse("rod.toml", ROD).unwrap_err();
    assert_eq!(
        none.to_string(),
        "rod.toml: no schema_version; a model comes from --save-model of `sma identify` or `sma diagnose`"
    );
    let absent = model_file::read("absent.toml".as_ref()).unwrap_err();
    assert_eq!(absent.to_string(), "absent.toml: cannot be read");
}

#[test]
fn a_rod_that_its_text_does_not_say_is_not_written() {
    let mut saved = saved(ROD).saved;
    saved.rod.ambient_degc = Some(24.0);
    assert_eq!(
        model_file::to_toml(&saved).unwrap_err().to_string(),
        "model of rod.toml: its rod is not what the text of rod.toml says; expected a rod as it was read"
    );
}

#[test]
fn numbers_that_no_fit_has_are_refused() {
    let written = model_file::to_toml(&saved(ROD).saved).unwrap();
    let refused = |text: &str| {
        model_file::parse("model.toml", text)
            .unwrap_err()
            .to_string()
    };
    // The line of a parameter's entry that begins with a key, with another value.
    let with = |name: &str, key: &str, value: &str| {
        let entry = written.find(&format!("name = \"{name}\"")).unwrap();
        let start = entry + written[entry..].find(&format!("\n{key} = ")).unwrap() + 1;
        let end = start + written[start..].find('\n').unwrap();
        format!("{}{key} = {value}{}", &written[..start], &written[end..])
    };
    let cold = refused(&with("loop_center_degc", "value", "-5e9"));
    assert!(
        cold.ends_with("no temperature of a rod: must lie from -273.15 to 3000 °C"),
        "{cold}"
    );
    let far = refused(&with("loop_half_width_k", "value", "1e4"));
    assert!(far.ends_with("must lie within its bounds"), "{far}");
    let unit = refused(&with("gain", "unit", "\"furlong\""));
    assert!(
        unit.ends_with("unit must be \"mm\", that of the output"),
        "{unit}"
    );
    // The covariance: a variance below 0, one side of a pair, a correlation of more than 1.
    let start = written.find("matrix = [[").unwrap() + "matrix = [[".len();
    let end = start + written[start..].find(',').unwrap();
    let first: f64 = written[start..end].parse().unwrap();
    for other in [-first, 1e-9 * first, f64::NAN] {
        let text = format!("{}{other:?}{}", &written[..start], &written[end..]);
        let said = refused(&text.replace("NaN", "nan"));
        assert!(said.contains("positive semidefinite"), "{other}: {said}");
    }
    // A parameter that nothing fixes is no fault, nor a draw that is no number.
    let text = format!("{}inf{}", &written[..start], &written[end..]);
    let open = model_file::parse("model.toml", &text).unwrap();
    assert_eq!(model_file::to_toml(&open).unwrap(), text);
    let drawn = open.draws(8, 1).points;
    assert!(drawn.iter().flatten().all(|value| value.is_finite()));
    let second = end + 2;
    let behind = second + written[second..].find(',').unwrap();
    let text = format!("{}1.0e6{}", &written[..second], &written[behind..]);
    assert!(refused(&text).contains("must be symmetric"));
    for (from, to) in [
        ("train_rmse = ", "train_rmse = -"),
        ("largest_drive = ", "largest_drive = -"),
        ("sample_time_s = ", "sample_time_s = -"),
    ] {
        let said = refused(&written.replacen(from, to, 1));
        assert!(said.contains("expected a finite number >"), "{said}");
    }
}

#[test]
fn a_file_without_effects_is_that_of_a_plain_model() {
    let written = model_file::to_toml(&saved(ROD).saved).unwrap();
    assert!(written.starts_with("# A model identified by `sma identify`; `sma simulate` and"));
    assert!(written.contains("\neffects = []\n"), "{written}");
    assert!(!written.contains("newton_iterations"), "{written}");
    let older = written.replacen("effects = []\n", "", 1);
    let read = model_file::parse("model.toml", &older).unwrap();
    assert_eq!(read.effects, None);
    assert_eq!(model_file::to_toml(&read).unwrap(), written);
}

#[test]
fn draws_move_the_parameters_of_effects_within_their_bounds() {
    let written = model_file::to_toml(&noisy_saved()).unwrap();
    let text = written
        .replacen("effects = []", "effects = [\"tide\"]", 1)
        .replacen("substeps = 1", "substeps = 1\nnewton_iterations = 3", 1)
        // In the covariance it takes the place of ζ.
        .replacen("\"zeta\"]", "\"tide_mm\"]", 1)
        .replacen(
            "[covariance]",
            "[[parameter]]\nname = \"tide_mm\"\nvalue = 2.0\nunit = \"mm\"\nstate = \"free\"\n\
             bounds = [1.999, 2.001]\n\n[covariance]",
            1,
        );
    let tide = Bounds {
        lower: 0.0,
        upper: 5.0,
    };
    let known = ParameterInfo::searched("tide_mm", "mm", Scale::Linear, tide);
    let saved = model_file::parse_with("model.toml", &text, &|named| match named.id {
        "tide" => Ok(vec![known.clone()]),
        _ => Err("no tide".to_owned()),
    })
    .unwrap();
    assert_eq!(saved.effects.as_ref().unwrap().ids, ["tide"]);
    let drawn: Vec<f64> = saved
        .draws(200, 1)
        .points
        .iter()
        .map(|one| one[one.len() - 1])
        .collect();
    assert!(
        drawn.iter().all(|mm| (1.999..=2.001).contains(mm)),
        "{drawn:?}"
    );
    assert!(drawn.iter().any(|mm| (mm - 2.0).abs() > 1e-6), "{drawn:?}");
}

#[test]
fn draws_have_the_covariance_of_the_estimates() {
    let saved = noisy_saved();
    let draws = saved.draws(20_000, 3);
    assert_eq!(draws.left_out, Vec::<&str>::new());
    assert_eq!(draws, saved.draws(20_000, 3));
    assert_ne!(draws.points[0], saved.draws(1, 4).points[0]);
    let covariance = &saved.covariance;
    let n = draws.points.len() as f64;
    // On the scale of the search, from the estimate.
    let moved: Vec<Vec<f64>> = (0..5)
        .map(|k| {
            let estimate = saved.point(0)[k];
            let scale = covariance.scales[row(&saved, k)];
            let of = |point: &Vec<f64>| match scale {
                Scale::Linear => point[k] - estimate,
                Scale::Logarithmic => (point[k] / estimate).ln(),
            };
            draws.points.iter().map(of).collect()
        })
        .collect();
    for i in 0..5 {
        for j in 0..5 {
            let (a, b) = (row(&saved, i), row(&saved, j));
            let drawn: f64 = moved[i]
                .iter()
                .zip(&moved[j])
                .map(|(x, y)| x * y)
                .sum::<f64>()
                / n;
            let scale = (covariance.matrix[a][a] * covariance.matrix[b][b]).sqrt();
            assert!(
                ((drawn - covariance.matrix[a][b]) / scale).abs() < 0.03,
                "{i} {j}"
            );
        }
    }
}

/// Row of the covariance of a parameter of the model.
fn row(saved: &SavedModel, parameter: usize) -> usize {
    let name = &saved.parameters[parameter].info.name;
    let names = &saved.covariance.names;
    names.iter().position(|other| other == name).unwrap()
}

/// A model of a recording with noise, and so with a covariance.
fn noisy_saved() -> SavedModel {
    let rod = rod(ROD);
    let clean = recording("a.csv", triangles(1200, 5.5), 0.5);
    let noise = |k: usize| 0.01 * (1.7 * (k * k % 1013) as f64).sin();
    let output = clean.output().iter().enumerate();
    let output = output.map(|(k, y)| y + noise(k)).collect();
    let training = [common::with_output(&clean, "mm", output)];
    let model = RigModel::new(&rod, Rule::Nested, &training).unwrap();
    let fit = fitted(&model, &training, &FitConfig::default());
    let identification = Identification {
        rod: &rod,
        model: &model,
        effects: None,
        rule: Rule::Nested,
        fit: &fit,
        training: &training,
        unseen: &[],
        validated: &[],
    };
    let provenance = Provenance {
        version: String::new(),
        command: String::new(),
        seed: 1,
        input: Vec::new(),
    };
    SavedModel::of(&identification, provenance)
}
