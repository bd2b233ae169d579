//! A wire whose loop is of another family than the paper's.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it makes its data"
)]

use crate::common;

use common::{current_a, diagnosed, found, noisy, output_mm, recording, setting};
use fixtures::wire::ROD;
use identify::WienerModel;
use missing_physics::{DiagnoseConfig, LoopFamily, Verdict, diagnose};
use rig_files::rod_file;
use sma_effects::{EffectId, EffectSet, EffectValues, Setting};
use std::ops::ControlFlow;
use wiener::hysteresis::Rule;

fn wire(loop_family: LoopFamily, effects: EffectSet) -> Setting {
    Setting {
        loop_family,
        active: effects,
        ..setting()
    }
}

#[test]
fn a_loop_of_kinetics_alone_is_another_shape_of_the_loop() {
    let wire = wire(LoopFamily::Kinetics, EffectSet::EMPTY);
    let diagnosis = diagnosed(noisy(output_mm(wire, EffectValues::default())), &[]);
    assert_eq!(found(&diagnosis), ["loop-shape"]);
    assert_eq!(diagnosis.verdict, Verdict::Explained);
    let extended = diagnosis.extended.unwrap();
    assert_eq!(extended.names(), ["loop-shape"]);
    assert_eq!(extended.model.loop_family(), LoopFamily::Kinetics);
    assert!(diagnosis.findings[0].sentence.contains("cosine kinetics"));
    // Noise of 5 µm.
    let rmse = extended.stage.fit.train_rmse;
    assert!((rmse - 5e-3).abs() < 5e-4, "{rmse}");
    let rungs = diagnosis.ladder.iter().map(|rung| rung.added.len());
    assert_eq!(rungs.collect::<Vec<_>>(), [0, 1]);
    assert!(diagnosis.ladder[0].train_rmse > 2.0 * diagnosis.ladder[1].train_rmse);
}

#[test]
fn asymmetry_beside_kinetics_that_set_in_sharply_is_named_with_its_size() {
    let effect = EffectId::LoopAsymmetry;
    let wire = wire(LoopFamily::Kinetics, EffectSet::of(effect));
    // Twice the typical: more than the formula of another loop may be off by.
    let mut truth = EffectValues::typical(effect, 2.0);
    truth.family.onset = 1.0;
    let diagnosis = diagnosed(noisy(output_mm(wire, truth)), &[]);
    let mut findings = diagnosis.findings.iter();
    let asymmetry = findings.find(|one| one.effect == effect).unwrap();
    let [lower, upper] = asymmetry.parameters[0].ci95.unwrap();
    let size = truth.loop_asymmetry.loop_asymmetry;
    assert!(lower < size && size < upper, "{lower} {upper}");
    let extended = diagnosis.extended.unwrap();
    assert_eq!(extended.model.loop_family(), LoopFamily::Kinetics);
    let onset = extended.stage.fit.parameter("onset_sharpness").unwrap();
    assert!(onset.values[0] > 0.8, "{:?}", onset.values);
    // Noise of 5 µm.
    let rmse = extended.stage.fit.train_rmse;
    assert!((rmse - 5e-3).abs() < 5e-4, "{rmse}");
}

#[test]
fn what_may_be_a_finer_form_of_another_loop_is_said_to_be_either() {
    let effect = EffectId::LoopAsymmetry;
    let wire = wire(LoopFamily::Kinetics, EffectSet::of(effect));
    let mut truth = EffectValues::typical(effect, 1.0);
    truth.family.onset = 1.0;
    let diagnosis = diagnosed(noisy(output_mm(wire, truth)), &[]);
    assert_eq!(diagnosis.verdict, Verdict::Ambiguous);
    assert_eq!(found(&diagnosis), ["loop-asymmetry", "loop-shape"]);
    let mut findings = diagnosis.findings.iter();
    let asymmetry = findings.find(|one| one.effect == effect).unwrap();
    assert_eq!(asymmetry.could_also_be, [EffectId::LoopShape]);
    // The loop's formula may make all of it.
    let [lower, upper] = asymmetry.parameters[0].ci95.unwrap();
    let size = truth.loop_asymmetry.loop_asymmetry;
    assert!(lower < 0.0 && size < upper, "{lower} {upper}");
}

#[test]
fn an_effect_beside_relays_is_named_with_its_size() {
    let effect = EffectId::LatentHeat;
    let wire = wire(LoopFamily::Relays, EffectSet::of(effect));
    let truth = EffectValues::typical(effect, 1.0);
    let diagnosis = diagnosed(noisy(output_mm(wire, truth)), &[]);
    assert_eq!(found(&diagnosis), ["latent-heat", "loop-shape"]);
    assert_eq!(diagnosis.verdict, Verdict::Explained);
    let mut findings = diagnosis.findings.iter();
    let latent = findings.find(|one| one.effect == effect).unwrap();
    let [lower, upper] = latent.parameters[0].ci95.unwrap();
    let size = truth.latent_heat.latent_heat_j_per_kg;
    assert!(lower < size && size < upper, "{lower} {upper}");
    let rungs = diagnosis.ladder.iter().map(|rung| rung.added.len());
    assert_eq!(rungs.collect::<Vec<_>>(), [0, 1, 1]);
}

#[test]
fn without_another_shape_of_the_loop_no_family_is_tried() {
    let wire = wire(LoopFamily::Kinetics, EffectSet::EMPTY);
    let output = noisy(output_mm(wire, EffectValues::default()));
    let rod = rod_file::parse("rod.toml", ROD).unwrap();
    let training = [recording("made-up.csv", current_a(), output, 0.2)];
    let base = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap();
    let config = DiagnoseConfig {
        setting: setting(),
        // Some effects to try in the place of families.
        catalogue: EffectSet::of(EffectId::LatentHeat)
            .with(EffectId::Backlash)
            .with(EffectId::SupplyLag),
        ..DiagnoseConfig::default()
    };
    let diagnosis = diagnose(&base, &training, &[], &config, &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap();
    assert!(!found(&diagnosis).contains(&"loop-shape"));
    let family = diagnosis.extended.map(|one| one.model.loop_family());
    assert_ne!(family, Some(LoopFamily::Kinetics));
}

#[test]
fn an_effect_that_shows_more_than_any_loop_is_named_beside_relays() {
    let effect = EffectId::LatentHeat;
    let wire = wire(LoopFamily::Relays, EffectSet::of(effect));
    let truth = EffectValues::typical(effect, 4.0);
    let diagnosis = diagnosed(noisy(output_mm(wire, truth)), &[]);
    assert_eq!(found(&diagnosis), ["latent-heat", "loop-shape"]);
    let extended = diagnosis.extended.unwrap();
    assert_eq!(extended.model.loop_family(), LoopFamily::Relays);
    // Noise of 5 µm, of which the paper's loop with nothing missing leaves more than twenty times.
    let rmse = extended.stage.fit.train_rmse;
    assert!((rmse - 5e-3).abs() < 5e-4, "{rmse}");
    assert!(diagnosis.baseline.fit.train_rmse > 20.0 * rmse);
}
