//! A measured wire against a bias spring: what screening points at, and what is named.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it reads its data"
)]

use std::ops::ControlFlow;

use fixtures::bologna;
use identify::{Fit, FitConfig, WienerModel, fit};
use missing_physics::{
    DiagnoseConfig, ScreenConfig, Verdict, diagnose_from, screen, setting_of_rod,
};
use recording::{Recording, read_csv};
use rig_files::rod_file;
use sma_effects::{EffectId, EffectSet, Setting};
use wiener::hysteresis::Rule;

struct Bologna {
    base: WienerModel,
    fit: Fit,
    training: Vec<Recording>,
    unseen: Recording,
    setting: Setting,
}

/// The fitted baseline; `None` where the recordings are not there.
fn measured() -> Option<Bologna> {
    let folder = fixtures::shared::path(bologna::FOLDER)?;
    let rod = rod_file::parse("rod.toml", bologna::ROD).unwrap();
    let read = |name: &str| read_csv(folder.join(name), &rod.read_options()).unwrap();
    let training: Vec<Recording> = bologna::TRAINING.map(read).into();
    let base = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap();
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let fit = fit(&base, &training, &FitConfig::default(), go_on).unwrap();
    Some(Bologna {
        setting: setting_of_rod(&rod, "mm"),
        unseen: read(bologna::UNSEEN),
        base,
        fit,
        training,
    })
}

#[test]
fn screening_points_at_heat_and_at_the_ends_of_the_stroke() {
    let Some(rig) = measured() else { return };
    let config = ScreenConfig {
        setting: rig.setting,
        seed: 1,
    };
    let screening = screen(&rig.base, &rig.fit, &rig.training, &config).unwrap();
    assert_eq!(screening.effects.len(), EffectId::ALL.len() - 1);
    assert_eq!(screening.unknown[0].0, EffectId::ThermocoupleLag);
    let score = |effect| {
        let found = screening.effects.iter().find(|one| one.effect == effect);
        found.unwrap().whitened
    };
    assert!(
        (2.5..4.0).contains(&screening.critical),
        "{}",
        screening.critical
    );
    // All three of the effects that together explain most of it.
    for effect in [
        EffectId::LatentHeat,
        EffectId::ThermalExpansion,
        EffectId::EndStop,
    ] {
        assert!(
            score(effect) > 2.0 * screening.critical,
            "{effect:?} {}",
            score(effect)
        );
    }
    // No inner reversals: their memory cannot be seen.
    assert!(score(EffectId::ReturnPointMemory).abs() < 1e-9);
}

#[test]
fn latent_heat_and_thermal_expansion_are_named_where_each_run_has_its_own_state() {
    let Some(rig) = measured() else { return };
    let config = DiagnoseConfig {
        setting: rig.setting,
        // A meter of wire has no ends to speak of, and heat along it takes ten times as long.
        catalogue: EffectSet::all().without(EffectId::EndConduction),
        ..DiagnoseConfig::default()
    };
    let unseen = std::slice::from_ref(&rig.unseen);
    let parts = [rig.training.as_slice(), unseen];
    let found = diagnose_from(&rig.base, rig.fit, parts, &config, &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap();
    // Two steps of the same drive, beside an offset.
    let repeats = found.repeats.unwrap();
    assert!((repeats.rms().unwrap() / 0.17 - 1.0).abs() < 0.1);
    assert!(!repeats.is_noise());
    // Part of what the unseen run could show is explained by a suspect only.
    assert_eq!(found.verdict, Verdict::ExplainedInPart);
    let by_findings = found.explained.unwrap().by_findings.unwrap();
    assert!((0.5..0.8).contains(&by_findings), "{by_findings}");
    let extended = found.extended.unwrap().stage;
    // 0.068 mm: nearer than runs of the same drive are to one model.
    assert!(
        extended.fit.train_rmse < 0.085,
        "{}",
        extended.fit.train_rmse
    );
    // With surroundings, heat loss and stroke of its own, and with nothing of its own but its rest.
    let calibrated = extended.validated[0].rmse;
    assert!(calibrated < 0.15, "{calibrated}");
    let predicted = extended.predicted_rmse.unwrap();
    assert!(predicted < 0.4, "{predicted}");
    assert!(predicted < 0.5 * found.baseline.predicted_rmse.unwrap());
    // Physical numbers that nobody put in.
    let interval = |effect| {
        let finding = found.findings.iter().find(|one| one.effect == effect);
        finding.unwrap().parameters[0].ci95.unwrap()
    };
    let [low, high] = interval(EffectId::LatentHeat);
    assert!(low > 12e3 && high < 25e3, "{low} {high}");
    // At 500 J/(kg K); it goes with the specific heat, which may be 450 to 840.
    let [low, high] = interval(EffectId::ThermalExpansion);
    assert!(low < 11e-6 && high > 6.6e-6, "{low} {high}");
    // States that a laboratory can have.
    for (name, most) in [
        ("ambient_level_k", 6.0),
        ("run_heat_loss", 0.15),
        ("run_gain", 0.03),
    ] {
        let own = &extended.fit.parameter(name).unwrap().values;
        assert!(own.iter().all(|value| value.abs() < most), "{name} {own:?}");
    }
}
