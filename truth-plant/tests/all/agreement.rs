//! With nothing added, the plant is the cascade of the paper, computed by other means.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test may end in a panic"
)]

use truth_plant::{Draw, DriveName, FamilyKind, LoopFamily, Shape, TruthPlant};
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Drive, Plant, Profile, Wiener, WienerParams, run};

const DT_S: f64 = 0.25;

/// Largest difference over the stroke, and in temperature.
fn difference(plant: &TruthPlant, current_a: &[f64], dt_s: f64) -> (f64, f64) {
    let traces = plant.simulate(current_a, dt_s, 1).unwrap();
    let LoopFamily::L2p(hysteresis) = plant.hysteresis else {
        panic!("the cascade has this loop only");
    };
    let rod = RodParams {
        diameter_m: plant.rod.diameter_m,
        density_kg_per_m3: plant.rod.density_kg_per_m3,
        specific_heat_j_per_kg_k: plant.rod.specific_heat_j_per_kg_k,
        resistance_ohm_per_m: plant.rod.resistance_ohm_per_m,
        convective_coefficient_w_per_m2_k: plant.convective_coefficient_w_per_m2_k,
    };
    let params = WienerParams {
        heat: rod.heat_balance().unwrap(),
        limiting_loop: LoopParams {
            loop_center_degc: hysteresis.loop_center_degc,
            loop_half_width_k: hysteresis.loop_half_width_k,
            loop_spread_k: hysteresis.loop_spread_k,
            ..LoopParams::default()
        },
        zeta: hysteresis.zeta,
        gain: 1e3 * plant.stroke_m,
        offset: 1e3 * plant.offset_m,
    };
    let model = Wiener::new(Drive::Current, Rule::LastReversal, &[params]).unwrap();
    let profile = Profile::uniform(current_a, dt_s, plant.ambient_degc).unwrap();
    let mut state = model.rest(plant.ambient_degc);
    let (mut largest, mut largest_k): (f64, f64) = (0.0, 0.0);
    run(&model, &mut state, &profile, |k, output| {
        let difference = output.displacement[0] - traces.displacement_mm[k];
        largest = largest.max(difference.abs() / params.gain);
        let difference_k = output.temperature_degc[0] - traces.temperature_degc[k];
        largest_k = largest_k.max(difference_k.abs());
    });
    (largest, largest_k)
}

fn ramps(n: usize) -> Vec<f64> {
    (0..n)
        .map(|k| 2.2 * (1.0 - (k as f64 / 300.0 % 2.0 - 1.0).abs()))
        .collect()
}

fn inner_loops(n: usize) -> Vec<f64> {
    let current = |k: usize| {
        let phase = k as f64 / 160.0;
        1.5 + 0.5 * phase.sin() * (1.0 - k as f64 / n as f64) + 0.15 * (4.1 * phase).sin()
    };
    (0..n).map(current).collect()
}

fn steps(n: usize) -> Vec<f64> {
    const LEVELS_A: [f64; 7] = [0.0, 2.2, 1.5, 1.9, 0.8, 1.7, 0.0];
    (0..n).map(|k| LEVELS_A[k / 170 % 7]).collect()
}

#[test]
fn the_plain_plant_is_the_cascade() {
    let plant = TruthPlant {
        offset_m: 0.3e-3,
        ..TruthPlant::default()
    };
    for (name, current_a) in [
        ("ramps", ramps(3000)),
        ("inner loops", inner_loops(3000)),
        ("steps", steps(3000)),
    ] {
        let (share, kelvin) = difference(&plant, &current_a, DT_S);
        assert!(share < 1e-7, "{name}: {share:.1e} of the stroke");
        assert!(kelvin < 1e-6, "{name}: {kelvin:.1e} K");
    }
}

#[test]
fn drawn_rods_agree_too() {
    for seed in 0..21 {
        let draw = Draw::new(seed);
        let plant = draw.plant(FamilyKind::L2p, DriveName::Current);
        let shape = Shape::ALL[seed as usize % 7];
        let profile = draw.drive(shape, &plant, 2000);
        let (share, kelvin) = difference(&plant, &profile.drive, profile.dt_s);
        assert!(share < 1e-7, "{seed}, {shape:?}: {share:.1e} of the stroke");
        assert!(kelvin < 1e-6, "{seed}, {shape:?}: {kelvin:.1e} K");
    }
}
