//! Models with effects that are written, read and run again.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it makes its data"
)]

use crate::common;

use std::ops::ControlFlow;

use common::{params, played, recording, setting};
use fixtures::wire::{AMBIENT_DEGC, ROD};
use identify::{
    Fit, FitConfig, ForwardModel, Identification, LeastSquaresConfig, ParameterVector, Provenance,
    RigModel, Rod, SavedModel, WienerModel, fit, predict, validate_at,
};
use missing_physics::{
    Candidate, ExtendedModel, ExtendedStage, LoopFamily, RestoredModel, Stage, known_effects,
    saved_effects, setting_of_rod,
};
use recording::Recording;
use rig_files::{model_file, rod_file};
use sma_effects::{EffectId, EffectSet, EffectValues, Extended, Hypothesis, Setting};
use wiener::hysteresis::Rule;
use wiener::{Start, WienerParams};

const DT_S: f64 = 0.3;

fn truth() -> WienerParams {
    WienerParams {
        offset: 1.0,
        ..params()
    }
}

/// A wire with latent heat and an expansion under some rest and triangles of current, with a wiggle for noise.
fn recorded(name: &str, heights_a: [f64; 3]) -> Recording {
    let mut current_a = vec![0.0; 30];
    for height_a in heights_a {
        let share = |k: i32| 1.0 - (f64::from(k) / 100.0 - 1.0).abs();
        current_a.extend((0..200).map(|k| height_a * share(k)));
    }
    let mut effects = EffectValues::typical(EffectId::LatentHeat, 1.0);
    effects.thermal_expansion.expansion_per_k = 1e-5;
    let fleet = Extended {
        setting: Setting {
            active: EffectSet::of(EffectId::LatentHeat).with(EffectId::ThermalExpansion),
            ..setting()
        },
    };
    let mut output = played(&fleet, truth(), effects, &current_a, DT_S);
    for (k, y) in output.iter_mut().enumerate() {
        *y += 0.01 * (2.1 * (k * k % 1009) as f64).sin();
    }
    recording(name, current_a, output, DT_S)
}

/// A model fitted from the truth, where it has such a parameter.
fn fitted(model: &dyn ForwardModel, training: &[Recording], iterations: usize) -> Fit {
    let infos = model.parameters();
    let vector = ParameterVector::new(infos, training.len());
    let from = vector.coordinates(|parameter, _| match infos[parameter].name {
        "tau_s" => Some(9.7),
        "loop_center_degc" => Some(55.0),
        "loop_half_width_k" => Some(8.0),
        "loop_spread_k" => Some(3.0),
        "zeta" => Some(0.85),
        "gain" => Some(5.0),
        "latent_heat_j_per_kg" => Some(12e3),
        "expansion_per_k" => Some(1e-5),
        _ => Some(0.0),
    });
    let config = FitConfig {
        starts: 0,
        from: vec![from],
        least_squares: LeastSquaresConfig {
            iterations,
            ..LeastSquaresConfig::default()
        },
        ..FitConfig::default()
    };
    fit(model, training, &config, &mut |_| ControlFlow::Continue(())).unwrap()
}

struct Made {
    rod: Rod,
    base: WienerModel,
    training: Vec<Recording>,
    unseen: Vec<Recording>,
    stage: ExtendedStage,
}

/// The model with these effects, fitted to two recordings and checked on a third.
fn made(effects: &[EffectId], iterations: usize) -> Made {
    made_of(LoopFamily::Proximity, effects, iterations)
}

fn made_of(loop_family: LoopFamily, effects: &[EffectId], iterations: usize) -> Made {
    let rod = rod_file::parse("rod.toml", ROD).unwrap();
    let training = vec![
        recorded("a.csv", [2.4, 2.0, 2.3]),
        recorded("b.csv", [2.2, 2.4, 1.9]),
    ];
    let unseen = vec![recorded("c.csv", [2.3, 1.9, 2.1])];
    let base = WienerModel::new(&rod, Rule::Nested, &training).unwrap();
    let plain = fitted(&base, &training, iterations);
    let active: EffectSet = effects.iter().copied().collect();
    let setting = Setting {
        loop_family,
        ..setting_of_rod(&rod, "mm")
    };
    let model = ExtendedModel::new(&base, &plain, setting, active);
    let fit = fitted(&model, &training, iterations);
    let validated = unseen
        .iter()
        .map(|one| validate_at(&model, &fit.point(0), one).unwrap())
        .collect();
    Made {
        stage: ExtendedStage {
            effects: active.iter().map(Candidate::from).collect(),
            model,
            stage: Stage {
                fit,
                validated,
                predicted_rmse: None,
            },
        },
        rod,
        base,
        training,
        unseen,
    }
}

