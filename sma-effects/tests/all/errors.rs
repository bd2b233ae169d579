//! Refused values, and the words of the refusal.

use crate::support;

use std::error::Error;

use sma_effects::{EffectId, EffectSet, EffectValues, ExtendedPlant, PhysicsError, Setting};
use support::{params, setting};
use wiener::Drive;

fn refused(setting: &Setting, values: EffectValues) -> PhysicsError {
    ExtendedPlant::new(setting, &params(), &values).unwrap_err()
}

#[test]
fn a_value_out_of_bounds_is_named_with_its_bounds() {
    let active = EffectSet::of(EffectId::LatentHeat);
    let of = |value: f64| {
        let mut values = EffectValues::default();
        values.latent_heat.latent_heat_j_per_kg = value;
        refused(&setting(active), values).to_string()
    };
    let text = |value: &str| {
        format!("latent-heat: latent_heat_j_per_kg = {value} J/kg: must be in [0, 60000]")
    };
    assert_eq!(of(-1.0), text("-1"));
    assert_eq!(of(6.1e4), text("61000"));
    assert_eq!(of(f64::NAN), text("NaN"));
    assert_eq!(of(f64::INFINITY), text("inf"));
}

#[test]
fn every_parameter_refuses_what_is_no_number_or_out_of_bounds() {
    for effect in EffectId::ALL {
        for (index, parameter) in effect.info().parameters.iter().enumerate() {
            let [lower, upper] = parameter.bounds;
            for value in [f64::NAN, f64::NEG_INFINITY, lower - 1e-3, upper + 1e-3] {
                let mut values = EffectValues::default();
                *values.slot(effect, index).unwrap() = value;
                let error = refused(&setting(EffectSet::of(effect)), values);
                assert!(
                    matches!(error, PhysicsError::OutOfBounds { name, .. } if name == parameter.name),
                    "{error}"
                );
            }
            for value in [lower, upper] {
                let mut values = EffectValues::default();
                *values.slot(effect, index).unwrap() = value;
                let setting = setting(EffectSet::of(effect));
                assert!(ExtendedPlant::new(&setting, &params(), &values).is_ok());
            }
        }
    }
}

#[test]
fn a_size_of_an_effect_that_is_not_active_is_refused() {
    let mut values = EffectValues::default();
    values.radiation.emissivity = 0.3;
    assert_eq!(
        refused(&setting(EffectSet::EMPTY), values).to_string(),
        "radiation: emissivity = 0.3: must be 0 while the effect is not active"
    );
    values.radiation.emissivity = f64::NAN;
    let error = refused(&setting(EffectSet::EMPTY), values);
    assert!(matches!(error, PhysicsError::Inactive { .. }));
}

#[test]
fn an_effect_says_what_it_lacks() {
    for (effect, what) in [
        (EffectId::LatentHeat, "mass_kg_per_m"),
        (EffectId::Radiation, "surface_m2_per_m"),
        (EffectId::AmbientDrift, "run_length_s"),
        (EffectId::SensorDrift, "run_length_s"),
        (EffectId::SupplyLimit, "largest_drive"),
    ] {
        let setting = Setting {
            active: EffectSet::of(effect),
            ..Setting::default()
        };
        assert_eq!(
            refused(&setting, EffectValues::default()).to_string(),
            format!("{effect} needs {what}, which the setting leaves out")
        );
    }
}

#[test]
fn a_setting_is_checked() {
    let of = |setting: Setting| refused(&setting, EffectValues::default()).to_string();
    let plain = Setting::default();
    for (value, shown) in [
        (0.0, "0"),
        (-1.0, "-1"),
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
    ] {
        let wanted =
            |name: &str, unit: &str| format!("{name} = {shown} {unit}: must be finite and > 0");
        let given = Some(value);
        let mass = Setting {
            mass_kg_per_m: given,
            ..plain
        };
        assert_eq!(of(mass), wanted("mass_kg_per_m", "kg/m"));
        let surface = Setting {
            surface_m2_per_m: given,
            ..plain
        };
        assert_eq!(of(surface), wanted("surface_m2_per_m", "m²/m"));
        let length = Setting {
            length_output: given,
            ..plain
        };
        assert_eq!(of(length), wanted("length_output", "(output unit)"));
        let run = Setting {
            run_length_s: given,
            ..plain
        };
        assert_eq!(of(run), wanted("run_length_s", "s"));
        let drive = Setting {
            largest_drive: given,
            ..plain
        };
        assert_eq!(of(drive), wanted("largest_drive", "(drive unit)"));
    }
    for (value, shown) in [(-1.0, "-1"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")] {
        assert_eq!(
            of(Setting {
                start_s: value,
                ..plain
            }),
            format!("start_s = {shown} s: must be finite and >= 0")
        );
    }
    for (value, shown) in [(-0.1, "-0.1"), (1.5, "1.5"), (f64::NAN, "NaN")] {
        assert_eq!(
            of(Setting {
                lead_share: value,
                ..plain
            }),
            format!("lead_share = {shown}: must be from 0 to 1")
        );
    }
    assert_eq!(
        of(Setting {
            reference_degc: f64::NAN,
            ..plain
        }),
        "reference_degc = NaN °C: must be finite"
    );
    assert_eq!(
        of(Setting {
            sub_steps: 0,
            ..plain
        }),
        "sub_steps = 0: must be in 1..=64"
    );
    assert_eq!(
        of(Setting {
            newton_iterations: 51,
            ..plain
        }),
        "newton_iterations = 51: must be in 1..=50"
    );
}

#[test]
fn errors_of_the_baseline_are_passed_on() {
    let mut wrong = params();
    wrong.zeta = f64::NAN;
    let error =
        ExtendedPlant::new(&Setting::default(), &wrong, &EffectValues::default()).unwrap_err();
    assert_eq!(error.to_string(), "baseline");
    assert_eq!(error.source().unwrap().to_string(), "hysteresis");
    let setting = Setting {
        drive: Drive::Voltage { length_m: 0.0 },
        ..Setting::default()
    };
    let error = refused(&setting, EffectValues::default());
    assert_eq!(
        error.source().unwrap().to_string(),
        "length_m = 0 m: must be finite and > 0"
    );
    let hysteresis = wiener::hysteresis::SineProximity::new([2.0]).unwrap_err();
    let error = PhysicsError::from(hysteresis);
    assert_eq!(error.to_string(), "hysteresis");
    assert!(error.source().is_some());
}

#[test]
fn an_unknown_id_is_answered_with_the_known_ones() {
    let text = EffectId::parse("latent_heat").unwrap_err().to_string();
    assert!(text.starts_with(
        "effect 'latent_heat': unknown; known are supply-limit supply-lag dead-time latent-heat "
    ));
    for effect in EffectId::ALL {
        assert_eq!(EffectId::parse(effect.id()).unwrap(), effect);
        assert_eq!(effect.to_string(), effect.id());
    }
}
