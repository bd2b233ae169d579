//! One spoiled sample in a sound recording: the diagnosis says what it says without it.
//!
//! A few by default; `SMA_SPOILED=32` spoils each of four recordings at as many places, in each way (docs/reliability.md).

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests, which say what was tried"
)]

use std::fmt::Write;
use std::fs;
use std::path::Path;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Recording, RecordingParts, wild};
use serde_json::Value;
use truth_plant::{Converter, Draw, LatentHeat, Noise, NoiseKind, OutputFilter, Shape, TruthPlant};

use crate::folder::sma;
use crate::make_fleet::rod_file;

const SAMPLES: usize = 600;
const DT_S: f64 = 1.0;
const NOISE_MM: f64 = 0.005;

/// Time, drive and output of a row.
type Row = [f64; 3];

/// Changes one row of a recording.
type Spoil = fn(&mut [Row], usize);

const WAYS: [(&str, Spoil); 7] = [
    ("drive x 0", |rows, k| rows[k][1] = 0.0),
    ("drive x 1.5", |rows, k| rows[k][1] *= 1.5),
    ("drive x 10", |rows, k| rows[k][1] *= 10.0),
    ("output + 10 deviations", |rows, k| {
        rows[k][2] += 10.0 * NOISE_MM;
    }),
    ("output 0", |rows, k| rows[k][2] = 0.0),
    ("output 1e6", |rows, k| rows[k][2] = 1e6),
    ("time + half a step", |rows, k| rows[k][0] += 0.5 * DT_S),
];

/// Four wires and how they are driven: two of the baseline model's physics, two that conceal an effect.
fn recordings() -> [Vec<Row>; 4] {
    let latent_heat = Some(LatentHeat {
        enthalpy_j_per_kg: 14_000.0,
    });
    let output_filter = Some(OutputFilter {
        time_constant_s: 3.0,
        dead_time_s: 0.0,
    });
    [
        (Shape::Ramps, None, None),
        (Shape::InnerLoops, latent_heat, None),
        (Shape::Holds, None, output_filter),
        (Shape::Stairs, None, None),
    ]
    .map(|(shape, latent_heat, output_filter)| {
        let plant = TruthPlant {
            latent_heat,
            output_filter,
            displacement_noise: Some(Noise {
                kind: NoiseKind::White,
                deviation: NOISE_MM * 1e-3,
            }),
            ..TruthPlant::default()
        };
        let drive = Draw::new(1).drive(shape, &plant, SAMPLES).drive;
        let traces = plant.simulate(&drive, DT_S, 1).unwrap();
        (0..SAMPLES)
            .map(|k| [traces.time_s[k], traces.drive[k], traces.displacement_mm[k]])
            .collect()
    })
}

/// Verdict and names.
type Said = (String, Vec<String>);

/// Diagnosis of a recording, as JSON.
fn document(folder: &Path, rows: &[Row], effort: &str) -> Value {
    let mut text = "time_s,current_a,displacement_mm\n".to_owned();
    for [time_s, drive, output] in rows {
        writeln!(text, "{time_s:.3},{drive:.4},{output:.4}").unwrap();
    }
    fs::write(folder.join("train.csv"), text).unwrap();
    let (code, json, said) = sma(
        folder,
        &format!(
            "diagnose rod.toml --train train.csv --effort {effort} --threads 1 --quiet --json -"
        ),
    );
    assert!(code == 0 || code == 4, "{said}");
    serde_json::from_str(&json).unwrap()
}

fn said(document: &Value) -> Said {
    let findings = document["findings"].as_array().unwrap().iter();
    (
        document["verdict"].as_str().unwrap().to_owned(),
        findings
            .map(|one| one["effect"].as_str().unwrap().to_owned())
            .collect(),
    )
}

fn diagnosed(folder: &Path, rows: &[Row], effort: &str) -> Said {
    said(&document(folder, rows, effort))
}

#[test]
fn sound_recordings_have_no_wild_samples() {
    for shape in Shape::ALL {
        // From two samples a time constant to fifty.
        for (seed, n) in (1..).zip([150, 300, 600, 1500, 3000]) {
            let plant = TruthPlant {
                displacement_noise: Some(Noise {
                    kind: NoiseKind::White,
                    deviation: 3e-6,
                }),
                converter: Some(Converter {
                    full_scale_m: 10e-3,
                    lowest_m: -1e-3,
                    bits: 12,
                }),
                ..TruthPlant::default()
            };
            let drive = Draw::new(seed).drive(shape, &plant, n).drive;
            let traces = plant.simulate(&drive, 600.0 / n as f64, seed).unwrap();
            let recording = Recording::new(RecordingParts {
                time_s: Some(traces.time_s),
                drive,
                output: traces.displacement_mm,
                output_unit: "mm".to_owned(),
                ..RecordingParts::default()
            });
            assert_eq!(wild(&recording.unwrap()), [], "{shape:?}, {n}");
        }
    }
}

