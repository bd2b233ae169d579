//! Makes the bundled recordings: a rod of known parameters, driven by two different currents, seen
//! through a noisy sensor with a 12-bit converter.
//!
//! `cargo run -p sma-cli --example generate_recording` writes them into `sma-cli/bundled`.

use std::error::Error;
use std::path::Path;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};
use recording::{Quantity, Recording, RecordingParts, write_csv};
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Drive, Plant, Profile, Wiener, WienerParams, run};

/// Sample time, s.
const DT_S: f64 = 0.2;
/// Temperature of the surroundings, °C.
const AMBIENT_DEGC: f64 = 22.0;
/// Standard deviation of the sensor's noise, mm.
const NOISE_MM: f64 = 0.005;
/// Step of a 12-bit converter over 5 mm, mm.
const CONVERTER_STEP_MM: f64 = 5.0 / 4096.0;

type Made<T> = Result<T, Box<dyn Error>>;

/// True parameters of the rod.
pub(crate) fn truth() -> Made<WienerParams> {
    let rod = RodParams {
        diameter_m: 1.2e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 480.0,
        resistance_ohm_per_m: 0.83,
        convective_coefficient_w_per_m2_k: 75.0,
    };
    Ok(WienerParams {
        heat: rod.heat_balance()?,
        limiting_loop: LoopParams {
            loop_center_degc: 66.0,
            loop_half_width_k: 9.0,
            loop_spread_k: 5.0,
            ..LoopParams::default()
        },
        zeta: 0.85,
        gain: 4.2,
        offset: 0.3,
    })
}

/// A current given by its corners: time, s, and current, A; straight between them.
fn current(corners: &[(f64, f64)]) -> Vec<f64> {
    let end_s = corners.last().map_or(0.0, |corner| corner.0);
    let samples = (end_s / DT_S).round() as usize;
    (0..samples)
        .map(|k| {
            let time_s = k as f64 * DT_S;
            let next = corners
                .iter()
                .position(|corner| corner.0 > time_s)
                .unwrap_or(corners.len() - 1);
            let ((t0, i0), (t1, i1)) = (corners[next - 1], corners[next]);
            let exact = i0 + (i1 - i0) * (time_s - t0) / (t1 - t0);
            // A supply set in steps of 1 mA.
            (exact * 1e3).round() / 1e3
        })
        .collect()
}

/// Slow ramps, fast ones, steps, and minor loops.
fn training_current() -> Vec<f64> {
    current(&[
        (0.0, 0.0),
        (10.0, 0.0),
        (70.0, 5.4),
        (90.0, 5.4),
        (150.0, 0.0),
        (170.0, 0.0),
        (170.1, 5.0),
        (210.0, 5.0),
        (210.1, 2.5),
        (240.0, 2.5),
        (255.0, 5.2),
        (275.0, 3.6),
        (290.0, 4.7),
        (305.0, 3.9),
        (325.0, 4.9),
        (325.1, 0.0),
        (400.0, 0.0),
    ])
}

/// A staircase and a sawtooth, neither of them in the training data.
fn validation_current() -> Vec<f64> {
    current(&[
        (0.0, 0.0),
        (10.0, 0.0),
        (10.1, 3.5),
        (45.0, 3.5),
        (45.1, 4.4),
        (80.0, 4.4),
        (80.1, 5.2),
        (110.0, 5.2),
        (110.1, 4.0),
        (150.0, 4.0),
        (150.1, 0.0),
        (190.0, 0.0),
        (215.0, 5.5),
        (215.1, 3.0),
        (240.0, 5.0),
        (240.1, 3.4),
        (260.0, 4.6),
        (260.1, 0.0),
        (320.0, 0.0),
    ])
}

/// One bundled file: a comment that says what it is, then the recording.
fn csv(name: &str, drive: Vec<f64>, seed: u64) -> Made<Vec<u8>> {
    let model = Wiener::new(Drive::Current, Rule::LastReversal, &[truth()?])?;
    let mut output = Vec::with_capacity(drive.len());
    run(
        &model,
        &mut model.rest(AMBIENT_DEGC),
        &Profile::uniform(&drive, DT_S, AMBIENT_DEGC)?,
        |_, shown| output.push(shown.displacement[0]),
    );
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, NOISE_MM)?;
    for value in &mut output {
        let codes = ((*value + noise.sample(&mut rng)) / CONVERTER_STEP_MM).round();
        // Microns are more than the converter resolves.
        *value = (codes * CONVERTER_STEP_MM * 1e6).round() / 1e6;
    }
    let recording = Recording::new(RecordingParts {
        name: name.to_owned(),
        time_s: Some(
            (0..drive.len())
                .map(|k| (k as f64 * DT_S * 10.0).round() / 10.0)
                .collect(),
        ),
        drive_quantity: Quantity::Current,
        drive,
        output_unit: "mm".to_owned(),
        output,
        ..RecordingParts::default()
    })?;
    let mut bytes =
        b"# Generated, not measured: cargo run -p sma-cli --example generate_recording\n".to_vec();
    write_csv(&recording, &mut bytes)?;
    Ok(bytes)
}

/// The bundled recordings: file name and content.
pub(crate) fn files() -> Made<Vec<(&'static str, Vec<u8>)>> {
    Ok(vec![
        ("train.csv", csv("train.csv", training_current(), 1)?),
        (
            "validate.csv",
            csv("validate.csv", validation_current(), 2)?,
        ),
    ])
}

#[allow(
    dead_code,
    reason = "the test that includes this file has its own main"
)]
fn main() -> Made<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("bundled");
    for (name, bytes) in files()? {
        std::fs::write(folder.join(name), bytes)?;
    }
    Ok(())
}