impl Made {
    fn saved(&self) -> SavedModel {
        let setting = Setting {
            newton_iterations: 4,
            ..Setting::default()
        };
        let identification = Identification {
            rod: &self.rod,
            model: &RigModel::Wiener(self.base.clone()),
            effects: Some(saved_effects(&self.stage, &setting).unwrap()),
            rule: Rule::Nested,
            fit: &self.stage.stage.fit,
            training: &self.training,
            unseen: &self.unseen,
            validated: &self.stage.stage.validated,
        };
        let provenance = Provenance {
            version: "0.1.0".to_owned(),
            command: "sma diagnose".to_owned(),
            seed: 1,
            input: Vec::new(),
        };
        SavedModel::of(&identification, provenance)
    }
}

const FOUND: [EffectId; 2] = [EffectId::LatentHeat, EffectId::ThermalExpansion];

#[test]
fn what_is_written_is_read_back() {
    let made = made(&FOUND, 20);
    let written = model_file::to_toml(&made.saved()).unwrap();
    assert!(
        written.contains("\neffects = [\"latent-heat\", \"thermal-expansion\"]\n"),
        "{written}"
    );
    let read = model_file::parse_with("model.toml", &written, &known_effects).unwrap();
    assert_eq!(model_file::to_toml(&read).unwrap(), written);
    let fit = &made.stage.stage.fit;
    assert_eq!(read.parameters, fit.parameters);
    assert_eq!(read.covariance, fit.covariance);
    assert_eq!(read.effects.as_ref().unwrap().newton_iterations, 4);
    let latent = &read.parameters[read.model.parameters().len()];
    assert_eq!(latent.info.name, "latent_heat_j_per_kg");
    assert!(latent.intervals[0].is_some());
    let restored = RestoredModel::new(&read).unwrap();
    assert_eq!(restored.fleet().setting.newton_iterations, 4);
}

#[test]
fn a_model_that_is_read_does_what_the_fitted_one_did() {
    let made = made(&FOUND, 20);
    let Stage { fit, validated, .. } = &made.stage.stage;
    // That of the fit, so that bits can be compared.
    let text = model_file::to_toml(&made.saved()).unwrap();
    let text = text.replace("newton_iterations = 4", "newton_iterations = 3");
    let saved = model_file::parse_with("model.toml", &text, &known_effects).unwrap();
    let restored = RestoredModel::new(&saved).unwrap();
    for (r, recording) in made.training.iter().enumerate() {
        let predicted = predict(&restored, &saved.point(r), recording).unwrap();
        let by_fit = predict(&made.stage.model, &fit.point(r), recording).unwrap();
        assert_eq!(predicted, by_fit);
        let pairs = predicted.output.iter().zip(recording.output());
        let squares: f64 = pairs.map(|(a, b)| (a - b) * (a - b)).sum();
        let rmse = (squares / recording.len() as f64).sqrt();
        assert!((rmse - fit.recordings[r].rmse).abs() < 1e-9, "{rmse}");
        // The baseline part alone is another model.
        let plain = predict(&saved.model, &saved.point(r), recording).unwrap();
        assert!((plain.output[100] - predicted.output[100]).abs() > 1e-3);
    }
    let unseen = saved
        .validate_by(&restored, &restored.point(), &made.unseen[0])
        .unwrap();
    assert_eq!(unseen.rmse.to_bits(), validated[0].rmse.to_bits());
}

#[test]
fn a_loop_of_another_family_is_kept() {
    for effects in [&[EffectId::LatentHeat][..], &[]] {
        let made = made_of(LoopFamily::Relays, effects, 5);
        let text = model_file::to_toml(&made.saved()).unwrap();
        assert!(text.contains("\nloop_family = \"relays\"\n"), "{text}");
        let text = text.replace("newton_iterations = 4", "newton_iterations = 3");
        let saved = model_file::parse_with("model.toml", &text, &known_effects).unwrap();
        assert_eq!(model_file::to_toml(&saved).unwrap(), text);
        let names = saved.effects.as_ref().unwrap().names().len();
        assert_eq!(names, 1 + effects.len());
        let restored = RestoredModel::new(&saved).unwrap();
        let recording = &made.training[0];
        let predicted = predict(&restored, &saved.point(0), recording).unwrap();
        let fit = &made.stage.stage.fit;
        let by_fit = predict(&made.stage.model, &fit.point(0), recording).unwrap();
        assert_eq!(predicted, by_fit);
        // Who reads baseline models alone says so; and no family is guessed.
        let refused = model_file::parse("model.toml", &text.replace("\"latent-heat\"", ""));
        assert!(refused.is_err());
        let unknown = text.replace("\"relays\"", "\"duhem\"");
        let refused = model_file::parse_with("model.toml", &unknown, &known_effects)
            .unwrap_err()
            .to_string();
        assert!(
            refused.contains("loop_family = \"duhem\"") && refused.contains("cosine-kinetics"),
            "{refused}"
        );
    }
}

