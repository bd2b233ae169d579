//! Parts of recordings, fewer rows, and no drift from rest to rest.

use recording::{Quantity, Recording, RecordingParts};

use crate::inspect::{Noise, recording, response};

const DT_S: f64 = 0.1;

fn drive() -> Vec<f64> {
    let level = |k: usize| [0.0, 1.0, 0.5, 0.0, 0.0][k / 200 % 5];
    (0..1000).map(level).collect()
}

fn plain() -> Recording {
    let drive = drive();
    let output = response(&drive, DT_S, 2.0);
    recording(DT_S, drive, output)
}

fn said(recording: &Recording) -> Vec<String> {
    let done = recording.adaptations().iter();
    done.map(ToString::to_string).collect()
}

#[test]
fn spans_at_the_ends_are_left_out_and_what_leaves_nothing_is_refused() {
    let plain = plain();
    let [left] = &plain.excluding(&[[-1.0, 5.05], [90.0, 99.9]]).unwrap()[..] else {
        unreachable!("one part is left")
    };
    assert_eq!(left.name(), "run3.csv");
    assert_eq!(left.len(), 1000 - 51 - 100);
    assert_eq!(left.drive(), &plain.drive()[51..900]);
    assert_eq!(
        said(left),
        [
            "-1 to 5.05 s of it are left out",
            "90 to 99.9 s of it are left out"
        ]
    );
    for spans in [
        &[[-1.0, 200.0]][..],
        &[[f64::NAN, 5.0]],
        &[[5.0, 1.0]],
        // One sample between two spans.
        &[[10.0, 20.0], [20.15, 30.0]],
    ] {
        let fault = plain.excluding(spans).unwrap_err().to_string();
        assert!(fault.starts_with("run3.csv: samples "), "{fault}");
    }
}

#[test]
fn a_span_in_the_middle_leaves_two_recordings() {
    let plain = plain();
    let parts = plain.excluding(&[[33.0, 41.0], [0.0, 0.05]]).unwrap();
    let names: Vec<&str> = parts.iter().map(Recording::name).collect();
    assert_eq!(names, ["run3.csv:0.1..32.9", "run3.csv:41.1..99.9"]);
    let [before, after] = &parts[..] else {
        unreachable!("two parts are left")
    };
    assert_eq!(before.output(), &plain.output()[1..330]);
    assert_eq!(after.output(), &plain.output()[411..]);
    assert_eq!(after.time_s(), &plain.time_s()[411..]);
    for part in &parts {
        assert_eq!(
            said(part),
            [
                "33 to 41 s of it are left out",
                "0 to 0.05 s of it are left out",
                "the parts are recordings of their own, each with its start and offset"
            ]
        );
    }
}

#[test]
fn fewer_rows_have_the_means_of_those_around_and_are_not_shifted() {
    let mut noise = Noise(1);
    let n = 2000;
    let ramp: Vec<f64> = (0..n).map(|k| 0.01 * f64::from(k)).collect();
    let noisy: Vec<f64> = ramp.iter().map(|y| y + 0.1 * noise.normal()).collect();
    let held: Vec<f64> = (0..n).map(|k| if k < 1000 { 0.0 } else { 0.3 }).collect();
    let few = recording(DT_S, held.clone(), noisy).decimated(10).unwrap();
    assert_eq!(few.len(), 200);
    assert!((few.time_s()[7] - 7.0).abs() < 1e-12);
    // A held drive stays as it is, to the bit.
    assert!((0..200).all(|j| few.drive()[j].to_bits() == held[10 * j].to_bits()));
    let off: Vec<f64> = (0..200).map(|j| few.output()[j] - ramp[10 * j]).collect();
    let mean = off.iter().sum::<f64>() / 200.0;
    let spread = (off.iter().map(|off| off * off).sum::<f64>() / 200.0).sqrt();
    // Nine samples: a third of the noise, and no lead or lag.
    assert!(
        mean.abs() < 0.01 && (spread / (0.1 / 3.0) - 1.0).abs() < 0.2,
        "{mean} {spread}"
    );
    assert_eq!(
        said(&few),
        ["one row in 10 is used, with the mean of those around it"]
    );
    // Currents heat by their squares, duties by themselves.
    let pulses: Vec<f64> = (0..n).map(|k| if k % 4 == 0 { 1.0 } else { 0.0 }).collect();
    let few = recording(DT_S, pulses.clone(), ramp.clone())
        .decimated(4)
        .unwrap();
    assert!((few.drive()[9] - 0.5).abs() < 1e-9);
    let duty = Recording::new(RecordingParts {
        time_s: Some((0..n).map(|k| DT_S * f64::from(k)).collect()),
        drive_quantity: Quantity::Duty,
        drive: pulses,
        output: ramp,
        ..RecordingParts::default()
    });
    assert!((duty.unwrap().decimated(4).unwrap().drive()[9] - 0.25).abs() < 1e-9);
    for n in [0, 1, 501] {
        assert_eq!(
            plain().decimated(n).unwrap_err().to_string(),
            format!("run3.csv: one row in {n}; expected one in 2 to 500, half of the rows")
        );
    }
}

#[test]
fn a_line_from_rest_to_rest_is_taken_off() {
    let plain = plain();
    let mut noise = Noise(2);
    let drifted = |k: usize, y: f64| y + 0.002 * k as f64 * DT_S;
    let output = plain.output().iter().enumerate();
    let output = output.map(|(k, y)| drifted(k, *y) + 0.001 * noise.normal());
    let straight = recording(DT_S, drive(), output.collect())
        .detrended()
        .unwrap();
    let off = straight.output().iter().zip(plain.output());
    let off: Vec<f64> = off.map(|(one, other)| one - other).collect();
    // The level at the start stays: it is that of the middle of the rest there.
    let level = drifted(100, 0.0);
    assert!(off.iter().all(|off| (off - level).abs() < 0.006));
    let said = said(&straight);
    assert!(
        said[0].starts_with("a straight line of 0.1")
            && said[0].ends_with(" mm from rest to rest is taken off the output"),
        "{said:?}"
    );
    let refused = |recording: Recording| recording.detrended().unwrap_err().to_string();
    assert_eq!(
        refused(plain.slice(200..1000).unwrap()),
        "run3.csv: at rest: 0 samples at the start, 400 at the end, where the output still moves by 0.0 % of its range; expected at \
         least 10 at the start, and 40 at the end that move by less than 1 %, to take a straight line off"
    );
    let text = refused(plain.slice(0..660).unwrap());
    assert!(
        text.contains("200 samples at the start, 60 at the end, where the output still moves by "),
        "{text}"
    );
    assert!(
        refused(plain.slice(0..300).unwrap()).contains("200 samples at the start, 0 at the end")
    );
}

#[test]
fn static_data_have_no_spans() {
    let untimed = Recording::new(RecordingParts {
        name: "loop.csv".to_owned(),
        drive: (0..100).map(f64::from).collect(),
        output: (0..100).map(|k| 2.0 * f64::from(k)).collect(),
        drive_quantity: Quantity::Temperature,
        ..RecordingParts::default()
    })
    .unwrap();
    let no_time = "loop.csv: no time; expected a recording with a time column";
    assert_eq!(
        untimed.excluding(&[[0.0, 1.0]]).unwrap_err().to_string(),
        no_time
    );
    assert_eq!(untimed.detrended().unwrap_err().to_string(), no_time);
    let few = untimed.decimated(5).unwrap();
    assert!((few.drive()[7] - 35.0).abs() < 1e-12 && (few.output()[7] - 70.0).abs() < 1e-12);
}
