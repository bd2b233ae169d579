//! Mending removes disturbances that the rig did not see, and keeps those that it saw.

use recording::{Recording, RecordingParts, Warning, inspect, inspect_as_recorded, mended, wild};

use crate::inspect::{Noise, recording, response};

const N: usize = 2000;
const DT_S: f64 = 0.1;

/// Three levels, each held for 20 s after 20 s of rest.
fn drive() -> Vec<f64> {
    let level = |k: usize| [0.0, 1.0, 0.0, 0.6, 0.0, 0.8][k / 200 % 6];
    (0..N).map(level).collect()
}

fn output(drive: &[f64], noise: &mut Noise) -> Vec<f64> {
    let mut output = response(drive, DT_S, 3.0);
    for y in &mut output {
        *y += 1.0 + 0.005 * noise.normal();
    }
    output
}

fn clean() -> Recording {
    let drive = drive();
    let output = output(&drive, &mut Noise(1));
    recording(DT_S, drive, output)
}

/// The clean recording with other values at some samples.
fn with(drive: &[(usize, f64)], output: &[(usize, f64)]) -> Recording {
    let clean = clean();
    let put = |values: &[f64], others: &[(usize, f64)]| {
        let mut values = values.to_vec();
        for (k, value) in others {
            values[*k] = *value;
        }
        values
    };
    recording(DT_S, put(clean.drive(), drive), put(clean.output(), output))
}

fn said(recording: &Recording) -> Vec<String> {
    let done = recording.adaptations().iter();
    done.map(ToString::to_string).collect()
}

#[test]
fn a_clean_recording_stays_as_it_is() {
    let clean = clean();
    assert_eq!(mended(&clean), clean);
}

#[test]
fn glitches_and_dropouts_are_replaced_and_said() {
    let odd = with(
        &[(50, 22.0), (300, 0.3), (1500, -4.0)],
        &[(77, 0.0), (412, 0.0), (413, 0.0), (1234, 0.0)],
    );
    let mended = mended(&odd);
    assert_eq!(mended.drive(), clean().drive());
    for k in [77, 412, 413, 1234] {
        let off = (mended.output()[k] - clean().output()[k]).abs();
        assert!(off < 0.03, "{k}: {off}");
    }
    assert_eq!(
        said(&mended),
        [
            "3 samples of the drive that stand far from both neighbors, the first 22 A at 5 s, are replaced by the mean of \
             their neighbors",
            "4 samples of the output that stand far from both neighbors, the first 0 mm at 7.7 s, are replaced by the line \
             between their neighbors"
        ]
    );
    assert_eq!(wild(&mended), []);
}

#[test]
fn a_single_sample_at_a_level_is_a_dropout_where_the_drive_stays_otherwise() {
    // Once or twice: a logger. Again and again: how the rod is driven.
    let dropouts =
        |n: usize| -> Vec<(usize, f64)> { (0..n).map(|d| (250 + 400 * d, 0.0)).collect() };
    for n in [1, 3] {
        let mended = mended(&with(&dropouts(n), &[]));
        assert_eq!(mended.drive(), clean().drive(), "{n}");
    }
    assert_eq!(wild(&with(&dropouts(4), &[])), []);
    // Where the drive also goes elsewhere for three samples, one sample is nothing special.
    let mut short = dropouts(1);
    short.extend([(1450, 0.3), (1451, 0.3), (1452, 0.3)]);
    assert_eq!(wild(&with(&short, &[])), []);
}

#[test]
fn a_glitch_beside_a_step_is_found_and_an_overshoot_is_none() {
    // The first and the last sample of a level, which is 1 from 20 to 40 s.
    for k in [200, 399] {
        assert_eq!(wild(&with(&[(k, 2.5)], &[]))[0].samples, [k]);
        assert_eq!(wild(&with(&[(k, 1.4)], &[])), []);
    }
}

#[test]
fn an_output_that_falls_out_as_the_drive_steps_is_found() {
    for k in [200, 201, 400, 401] {
        assert_eq!(wild(&with(&[], &[(k, -3.0)]))[0].samples, [k]);
    }
}

/// Samples of the drive and of the output that are wild in a triangle with its answer, some of which are others.
fn wild_in_a_triangle(drive: &[(usize, f64)], output: &[(usize, f64)]) -> [Vec<usize>; 2] {
    let mut up: Vec<f64> = (0..400)
        .map(|k| 0.02 * (200 - (k - 200_i32).abs()) as f64)
        .collect();
    let mut noise = Noise(4);
    // Transforms within six samples near the middle of either slope.
    let answer = |x: f64| 4.0 / (1.0 + (-12.0 * (x - 2.0)).exp());
    let mut answers: Vec<f64> = up
        .iter()
        .map(|x| answer(*x) + 0.003 * noise.normal())
        .collect();
    for (series, others) in [(&mut up, drive), (&mut answers, output)] {
        for (k, value) in others {
            series[*k] = *value;
        }
    }
    let mut found = [Vec::new(), Vec::new()];
    for one in wild(&recording(1.0, up, answers)) {
        found[usize::from(one.role == "output")] = one.samples;
    }
    found
}

#[test]
fn a_slope_hides_no_sample_and_a_corner_is_none() {
    assert_eq!(wild_in_a_triangle(&[], &[]), [vec![], vec![]]);
    for k in [30, 101, 300, 398] {
        assert_eq!(
            wild_in_a_triangle(&[(k, 0.0)], &[])[0].len(),
            usize::from(k < 398),
            "{k}"
        );
    }
    for k in [50, 199, 200, 201, 350] {
        assert_eq!(wild_in_a_triangle(&[], &[(k, -1.0)])[1], [k]);
    }
    // On the steep part of the loop.
    for k in [98, 99, 100, 101, 300, 301] {
        assert_eq!(wild_in_a_triangle(&[], &[(k, -2.0)])[1], [k]);
    }
}

