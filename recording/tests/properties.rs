//! Laws: what is written reads back exactly, and nothing panics.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(clippy::unwrap_used, clippy::panic)]

use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use recording::{
    ColumnSpec, Columns, Quantity, ReadOptions, Recording, RecordingParts, Sampling, parse_csv,
    write_csv,
};

/// Finite numbers of every magnitude.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO,
        4 => -100.0..100.0,
        1 => (-1000_i32..1000).prop_map(f64::from),
    ]
}

fn quantity() -> impl Strategy<Value = Quantity> {
    prop::sample::select(vec![
        Quantity::Current,
        Quantity::Duty,
        Quantity::Voltage,
        Quantity::Power,
        Quantity::Temperature,
    ])
}

/// Times as loggers write them: a grid, full or rounded, or anything that rises.
fn times(n: usize) -> impl Strategy<Value = Vec<f64>> {
    let grid = (0.001..10.0, 0_i32..9, any::<bool>()).prop_map(move |(dt, decimals, rounded)| {
        let scale = 10_f64.powi(decimals);
        let print = |t: f64| {
            if rounded {
                (t * scale).round() / scale
            } else {
                t
            }
        };
        (0..n).map(|k| print(k as f64 * dt)).collect()
    });
    prop_oneof![grid, prop::collection::vec(number(), n)].prop_map(|mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        let rises = times.windows(2).all(|pair| pair[1] > pair[0]);
        if rises {
            times
        } else {
            (0..times.len()).map(|k| k as f64 * 0.3).collect()
        }
    })
}

fn parts() -> impl Strategy<Value = RecordingParts> {
    (2_usize..40).prop_flat_map(|n| {
        let column = || prop::collection::vec(number(), n);
        (
            (
                prop::option::weighted(0.8, times(n)),
                quantity(),
                column(),
                column(),
            ),
            "mm|DEG|N|MPa|1|%||degc|[a-zA-Zµ/·²,;() ]{0,6}",
            prop::option::of(column()),
            prop::option::of(column()),
        )
            .prop_map(
                |((time_s, drive_quantity, drive, output), unit, temperature, ambient)| {
                    let is_temperature = drive_quantity == Quantity::Temperature;
                    let is_duty = drive_quantity == Quantity::Duty;
                    RecordingParts {
                        name: "generated".to_owned(),
                        time_s,
                        drive_quantity,
                        drive: if is_duty {
                            drive.iter().map(|d| d.sin().abs()).collect()
                        } else {
                            drive
                        },
                        output_unit: unit,
                        output,
                        temperature_degc: temperature.filter(|_| !is_temperature),
                        ambient_degc: ambient,
                    }
                },
            )
    })
}

/// Keeps failed cases beside this file, to be committed.
fn config() -> ProptestConfig {
    let file = FileFailurePersistence::Direct("tests/properties.proptest-regressions");
    ProptestConfig::with_failure_persistence(file)
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn written_recording_reads_back_exactly(parts in parts()) {
        let written = Recording::new(parts).unwrap();
        let mut csv = Vec::new();
        write_csv(&written, &mut csv).unwrap();
        let options =
            ReadOptions { allow_untimed: true, ..ReadOptions::new(written.drive_quantity()) };
        let read = parse_csv(csv.as_slice(), "generated", &options).unwrap();
        prop_assert_eq!(bits(read.time_s()), bits(written.time_s()));
        prop_assert_eq!(bits(read.drive()), bits(written.drive()));
        prop_assert_eq!(bits(read.output()), bits(written.output()));
        // Names, units, sampling and the rest; -0 equals 0 here, hence the bits above.
        prop_assert_eq!(read, written);
    }

    #[test]
    fn byte_soup_never_panics(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        read_every_way(&bytes);
    }

    #[test]
    fn csv_soup_never_panics(
        soup in "((\u{feff}|time_s|duty|position_mm|[0-9]{1,3}|[-+.e]|nan|\"|[,;\t #]|\r?\n|µ|\\[|\\]){0,12}\n){0,12}"
    ) {
        read_every_way(soup.as_bytes());
    }

    #[test]
    fn rounded_grid_is_uniform(
        n in 3_usize..400,
        start in 0_u32..100_000,
        dt in 0.05_f64..5.0,
        decimals in 2_i32..8,
    ) {
        // A step of at least five resolutions: coarser stamps are not claimed.
        let scale: f64 = 10_f64.powi(decimals);
        prop_assume!(dt * scale >= 5.0);
        let stamp = |k: usize| ((f64::from(start) + k as f64 * dt) * scale).round() / scale;
        let recording = timed((0..n).map(stamp).collect());
        let uniform = matches!(recording.sampling(), Sampling::Uniform { .. });
        prop_assert!(uniform);
        prop_assert!(recording.gaps().is_empty());
    }

    #[test]
    fn lost_sample_is_not_uniform(
        n in 4_usize..400,
        lost in 1_usize..400,
        dt in 0.05_f64..5.0,
        decimals in 0_i32..8,
    ) {
        let lost = 1 + lost % (n - 2);
        let scale: f64 = 10_f64.powi(decimals);
        prop_assume!(dt * scale >= 1.0);
        let stamp = |k: usize| (k as f64 * dt * scale).round() / scale;
        let recording = timed((0..=n).filter(|&k| k != lost).map(stamp).collect());
        let jittered = matches!(recording.sampling(), Sampling::Jittered { .. });
        prop_assert!(jittered);
    }
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

fn timed(time_s: Vec<f64>) -> Recording {
    let n = time_s.len();
    let parts = RecordingParts {
        time_s: Some(time_s),
        drive: vec![0.0; n],
        output: vec![0.0; n],
        ..RecordingParts::default()
    };
    Recording::new(parts).unwrap()
}

fn read_every_way(bytes: &[u8]) {
    let numbered = Columns {
        drive: Some(ColumnSpec::number(1).in_unit("v")),
        output: Some(ColumnSpec::number(2)),
        ..Columns::default()
    };
    let voltage = ReadOptions {
        columns: numbered,
        allow_untimed: true,
        ..ReadOptions::new(Quantity::Voltage)
    };
    for options in [ReadOptions::new(Quantity::Duty), voltage] {
        match parse_csv(bytes, "soup", &options) {
            Ok(recording) => assert!(recording.drive().iter().all(|drive| drive.is_finite())),
            Err(fault) => assert!(fault.to_string().starts_with("soup")),
        }
    }
}
