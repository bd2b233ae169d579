//! A noisy column of a drive is seen, and smoothed only where the rod did not see the noise.

use recording::{Recording, Warning, drive_noise, inspect, mended};

use crate::inspect::{Noise, recording, response};

const DT_S: f64 = 0.05;
const SIGMA: f64 = 0.03;

/// Rest, then steps, a ramp, and a sine about a level.
fn drive() -> Vec<f64> {
    let value = |k: usize| match k {
        0..200 => 0.0,
        200..400 => 0.45,
        400..600 => 0.0,
        600..800 => 0.6,
        800..1000 => 0.38,
        1000..1300 => 0.002 * (k - 1000) as f64,
        1300..1500 => 0.0,
        _ => 0.4 + 0.15 * (0.04 * (k - 1500) as f64).sin(),
    };
    (0..2000).map(value).collect()
}

fn with_column(column: Vec<f64>) -> Recording {
    let output = response(&drive(), DT_S, 3.0);
    recording(DT_S, column, output)
}

fn noisy(seed: u64) -> Vec<f64> {
    let mut noise = Noise(seed);
    let column = drive().into_iter();
    column.map(|i| i + SIGMA * noise.normal()).collect()
}

#[test]
fn noise_of_a_sensor_is_said_and_smoothed() {
    for seed in 1..=4 {
        let noisy = with_column(noisy(seed));
        let seen = drive_noise(&noisy).unwrap();
        assert!(seen.is_of_the_sensor);
        assert!((seen.standard_deviation / SIGMA - 1.0).abs() < 0.15);
        let smooth = mended(&noisy);
        let truth = drive();
        let rms = |drive: &[f64]| {
            let squares = drive.iter().zip(&truth).map(|(a, b)| (a - b).powi(2));
            (squares.sum::<f64>() / truth.len() as f64).sqrt()
        };
        let left = rms(smooth.drive());
        assert!(left < rms(noisy.drive()) / 3.0, "{seed}: {left}");
        // At rest nothing drives; steps stay where they are; what is held is one number.
        assert!(smooth.drive()[..200].iter().all(|i| i.abs() < 1e-12));
        for k in [200, 400, 600, 800] {
            let (before, after) = (smooth.drive()[k - 1], smooth.drive()[k]);
            assert!(
                (after - before - (truth[k] - truth[k - 1])).abs() < 0.02,
                "{seed}: {k}"
            );
        }
        assert!(
            smooth.drive()[201..400]
                .windows(2)
                .all(|two| two[0].to_bits() == two[1].to_bits())
        );
        // The sine is not flattened: of its amplitude, 0.15, all is there.
        let sine = |k: usize| (0.04 * (k - 1500) as f64).sin();
        let product: f64 = (1500..2000)
            .map(|k| (smooth.drive()[k] - 0.4) * sine(k))
            .sum();
        let amplitude = product / (1500..2000).map(|k| sine(k).powi(2)).sum::<f64>();
        assert!((amplitude - 0.15).abs() < 0.006, "{amplitude}");
        let inspection = inspect(&noisy);
        assert_eq!(inspection.rest_samples, 200);
        let said = smooth.adaptations()[0].to_string();
        assert!(
            said.starts_with("the drive is noisy by 0.0")
                && said.contains(" A (standard deviation, "),
            "{said}"
        );
        assert!(
            said.ends_with("% of its range), at rest, too: held levels are replaced by their means, ramps by lines"),
            "{said}"
        );
        assert!(inspection.warnings().iter().any(|warning| {
            matches!(
                warning,
                Warning::NoisyDrive {
                    is_smoothed: true,
                    ..
                }
            ) && warning
                .to_string()
                .ends_with("as_recorded = true under [columns] keeps it")
        }));
        // Once is enough.
        assert_eq!(drive_noise(&smooth), None);
    }
}

#[test]
fn what_the_rod_may_have_seen_stays() {
    let mut noise = Noise(7);
    // A supply whose noise goes with what it gives, and a controller with a noisy sensor: both are still at rest.
    let of_supply: Vec<f64> = drive()
        .into_iter()
        .map(|i| i * (1.0 + 0.06 * noise.normal()))
        .collect();
    let of_supply = with_column(of_supply);
    let seen = drive_noise(&of_supply);
    assert!(seen.is_none_or(|seen| !seen.is_of_the_sensor));
    assert_eq!(mended(&of_supply), of_supply);
    let busy: Vec<f64> = (0..2000)
        .map(|k| {
            if k < 200 {
                0.0
            } else {
                0.4 + 0.02 * noise.normal()
            }
        })
        .collect();
    let busy = with_column(busy);
    let seen = drive_noise(&busy).unwrap();
    assert!(!seen.is_of_the_sensor);
    assert_eq!(mended(&busy), busy);
    let warning = Warning::NoisyDrive {
        noise: seen,
        is_smoothed: false,
    }
    .to_string();
    assert!(
        warning.contains("none is seen at rest, so the rod may have seen it"),
        "{warning}"
    );
}

#[test]
fn drives_are_no_noise() {
    let mut noise = Noise(8);
    let is_quiet = |column: Vec<f64>| {
        let recording = with_column(column);
        drive_noise(&recording).is_none() && mended(&recording) == recording
    };
    // As it was set.
    assert!(is_quiet(drive()));
    // A fast sine, pulses of a duty, a chatter from sample to sample, and a random drive.
    let n = 0..2000;
    assert!(is_quiet(
        n.clone()
            .map(|k| 0.3 + 0.3 * (0.3 * f64::from(k)).sin())
            .collect()
    ));
    assert!(is_quiet(
        n.clone().map(|k| f64::from(u8::from(k % 7 < 3))).collect()
    ));
    assert!(is_quiet(
        n.clone()
            .map(|k| f64::from(k % 400) / 400.0 + 0.02 * f64::from(k % 2))
            .collect()
    ));
    assert!(is_quiet(
        n.clone().map(|_| 0.5 + 0.1 * noise.normal()).collect()
    ));
    // Steps of a converter.
    assert!(is_quiet(
        drive()
            .into_iter()
            .map(|i| (i / 0.01).round() * 0.01)
            .collect()
    ));
    // A wander is no independent noise.
    let mut wander = 0.0;
    assert!(is_quiet(
        n.map(|_| {
            wander = 0.9 * wander + 0.01 * noise.normal();
            0.4 + wander
        })
        .collect()
    ));
}
