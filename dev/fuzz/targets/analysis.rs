//! Any recording, and all that is computed of one without a model: nothing panics, and no number is none.
#![no_main]

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use recording::{
    NoiseConfig, Quantity, Recording, RecordingParts, clipping, cycles, drive_noise,
    drive_resolution, has_one_rate, holds, inspect, mended, noise_floor, quantization_step,
    repeat_floor, repeats, resample, slips, stuck, wild,
};

#[derive(Debug, Arbitrary)]
struct Drawn {
    quantity: u8,
    is_timed: bool,
    /// Steps of the time, some of them gaps.
    dt: u16,
    exponent: i8,
    rows: Vec<(u8, i16, i16)>,
}

fuzz_target!(|drawn: Drawn| {
    if drawn.rows.len() > 500 {
        return;
    }
    let scale = 10f64.powi(i32::from(drawn.exponent % 40));
    let quantity = match drawn.quantity % 4 {
        0 => Quantity::Current,
        1 => Quantity::Voltage,
        2 => Quantity::Power,
        _ => Quantity::Temperature,
    };
    let mut time_s = 0.0;
    let time = drawn.rows.iter().map(|row| {
        time_s += f64::from(drawn.dt.max(1))
            * 1e-3
            * f64::from(1 + u32::from(row.0 / 64) * u32::from(row.0 % 8));
        time_s
    });
    let time: Vec<f64> = time.collect();
    let parts = RecordingParts {
        name: "drawn".to_owned(),
        time_s: drawn.is_timed.then_some(time),
        drive_quantity: quantity,
        drive: drawn
            .rows
            .iter()
            .map(|row| f64::from(row.1) * 1e-2)
            .collect(),
        output_unit: "mm".to_owned(),
        output: drawn
            .rows
            .iter()
            .map(|row| f64::from(row.2) * scale)
            .collect(),
        ..RecordingParts::default()
    };
    let Ok(recording) = Recording::new(parts) else {
        return;
    };
    let seen = inspect(&recording);
    for warning in seen.warnings() {
        let text = warning.to_string();
        assert!(!text.contains("NaN"), "{text}");
    }
    if let Some(floor) = noise_floor(&recording, NoiseConfig::default()) {
        assert!(floor.lower() >= 0.0);
    }
    let repaired = mended(&recording);
    assert_eq!(repaired.len(), recording.len());
    assert!(repaired.output().iter().all(|value| value.is_finite()));
    assert!(repaired.drive().iter().all(|value| value.is_finite()));
    for one in wild(&recording) {
        assert!(!one.samples.is_empty());
    }
    let _ = (
        slips(&recording),
        stuck(&recording),
        drive_noise(&recording),
        clipping(recording.output()),
    );
    let _ = (
        cycles(&recording),
        repeats(&recording),
        holds(&recording, 1.0),
    );
    let _ = (quantization_step(recording.output()), recording.gaps());
    let resolution = drive_resolution(&recording);
    assert!(
        resolution
            .step
            .is_none_or(|step| step > 0.0 && step.is_finite())
    );
    assert!(
        resolution
            .dead_zone
            .is_none_or(|edge| edge > 0.0 && edge.is_finite())
    );
    let pair = [recording.clone(), recording.clone()];
    let _ = (
        has_one_rate(&pair),
        repeat_floor(&pair).map(|floor| floor.rms()),
    );
    if drawn.is_timed
        && let Ok(even) = resample(&recording, 0.5)
    {
        assert!(even.output().iter().all(|value| value.is_finite()));
    }
});
