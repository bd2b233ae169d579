//! A supply that saturates: what is beyond its limit counts as the limit.

use recording::{Quantity, ReadOptions, Recording, RecordingParts, parse_csv};

fn with_limit(limit: f64, csv: &str) -> Recording {
    let options = ReadOptions {
        drive_limit: Some(limit),
        ..ReadOptions::new(Quantity::Current)
    };
    parse_csv(csv.as_bytes(), "run3.csv", &options).unwrap()
}

#[test]
fn what_the_supply_does_not_give_does_not_act_and_is_said() {
    let csv = "time_s,current_a,position_mm\n0,0,1\n1,0.62,1\n2,-0.5,1\n3,0.45,2\n4,0.3,2\n";
    let limited = with_limit(0.45, csv);
    assert_eq!(limited.drive(), [0.0, 0.45, -0.45, 0.45, 0.3]);
    let said: Vec<String> = limited
        .adaptations()
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(
        said,
        [
            "the supply gives at most 0.45 A: 2 samples of the drive, up to 0.62 A and the first at 1 s, count as that"
        ]
    );
}

#[test]
fn a_limit_that_is_never_met_changes_nothing() {
    let csv = "time_s,current_a,position_mm\n0,0,1\n1,0.45,1\n";
    let limited = with_limit(0.45, csv);
    let as_it_is = parse_csv(csv.as_bytes(), "run3.csv", &ReadOptions::default()).unwrap();
    assert_eq!(limited, as_it_is);
}

#[test]
fn what_was_done_to_the_file_is_said_before_it() {
    let folder = std::env::temp_dir().join(format!("recording-limited-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("comma.csv");
    std::fs::write(
        &path,
        "time_s;current_a;position_mm\n0;0,0;1\n1;0,8;1\n2;0,2;2\n",
    )
    .unwrap();
    let options = ReadOptions {
        drive_limit: Some(0.5),
        ..ReadOptions::default()
    };
    let read = recording::read_csv(&path, &options);
    std::fs::remove_dir_all(&folder).unwrap();
    let read = read.unwrap();
    assert_eq!(read.drive(), [0.0, 0.5, 0.2]);
    assert_eq!(read.adaptations().len(), 2, "{:?}", read.adaptations());
    assert!(read.adaptations()[1].what.starts_with("the supply gives"));
}

#[test]
fn a_limit_is_a_magnitude() {
    let recording = || {
        Recording::new(RecordingParts {
            name: "run".to_owned(),
            drive_quantity: Quantity::Voltage,
            drive: vec![0.0, 1.0],
            output: vec![0.0, 1.0],
            ..RecordingParts::default()
        })
        .unwrap()
    };
    for limit in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        assert_eq!(
            recording().limited(limit).unwrap_err().to_string(),
            format!("run: drive limit = {limit} V: must be finite and > 0")
        );
    }
}
