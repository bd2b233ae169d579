//! A larger size moves the output where physics says it does, from 0 up to the bound.

use crate::support;

use sma_effects::{EffectId, EffectSet, EffectValues, Setting};
use support::{Trace, current_a, drive_of, params, setting, trace, with_effect};
use wiener::Drive;

const DT_S: f64 = 0.2;

/// Runs with one parameter at rising values.
fn rising(effect: EffectId, index: usize, values: &[f64]) -> Vec<Trace> {
    values
        .iter()
        .map(|&value| {
            let mut sized = EffectValues::default();
            *sized.slot(effect, index).unwrap() = value;
            with_effect(effect, &sized, DT_S)
        })
        .collect()
}

fn highest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

fn falls(values: impl IntoIterator<Item = f64>) -> bool {
    let values: Vec<f64> = values.into_iter().collect();
    values.windows(2).all(|pair| pair[1] < pair[0])
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Samples of the first heating, 3 to 9 s, and of the first cooling, 20 to 30 s.
const HEATING: std::ops::Range<usize> = 15..45;
const COOLING: std::ops::Range<usize> = 100..150;

#[test]
fn losses_keep_the_rod_colder() {
    for (effect, values) in [
        (EffectId::Radiation, [0.0, 0.3, 0.7, 1.0]),
        (EffectId::EndConduction, [0.0, 0.1, 0.3, 0.6]),
    ] {
        let runs = rising(effect, 0, &values);
        let highest_degc = runs.iter().map(|run| highest(&run.temperature_degc));
        assert!(falls(highest_degc), "{effect}");
        let strokes = runs.iter().map(|run| mean(&run.displacement));
        assert!(falls(strokes), "{effect}");
    }
    // Above 50 K over the surroundings the air cools better; below, as the rod cools, worse.
    let runs = rising(EffectId::NaturalConvection, 0, &[0.0, 0.1, 0.2, 0.33]);
    assert!(falls(runs.iter().map(|run| highest(&run.temperature_degc))));
    assert!(falls(runs.iter().map(|run| -run.temperature_degc[190])));
}

#[test]
fn latent_heat_holds_back_both_ways() {
    let runs = rising(EffectId::LatentHeat, 0, &[0.0, 5e3, 15e3, 40e3]);
    assert!(falls(
        runs.iter().map(|run| mean(&run.displacement[HEATING]))
    ));
    // Where all have started to fall.
    assert!(falls(
        runs[..3]
            .iter()
            .map(|run| -mean(&run.displacement[145..170]))
    ));
}

#[test]
fn whatever_lags_comes_later() {
    for (effect, values) in [
        (EffectId::DeadTime, [0.0, 0.1, 0.25, 0.6]),
        (EffectId::SupplyLag, [0.0, 0.05, 0.2, 0.5]),
        (EffectId::OutputLag, [0.0, 0.1, 0.3, 1.0]),
    ] {
        let runs = rising(effect, 0, &values);
        assert!(
            falls(runs.iter().map(|run| mean(&run.displacement[HEATING]))),
            "{effect}"
        );
    }
    let runs = rising(EffectId::ThermocoupleLag, 0, &[0.0, 0.2, 1.0, 5.0]);
    assert!(falls(
        runs.iter().map(|run| mean(&run.recorded_degc[HEATING]))
    ));
}

#[test]
fn a_higher_resistance_of_austenite_heats_by_current_and_not_by_duty() {
    let duty = Drive::Duty {
        supply_v: 12.0,
        length_m: 0.5,
    };
    let power = Drive::Power { length_m: 0.5 };
    let strokes = |drive: Drive| -> Vec<f64> {
        let samples = drive_of(drive, &current_a(DT_S));
        let run = |change: f64| {
            let mut values = EffectValues::default();
            values.phase_dependent_resistance.resistance_change = change;
            let setting = Setting {
                drive,
                ..setting(EffectSet::of(EffectId::PhaseDependentResistance))
            };
            highest(&trace(&setting, &params(), &values, &samples, DT_S).temperature_degc)
        };
        [-0.2, 0.0, 0.2].map(run).to_vec()
    };
    assert!(falls(strokes(Drive::Current).into_iter().map(|degc| -degc)));
    assert!(falls(strokes(duty)));
    let same = strokes(power);
    assert!((same[0] - same[2]).abs() <= 0.0);
}

#[test]
fn warmer_surroundings_move_the_loop_like_fatigue_does_the_other_way() {
    let runs = rising(EffectId::AmbientDrift, 3, &[-5.0, 0.0, 5.0]);
    assert!(falls(
        runs.iter().map(|run| -mean(&run.displacement[450..]))
    ));
    let runs = rising(EffectId::FunctionalFatigue, 0, &[-3.0, 0.0, 3.0]);
    assert!(falls(runs.iter().map(|run| mean(&run.displacement[200..]))));
}

#[test]
fn stress_delays_heating_and_hastens_cooling() {
    let runs = rising(EffectId::StressCoupling, 0, &[0.0, 5.0, 20.0, 60.0]);
    assert!(falls(
        runs.iter().map(|run| mean(&run.displacement[HEATING]))
    ));
    assert!(falls(
        runs.iter().map(|run| mean(&run.displacement[COOLING]))
    ));
}

#[test]
fn what_takes_from_the_stroke_takes_the_more_the_larger_it_is() {
    for (effect, values) in [
        (EffectId::SupplyLimit, [0.0, 0.3, 0.7, 1.0]),
        (EffectId::EndStop, [0.0, 0.3, 0.7, 1.0]),
        (EffectId::ThermalExpansion, [0.0, 1e-5, 2e-5, 3e-5]),
        (EffectId::RPhase, [0.0, 0.1, 0.3, 0.5]),
    ] {
        let runs = rising(effect, 0, &values);
        let strokes = runs.iter().map(|run| mean(&run.displacement[45..]));
        assert!(falls(strokes), "{effect}");
    }
    let runs = rising(EffectId::Backlash, 0, &[0.0, 0.02, 0.1, 0.3]);
    assert!(falls(runs.iter().map(|run| highest(&run.displacement))));
}

#[test]
fn bent_scales_and_drifts_move_what_they_bend() {
    for (effect, index, values) in [
        (EffectId::SensorNonlinearity, 0, [-0.05, 0.0, 0.05]),
        (EffectId::SensorDrift, 3, [-0.1, 0.0, 0.1]),
        (EffectId::LoopShape, 0, [-0.3, 0.0, 0.3]),
    ] {
        let runs = rising(effect, index, &values);
        assert!(
            falls(runs.iter().map(|run| -mean(&run.displacement))),
            "{effect}"
        );
    }
}

#[test]
fn a_narrower_heating_curve_gets_further_and_a_wider_cooling_curve_ends_later() {
    let runs = rising(EffectId::LoopAsymmetry, 0, &[-0.5, 0.0, 0.5]);
    // At the end of the first heating, and at that of the cooling.
    assert!(falls(runs.iter().map(|run| -run.displacement[100])));
    assert!(falls(runs.iter().map(|run| -run.displacement[170])));
}