#[test]
fn drifts_stay_with_their_recordings() {
    let drifts = [EffectId::AmbientDrift, EffectId::SensorDrift];
    let mut made = made(&[EffectId::LatentHeat, drifts[0], drifts[1]], 0);
    for parameter in &mut made.stage.stage.fit.parameters {
        let name = parameter.info.name;
        let knot = name
            .strip_prefix("ambient_drift_")
            .and_then(|rest| rest.strip_suffix("_k"));
        if let Some(knot) = knot {
            parameter.values[0] = 0.5 * knot.parse::<f64>().unwrap();
        } else if name == "sensor_drift_2" {
            parameter.values[0] = 0.1;
        }
    }
    let text = model_file::to_toml(&made.saved()).unwrap();
    let saved = model_file::parse_with("model.toml", &text, &known_effects).unwrap();
    assert_eq!(model_file::to_toml(&saved).unwrap(), text);
    let restored = RestoredModel::new(&saved).unwrap();
    assert_eq!(restored.drifts().collect::<Vec<_>>(), drifts);
    let member = restored
        .member(&restored.point(), Start::rest(AMBIENT_DEGC))
        .unwrap();
    // A line from 0 to 4 K is 2 K in the mean: as a loop that lies 2 K lower.
    let center_degc = saved
        .wiener_params()
        .unwrap()
        .limiting_loop
        .loop_center_degc
        - 2.0;
    let shifted_degc = member.params.limiting_loop.loop_center_degc;
    assert!((shifted_degc - center_degc).abs() < 1e-12, "{shifted_degc}");
    let mut effects = EffectValues::default();
    effects.latent_heat = member.effects.latent_heat;
    assert_eq!(member.effects, effects);
    // Taken out twice is taken out once.
    let again = restored.member(&saved.point(0), member.start);
    assert_eq!(again, Some(member));
    let fleet = Extended {
        setting: Setting {
            active: EffectSet::of(EffectId::LatentHeat),
            ..restored.fleet().setting
        },
    };
    let recording = &made.unseen[0];
    let expected = played(&fleet, member.params, effects, recording.drive(), DT_S);
    let predicted = predict(&restored, &restored.point(), recording).unwrap();
    for (predicted, expected) in predicted.output.iter().zip(expected) {
        assert!((predicted - expected).abs() < 1e-9);
    }
    // Another recording, be it without a rest, tells its offset and its start, and no drift.
    let driven = recording
        .slice(recording.len() / 4..recording.len())
        .unwrap();
    let validated = saved
        .validate_by(&restored, &restored.point(), &driven)
        .unwrap();
    for (info, value) in restored.parameters().iter().zip(&validated.point) {
        assert!(!info.name.contains("drift") || *value == 0.0, "{info:?}");
    }
    assert!(validated.rmse < 0.1 * validated.output_range);
}

#[test]
fn a_hypothesis_of_one_s_own_has_no_place_in_a_file() {
    let text = "[[hypothesis]]\nid = \"own-shift\"\nshift_k = \"a * xi\"\n[hypothesis.parameters.a]\n\
                unit = \"1\"\ntypical = 1\nbounds = [-10, 10]\n";
    let own = Hypothesis::parse("own.toml", text).unwrap();
    let mut stage = made(&FOUND, 0).stage;
    stage.effects.push(Candidate::Own(0, own));
    let refused = saved_effects(&stage, &Setting::default()).unwrap_err();
    let known = EffectId::ALL.map(EffectId::id).join(" ");
    assert_eq!(
        refused.to_string(),
        format!("effect 'own-shift': unknown; known are {known}")
    );
}

