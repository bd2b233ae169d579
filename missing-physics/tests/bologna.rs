//! A measured wire against a bias spring: what screening points at, and what four effects together explain.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it reads its data"
)]

use std::f64::consts::PI;
use std::ops::ControlFlow;

use identify::{
    Fit, FitConfig, ForwardModel, ParameterVector, RefineConfig, Rod, WienerModel, fit, refine,
    validate, validate_at,
};
use missing_physics::{EffectId, ExtendedModel, Role, ScreenConfig, Setting, screen};
use recording::{Recording, read_csv};
use wiener::hysteresis::Rule;

const ROD: &str = r#"
[rod]
diameter_mm = 0.5
length_mm = 1000.0
density_kg_per_m3 = 6450.0
specific_heat_j_per_kg_k = 500.0
resistance_ohm_per_m = 4.3

[surroundings]
ambient_degc = 24.0

[drive]
kind = "duty"
supply_v = 24.0

[columns]
output = { name = "position_mm", unit = "mm" }
"#;

struct Bologna {
    base: WienerModel,
    fit: Fit,
    training: Vec<Recording>,
    unseen: Recording,
    setting: Setting,
}

/// The fitted baseline; `None` where the recordings are not there.
fn bologna() -> Option<Bologna> {
    let folder = fixtures::shared::path("recordings/bologna")?;
    let rod = Rod::parse("rod.toml", ROD).unwrap();
    let read = |name: &str| read_csv(folder.join(name), &rod.read_options()).unwrap();
    let training: Vec<Recording> = ["ramp01.csv", "step01.csv", "step02.csv"].map(read).into();
    let base = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap();
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let fit = fit(&base, &training, &FitConfig::default(), go_on).unwrap();
    let diameter_m = rod.diameter_m.unwrap();
    Some(Bologna {
        setting: Setting {
            mass_kg_per_m: Some(
                rod.density_kg_per_m3.unwrap() * PI * diameter_m * diameter_m / 4.0,
            ),
            surface_m2_per_m: Some(PI * diameter_m),
            length_output: Some(1000.0 * rod.length_m.unwrap()),
            ..Setting::default()
        },
        unseen: read("ramp02.csv"),
        base,
        fit,
        training,
    })
}

#[test]
fn screening_points_at_heat_and_at_the_ends_of_the_stroke() {
    let Some(rig) = bologna() else { return };
    let config = ScreenConfig {
        setting: rig.setting,
        seed: 1,
    };
    let screening = screen(&rig.base, &rig.fit, &rig.training, &config).unwrap();
    assert_eq!(screening.effects.len(), 20);
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
fn four_effects_explain_most_of_it_on_what_they_have_not_seen() {
    let Some(rig) = bologna() else { return };
    let active = [
        EffectId::LatentHeat,
        EffectId::ThermalExpansion,
        EffectId::EndStop,
        EffectId::NaturalConvection,
    ];
    let setting = Setting {
        active: active.into_iter().collect(),
        ..rig.setting
    };
    let model = ExtendedModel::new(&rig.base, &rig.fit, setting);
    let vector = ParameterVector::new(model.parameters(), rig.training.len());
    let at = |share: f64, parameter: usize| {
        let name = model.parameters()[parameter].name;
        if let Some(fitted) = rig.fit.parameter(name) {
            return Some(fitted.values[0]);
        }
        let parameters = active.iter().flat_map(|effect| effect.info().parameters);
        let own = parameters.into_iter().find(|own| own.name == name)?;
        Some(match own.role {
            Role::Size => share * own.typical,
            Role::Partner { .. } => own.typical,
        })
    };
    // An end stop that starts far from its place stays there: from more than one size.
    let starts = [0.3, 1.0].map(|share| vector.coordinates(|parameter, _| at(share, parameter)));
    let config = RefineConfig::default();
    let refined = refine(&model, &rig.training, &starts, &config).unwrap();
    let point = &refined.points[0];
    let unseen = validate_at(&model, point, &rig.unseen).unwrap().rmse;
    let plain = validate(&rig.base, &rig.fit, &rig.unseen).unwrap().rmse;
    // 0.0915 mm, where the plain model has 0.369; 0.368 mm unseen, where it has 1.025.
    assert!(
        refined.mean_square.sqrt() < 0.092,
        "{}",
        refined.mean_square.sqrt()
    );
    assert!(unseen < 0.37 * plain, "{unseen} {plain}");
    let value = |effect| point[model.first_parameter(effect).unwrap()];
    // Physical numbers that nobody put in: 16.4 kJ/kg, 15e-6 /K at 500 J/(kg K), an exponent of 0.22.
    assert!((4e3..37e3).contains(&value(EffectId::LatentHeat)));
    assert!((6e-6..2e-5).contains(&value(EffectId::ThermalExpansion)));
    assert!((0.05..0.3).contains(&value(EffectId::NaturalConvection)));
}
