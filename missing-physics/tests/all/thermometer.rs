//! A recorded temperature that is missed is missed, however well the output is met.

use std::ops::ControlFlow;

use fixtures::wire::{AMBIENT_DEGC, ROD};
use identify::{Rod, WienerModel};
use missing_physics::{DiagnoseConfig, Diagnosis, Verdict, diagnose};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Recording, RecordingParts};
use sma_effects::{EffectId, EffectSet, EffectValues, Extended, Member, Setting};
use wiener::hysteresis::Rule;
use wiener::{Profile, Start};

use crate::common;

use common::{DT_S, current_a, found, noisy, params, setting};

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
    let member = Member {
        params: params(),
        effects,
        start: Start::rest(AMBIENT_DEGC),
    };
    let current_a = current_a();
    let profile = Profile::uniform(&current_a, DT_S, AMBIENT_DEGC).unwrap();
    let (mut output, mut temperature_degc) = (Vec::new(), Vec::new());
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    fleet
        .run(&[member], &profile, &mut |block| {
            output.extend(block.displacement.iter().step_by(block.stride));
            for degc in block.temperature_degc.iter().step_by(block.stride) {
                let normal: f64 = StandardNormal.sample(&mut rng);
                temperature_degc.push(degc + 0.1 * normal);
            }
        })
        .unwrap();
    let training = [Recording::new(RecordingParts {
        name: "made-up.csv".to_owned(),
        time_s: Some((0..output.len()).map(|k| DT_S * k as f64).collect()),
        drive: current_a,
        output: noisy(output),
        output_unit: "mm".to_owned(),
        temperature_degc: Some(temperature_degc),
        ..RecordingParts::default()
    })
    .unwrap()];
    let rod = Rod::parse("rod.toml", ROD).unwrap();
    let base = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap();
    let config = DiagnoseConfig {
        setting: setting(),
        catalogue,
        ..DiagnoseConfig::default()
    };
    let go_on = &mut |_| ControlFlow::Continue(());
    diagnose(&base, &training, &[], &config, go_on).unwrap()
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
