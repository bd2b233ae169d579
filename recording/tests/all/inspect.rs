//! Findings in synthetic signals, of which everything is known.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::f64::consts::{PI, SQRT_2};

use recording::{
    DifferenceNoise, NoiseConfig, NoiseFloor, Quantity, Recording, RecordingParts, Resistance,
    Side, Warning, clipping, cycles, holds, inspect, noise_floor, quantization_step, repeats,
    resample, split_by_cycles,
};

/// Normal numbers of a small generator: the sum of twelve uniform ones, less six.
pub(crate) struct Noise(pub(crate) u64);

impl Noise {
    pub(crate) fn uniform(&mut self) -> f64 {
        // Knuth's linear congruential generator; its upper bits serve.
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

pub(crate) fn recording(dt_s: f64, drive: Vec<f64>, output: Vec<f64>) -> Recording {
    Recording::new(RecordingParts {
        name: "run3.csv".to_owned(),
        time_s: Some((0..drive.len()).map(|k| k as f64 * dt_s).collect()),
        drive,
        output_unit: "mm".to_owned(),
        output,
        ..RecordingParts::default()
    })
    .unwrap()
}

/// Time stamps that wander by up to 30 % of the step.
fn jittered(dt_s: f64, n: usize, noise: &mut Noise) -> Vec<f64> {
    (0..n)
        .map(|k| (k as f64 + 0.6 * (noise.uniform() - 0.5)) * dt_s)
        .collect()
}

/// `n_rest` samples at rest, then pulses: on for `n_on` of every `n_period`.
fn pulses(n: usize, n_rest: usize, n_on: usize, n_period: usize) -> Vec<f64> {
    let on = |k: usize| k >= n_rest && (k - n_rest) % n_period < n_on;
    (0..n).map(|k| if on(k) { 1.8 } else { 0.0 }).collect()
}

/// First-order response to the square of the drive.
pub(crate) fn response(drive: &[f64], dt_s: f64, tau_s: f64) -> Vec<f64> {
    let mut y = 0.0;
    let each = drive.iter().map(|i| {
        let measured = y;
        y += (i * i - y) * (1.0 - (-dt_s / tau_s).exp());
        measured
    });
    each.collect()
}

fn assert_within(found: f64, expected: f64, share: f64) {
    assert!(
        (found - expected).abs() <= share * expected.abs(),
        "{found} is not {expected} within {share}"
    );
}

#[test]
fn quantization_step_is_found_exactly() {
    let mut noise = Noise(1);
    let signal: Vec<f64> = (0..2000)
        .map(|k| 3.0 * (f64::from(k) / 150.0).sin() + 0.004 * noise.normal())
        .collect();
    for step in [0.0206, 0.0012207, 5.0 / 4096.0, 0.01, 0.02, 0.1 / 3.0] {
        for offset in [0.0, 0.3777] {
            let quantized = |y: &f64| (y / step).round() * step + offset;
            let values: Vec<f64> = signal.iter().map(quantized).collect();
            assert_within(quantization_step(&values).unwrap(), step, 1e-9);
            // As a file would have it.
            for decimals in [4, 6] {
                let scale = 10_f64.powi(decimals);
                let printed: Vec<f64> =
                    values.iter().map(|y| (y * scale).round() / scale).collect();
                // Within the resolution over the range: a step of 12 units of the last digit is
                // off by less than 1e-4 of itself.
                assert_within(quantization_step(&printed).unwrap(), step, 1e-4);
            }
        }
    }
}

#[test]
fn stray_values_do_not_hide_the_step() {
    let mut noise = Noise(2);
    let mut values: Vec<f64> = (0..3000)
        .map(|k| {
            ((2.0 * (f64::from(k) / 99.0).sin() + 0.02 * noise.normal()) / 0.0206).round() * 0.0206
        })
        .collect();
    for k in [300, 1700, 2900] {
        values[k] += 0.007;
    }
    assert_within(quantization_step(&values).unwrap(), 0.0206, 1e-3);
}

#[test]
fn no_step_is_seen_where_there_is_none() {
    let mut noise = Noise(3);
    let smooth: Vec<f64> = (0..4000).map(|_| noise.normal()).collect();
    assert_eq!(quantization_step(&smooth), None);
    let printed: Vec<f64> = smooth.iter().map(|y| (y * 1e6).round() / 1e6).collect();
    assert_eq!(quantization_step(&printed), None);
    assert_eq!(quantization_step(&[]), None);
    assert_eq!(quantization_step(&[1.0; 50]), None);
    assert_eq!(quantization_step(&[1.0, 2.0, 3.0, f64::NAN]), None);
    // Few levels at random, each seen often.
    let levels: Vec<f64> = (0..7).map(|_| noise.normal()).collect();
    let values: Vec<f64> = (0..700).map(|k| levels[k % 7]).collect();
    assert_eq!(quantization_step(&values), None);
}

#[test]
fn clipping_is_found_on_its_side() {
    let mut noise = Noise(4);
    let signal: Vec<f64> = (0..3000)
        .map(|k| (f64::from(k) / 60.0).sin() + 0.01 * noise.normal())
        .collect();
    assert_eq!(clipping(&signal), []);
    let clipped: Vec<f64> = signal.iter().map(|y| y.min(0.8)).collect();
    let [flat] = clipping(&clipped)[..] else {
        panic!("{:?}", clipping(&clipped))
    };
    assert_eq!(flat.side, Side::Highest);
    assert_within(flat.at, 0.8, 1e-15);
    assert_eq!(flat.samples, signal.iter().filter(|y| **y >= 0.8).count());
    assert_eq!(Some(flat.first), signal.iter().position(|y| *y >= 0.8));
    assert!(flat.occasions >= 8 && flat.longest > 40, "{flat:?}");
    let both: Vec<f64> = signal.iter().map(|y| y.clamp(-0.9, 0.8)).collect();
    let sides: Vec<Side> = clipping(&both).iter().map(|flat| flat.side).collect();
    assert_eq!(sides, [Side::Lowest, Side::Highest]);
}

#[test]
fn quantized_plateaus_are_not_clipping() {
    let mut noise = Noise(5);
    for (step, noise_share) in [(0.02, 0.6), (0.02, 0.0), (0.1, 0.3), (0.005, 2.0)] {
        let values: Vec<f64> = (0..4000)
            .map(|k| {
                let y = (f64::from(k) / 90.0).sin() + noise_share * step * noise.normal();
                (y / step).round() * step
            })
            .collect();
        assert_eq!(clipping(&values), [], "step {step}, noise {noise_share}");
    }
    assert_eq!(clipping(&[2.0; 100]), []);
    assert_eq!(clipping(&[0.0, 1.0, f64::NAN]), []);
}

#[test]
fn holds_are_the_stretches_of_constant_drive() {
    let mut drive = vec![0.0; 100];
    drive.extend((0..200).map(|k| f64::from(k) / 200.0));
    // Ripple below a hundredth of the range.
    drive.extend((0..300).map(|k| if k % 2 == 0 { 1.0 } else { 0.995 }));
    drive.extend([0.0; 50]);
    let n = drive.len();
    let found = holds(&recording(0.5, drive, vec![0.0; n]), 20.0);
    let ranges: Vec<_> = found.iter().map(|hold| hold.samples.clone()).collect();
    assert_eq!(ranges.len(), 3, "{found:?}");
    // The ramp's first steps are below the tolerance.
    assert_eq!(ranges[0], 0..103);
    assert!(ranges[1].start.abs_diff(300) <= 3 && ranges[1].end == 600);
    assert_eq!(ranges[2], 600..650);
    assert_within(found[1].drive, 0.995, 0.005);
    assert_within(found[2].duration_s, 24.5, 1e-9);
    let n_nan = holds(&recording(0.5, vec![0.0; 9], vec![0.0; 9]), f64::NAN).len();
    assert_eq!(n_nan, 0);
}

#[test]
fn an_antagonist_that_moves_ends_a_hold_and_a_rest() {
    let drive = pulses(600, 300, 300, 400);
    let antagonist = pulses(600, 100, 400, 900);
    let pair = Recording::new(RecordingParts {
        time_s: Some((0..600).map(|k| 0.5 * f64::from(k)).collect()),
        output: vec![0.0; 600],
        drive,
        antagonist_drive: Some(antagonist),
        ..RecordingParts::default()
    })
    .unwrap();
    let ranges: Vec<_> = holds(&pair, 20.0)
        .into_iter()
        .map(|hold| hold.samples)
        .collect();
    assert_eq!(ranges, [0..100, 100..300, 300..500, 500..600]);
    let found = inspect(&pair);
    assert_eq!(found.rest_samples, 100);
    let antagonist = found.antagonist.unwrap();
    assert_eq!((antagonist.role, antagonist.highest), ("antagonist", 1.8));
}

#[test]
fn a_gap_ends_a_hold() {
    let time_s = (0..100).map(|k| {
        if k < 50 {
            f64::from(k)
        } else {
            f64::from(k) + 40.0
        }
    });
    let gapped = Recording::new(RecordingParts {
        time_s: Some(time_s.collect()),
        drive: vec![0.0; 100],
        output: vec![0.0; 100],
        ..RecordingParts::default()
    })
    .unwrap();
    let ranges: Vec<_> = holds(&gapped, 10.0)
        .into_iter()
        .map(|hold| (hold.samples, hold.duration_s))
        .collect();
    assert_eq!(ranges, [(0..50, 49.0), (50..100, 49.0)]);
}

#[test]
fn white_noise_is_recovered_three_ways() {
    // 8000 samples: the standard error of a standard deviation is below 1 %, that by differences
    // 1.2 %, that by the median 1.5 %.
    let (dt_s, sigma) = (0.2, 0.01);
    let mut noise = Noise(6);
    let drive = pulses(8000, 1000, 900, 2000);
    let clean = response(&drive, dt_s, 8.0);
    let output = clean.iter().map(|y| y + sigma * noise.normal()).collect();
    let run = recording(dt_s, drive, output);
    let config = NoiseConfig {
        hold_s: 60.0,
        settle_s: 80.0,
    };
    let floor = noise_floor(&run, config).unwrap();
    let DifferenceNoise {
        standard_deviation,
        robust_standard_deviation,
        samples,
    } = floor.differences;
    assert_eq!(samples, 7998);
    assert_within(standard_deviation, sigma, 0.05);
    assert_within(robust_standard_deviation, sigma, 0.05);
    let held = floor.holds.unwrap();
    assert_eq!((held.holds, held.still_moving), (8, 0));
    assert_within(held.standard_deviation, sigma, 0.03);
    assert!(held.lag1_autocorrelation.abs() < 0.05, "{held:?}");
    let repeated = floor.repeats.unwrap();
    assert_eq!(repeated.cycles, 2);
    assert_within(repeated.standard_deviation, sigma, 0.05);
    assert_within(repeated.robust_standard_deviation, sigma, 0.05);
    assert_eq!(floor.rounding, None);
    assert!(!floor.is_lower_bound_only());
    assert!(floor.lower() <= floor.upper().unwrap());
}

#[test]
fn unequal_steps_change_no_estimate() {
    let (dt_s, sigma) = (0.2, 0.01);
    let mut noise = Noise(7);
    let drive = pulses(8000, 1000, 900, 2000);
    let clean = response(&drive, dt_s, 8.0);
    let run = Recording::new(RecordingParts {
        time_s: Some(jittered(dt_s, 8000, &mut noise)),
        output: clean.iter().map(|y| y + sigma * noise.normal()).collect(),
        drive,
        ..RecordingParts::default()
    })
    .unwrap();
    let floor = noise_floor(
        &run,
        NoiseConfig {
            hold_s: 60.0,
            settle_s: 80.0,
        },
    )
    .unwrap();
    assert_within(floor.differences.robust_standard_deviation, sigma, 0.05);
    assert_within(floor.holds.unwrap().standard_deviation, sigma, 0.03);
    // The response is taken at nominal times here: its slope times the jitter counts as noise.
    assert_within(floor.repeats.unwrap().robust_standard_deviation, sigma, 0.1);
}

#[test]
fn noise_with_memory_lies_between_the_bounds() {
    // First-order, coefficient 0.9: differences of order 7 see Σ w_i w_j 0.9^|i − j| = 0.0567 of its variance.
    let mut noise = Noise(8);
    let mut colored = 0.0;
    let drive = pulses(20_000, 4000, 3000, 5000);
    let output = drive
        .iter()
        .map(|_| {
            colored = 0.9 * colored + 0.01 * noise.normal();
            colored
        })
        .collect();
    let floor = noise_floor(&recording(0.1, drive, output), NoiseConfig::default()).unwrap();
    let sigma = 0.01 / (1.0_f64 - 0.81).sqrt();
    assert_within(
        floor.differences.standard_deviation,
        sigma * 0.0567_f64.sqrt(),
        0.05,
    );
    let held = floor.holds.unwrap();
    assert_within(held.standard_deviation, sigma, 0.1);
    assert_within(held.lag1_autocorrelation, 0.9, 0.05);
    assert_within(floor.upper().unwrap(), sigma, 0.1);
    assert!(floor.lower() < 0.3 * sigma);
}

#[test]
fn the_curvature_of_the_signal_is_no_noise() {
    // Three samples a time constant, and no rest: a line between neighbors misses the signal by more than the noise.
    let drive: Vec<f64> = (0..400).map(|k| (0.08 * k as f64).sin().powi(2)).collect();
    let signal = response(&drive, 1.0, 3.0);
    let bounds: Vec<f64> = (0..200)
        .map(|seed| {
            let mut noise = Noise(seed);
            let output = signal
                .iter()
                .map(|y| 4.0 * y + 0.005 * noise.normal())
                .collect();
            let floor = noise_floor(
                &recording(1.0, drive.clone(), output),
                NoiseConfig::default(),
            );
            floor.unwrap().lower()
        })
        .collect();
    let above = bounds.iter().filter(|bound| **bound > 0.005).count();
    assert!(above <= 10, "{above} of 200");
    let mean = bounds.iter().sum::<f64>() / 200.0;
    assert!(mean > 0.0042, "{mean}");
}

#[test]
fn a_hold_that_still_moves_is_no_noise() {
    let drive = pulses(2000, 0, 1000, 2000);
    let output = response(&drive, 0.2, 40.0);
    let floor = noise_floor(&recording(0.2, drive, output), NoiseConfig::default()).unwrap();
    assert_eq!(floor.holds, None);
    assert!(floor.is_lower_bound_only() && floor.upper().is_none());
    let nan = NoiseConfig {
        hold_s: 60.0,
        settle_s: f64::NAN,
    };
    let still = recording(0.2, vec![0.0; 2000], vec![0.0; 2000]);
    assert_eq!(noise_floor(&still, nan).unwrap().holds, None);
}

#[test]
fn a_transient_at_the_start_of_a_long_hold_is_no_noise() {
    // Settled after 30 s? With a time constant of 15 s a tenth of the stroke is still to come.
    let mut noise = Noise(14);
    let drive = pulses(20_000, 0, 10_000, 20_000);
    let clean = response(&drive, 0.05, 15.0);
    let output = clean.iter().map(|y| y + 0.005 * noise.normal()).collect();
    let run = recording(0.05, drive, output);
    let hasty = noise_floor(&run, NoiseConfig::default()).unwrap();
    assert_eq!(hasty.holds, None);
    let patient = NoiseConfig {
        settle_s: 150.0,
        ..NoiseConfig::default()
    };
    let held = noise_floor(&run, patient).unwrap().holds.unwrap();
    assert_within(held.standard_deviation, 0.005, 0.02);
}

#[test]
fn rounding_is_the_least_that_is_claimed() {
    // A rod at rest, read without noise through a converter: nothing varies, and yet q/√12 is wrong.
    let drive = pulses(2000, 1000, 1000, 2000);
    let q = 0.0206;
    let output = response(&drive, 0.1, 10.0)
        .iter()
        .map(|y| (y / q).round() * q)
        .collect();
    let floor = noise_floor(&recording(0.1, drive, output), NoiseConfig::default()).unwrap();
    assert_within(floor.rounding.unwrap(), q / 12.0_f64.sqrt(), 1e-9);
    assert_within(floor.lower(), q / 12.0_f64.sqrt(), 1e-9);
    assert!(floor.upper().unwrap() >= floor.lower());
}

#[test]
fn repeated_cycles_are_found_by_the_drive() {
    // Rest, three equal cycles of two pulses each, then another one of its own.
    let mut drive = vec![0.0; 50];
    for _ in 0..3 {
        for (level, n) in [(1.5, 60), (0.0, 40), (1.0, 30), (0.0, 70)] {
            drive.extend(vec![level; n]);
        }
    }
    drive.extend(vec![1.8; 90]);
    drive.extend(vec![0.0; 30]);
    let n = drive.len();
    let run = recording(0.5, drive, vec![0.0; n]);
    let found = repeats(&run).unwrap();
    let ranges: Vec<_> = found
        .cycles
        .iter()
        .map(|cycle| cycle.samples.clone())
        .collect();
    assert_eq!(ranges, [50..250, 250..450, 450..650]);
    assert_within(found.period_s, 100.0, 1e-12);

    let ranges: Vec<_> = cycles(&run)
        .into_iter()
        .map(|cycle| cycle.samples)
        .collect();
    assert_eq!(
        ranges,
        [
            50..150,
            150..250,
            250..350,
            350..450,
            450..550,
            550..650,
            650..770
        ]
    );
}

#[test]
fn a_sine_about_a_bias_repeats_after_a_rest() {
    let mut drive = vec![0.0; 100];
    drive.extend((0..1000).map(|k| 1.0 + 0.4 * (2.0 * PI * f64::from(k) / 200.0).sin()));
    let n = drive.len();
    let run = recording(0.5, drive, vec![0.0; n]);
    let found = repeats(&run).unwrap();
    assert_within(found.period_s, 100.0, 1e-12);
    assert!((4..=5).contains(&found.cycles.len()), "{found:?}");
    // To the near-minimum it comes but once.
    assert_eq!(cycles(&run).len(), 0);
}

#[test]
fn repeats_survive_jitter_and_edges_off_by_a_sample() {
    let mut noise = Noise(9);
    let time_s = jittered(0.2, 3100, &mut noise);
    // 120.05 s is no multiple of the step.
    let on = |t: &f64| *t > 20.0 && (t - 20.0) % 120.05 < 60.0;
    let drive: Vec<f64> = time_s
        .iter()
        .map(|t| if on(t) { 2.0 } else { 0.0 })
        .collect();
    let run = Recording::new(RecordingParts {
        output: vec![0.0; drive.len()],
        time_s: Some(time_s),
        drive,
        ..RecordingParts::default()
    })
    .unwrap();
    let found = repeats(&run).unwrap();
    assert_eq!(found.cycles.len(), 5);
    assert_within(found.period_s, 120.05, 0.3 / 120.0);
    for pair in found.cycles.windows(2) {
        assert!(pair[0].samples.end <= pair[1].samples.start);
    }
}

#[test]
fn unlike_cycles_do_not_repeat() {
    let mut drive = Vec::new();
    for level in [1.0, 1.2, 1.4, 1.6] {
        drive.extend([0.0; 50]);
        drive.extend([level; 50]);
    }
    let n = drive.len();
    let run = recording(0.5, drive, vec![0.0; n]);
    assert_eq!(repeats(&run), None);
    // The last pulse is cut off.
    assert_eq!(cycles(&run).len(), 3);
}

#[test]
fn either_direction_of_a_current_heats() {
    let drive: Vec<f64> = pulses(400, 20, 50, 100)
        .iter()
        .enumerate()
        .map(|(k, i)| if (k / 100) % 2 == 0 { *i } else { -i })
        .collect();
    assert_eq!(cycles(&recording(0.5, drive, vec![0.0; 400])).len(), 4);
}

#[test]
fn splits_hold_whole_cycles() {
    let run = recording(0.5, pulses(1050, 40, 50, 100), vec![0.0; 1050]);
    assert_eq!(cycles(&run).len(), 10);
    assert_eq!(split_by_cycles(&run, 1).unwrap().first(), Some(&(0..1050)));
    assert_eq!(split_by_cycles(&run, 2).unwrap(), [0..540, 540..1050]);
    let parts = split_by_cycles(&run, 10).unwrap();
    assert_eq!((parts[0].clone(), parts[9].clone()), (0..140, 940..1050));
    for (n_parts, text) in [
        (
            0,
            "run3.csv: parts: 0; expected 1 to 10, each of at least one whole cycle",
        ),
        (
            11,
            "run3.csv: parts: 11; expected 1 to 10, each of at least one whole cycle",
        ),
    ] {
        assert_eq!(
            split_by_cycles(&run, n_parts).unwrap_err().to_string(),
            text
        );
    }
    let still = recording(0.5, vec![0.0; 9], vec![0.0; 9]);
    assert_eq!(split_by_cycles(&still, 1).unwrap().first(), Some(&(0..9)));
}

#[test]
fn a_slice_keeps_its_time() {
    let run = recording(
        0.5,
        pulses(100, 10, 20, 40),
        (0..100).map(f64::from).collect(),
    );
    let part = run.slice(40..60).unwrap();
    assert_eq!(part.time_s(), &run.time_s()[40..60]);
    assert_eq!(part.output(), &run.output()[40..60]);
    assert_eq!((part.name(), part.output_unit()), ("run3.csv", "mm"));
    assert_eq!(run.slice(0..100).unwrap(), run);
    let backward = std::ops::Range { start: 7, end: 3 };
    for range in [99..101, 5..6, backward, 200..300] {
        let expected = format!(
            "run3.csv: samples {}..{}; expected a range of at least 2 samples within 0..100",
            range.start, range.end
        );
        assert_eq!(run.slice(range).unwrap_err().to_string(), expected);
    }
}

/// Amplitude of a sine of this frequency in samples k·dt, away from the ends.
fn amplitude(run: &Recording, hertz: f64) -> f64 {
    let n = run.len();
    let inner = n / 5..n - n / 5;
    let (mut sine, mut cosine) = (0.0, 0.0);
    let (mut ss, mut cc, mut sc) = (0.0, 0.0, 0.0);
    for k in inner {
        let (s, c) = (2.0 * PI * hertz * run.time_s()[k]).sin_cos();
        sine += s * run.output()[k];
        cosine += c * run.output()[k];
        (ss, cc, sc) = (ss + s * s, cc + c * c, sc + s * c);
    }
    // Least squares of the two phases.
    let det = ss * cc - sc * sc;
    let a = (sine * cc - cosine * sc) / det;
    let b = (cosine * ss - sine * sc) / det;
    a.hypot(b)
}

#[test]
fn a_sine_below_the_cutoff_is_kept_and_one_above_nyquist_is_not() {
    for new_dt_s in [0.1, 0.073, 0.02, 0.5] {
        for share in [0.05, 0.2, 0.3] {
            let hertz = share / new_dt_s;
            let sine = (0..20_000).map(|k| (2.0 * PI * hertz * f64::from(k) * 0.01).sin());
            let run = recording(0.01, vec![0.0; 20_000], sine.collect());
            let slow = resample(&run, new_dt_s).unwrap();
            assert_within(amplitude(&slow, hertz), 1.0, 0.002);
        }
        for share in [0.5, 0.7, 1.02, 2.3] {
            let hertz = share / new_dt_s;
            if hertz > 49.0 {
                continue;
            }
            let sine = (0..20_000).map(|k| (2.0 * PI * hertz * f64::from(k) * 0.01 + 0.3).sin());
            let run = recording(0.01, vec![0.0; 20_000], sine.collect());
            let slow = resample(&run, new_dt_s).unwrap();
            let n = slow.len();
            let inner = &slow.output()[n / 5..n - n / 5];
            let largest = inner
                .iter()
                .fold(0.0, |largest: f64, y| largest.max(y.abs()));
            assert!(largest <= 0.002, "{share} of 1/{new_dt_s}: {largest}");
        }
    }
}

#[test]
fn unequal_steps_lose_what_is_stated() {
    let mut noise = Noise(10);
    let time_s = jittered(0.01, 20_000, &mut noise);
    let (new_dt_s, hertz) = (0.1, 2.0);
    let run = Recording::new(RecordingParts {
        output: time_s
            .iter()
            .map(|t| (2.0 * PI * hertz * t).sin())
            .collect(),
        drive: vec![0.0; 20_000],
        time_s: Some(time_s),
        ..RecordingParts::default()
    })
    .unwrap();
    let slow = resample(&run, new_dt_s).unwrap();
    let interpolation = (PI * hertz * 0.01).powi(2) / 3.0;
    let kept = amplitude(&slow, hertz);
    assert!(
        (1.0 - 0.002 - 2.0 * interpolation..=1.002).contains(&kept),
        "{kept}"
    );
}

#[test]
fn a_line_stays_a_line_to_its_ends() {
    let line: Vec<f64> = (0..1000).map(|k| 3.0 - 0.01 * f64::from(k)).collect();
    let slow = resample(&recording(0.01, vec![0.0; 1000], line), 0.1).unwrap();
    assert_eq!(slow.len(), 100);
    for (t, y) in slow.time_s().iter().zip(slow.output()) {
        assert!((y - (3.0 - t)).abs() < 1e-9, "{y} at {t} s");
    }
}

/// Heat of a drive in 1 Ω, up to the last time stamp.
fn heat(run: &Recording, squared: bool) -> f64 {
    let steps = run.time_s().windows(2).map(|pair| pair[1] - pair[0]);
    let power = run.drive().iter().map(|d| if squared { d * d } else { *d });
    steps.zip(power).map(|(dt_s, p)| dt_s * p).sum()
}

#[test]
fn the_heat_of_the_drive_is_kept() {
    let mut noise = Noise(11);
    for quantity in [
        Quantity::Current,
        Quantity::Duty,
        Quantity::Voltage,
        Quantity::Power,
    ] {
        for jitter in [false, true] {
            let time_s = if jitter {
                let mut stamps = jittered(0.01, 1001, &mut noise);
                // So that old and new stamps end together.
                (stamps[0], stamps[1000]) = (0.0, 10.0);
                stamps
            } else {
                (0..1001).map(|k| f64::from(k) / 100.0).collect()
            };
            let run = Recording::new(RecordingParts {
                time_s: Some(time_s),
                drive_quantity: quantity,
                drive: (0..1001).map(|_| noise.uniform()).collect(),
                output: vec![0.0; 1001],
                ..RecordingParts::default()
            })
            .unwrap();
            let squared = matches!(quantity, Quantity::Current | Quantity::Voltage);
            for new_dt_s in [0.1, 0.04, 0.3125] {
                let slow = resample(&run, new_dt_s).unwrap();
                assert_within(heat(&slow, squared), heat(&run, squared), 1e-12);
            }
        }
    }
}

#[test]
fn the_sign_of_a_current_is_that_of_its_mean() {
    let drive = [-2.0, -2.0, -2.0, 1.0, 1.0, 1.0, 1.0, -1.0];
    let run = recording(1.0, drive.to_vec(), vec![0.0; 8]);
    let slow = resample(&run, 4.0).unwrap();
    assert_eq!(slow.len(), 2);
    assert_within(slow.drive()[0], -(13.0_f64 / 4.0).sqrt(), 1e-12);
    assert_within(slow.drive()[1], 1.0, 1e-12);
    let alternating = recording(1.0, vec![SQRT_2, -SQRT_2, SQRT_2, -SQRT_2], vec![0.0; 4]);
    assert_within(
        resample(&alternating, 2.0).unwrap().drive()[0],
        SQRT_2,
        1e-12,
    );
}

#[test]
fn other_measurements_are_resampled_too() {
    let run = Recording::new(RecordingParts {
        time_s: Some((0..100).map(f64::from).collect()),
        drive: vec![0.5; 100],
        output: vec![0.0; 100],
        temperature_degc: Some((0..100).map(f64::from).collect()),
        ambient_degc: Some(vec![22.0; 100]),
        stress_pa: Some(vec![5e7; 100]),
        resistance: Some(Resistance::Ohm(vec![3.5; 100])),
        ..RecordingParts::default()
    })
    .unwrap();
    let slow = resample(&run, 5.0).unwrap();
    assert_within(slow.temperature_degc().unwrap()[7], 35.0, 1e-9);
    assert_within(slow.ambient_degc().unwrap()[19], 22.0, 1e-12);
    assert_within(slow.stress_pa().unwrap()[19], 5e7, 1e-5);
    let mut ohm = slow.resistance().unwrap().ohm();
    assert_within(ohm.nth(19).flatten().unwrap(), 3.5, 1e-12);
    let seen = inspect(&run);
    assert_within(seen.stress.unwrap().highest, 5e7, 0.0);
    assert_within(seen.resistance.unwrap().lowest, 3.5, 0.0);
    assert_within(slow.drive()[3], 0.5, 1e-15);
    // Its own step: nothing to do.
    assert_eq!(resample(&run, 1.0).unwrap(), run);
}

#[test]
fn resampling_says_what_it_accepts() {
    let run = recording(0.5, vec![0.0; 21], vec![0.0; 21]);
    for dt_s in [0.2, 11.0, 0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(
            resample(&run, dt_s).unwrap_err().to_string(),
            format!(
                "run3.csv: dt_s = {dt_s} s; expected 0.5 s, its own step, to 10 s, its duration"
            )
        );
    }
    let gapped = Recording::new(RecordingParts {
        name: "run3.csv".to_owned(),
        time_s: Some(vec![0.0, 1.0, 2.0, 3.0, 13.0, 14.0]),
        drive: vec![0.0; 6],
        output: vec![0.0; 6],
        ..RecordingParts::default()
    })
    .unwrap();
    assert_eq!(
        resample(&gapped, 2.0).unwrap_err().to_string(),
        "run3.csv: gap of 10 s after time_s = 3; expected no gap, slice the recording at samples \
         0..4 and 4..6"
    );
    let untimed = Recording::new(RecordingParts {
        name: "loop.csv".to_owned(),
        drive: vec![0.0; 6],
        output: vec![0.0; 6],
        ..RecordingParts::default()
    })
    .unwrap();
    assert_eq!(
        resample(&untimed, 2.0).unwrap_err().to_string(),
        "loop.csv: no time; expected a recording with a time column"
    );
}

#[test]
fn a_sound_recording_is_warned_of_its_one_rate_alone() {
    let mut noise = Noise(12);
    let drive = pulses(8000, 1000, 900, 2000);
    let output = response(&drive, 0.2, 8.0)
        .iter()
        .map(|y| ((y + 0.004 * noise.normal()) / 0.0012207).round() * 0.0012207)
        .collect();
    let found = inspect(&recording(0.2, drive, output));
    assert_eq!(found.warnings(), [Warning::OneRate]);
    assert_eq!((found.n_samples, found.rest_samples), (8000, 1000));
    assert_within(found.duration_s.unwrap(), 1599.8, 1e-12);
    assert_eq!((found.cycles.len(), found.holds.len()), (4, 8));
    assert_eq!(found.repeats.unwrap().cycles.len(), 3);
    assert_within(found.output.quantization_step.unwrap(), 0.0012207, 1e-9);
    assert!(found.motion_at_highest_drive.unwrap() < 0.01);
}

/// The warnings of a recording, as text.
fn warnings(run: &Recording) -> Vec<String> {
    let warnings = inspect(run).warnings();
    warnings.iter().map(Warning::to_string).collect()
}

#[test]
fn a_short_pulse_is_warned_of() {
    let drive = pulses(200, 5, 60, 200);
    let output = response(&drive, 0.2, 40.0)
        .iter()
        .map(|y| (y / 0.1).round() * 0.1)
        .collect();
    assert_eq!(
        warnings(&recording(0.2, drive, output)),
        [
            "samples at rest before the drive rises: 5: offset and initial state are not measured \
             and must be fitted; start with 10 samples or more, cold and undriven",
            "whole cycles: 1: nothing can be held out, nor drift told from a slow response; record \
             at least 2, better 3 equal ones",
            "the drive rises to one level at one rate: the time constant, the loop's center and its width trade against \
             one another; record a second run at another rate or to another level, a slow ramp beside steps say, and fit \
             both together",
            "at the highest drive, 1.8 A, the output still moves, by 20.83 % of its range in the \
             last fifth of the time: it is not seen to settle or saturate, and the far end of the \
             loop is a guess; hold longer, or drive higher if the rig allows",
            "output moves over 8 steps of 0.1 mm: its converter hides most of the loop; use a finer \
             range or a longer lever",
            "output comes in steps of 0.1 mm at a noise of 0.02887 mm: rounding follows the signal, \
             so what is left of a fit is not independent noise; repeat cycles, or record with a \
             finer converter",
            "no hold of 60 s and no three repeated cycles: the noise floor, 0.02887 mm, is a lower \
             bound only, and so is any share explained; hold the drive for 60 s at rest, and repeat \
             a cycle three times",
        ]
    );
}

#[test]
fn gaps_jitter_and_clipping_are_warned_of() {
    let mut noise = Noise(13);
    let mut time_s = jittered(1.0, 1000, &mut noise);
    time_s[500..].iter_mut().for_each(|t| *t += 30.0);
    time_s[0] = 0.0;
    let drive = pulses(1000, 100, 100, 300);
    let output = response(&drive, 1.0, 30.0);
    let run = Recording::new(RecordingParts {
        time_s: Some(time_s),
        temperature_degc: Some(output.iter().map(|y| (20.0 + 30.0 * y).min(90.0)).collect()),
        output: output.iter().map(|y| y + 0.01 * noise.normal()).collect(),
        drive,
        ..RecordingParts::default()
    })
    .unwrap();
    let text = warnings(&run);
    assert!(text[0].starts_with("gaps: 1, the longest 30.8"), "{text:?}");
    assert!(text[1].starts_with("steps of 0."), "{text:?}");
    let flat = text.iter().find(|text| text.starts_with("temperature"));
    let flat = flat.unwrap();
    assert!(
        flat.starts_with("temperature is flat at its highest, 90 degC: "),
        "{flat}"
    );
    assert!(
        flat.contains(" samples, 3 times: at rest or against a stop"),
        "{flat}"
    );
}

#[test]
fn nothing_to_see_is_said() {
    let still = Recording::new(RecordingParts {
        drive: vec![0.0; 30],
        output: vec![0.0; 30],
        ..RecordingParts::default()
    })
    .unwrap();
    assert_eq!(
        warnings(&still),
        [
            "no time: only a static loop can be identified, no time constant; record with a time \
             column",
            "drive never changes: there is nothing to identify; check the column and the wiring",
            "output never changes: there is nothing to identify; check the column and the wiring",
        ]
    );
    // A hold that is long enough, but moves.
    let drive = pulses(2000, 50, 1000, 2000);
    let run = recording(0.2, drive.clone(), response(&drive, 0.2, 40.0));
    let text = warnings(&run);
    let bound = "no hold of 60 s in which the output is at rest after 30 s, and no three repeated";
    assert!(text.iter().any(|text| text.starts_with(bound)), "{text:?}");
}

#[test]
fn floor_is_the_least_and_the_largest_of_its_parts() {
    let floor = NoiseFloor {
        differences: DifferenceNoise {
            standard_deviation: 0.03,
            robust_standard_deviation: 0.02,
            samples: 100,
        },
        holds: None,
        repeats: None,
        rounding: Some(0.001),
    };
    assert_eq!((floor.white(), floor.upper()), (0.02, None));
    // 1 − 1.25/√100 of it.
    assert_within(floor.lower(), 0.0175, 1e-12);
    let coarse = NoiseFloor {
        rounding: Some(0.05),
        ..floor
    };
    assert_eq!((coarse.lower(), coarse.upper()), (0.05, None));
}
