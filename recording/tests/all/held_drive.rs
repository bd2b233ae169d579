//! A drive at even times, held between its samples.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use recording::{Recording, RecordingParts};

fn with_times(time_s: Option<Vec<f64>>) -> Recording {
    Recording::new(RecordingParts {
        time_s,
        drive: vec![1.0, 2.0, 3.0],
        output: vec![0.0, 0.1, 0.2],
        ..RecordingParts::default()
    })
    .unwrap()
}

#[test]
fn each_sample_holds_until_the_next_and_the_last_for_good() {
    let uneven = with_times(Some(vec![10.0, 10.3, 11.0]));
    assert_eq!(uneven.held_drive(0.25, 6), [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]);
}

#[test]
fn its_own_step_gives_the_drive_whatever_the_time_stamps_were_rounded_to() {
    let even = with_times(Some(vec![0.1, 0.2, 0.300_000_01]));
    assert_eq!(even.held_drive(0.1, 3), even.drive());
}

#[test]
fn static_data_have_no_time_to_hold_over() {
    assert!(with_times(None).held_drive(0.1, 3).is_empty());
}
