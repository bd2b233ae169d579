//! An output that slips is told from one that moves.

use recording::{Recording, inspect, mended, slips, stuck};

use crate::inspect::{Noise, recording, response};

const DT_S: f64 = 0.05;

fn drive() -> Vec<f64> {
    let level = |k: usize| [0.0, 1.0, 0.0, 0.6, 0.0, 0.8][k / 400 % 6];
    (0..4000).map(level).collect()
}

/// The response with noise, and steps of its own from some samples on.
fn slipped(at: &[(usize, f64)], seed: u64) -> Recording {
    let drive = drive();
    let mut noise = Noise(seed);
    let mut output = response(&drive, DT_S, 1.0);
    for (k, y) in output.iter_mut().enumerate() {
        let steps = at.iter().filter(|(from, _)| k >= *from);
        *y += 0.005 * noise.normal() + steps.map(|(_, step)| step).sum::<f64>();
    }
    recording(DT_S, drive, output)
}

#[test]
fn a_slip_is_said_with_its_place_and_the_way_round_it() {
    for seed in 1..=4 {
        // At rest, and while a level is held.
        for at in [1100, 1900, 3100] {
            let found = slips(&slipped(&[(at, 0.8)], seed));
            assert_eq!(found.len(), 1, "{seed}: {at}");
            assert_eq!(found[0].index + 1, at);
            assert!((found[0].step - 0.8).abs() < 0.03);
        }
    }
    let odd = slipped(&[(3100, -0.8)], 1);
    let warnings = inspect(&odd).warnings();
    let said = warnings.iter().map(ToString::to_string);
    let said = said
        .filter(|said| said.contains("slips"))
        .collect::<Vec<_>>();
    assert_eq!(said.len(), 1);
    assert!(
        said[0].starts_with("the output slips by -0.7931 mm"),
        "{}",
        said[0]
    );
    assert!(
        said[0].ends_with(
            " mm at 155 s, while the drive is held, and stays there: no model follows that; fits take it back unless \
             as_recorded = true; a part without it is --window run3.csv:0..154.95, or window_s = [0, 154.95] under [recordings.\"run3.csv\"] in the rod file"
        ),
        "{}",
        said[0]
    );
    // The longest part, where there are two.
    let two = slips(&slipped(&[(1100, 0.8), (3100, 0.5)], 1));
    assert_eq!(two.len(), 2);
    let ends = two[0]
        .longest_s
        .map(|end_s| (end_s / DT_S).round() as usize);
    assert_eq!(ends, [1100, 3099]);
}

#[test]
fn fits_take_a_slip_back() {
    let whole = slipped(&[], 1);
    let taken_back = mended(&slipped(&[(1100, 0.8), (3100, -0.5)], 1));
    let said: Vec<String> = taken_back
        .adaptations()
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(
        said[0].ends_with("is taken back: what comes after is moved by as much"),
        "{said:?}"
    );
    // By the noise of ten samples on either side, twice; two samples alone would leave 0.01 mm.
    let pairs = whole.output().iter().zip(taken_back.output());
    let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 0.005, "{worst}");
}

#[test]
fn motion_is_no_slip() {
    assert_eq!(slips(&slipped(&[], 1)), []);
    // Of the size of what neighbors differ by.
    assert_eq!(slips(&slipped(&[(1100, 0.02)], 1)), []);
    // A converter of few steps.
    let rounded = slipped(&[], 1);
    let output = rounded.output().iter().map(|y| (y * 8.0).round() / 8.0);
    assert_eq!(slips(&recording(DT_S, drive(), output.collect())), []);
    // Beside a step of the drive.
    assert_eq!(slips(&slipped(&[(1202, 0.8)], 1)), []);
    // To another place and back again: a mechanism that snaps.
    let snaps = [(1100, 0.8), (1500, -0.8), (1900, 0.8), (2300, -0.8)];
    assert_eq!(slips(&slipped(&snaps, 1)), []);
    // A dropout is no slip, nor is a rod that is as fast as the logger.
    let output: Vec<f64> = drive().iter().map(|i| i * i).collect();
    assert_eq!(slips(&recording(DT_S, drive(), output)), []);
    let mut drive = drive();
    let output = response(&drive, DT_S, 0.01);
    drive.rotate_left(3);
    assert_eq!(slips(&recording(DT_S, drive, output)), []);
}

/// The response with noise, its value repeated in some runs of samples.
fn repeated(runs: &[(usize, usize)]) -> Recording {
    let mut output = slipped(&[], 1).output().to_vec();
    for &(start, end) in runs {
        let value = output[start];
        output[start..end].fill(value);
    }
    recording(DT_S, drive(), output)
}

#[test]
fn a_logger_that_repeats_a_value_is_said_with_the_way_round_it_and_is_no_slip() {
    // While the rod cools and a drive of zero is held.
    let odd = repeated(&[(805, 845), (2405, 2480)]);
    assert_eq!(slips(&odd), []);
    let found = stuck(&odd).unwrap();
    assert_eq!(found.runs, [806..845, 2406..2480]);
    let warnings = inspect(&odd).warnings();
    let said = warnings.iter().map(ToString::to_string);
    let said: Vec<String> = said.filter(|said| said.contains("repeats")).collect();
    assert_eq!(said.len(), 1);
    assert!(
        said[0].starts_with("the output stands at one value from 40.3 to 42.2 s and once more, and goes on by a step of -"),
        "{said:?}"
    );
    assert!(
        said[0].ends_with("leave it out with exclude_s = [[40.3, 42.2], [120.3, 123.95]] under [recordings.\"run3.csv\"] in the rod file"),
        "{said:?}"
    );
    // Whole, at rest for as long, and where a converter repeats most of its values.
    assert_eq!(stuck(&repeated(&[])), None);
    assert_eq!(stuck(&repeated(&[(100, 200)])), None);
    // A rod without noise that rests, a sensor at its end, and a slip of an output that rests to the last digit.
    let quiet = response(&drive(), DT_S, 1.0);
    assert_eq!(stuck(&recording(DT_S, drive(), quiet.clone())), None);
    let clipped = slipped(&[], 1)
        .output()
        .iter()
        .map(|y| y.min(0.7))
        .collect();
    assert_eq!(stuck(&recording(DT_S, drive(), clipped)), None);
    let digits = |y: f64| (y * 1e6).round() / 1e6;
    let slipping = quiet.iter().zip(0..);
    let slipping = slipping.map(|(y, k)| digits(if k < 1100 { *y } else { y + 0.8 }));
    let slipping = recording(DT_S, drive(), slipping.collect());
    assert_eq!(stuck(&slipping), None);
    assert_eq!(slips(&slipping).len(), 1);
    let rounded = repeated(&[(805, 845)]);
    let output = rounded.output().iter().map(|y| (y * 8.0).round() / 8.0);
    assert_eq!(stuck(&recording(DT_S, drive(), output.collect())), None);
}
