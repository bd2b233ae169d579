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
    let mut effects = EffectValues::default();
    let mut active = EffectSet::EMPTY;
    if thermocouple_lag_s > 0.0 {
        active = active.with(EffectId::ThermocoupleLag);
        *effects.slot(EffectId::ThermocoupleLag, 0).unwrap() = thermocouple_lag_s;
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
        degc + 0.1 * normal
    };
    let training = [Recording::new(RecordingParts {
        temperature_degc: Some(temperature_degc.into_iter().map(read).collect()),
        ..parts("made-up.csv", current_a, noisy(output), DT_S)
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
