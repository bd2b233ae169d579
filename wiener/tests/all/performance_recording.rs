//! A recording that another program simulated from a known truth: the truth must explain it down to
//! its noise.

#![allow(clippy::expect_used, reason = "a test may end in a panic")]

use std::path::Path;

use fixtures::shared;
use serde_json::Value;
use sma_hysteresis::{LoopParams, Rule};
use sma_thermal::{HeatBalanceParams, ThermalConstants};
use wiener::{Drive, Plant, Profile, Wiener, WienerParams, run};

/// Names of the parameters in the order of their values.
const NAMES: [&str; 8] = [
    "tau_s",
    "lambda_C_per_A2",
    "Tm_C",
    "Tc_C",
    "h0_C",
    "zeta",
    "gain_mm",
    "offset_mm",
];

fn number(truth: &Value, key: &str) -> f64 {
    truth[key].as_f64().expect("a number")
}

fn true_params(truth: &Value) -> WienerParams {
    let names = truth["names"].as_array().expect("names");
    assert_eq!(names, &NAMES.map(Value::from));
    let values = truth["true"].as_array().expect("values");
    assert_eq!(values.len(), NAMES.len());
    let [tau, lambda, center, half_width, spread, zeta, gain, offset] =
        std::array::from_fn(|k| values[k].as_f64().expect("a number"));
    WienerParams {
        heat: HeatBalanceParams::from_constants(ThermalConstants {
            tau_s: tau,
            lambda_k_per_a2: lambda,
        }),
        limiting_loop: LoopParams {
            loop_center_degc: center,
            loop_half_width_k: half_width,
            loop_spread_k: spread,
            fraction_center: number(truth, "x0"),
            fraction_swing: number(truth, "xs"),
        },
        zeta,
        gain,
        offset,
    }
}

/// Currents, A, and displacements, mm.
fn read(path: &Path) -> (Vec<f64>, Vec<f64>) {
    let text = std::fs::read_to_string(path).expect("the recording is readable");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time_s,current_A,displacement_mm"));
    lines
        .map(|line| {
            let fields: Vec<f64> = line
                .split(',')
                .map(|field| field.parse().expect("a number"))
                .collect();
            assert_eq!(fields.len(), 3, "{line}");
            (fields[1], fields[2])
        })
        .unzip()
}

#[test]
fn the_truth_leaves_only_the_noise() {
    let (Some(recording), Some(truth)) = (
        shared::path("performance/recording.csv"),
        shared::path("performance/truth.json"),
    ) else {
        return;
    };
    let text = std::fs::read_to_string(truth).expect("the truth is readable");
    let truth: Value = serde_json::from_str(&text).expect("the truth is JSON");
    let (currents_a, displacements_mm) = read(&recording);
    assert_eq!(Some(currents_a.len() as u64), truth["N"].as_u64());

    let model = Wiener::new(Drive::Current, Rule::LastReversal, &[true_params(&truth)]).unwrap();
    let ambient_degc = number(&truth, "Ta_C");
    let profile = Profile::uniform(&currents_a, number(&truth, "dt_s"), ambient_degc).unwrap();
    let mut sum_of_squares = 0.0;
    let mut range_degc = [f64::INFINITY, f64::NEG_INFINITY];
    run(
        &model,
        &mut model.rest(ambient_degc),
        &profile,
        |k, output| {
            let residual_mm = output.displacement[0] - displacements_mm[k];
            sum_of_squares += residual_mm * residual_mm;
            let [temperature_degc] = output.temperature_degc;
            range_degc = [
                range_degc[0].min(temperature_degc),
                range_degc[1].max(temperature_degc),
            ];
        },
    );
    let mse_mm2 = sum_of_squares / displacements_mm.len() as f64;

    assert_eq!(format!("{mse_mm2:.4e}"), "1.1292e-4");
    let expected_mm2 = number(&truth, "mse_at_truth_mm2");
    let deviation = mse_mm2 / expected_mm2 - 1.0;
    assert!(deviation.abs() < 1e-9, "{mse_mm2:e}: off by {deviation:e}");
    for (found, expected) in range_degc
        .iter()
        .zip(truth["T_range_C"].as_array().unwrap())
    {
        assert!((found - expected.as_f64().unwrap()).abs() < 1e-9, "{found}");
    }
}
