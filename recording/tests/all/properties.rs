//! Laws: what is written reads back exactly, and nothing panics.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(clippy::unwrap_used, clippy::panic)]

use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use recording::{
    ColumnSpec, Columns, NoiseConfig, Quantity, ReadOptions, Recording, RecordingParts, Resistance,
    Sampling, clipping, cycles, holds, inspect, noise_floor, parse_csv, quantization_step, repeats,
    resample, split_by_cycles, write_csv,
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
                prop::option::of(column()),
            ),
            "mm|DEG|N|MPa|1|%||degc|[a-zA-Zµ/·²,;() ]{0,6}",
            prop::option::of(column()),
            prop::option::of(column()),
            prop::option::of(column()),
            prop::option::of(column()),
        )
            .prop_map(
                |(
                    (time_s, drive_quantity, drive, output, antagonist),
                    unit,
                    temperature,
                    ambient,
                    stress,
                    ohm,
                )| {
                    let is_temperature = drive_quantity == Quantity::Temperature;
                    let is_duty = drive_quantity == Quantity::Duty;
                    let driven = |drive: Vec<f64>| match is_duty {
                        true => drive.iter().map(|d| d.sin().abs()).collect(),
                        false => drive,
                    };
                    RecordingParts {
                        name: "generated".to_owned(),
                        time_s,
                        drive_quantity,
                        drive: driven(drive),
                        antagonist_drive: antagonist.filter(|_| !is_temperature).map(driven),
                        drive_unit: String::new(),
                        output_unit: unit,
                        output,
                        temperature_degc: temperature.filter(|_| !is_temperature),
                        ambient_degc: ambient,
                        stress_pa: stress,
                        resistance: ohm.map(Resistance::Ohm),
                        smoothed_noise: 0.0,
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

/// Recordings as a lab makes them: levels held, an output on a comb or not, steps equal or not.
fn driven() -> impl Strategy<Value = RecordingParts> {
    let levels = prop::collection::vec((0_u8..3, 1_usize..30), 2..30);
    let shape = (0.05_f64..20.0, 0.0_f64..0.4, 0.0_f64..0.3, any::<bool>());
    (levels, shape, any::<u32>(), quantity()).prop_map(
        |(levels, (dt_s, jitter, step, with_time), seed, drive_quantity)| {
            let drive: Vec<f64> = levels
                .iter()
                .flat_map(|(level, n)| vec![f64::from(*level) / 2.0; *n])
                .chain([0.0, 0.0])
                .collect();
            let mut state = u64::from(seed);
            let mut uniform = || {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            };
            let times = (0..drive.len())
                .map(|k| (k as f64 + jitter * uniform()) * dt_s)
                .collect();
            let mut y = 0.0_f64;
            let output = drive
                .iter()
                .map(|d| {
                    y += 0.1 * (d - y);
                    let noisy = y + 0.02 * uniform();
                    if step > 0.02 {
                        (noisy / step).round() * step
                    } else {
                        noisy
                    }
                })
                .collect();
            RecordingParts {
                time_s: with_time.then_some(times),
                drive_quantity,
                drive,
                output,
                ..RecordingParts::default()
            }
        },
    )
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn written_recording_reads_back_exactly(parts in parts()) {
        let written = Recording::new(parts).unwrap();
        let mut csv = Vec::new();
        write_csv(&written, &mut csv).unwrap();
        let antagonist = format!("antagonist_{}", written.drive_quantity().column());
        let columns = Columns {
            antagonist: written.antagonist_drive().map(|_| ColumnSpec::name(antagonist)),
            ..Columns::default()
        };
        let options = ReadOptions {
            allow_untimed: true,
            columns,
            ..ReadOptions::new(written.drive_quantity())
        };
        let read = parse_csv(csv.as_slice(), "generated", &options).unwrap();
        prop_assert_eq!(bits(read.time_s()), bits(written.time_s()));
        prop_assert_eq!(bits(read.drive()), bits(written.drive()));
        prop_assert_eq!(bits(read.output()), bits(written.output()));
        // Names, units, sampling and the rest; -0 equals 0 here, hence the bits above.
        prop_assert_eq!(read, written);
    }

    #[test]
    fn anything_can_be_inspected(parts in prop_oneof![parts(), driven()], hold_s in number()) {
        let recording = Recording::new(parts).unwrap();
        for warning in inspect(&recording).warnings() {
            prop_assert!(!warning.to_string().contains("NaN"), "{warning}");
        }
        if let Some(step) = quantization_step(recording.output()) {
            prop_assert!(step > 0.0 && step.is_finite());
        }
        prop_assert!(clipping(recording.output()).iter().all(|flat| flat.samples >= flat.longest));
        let config = NoiseConfig { hold_s, settle_s: hold_s / 2.0 };
        if let Some(floor) = noise_floor(&recording, config) {
            let (lower, upper) = (floor.lower(), floor.upper().unwrap_or(f64::MAX));
            prop_assert!(lower >= 0.0 && upper.is_finite() && lower <= upper, "{floor:?}");
            let correlation = floor.holds.map_or(0.0, |holds| holds.lag1_autocorrelation);
            prop_assert!((-1.0..=1.0).contains(&correlation));
        }
        for hold in holds(&recording, hold_s) {
            prop_assert!(hold.duration_s > hold_s && hold.samples.end <= recording.len());
        }
    }

    #[test]
    fn splits_cover_without_overlap(parts in prop_oneof![parts(), driven()], n_parts in 1_usize..9) {
        let recording = Recording::new(parts).unwrap();
        let cycles = cycles(&recording);
        prop_assert!(cycles.windows(2).all(|pair| pair[0].samples.end == pair[1].samples.start));
        prop_assert!(cycles.iter().all(|cycle| cycle.samples.start < cycle.samples.end));
        if let Some(repeats) = repeats(&recording) {
            let ordered = |pair: &[recording::Cycle]| pair[0].samples.end <= pair[1].samples.start;
            prop_assert!(repeats.cycles.len() >= 2 && repeats.cycles.windows(2).all(ordered));
            prop_assert!(repeats.cycles.iter().all(|cycle| cycle.samples.end <= recording.len()));
        }
        match split_by_cycles(&recording, n_parts) {
            Ok(ranges) => {
                prop_assert_eq!(ranges.len(), n_parts);
                let covered: Vec<usize> = ranges.iter().cloned().flatten().collect();
                let all: Vec<usize> = (0..recording.len()).collect();
                prop_assert_eq!(covered, all);
                for range in ranges {
                    let holds_cycle = cycles.iter().any(|cycle| {
                        range.start <= cycle.samples.start && cycle.samples.end <= range.end
                    });
                    prop_assert!(holds_cycle || n_parts == 1);
                    if range.len() >= 2 {
                        let part = recording.slice(range.clone()).unwrap();
                        prop_assert_eq!(bits(part.output()), bits(&recording.output()[range]));
                    }
                }
            }
            Err(_) => prop_assert!(n_parts > cycles.len().max(1)),
        }
    }

    #[test]
    fn resampling_never_panics_nor_invents(parts in prop_oneof![parts(), driven()], dt_s in number()) {
        let recording = Recording::new(parts).unwrap();
        let steps = match recording.sampling() {
            Sampling::Uniform { dt_s: own } => vec![dt_s, own, 2.0 * own, 3.7 * own],
            Sampling::Jittered { median_dt_s: own, .. } => vec![dt_s, own, 2.0 * own],
            _ => vec![dt_s],
        };
        for dt_s in steps {
            if let Ok(slow) = resample(&recording, dt_s) {
                prop_assert_eq!(slow.time_s()[0].to_bits(), recording.time_s()[0].to_bits());
                let largest = |run: &Recording| run.drive().iter().fold(0.0, |a: f64, d| a.max(d.abs()));
                prop_assert!(largest(&slow) <= largest(&recording));
            }
        }
    }

    #[test]
    fn a_slice_of_an_equal_grid_is_one(start in 0_usize..90, n in 2_usize..10, dt in 0.01_f64..3.0) {
        let stamp = |k: usize| ((k as f64 * dt) * 1000.0).round() / 1000.0;
        let part = timed((0..100).map(stamp).collect()).slice(start..start + n).unwrap();
        let uniform = matches!(part.sampling(), Sampling::Uniform { .. });
        prop_assert!(uniform);
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