#[test]
fn effects_that_cannot_be_are_named_with_their_place() {
    let written = model_file::to_toml(&made(&FOUND, 0).saved()).unwrap();
    let said = |from: &str, to: &str| {
        assert!(written.contains(from), "{from}\n{written}");
        let text = written.replacen(from, to, 1);
        match model_file::parse_with("model.toml", &text, &known_effects) {
            Ok(saved) => {
                let mut error: &dyn std::error::Error = &RestoredModel::new(&saved).unwrap_err();
                let mut said = error.to_string();
                while let Some(source) = error.source() {
                    said += &format!(": {source}");
                    error = source;
                }
                said
            }
            Err(error) => error.to_string(),
        }
    };
    let line_of = |what: &str| {
        let at = written.find(what).unwrap();
        written[..at].matches('\n').count() + 1
    };
    let entry = |name: &str| {
        let at = written.find(&format!("name = \"{name}\"")).unwrap();
        let start = written[..at].rfind("[[parameter]]").unwrap();
        let end = start + written[start..].find("\n\n").unwrap();
        &written[start..end]
    };
    let effects = line_of("effects = ");
    let latent = entry("latent_heat_j_per_kg");
    let latent_line = line_of(latent);
    let value = latent
        .lines()
        .find(|line| line.starts_with("value"))
        .unwrap();
    let of_latent = |to: &str| latent.replace(value, to);
    let known = EffectId::ALL.map(EffectId::id).join(" ");
    let with_other_value = |to: &str| said(latent, &of_latent(&format!("value = {to}")));
    assert_eq!(
        said("\"thermal-expansion\"]", "\"thermal-expanse\"]"),
        format!(
            "model.toml:{effects}:27: effects: \"thermal-expanse\": no such effect; known are {known}"
        )
    );
    assert_eq!(
        said("\"thermal-expansion\"]", "\"latent-heat\"]"),
        format!("model.toml:{effects}:27: effects: \"latent-heat\": must be there once")
    );
    assert_eq!(
        said("density_kg_per_m3 = 6450.0\n", ""),
        format!(
            "model.toml:{}:12: effects: \"latent-heat\": needs diameter_mm and density_kg_per_m3 in [rod]",
            effects
        )
    );
    let expansion = entry("expansion_per_k");
    let value_of_expansion: f64 = expansion
        .lines()
        .find_map(|line| line.strip_prefix("value = ")?.parse().ok())
        .unwrap();
    assert_eq!(
        said("lever = 1.0", ""),
        format!(
            "model.toml:{}:1: parameter expansion_per_k = {value_of_expansion}: unit must be \"1/K at a strain of 4 %\"",
            line_of(expansion)
        )
    );
    assert_eq!(
        said("model = \"wiener\"", "model = \"sadeghi\""),
        format!(
            "model.toml:{effects}:12: effects: \"latent-heat\": only a model = \"wiener\" may have effects"
        )
    );
    assert_eq!(
        said("newton_iterations = 4\n", ""),
        format!(
            "model.toml:{}:1: integration: must have newton_iterations, since the model has effects",
            line_of("[integration]")
        )
    );
    assert_eq!(
        said("newton_iterations = 4", "newton_iterations = 400"),
        "model: newton_iterations = 400: must be in 1..=50"
    );
    // Parameters.
    assert_eq!(
        with_other_value("90000.0"),
        format!(
            "model.toml:{latent_line}:1: parameter latent_heat_j_per_kg = 90000: must lie from 0e0 to 6e4 J/kg"
        )
    );
    assert_eq!(
        with_other_value("nan"),
        format!(
            "model.toml:{latent_line}:1: parameter latent_heat_j_per_kg = NaN: must lie from 0e0 to 6e4 J/kg"
        )
    );
    assert_eq!(
        said(latent, ""),
        "model.toml:1:1: parameter latent_heat_j_per_kg: must be there once"
    );
    let in_kj = said(
        latent,
        &of_latent("value = 12.0").replace("\"J/kg\"", "\"kJ/kg\""),
    );
    assert_eq!(
        in_kj,
        format!(
            "model.toml:{latent_line}:1: parameter latent_heat_j_per_kg = 12: unit must be \"J/kg\""
        )
    );
    let plain = said(
        "effects = [\"latent-heat\", \"thermal-expansion\"]",
        "effects = []",
    );
    assert!(
        plain.starts_with(&format!(
            "model.toml:{latent_line}:1: parameter latent_heat_j_per_kg = "
        )) && plain.ends_with(
            "start_share, start_since_reversal_k, ambient_level_k, run_heat_loss, run_gain"
        ),
        "{plain}"
    );
    // A reader that knows no effects.
    let refused = model_file::parse("model.toml", &written).unwrap_err();
    assert_eq!(
        refused.to_string(),
        format!(
            "model.toml:{effects}:12: effects: \"latent-heat\": must be empty: only baseline models are read here"
        )
    );
}