#[test]
fn a_time_out_of_step_is_put_back() {
    let [clean, mut odd] = [(); 2].map(|()| RecordingParts {
        time_s: Some((0..N).map(|k| k as f64 * DT_S).collect()),
        drive: drive(),
        output: output(&drive(), &mut Noise(1)),
        ..RecordingParts::default()
    });
    odd.time_s
        .iter_mut()
        .for_each(|time_s| time_s[210] += 0.5 * DT_S);
    // Not that of a sample that was taken late.
    let mut late = odd.clone();
    late.output[210] = 0.5 * (clean.output[210] + clean.output[211]);
    let [clean, odd, late] = [clean, odd, late].map(|parts| Recording::new(parts).unwrap());
    assert_eq!(mended(&late), late);
    let mended = mended(&odd);
    assert!((mended.time_s()[210] - clean.time_s()[210]).abs() < 1e-9);
    assert_eq!(mended.sampling(), clean.sampling());
    assert_eq!(
        said(&mended),
        [
            "a time between samples in step, 21.05 s in sample 210, is replaced by the mean of its neighbors"
        ]
    );
    let kept = inspect_as_recorded(&odd).warnings();
    let kept = kept.iter().map(ToString::to_string);
    let advice = "a time between samples in step, 21.05 s in sample 210: if the sample was taken in step, correct it in the file";
    assert_eq!(kept.filter(|text| text == advice).count(), 1);
}

#[test]
fn gaps_and_jitter_are_no_times_out_of_step() {
    let parts = |at: &dyn Fn(usize) -> f64| {
        let parts = RecordingParts {
            time_s: Some((0..N).map(at).collect()),
            drive: drive(),
            output: output(&drive(), &mut Noise(1)),
            ..RecordingParts::default()
        };
        wild(&Recording::new(parts).unwrap())
    };
    let gap = |n: f64| move |k: usize| DT_S * (k as f64 + if k < 700 { 0.0 } else { n });
    for n in [0.5, 1.0, 40.0] {
        assert_eq!(parts(&gap(n)), [], "{n}");
    }
    let jitter = |k: usize| DT_S * (k as f64 + 0.5 * (k as f64 * k as f64 * 0.7).sin().abs());
    assert_eq!(parts(&jitter), []);
}

#[test]
fn an_inspection_names_them_and_is_of_the_rest() {
    let odd = with(&[(50, 22.0)], &[]);
    let inspection = inspect(&odd);
    assert!((inspection.drive.highest - 1.0).abs() < 1e-12);
    assert_eq!(inspection.cycles.len(), inspect(&clean()).cycles.len());
    let warns = |inspection: &recording::Inspection| {
        let warnings = inspection.warnings();
        let wild = warnings
            .iter()
            .find(|warning| matches!(warning, Warning::Wild { .. }));
        wild.unwrap().to_string()
    };
    assert_eq!(
        warns(&inspection),
        "a sample of the drive that stands far from both neighbors, 22 A at 5 s, is replaced by the mean of its neighbors in a \
         fit; as_recorded = true under [columns] keeps what was recorded"
    );
    let kept = inspect_as_recorded(&odd);
    assert!((kept.drive.highest - 22.0).abs() < 1e-12);
    assert_eq!(
        warns(&kept),
        "a sample of the drive that stands far from both neighbors, 22 A at 5 s: if the rig did not see it, take it out of the \
         file, or every fit follows it"
    );
}

#[test]
fn what_drives_the_rod_is_no_glitch() {
    // A pulse of one sample every fifth second, and what the output makes of it.
    let drive: Vec<f64> = (0..N).map(|k| f64::from(u8::from(k % 50 == 25))).collect();
    let output = output(&drive, &mut Noise(2));
    assert_eq!(wild(&recording(DT_S, drive, output)), []);
    // Small single steps of a controller's duty.
    let drive: Vec<f64> = (0..N)
        .map(|k| (k / 200) as f64 + f64::from(u8::from(k % 301 == 25)) * 0.2)
        .collect();
    let output = response(&drive, DT_S, 3.0);
    assert_eq!(wild(&recording(DT_S, drive, output)), []);
    // An output that is quiet at rest, and busy in steps of its converter where it is driven.
    let mut noise = Noise(3);
    let busy: Vec<f64> = (0..N)
        .map(|k| {
            if k < 1500 {
                40.0
            } else {
                50.0 + (2.0 * noise.normal()).round()
            }
        })
        .collect();
    assert_eq!(wild(&recording(DT_S, clean().drive().to_vec(), busy)), []);
    // A rod faster than the logger follows two samples of drive.
    let mut drive = vec![0.0; N];
    drive[500..502].fill(1.0);
    drive[1000..1300].fill(1.0);
    let mut output = vec![1.0; N];
    output[501..503].fill(2.0);
    output[1001..1301].fill(2.0);
    assert_eq!(wild(&recording(DT_S, drive, output)), []);
}

#[test]
fn static_data_have_places_instead_of_times() {
    let mut output: Vec<f64> = (0..200).map(|k| (0.03 * f64::from(k)).sin()).collect();
    output[120] = 9.0;
    let odd = Recording::new(RecordingParts {
        name: "loop.csv".to_owned(),
        drive: (0..200).map(f64::from).collect(),
        output,
        drive_quantity: recording::Quantity::Temperature,
        output_unit: "mm".to_owned(),
        ..RecordingParts::default()
    })
    .unwrap();
    assert_eq!(
        said(&mended(&odd)),
        [
            "a sample of the output that stands far from both neighbors, 9 mm in sample 120, is replaced by the mean of its neighbors"
        ]
    );
}
