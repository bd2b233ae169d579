//! Every addition shows at its typical size, and vanishes with it.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test may end in a panic"
)]

use truth_plant::{Addition, TruthPlant};

const DT_S: f64 = 0.2;
const SAMPLES: usize = 2400;

/// A slow triangle, inner loops, squares: 480 s.
fn drive() -> Vec<f64> {
    let level = |k: usize| {
        let t = k as f64 * DT_S;
        match t {
            _ if t < 20.0 => 0.0,
            _ if t < 80.0 => 2.2 * (t - 20.0) / 60.0,
            _ if t < 140.0 => 2.2 * (140.0 - t) / 60.0,
            _ if t < 320.0 => 1.45 + 0.35 * (0.35 * (t - 140.0)).sin(),
            _ if t < 440.0 => 2.2 * ((t - 320.0) / 20.0 % 2.0).floor(),
            _ => 0.0,
        }
    };
    (0..SAMPLES).map(level).collect()
}

fn displacement(plant: &TruthPlant) -> Vec<f64> {
    plant
        .simulate(&drive(), DT_S, 3)
        .unwrap()
        .quiet_displacement_mm
}

/// The plant in which the addition is the only news.
fn base(addition: Addition) -> TruthPlant {
    let mut plant = TruthPlant::default();
    if matches!(addition, Addition::SpringChange | Addition::MountSlip) {
        let mut with_spring = plant.clone();
        Addition::StressCoupling.install(&mut with_spring, 1.0, 480.0);
        plant.bias_spring = with_spring.bias_spring;
    }
    plant
}

/// Root mean square and largest difference over the stroke.
fn difference(a: &[f64], b: &[f64]) -> (f64, f64) {
    let stroke_mm = 1e3 * TruthPlant::default().stroke_m;
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs() / stroke_mm);
    let squares: f64 = differences.clone().map(|d| d * d).sum();
    (
        (squares / a.len() as f64).sqrt(),
        differences.fold(0.0, f64::max),
    )
}

#[test]
fn shows_at_its_typical_size_and_vanishes_at_none() {
    for addition in Addition::ALL {
        let base = base(addition);
        let with = |size: f64| {
            let mut plant = base.clone();
            addition.install(&mut plant, size, SAMPLES as f64 * DT_S);
            plant.simulate(&drive(), DT_S, 3).unwrap()
        };
        let plain = displacement(&base);
        let (rms, largest) = difference(&plain, &with(1.0).quiet_displacement_mm);
        let (_, none) = difference(&plain, &with(0.0).quiet_displacement_mm);
        let (small, _) = difference(&plain, &with(0.1).quiet_displacement_mm);
        assert!(
            none < 2e-6,
            "{addition:?} at size 0 moves the output by {none:e}"
        );
        if addition == Addition::Thermocouple {
            assert!(rms < 1e-7, "the bead takes no heat from the rod");
            let traces = with(1.0);
            let lag = traces
                .thermocouple_degc
                .iter()
                .zip(&traces.temperature_degc);
            let largest_k = lag.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!((2.0..40.0).contains(&largest_k), "{largest_k}");
            continue;
        }
        assert!(
            (0.002..0.4).contains(&rms),
            "{addition:?}: {rms} of the stroke"
        );
        assert!(largest < 0.95, "{addition:?}: {largest} of the stroke");
        if addition != Addition::NestedMemory {
            assert!(
                small < 0.5 * rms,
                "{addition:?}: {small} at a tenth, {rms} at 1"
            );
        }
    }
}

#[test]
fn halving_the_tolerance_moves_nothing_that_counts() {
    for addition in Addition::ALL {
        let mut plant = base(addition);
        addition.install(&mut plant, 1.0, SAMPLES as f64 * DT_S);
        let coarse = displacement(&plant);
        plant.tolerance_k *= 0.5;
        plant.longest_step_s = DT_S / 37.0;
        let (_, largest) = difference(&coarse, &displacement(&plant));
        assert!(largest < 1e-6, "{addition:?}: {largest:e} of the stroke");
    }
}
