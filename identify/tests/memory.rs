//! A fit of a long recording needs little more than the recording.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it reads its data"
)]

use std::fmt::Write;
use std::ops::ControlFlow;

use identify::{FitConfig, WienerModel, fit, predict};
use peak_alloc::PeakAlloc;
use recording::{ReadOptions, read_csv};
use rig_files::rod_file;
use wiener::hysteresis::Rule;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

const ROD: &str = "[surroundings]\nambient_degc = 22.0\n";

/// Bytes at the peak of reading, fitting and predicting a recording of so many samples.
fn peak_bytes(n_samples: usize) -> usize {
    let folder = std::env::temp_dir();
    let path = folder.join(format!("memory-{}-{n_samples}.csv", std::process::id()));
    let mut text = "time_s,current_a,displacement_mm\n".to_owned();
    let mut lag = 0.0;
    for k in 0..n_samples {
        let current_a = 1.0 + (0.001 * k as f64).sin();
        lag += 0.01 * (current_a - lag);
        writeln!(text, "{},{current_a:.4},{:.5}", 0.1 * k as f64, lag.tanh()).unwrap();
    }
    std::fs::write(&path, &text).unwrap();
    drop(text);

    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    let training = [read_csv(&path, &ReadOptions::default()).unwrap()];
    std::fs::remove_file(&path).unwrap();
    let rod = rod_file::parse("rod.toml", ROD).unwrap();
    let model = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap();
    let config = FitConfig {
        swarm_iterations: 2,
        starts: 1,
        ..FitConfig::default()
    };
    let fit = fit(&model, &training, &config, &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap();
    let prediction = predict(&model, &fit.point(0), &training[0]).unwrap();
    assert_eq!(prediction.output.len(), n_samples);
    ALLOCATOR.peak_usage() - before
}

#[test]
fn a_sample_costs_less_than_200_bytes() {
    // The difference of two lengths leaves out what does not grow.
    let (short, long) = (50_000, 150_000);
    let growth = peak_bytes(long) - peak_bytes(short);
    let bytes_a_sample = growth as f64 / (long - short) as f64;
    // 82: three columns, which double while they are read, residuals, and the prediction.
    assert!(bytes_a_sample < 100.0, "{bytes_a_sample}");
    assert!(
        bytes_a_sample > 24.0,
        "{bytes_a_sample}: less than the recording itself"
    );
}
