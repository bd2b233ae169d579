//! Recordings that are one measurement: a copy of a file, or one with rounded numbers, missing rows, other offsets or a little noise.

use recording::Recording;

/// Rows by which one may begin later than the other.
const ROWS: usize = 5;

/// Fewest samples that are compared.
const FEWEST: usize = 64;

/// Share of the shorter one that the common rows are, at least.
const MOST_OF_IT: f64 = 0.8;

/// Distance of the outputs over the noise, up to which they are one measurement: two measurements have noise of their own, and
/// are √2 times the noise apart.
const NEAR: f64 = 0.3;

/// Distance of the drives over their range, up to which they are one.
const DRIVES: f64 = 0.01;

/// Samples of a stretch in which noise is sought.
const STRETCH: usize = 16;

/// True if two recordings are one measurement, whatever their names: the same data, or data that differ by less than noise.
pub(crate) fn is_near_copy(one: &Recording, other: &Recording) -> bool {
    same_data(one, other) || differ_by_less_than_noise(one, other)
}

fn same_data(one: &Recording, other: &Recording) -> bool {
    let bits = |recording: &Recording| -> Vec<u64> {
        let values = recording.drive().iter().chain(recording.output());
        values.map(|value| value.to_bits()).collect()
    };
    one.len() == other.len() && bits(one) == bits(other)
}

fn differ_by_less_than_noise(one: &Recording, other: &Recording) -> bool {
    let noise = quiet_noise(one.output()).min(quiet_noise(other.output()));
    if !(noise > 0.0 && one.output_unit() == other.output_unit()) {
        return false;
    }
    let range = one.largest_drive().max(other.largest_drive());
    let later = |by: usize, late: &Recording, early: &Recording| {
        let n = late.len().saturating_sub(by).min(early.len());
        let is_enough = n >= FEWEST && n as f64 >= MOST_OF_IT * late.len().min(early.len()) as f64;
        is_enough
            && spread(&late.drive()[by..by + n], &early.drive()[..n]) <= DRIVES * range
            && spread(&late.output()[by..by + n], &early.output()[..n]) <= NEAR * noise
    };
    (0..=ROWS).any(|by| later(by, one, other) || later(by, other, one))
}

/// Root mean square of what is left of the difference without its mean.
fn spread(one: &[f64], other: &[f64]) -> f64 {
    let n = one.len() as f64;
    let pairs = || one.iter().zip(other).map(|(a, b)| a - b);
    let mean = pairs().sum::<f64>() / n;
    (pairs().map(|apart| (apart - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// Noise between neighboring samples in the quieter stretches, which is more than that of the sensor only if the output bends
/// in all of them; 0 if there are too few samples.
fn quiet_noise(output: &[f64]) -> f64 {
    if output.len() < FEWEST {
        return 0.0;
    }
    // Var(y₋ - 2y + y₊) = 6σ² of white noise.
    let bend = |three: &[f64]| (three[0] - 2.0 * three[1] + three[2]).powi(2) / 6.0;
    let mut variances: Vec<f64> = output
        .chunks_exact(STRETCH)
        .map(|stretch| stretch.windows(3).map(bend).sum::<f64>() / (STRETCH - 2) as f64)
        .collect();
    variances.sort_by(f64::total_cmp);
    variances[variances.len() / 4].sqrt()
}

#[cfg(test)]
mod tests {
    use recording::RecordingParts;

    use super::*;

    /// Numbers between -1 and 1 that a seed decides.
    fn drawn(seed: u64) -> impl Iterator<Item = f64> {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        std::iter::repeat_with(move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        })
    }

    fn recording(drive: Vec<f64>, output: Vec<f64>) -> Recording {
        Recording::new(RecordingParts {
            name: "run".to_owned(),
            time_s: Some((0..drive.len()).map(|k| k as f64).collect()),
            drive,
            output_unit: "mm".to_owned(),
            output,
            ..RecordingParts::default()
        })
        .unwrap()
    }

    const N: usize = 400;
    const NOISE: f64 = 0.01;

    fn drive() -> Vec<f64> {
        (0..N)
            .map(|k| if k / 50 % 2 == 0 { 0.0 } else { 2.0 })
            .collect()
    }

    /// A run of that drive with noise of its own; the rod, or the surroundings, may differ by a share.
    fn run(seed: u64, by: f64) -> Recording {
        let mut position = 0.0;
        let noise = drawn(seed).skip(20);
        let output = drive().into_iter().zip(noise).map(|(drive, noise)| {
            position += (drive * (1.0 + by) - position) / 8.0;
            position + NOISE * noise
        });
        recording(drive(), output.collect())
    }

    #[test]
    fn a_copy_is_seen_through_rounding_offsets_noise_and_rows_cut_off() {
        let train = run(1, 0.0);
        let changed = |change: &dyn Fn(f64) -> f64| {
            recording(drive(), train.output().iter().map(|&y| change(y)).collect())
        };
        assert!(is_near_copy(&train, &train));
        assert!(is_near_copy(&changed(&|y| (y * 1e3).round() / 1e3), &train));
        assert!(is_near_copy(&changed(&|y| y + 3.0), &train));
        let mut more = drawn(9).skip(20);
        let noisy = train
            .output()
            .iter()
            .map(|y| y + 0.2 * NOISE * more.next().unwrap());
        assert!(is_near_copy(&recording(drive(), noisy.collect()), &train));
        let cut = recording(drive()[3..380].to_vec(), train.output()[3..380].to_vec());
        assert!(is_near_copy(&cut, &train) && is_near_copy(&train, &cut));
    }

    #[test]
    fn a_second_run_of_the_same_drive_is_no_copy() {
        for seed in 2..40 {
            assert!(!is_near_copy(&run(seed, 0.0), &run(1, 0.0)), "{seed}");
        }
        // Without noise two runs differ by what the rod does.
        let quiet = |by: f64| {
            let mut position = 0.0;
            let output = drive().into_iter().map(|drive| {
                position += (drive * (1.0 + by) - position) / 8.0;
                position
            });
            recording(drive(), output.collect())
        };
        assert!(!is_near_copy(&quiet(1e-3), &quiet(0.0)));
    }
}
