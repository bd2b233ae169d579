//! Any residuals as noise with a memory: its description is finite, or none is made.
#![no_main]

use identify::ResidualNoise;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|drawn: (i8, Vec<i32>, Vec<i8>)| {
    let (exponent, large, small) = drawn;
    let scale = 10f64.powi(i32::from(exponent));
    let large: Vec<f64> = large
        .iter()
        .map(|&value| f64::from(value) * scale)
        .collect();
    let small: Vec<f64> = small
        .iter()
        .map(|&value| f64::from(value) * scale)
        .collect();
    let noise = ResidualNoise::of(&[&large, &small]);
    let text = format!("{noise:?}");
    assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
});
