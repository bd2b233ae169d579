//! The smaller of two effects, and what is only the form of the larger one.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it makes its data"
)]

use crate::common;

use common::{DT_S, diagnosed_under, found, noisy, params, played, setting};
use missing_physics::Diagnosis;
use sma_effects::{EffectId, EffectSet, EffectValues, Extended, Setting};

/// Steps and ramps of different heights.
fn current_a() -> Vec<f64> {
    let heights_a = [2.3, 1.9, 2.1, 1.8];
    let cycle = |height_a: f64| {
        let up = (0..150).map(move |k| height_a * f64::from(k) / 150.0);
        let down = (0..150).map(move |k| height_a * (1.0 - f64::from(k) / 150.0));
        up.chain([height_a; 100]).chain(down).chain([0.0; 200])
    };
    heights_a.into_iter().flat_map(cycle).collect()
}

fn of_wire(active: EffectSet, effects: EffectValues) -> Diagnosis {
    let setting = Setting {
        active,
        ..setting()
    };
    let output = played(&Extended { setting }, params(), effects, &current_a(), DT_S);
    diagnosed_under(current_a(), noisy(output), &[])
}

#[test]
fn a_resistance_that_rises_with_temperature_brings_no_convection() {
    let mut effects = EffectValues::default();
    effects.phase_dependent_resistance.resistance_change = -0.2;
    effects.phase_dependent_resistance.resistance_rise_per_k = 4e-4;
    let active = EffectSet::of(EffectId::PhaseDependentResistance);
    let diagnosis = of_wire(active, effects);
    assert_eq!(found(&diagnosis), ["phase-dependent-resistance"]);
    let [change, rise_per_k] = &diagnosis.findings[0].parameters[..] else {
        panic!("{:?}", diagnosis.findings[0]);
    };
    assert!((change.value / -0.2 - 1.0).abs() < 0.05, "{change:?}");
    let [lower, upper] = rise_per_k.ci95.unwrap();
    assert!((lower..=upper).contains(&4e-4), "{rise_per_k:?}");
    // The name is of the change.
    let sentence = &diagnosis.findings[0].sentence;
    assert!(sentence.contains("changes by -20"), "{sentence}");
}

#[test]
fn a_lag_stays_beside_a_loss_that_no_single_law_follows() {
    let mut effects = EffectValues::default();
    effects.natural_convection.convection_exponent = 0.25;
    effects.radiation.emissivity = 0.9;
    effects.output_lag.output_lag_s = 0.1;
    let active = EffectSet::of(EffectId::NaturalConvection)
        .with(EffectId::Radiation)
        .with(EffectId::OutputLag);
    let diagnosis = of_wire(active, effects);
    let found = found(&diagnosis);
    assert!(
        found.contains(&"output-lag"),
        "{found:?}, {:?}",
        diagnosis.suspects
    );
}