#[test]
fn a_spoiled_sample_beside_a_step_is_put_right_by_the_model() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rod.toml"), rod_file()).unwrap();
    let [_, _, rows, _] = recordings();
    // A step a sample late: the drives before and behind it are as near.
    let mut spoiled = rows;
    spoiled[260][1] *= 1.5;
    let document = document(folder.path(), &spoiled, "quick");
    assert_eq!(
        said(&document),
        ("explained".to_owned(), vec!["output-lag".to_owned()])
    );
    let mut notes = document["notes"].as_array().unwrap().iter();
    let note = "at 260 s does not fit the output";
    assert!(
        notes.any(|one| one.as_str().unwrap().contains(note)),
        "{document}"
    );
}

/// Places that are tried in each recording, if it is not a few, and the effort of the diagnoses.
fn asked_for() -> (Option<usize>, &'static str) {
    let n_places = std::env::var("SMA_SPOILED").ok();
    let n_places: Option<usize> = n_places.map(|text| text.parse().unwrap());
    (n_places, n_places.map_or("quick", |_| "normal"))
}

/// The rod did not see the noise of the sensor that reads its drive. It is smoothed, and what is left of it is no effect.
#[test]
fn noise_in_the_column_of_the_drive_has_no_name() {
    let (all, effort) = asked_for();
    let (shares, seeds): (&[f64], _) = match all {
        Some(_) => (&[0.005, 0.01, 0.03], 1..3),
        None => (&[0.01], 1..2),
    };
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rod.toml"), rod_file()).unwrap();
    let (mut n_tried, mut n_found) = (0, 0);
    let concealed: [&[&str]; 4] = [&[], &["latent-heat"], &["output-lag"], &[]];
    for ((wire, rows), names) in recordings().into_iter().enumerate().zip(concealed) {
        let highest = rows.iter().map(|row| row[1]).fold(0.0, f64::max);
        for share in shares {
            for seed in seeds.clone() {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                let noisy: Vec<Row> = rows
                    .iter()
                    .map(|&[time_s, drive, output]| {
                        let normal: f64 = StandardNormal.sample(&mut rng);
                        [time_s, drive + share * highest * normal, output]
                    })
                    .collect();
                let found = diagnosed(folder.path(), &noisy, effort);
                println!("wire {wire}, {share}, {seed}: {found:?}");
                let strangers = found
                    .1
                    .iter()
                    .filter(|name| !names.contains(&name.as_str()));
                assert_eq!(
                    strangers.count(),
                    0,
                    "wire {wire}, {share}, {seed}: {found:?}"
                );
                n_tried += names.len();
                n_found += found.1.len();
            }
        }
    }
    println!("{n_found} of {n_tried} effects found");
    // Of large noise an effect may be hidden.
    assert!(4 * n_found >= 3 * n_tried, "{n_found} of {n_tried}");
}

#[test]
fn one_spoiled_sample_changes_no_verdict() {
    let (n_places, effort) = asked_for();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("rod.toml"), rod_file()).unwrap();
    let mut others = Vec::new();
    let mut n_tried = 0;
    for (wire, rows) in recordings().into_iter().enumerate() {
        let sound = diagnosed(folder.path(), &rows, effort);
        println!("wire {wire}: {sound:?}");
        for place in 0..n_places.unwrap_or(1) {
            // The first three and the last three stand beside no others.
            let room = (SAMPLES - 6) as f64;
            let share = (place as f64 + 0.618 * (wire + 1) as f64).fract();
            let k = 3 + ((place as f64 + share) * room / n_places.unwrap_or(1) as f64) as usize;
            for (way, (name, spoil)) in WAYS.iter().enumerate() {
                if n_places.is_none() && way % 4 != wire {
                    continue;
                }
                let mut spoiled = rows.clone();
                spoil(&mut spoiled, k);
                n_tried += 1;
                let found = diagnosed(folder.path(), &spoiled, effort);
                if found != sound {
                    others.push(format!(
                        "wire {wire}, row {k}, {name}: {found:?} instead of {sound:?}"
                    ));
                    println!("{}", others[others.len() - 1]);
                }
            }
        }
    }
    println!("{n_tried} tried, {} others", others.len());
    assert!(others.is_empty(), "{others:#?}");
}
