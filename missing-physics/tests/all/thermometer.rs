//! A recorded temperature that is missed is missed, however well the output is met.

use missing_physics::{DiagnoseConfig, Diagnosis, Verdict};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Recording, RecordingParts};
use sma_effects::{EffectId, EffectSet, EffectValues, Extended, Setting};

use crate::common;

use common::{DT_S, current_a, diagnosed_as, found, noisy, params, parts, played_warm, setting};

/// Diagnosis of the wire with a thermometer that lags by so much, s, by some effects; it is read to 0.1 K.
fn diagnosed(thermocouple_lag_s: f64, catalogue: EffectSet) -> Diagnosis {
    read_to(
        0.1,
        (EffectId::ThermocoupleLag, thermocouple_lag_s),
        noisy,
        catalogue,
    )
}

/// Diagnosis of the wire with one effect of a size, by some effects. Its temperature is read to so many kelvins.
fn read_to(
    noise_k: f64,
    (effect, size): (EffectId, f64),
    sensed: fn(Vec<f64>) -> Vec<f64>,
    catalogue: EffectSet,
) -> Diagnosis {
    let mut effects = EffectValues::default();
    let mut active = EffectSet::EMPTY;
    if size > 0.0 {
        active = active.with(effect);
        *effects.slot(effect, 0).unwrap() = size;
    }
    let fleet = Extended {
        setting: Setting {
            active,
            ..setting()
        },
    };
    let current_a = current_a();
    let [output, temperature_degc] = played_warm(&fleet, params(), effects, &current_a, DT_S);
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let read = |degc: f64| {
        let normal: f64 = StandardNormal.sample(&mut rng);
        degc + noise_k * normal
    };
    let training = [Recording::new(RecordingParts {
        temperature_degc: Some(temperature_degc.into_iter().map(read).collect()),
        ..parts("made-up.csv", current_a, sensed(output), DT_S)
    })
    .unwrap()];
    let config = DiagnoseConfig {
        setting: setting(),
        catalogue,
        ..DiagnoseConfig::default()
    };
    diagnosed_as(&training, &[], &config)
}

#[test]
fn a_thermometer_that_lags_is_never_adequate() {
    let without = EffectSet::all().without(EffectId::ThermocoupleLag);
    // The output is met to its noise all the same.
    let unnamed = diagnosed(10.0, without);
    assert_eq!(unnamed.verdict, Verdict::Unexplained);
    let missed_k = unnamed.baseline.fit.temperature_rmse_k.unwrap();
    assert!(missed_k > 5.0, "{missed_k}");
    let named = diagnosed(2.0, EffectSet::all());
    assert_eq!(found(&named), ["thermocouple-lag"]);
    assert_eq!(named.verdict, Verdict::Explained);
    assert_eq!(diagnosed(0.0, without).verdict, Verdict::Adequate);
}

#[test]
fn a_temperature_without_noise_does_not_decide_alone() {
    let all = EffectSet::all();
    for (effect, size) in [
        (EffectId::OutputLag, 0.3),
        (EffectId::Backlash, 0.015),
        (EffectId::LoopAsymmetry, 0.3),
    ] {
        let named = read_to(0.0, (effect, size), noisy, all);
        assert_eq!(found(&named), [effect.id()]);
        let [lower, upper] = named.findings[0].parameters[0].ci95.unwrap();
        assert!((lower..=upper).contains(&size), "{lower} {size} {upper}");
    }
}

#[test]
fn a_simulation_without_noise_is_met_and_not_doubted() {
    // As a file of six decimals has it.
    let rounded = |output: Vec<f64>| output.iter().map(|y| (1e6 * y).round() / 1e6).collect();
    let nothing = read_to(0.0, (EffectId::Backlash, 0.0), rounded, EffectSet::all());
    assert_eq!(nothing.verdict, Verdict::Adequate);
    let lag = (EffectId::OutputLag, 0.3);
    assert_eq!(
        found(&read_to(0.0, lag, rounded, EffectSet::all())),
        ["output-lag"]
    );
}
