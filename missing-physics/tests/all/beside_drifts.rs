//! Effects beside something that drifts through the whole run.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it makes its data"
)]

use crate::common;

use common::{
    DT_S, diagnosed_against, diagnosed_under, found, noisy, params, played, recording, setting,
    triangles_a,
};
use missing_physics::{Diagnosis, Verdict};
use sma_effects::{EffectId, EffectSet, EffectValues, Extended, Hypothesis, Setting};

/// Surroundings that wander, faster than a curve through eight knots follows.
const WANDERING: &str = r#"
[[hypothesis]]
id = "surroundings"
heat_flow_w_per_m = "a * (sin(2 * pi * t / 800) + 0.06 * sin(2 * pi * t / 67 + 1))"
[hypothesis.parameters.a]
unit = "W/m"
typical = 0.3
bounds = [0.0, 3.0]
"#;

/// Eight cycles of steps and ramps, of different heights.
fn current_a() -> Vec<f64> {
    let heights_a = [2.3, 2.0, 2.2, 1.8, 2.3, 2.1, 1.9, 2.2];
    let cycle = |height_a: f64| {
        let up = (0..100).map(move |k| height_a * f64::from(k) / 100.0);
        let down = (0..100).map(move |k| height_a * (1.0 - f64::from(k) / 100.0));
        up.chain([height_a; 50]).chain(down).chain([0.0; 100])
    };
    heights_a.into_iter().flat_map(cycle).collect()
}

/// Diagnosis of a wire with effects.
fn of_wire(setting: Setting, effects: EffectValues) -> Diagnosis {
    let output = played(&Extended { setting }, params(), effects, &current_a(), DT_S);
    diagnosed_under(current_a(), noisy(output), &[])
}

/// The wire in surroundings that wander by some 3 K, its output late by so much.
fn in_the_open(output_lag_s: f64) -> Diagnosis {
    let setting = Setting {
        hypotheses: Hypothesis::parse("own.toml", WANDERING).unwrap(),
        active: EffectSet::of(EffectId::OutputLag),
        ..setting()
    };
    let mut effects = EffectValues::default();
    effects.own[0][0] = 0.4;
    effects.output_lag.output_lag_s = output_lag_s;
    of_wire(setting, effects)
}

#[test]
fn a_lag_is_named_beside_surroundings_that_wander() {
    let late = in_the_open(0.4);
    assert_eq!(
        found(&late),
        ["ambient-drift", "output-lag"],
        "{:?}",
        late.suspects
    );
    // A curve through eight knots leaves more than the noise of 5 µm, which is no effect's.
    let rmse = late.extended.unwrap().stage.fit.train_rmse;
    assert!(rmse > 7e-3, "{rmse}");
}

#[test]
fn where_there_is_no_lag_the_drift_stands_alone() {
    assert_eq!(found(&in_the_open(0.0)), ["ambient-drift"]);
}

#[test]
fn a_lag_is_named_beside_a_fatigue_that_dwarfs_it() {
    let setting = Setting {
        active: EffectSet::of(EffectId::OutputLag).with(EffectId::FunctionalFatigue),
        ..setting()
    };
    let mut effects = EffectValues::default();
    effects.functional_fatigue.fatigue_k = -2.0;
    effects.functional_fatigue.fatigue_fading = 0.3;
    effects.output_lag.output_lag_s = 0.1;
    let diagnosis = of_wire(setting, effects);
    assert_eq!(
        found(&diagnosis),
        ["functional-fatigue", "output-lag"],
        "{:?}",
        diagnosis.suspects
    );
    assert_eq!(diagnosis.verdict, Verdict::Explained);
    let mut findings = diagnosis.findings.iter();
    let fatigue = findings.find(|one| one.effect == EffectId::FunctionalFatigue);
    assert!(fatigue.unwrap().could_also_be.is_empty(), "{fatigue:?}");
    let [shift_k, _, fading] = &fatigue.unwrap().parameters[..] else {
        panic!("{fatigue:?}");
    };
    assert!((shift_k.value / -2.0 - 1.0).abs() < 0.05, "{shift_k:?}");
    assert!((fading.value - 0.3).abs() < 0.05, "{fading:?}");
}

#[test]
fn a_fatigue_is_told_from_surroundings_that_drift_by_its_steps() {
    let setting = Setting {
        active: EffectSet::of(EffectId::FunctionalFatigue),
        ..setting()
    };
    let mut effects = EffectValues::default();
    effects.functional_fatigue.fatigue_k = -0.4;
    effects.functional_fatigue.fatigue_fading = 0.0;
    let diagnosis = of_wire(setting, effects);
    let [finding] = &diagnosis.findings[..] else {
        panic!("{:?}", diagnosis.findings);
    };
    // It neither fades nor takes stroke, but moves where the rod transforms and stands still where it rests.
    assert_eq!(finding.effect, EffectId::FunctionalFatigue);
}

#[test]
fn a_room_that_is_cooler_the_next_day_is_no_drift() {
    let setting = Setting {
        active: EffectSet::of(EffectId::LoopAsymmetry),
        ..setting()
    };
    let mut effects = EffectValues::default();
    // It dwarfs what the room does.
    effects.loop_asymmetry.loop_asymmetry = 0.4;
    let run = |name: &str, cooler_k: f64| {
        // A rod in cooler surroundings does what one does whose loop lies as much higher.
        let mut params = params();
        params.limiting_loop.loop_center_degc += cooler_k;
        let drive = triangles_a(&[2.3, 1.9, 2.1]);
        let output = played(&Extended { setting }, params, effects, &drive, 0.5);
        recording(name, drive, noisy(output), 0.5)
    };
    let diagnosis = diagnosed_against(&[run("monday.csv", 0.0), run("tuesday.csv", 0.05)], &[]);
    assert_eq!(found(&diagnosis), ["loop-asymmetry"]);
    let level_k = diagnosis.extended.unwrap().stage.fit;
    let level_k = level_k.parameter("ambient_level_k").unwrap().values[1];
    assert!((level_k + 0.05).abs() < 0.02, "{level_k}");
}
