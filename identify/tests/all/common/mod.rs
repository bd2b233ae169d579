//! A rig that the tests share: its rod file, its truth, and recordings generated from it.

use std::ops::ControlFlow;

use identify::{Fit, FitConfig, Rod, WienerModel, fit};
use recording::{Quantity, Recording, RecordingParts};
use rig_files::rod_file;
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Drive, Plant, Profile, Wiener, WienerParams, run};

pub(crate) const ROD: &str = "\
[rod]
diameter_mm = 1.0
length_mm = 200.0
density_kg_per_m3 = 6450.0
specific_heat_j_per_kg_k = 500.0
resistance_ohm_per_m = 1.2

[surroundings]
ambient_degc = 21.0
";

pub(crate) fn rod(text: &str) -> Rod {
    rod_file::parse("rod.toml", text).unwrap()
}

pub(crate) fn truth() -> WienerParams {
    let rod = RodParams {
        diameter_m: 1e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 500.0,
        resistance_ohm_per_m: 1.2,
        convective_coefficient_w_per_m2_k: 90.0,
    };
    WienerParams {
        heat: rod.heat_balance().unwrap(),
        limiting_loop: LoopParams {
            loop_center_degc: 70.0,
            loop_half_width_k: 8.0,
            loop_spread_k: 6.0,
            ..LoopParams::default()
        },
        zeta: 0.8,
        gain: -3.0,
        offset: 0.5,
    }
}

/// Time constant of the truth, s: m C_p/(h A) = ρ d C_p/(4 h).
pub(crate) const TRUE_TAU_S: f64 = 6450.0 * 1e-3 * 500.0 / (4.0 * 90.0);

/// A noise-free recording of the truth from its cold state; `offset` is where its sensor's zero was.
pub(crate) fn recording(name: &str, drive: Vec<f64>, offset: f64) -> Recording {
    let params = WienerParams { offset, ..truth() };
    let model = Wiener::new(Drive::Current, Rule::LastReversal, &[params]).unwrap();
    let profile = Profile::uniform(&drive, 0.25, 21.0).unwrap();
    let mut output = Vec::new();
    run(&model, &mut model.rest(21.0), &profile, |_, shown| {
        output.push(shown.displacement[0])
    });
    Recording::new(RecordingParts {
        name: name.to_owned(),
        time_s: Some((0..drive.len()).map(|k| 0.25 * k as f64).collect()),
        drive_quantity: Quantity::Current,
        drive,
        output_unit: "mm".to_owned(),
        output,
        ..RecordingParts::default()
    })
    .unwrap()
}

/// A recording like `like` with another output.
pub(crate) fn with_output(like: &Recording, unit: &str, output: Vec<f64>) -> Recording {
    Recording::new(RecordingParts {
        name: "b.csv".to_owned(),
        time_s: Some(like.time_s().to_vec()),
        drive: like.drive().to_vec(),
        output_unit: unit.to_owned(),
        output,
        ..RecordingParts::default()
    })
    .unwrap()
}

/// Rest, then triangles of falling height: full strokes and minor loops.
pub(crate) fn triangles(samples: usize, height: f64) -> Vec<f64> {
    (0..samples)
        .map(|k| {
            if k < 20 {
                return 0.0;
            }
            let turns = (k - 20) as f64 / 150.0;
            let fall = 1.0 - 0.08 * turns.floor();
            height * fall * (1.0 - (2.0 * turns.fract() - 1.0).abs())
        })
        .collect()
}

/// Rest, then steps.
pub(crate) fn steps(samples: usize) -> Vec<f64> {
    let levels = [3.8, 1.5, 3.2, 2.4, 4.0, 0.0];
    (0..samples)
        .map(|k| {
            if k < 20 {
                0.0
            } else {
                levels[(k - 20) / 100 % levels.len()]
            }
        })
        .collect()
}

/// The baseline model of a rod file, and its fit from the default settings.
pub(crate) fn fitted(text: &str, training: &[Recording]) -> (WienerModel, Fit) {
    let model = WienerModel::new(&rod(text), Rule::LastReversal, training).unwrap();
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let fit = fit(&model, training, &FitConfig::default(), go_on).unwrap();
    (model, fit)
}
