//! A whole diagnosis of one rig, told in other units, at another time, with another zero: the same verdict and the same numbers.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

use crate::diagnose::sampled_with_latent_heat;

/// Samples of the bundled recordings for one of the rig: a diagnosis takes a fraction of a second.
const EVERY: usize = 8;

/// Relative distance of numbers that are the same.
const SAME: f64 = 1e-6;

/// Time, drive and output of a row.
type Row = [f64; 3];

/// One way to tell of the rig.
struct Told {
    name: &'static str,
    header: &'static str,
    row: fn(Row) -> Row,
    /// Output of the variant over that of the rig, without its zero.
    output: f64,
    /// Training recordings, in their order.
    order: &'static [&'static str],
}

impl Told {
    /// True if the training recordings begin with the second.
    fn is_turned(&self) -> bool {
        self.order[0] == "b.csv"
    }
}

const PLAIN: Told = Told {
    name: "as it is",
    header: "time_s,current_a,displacement_mm",
    row: |row| row,
    output: 1.0,
    order: &["a.csv", "b.csv"],
};

const TOLD: [Told; 5] = [
    Told {
        name: "in micrometers, milliseconds and milliamperes",
        header: "\"time_ms\",\"current_ma\",\"displacement_um\"",
        row: |[t, i, y]| [t * 1e3, i * 1e3, y * 1e3],
        output: 1e3,
        ..PLAIN
    },
    Told {
        name: "a day later, a meter higher",
        row: |[t, i, y]| [t + 86_400.0, i, y + 1000.0],
        ..PLAIN
    },
    Told {
        name: "the other way round",
        row: |[t, i, y]| [t, i, -y],
        output: -1.0,
        ..PLAIN
    },
    Told {
        name: "recordings in another order",
        order: &["b.csv", "a.csv"],
        ..PLAIN
    },
    Told {
        name: "a recording given twice, the second time with fewer digits",
        order: &["a.csv", "b.csv", "copy.csv"],
        ..PLAIN
    },
];

/// Recordings with the surroundings of each sample, in °C and in K.
const SURROUNDED: [Told; 2] = [
    Told {
        name: "surroundings in degrees",
        header: "time_s,current_a,displacement_mm,ambient_degc",
        ..PLAIN
    },
    Told {
        name: "surroundings in kelvins",
        header: "time_s,current_a,displacement_mm,ambient_k",
        ..PLAIN
    },
];

/// Temperature of the surroundings, as in the rod file.
const AMBIENT_DEGC: f64 = 22.0;

/// A recording of the rig.
fn rows(folder: &Path, name: &str) -> Vec<Row> {
    let text = fs::read_to_string(folder.join(name)).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines
        .map(|line| {
            let values: Vec<f64> = line
                .split(',')
                .map(|field| field.parse().unwrap())
                .collect();
            [values[0], values[1], values[2]]
        })
        .collect()
}

fn write(place: &Path, told: &Told, rows: &[Row]) {
    let mut text = format!("{}\n", told.header);
    for row in rows {
        let [time, drive, output] = (told.row)(*row);
        write!(text, "{time},{drive},{output}").unwrap();
        if told.header.ends_with("ambient_degc") {
            write!(text, ",{AMBIENT_DEGC}").unwrap();
        } else if told.header.ends_with("ambient_k") {
            write!(text, ",{}", AMBIENT_DEGC + 273.15).unwrap();
        }
        text.push('\n');
    }
    fs::write(place, text).unwrap();
}

/// Two training recordings.
fn parts(folder: &Path) -> [Vec<Row>; 2] {
    ["train.csv", "validate.csv"].map(|name| rows(folder, name))
}

fn diagnosed(rig: &Path, parts: &[Vec<Row>; 2], told: &Told) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    fs::copy(rig.join("rod.toml"), place("rod.toml")).unwrap();
    for (name, rows) in ["a.csv", "b.csv"].into_iter().zip(parts) {
        write(&place(name), told, rows);
    }
    let fewer_digits = |[time, drive, output]: &Row| [*time, *drive, (output * 1e3).round() / 1e3];
    let copy: Vec<Row> = parts[0].iter().map(fewer_digits).collect();
    write(&place("copy.csv"), told, &copy);
    let output = Command::cargo_bin("sma")
        .unwrap()
        .current_dir(folder.path())
        .args(["diagnose", "rod.toml", "--train"])
        .args(told.order)
        .args([
            "--effort",
            "quick",
            "--threads",
            "1",
            "--quiet",
            "--json",
            "-",
        ])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.stdout.is_empty(), "{}: {said}", told.name);
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Verdict and names of what was found.
fn names(document: &Value) -> (String, Vec<String>) {
    let findings = document["findings"].as_array().unwrap().iter();
    let effects = findings.map(|one| one["effect"].as_str().unwrap().to_owned());
    (
        document["verdict"].as_str().unwrap().to_owned(),
        effects.collect(),
    )
}

/// A parameter: its name, its value, and the width of its interval.
type Number = (String, f64, f64);

/// Parameters of the baseline model that all recordings share, then those of the extended model; the center of the loop as it would
/// be if the surroundings of `a.csv` were those that are stated, which are those of the first recording.
fn numbers(document: &Value, told: &Told) -> Vec<Number> {
    let mut all = Vec::new();
    for model in ["baseline", "extended"] {
        let parameters = document[model]["parameters"].as_array();
        let parameters = || parameters.into_iter().flatten();
        let level = parameters().find(|one| one["name"] == "ambient_level_k");
        let level_k = level.map_or(0.0, |one| {
            one["values"][usize::from(told.is_turned())]
                .as_f64()
                .unwrap()
        });
        for one in parameters().filter(|one| one["per_recording"] == false) {
            let name = one["name"].as_str().unwrap().to_owned();
            let ends = [0, 1].map(|end| one["ci95"][0][end].as_f64().unwrap_or(0.0));
            let value = one["values"][0].as_f64().unwrap();
            let above_k = if name == "loop_center_degc" {
                level_k
            } else {
                0.0
            };
            all.push((name, value - above_k, ends[1] - ends[0]));
        }
    }
    all
}

/// Fails if a variant has another verdict, other names or other numbers than the first.
fn compare(rig: &Path, parts: &[Vec<Row>; 2], plain: &Told, others: &[Told]) {
    let document = diagnosed(rig, parts, plain);
    let said = names(&document);
    assert_eq!(said.1, ["latent-heat"]);
    let expected = numbers(&document, plain);
    assert!(expected.len() >= 12, "{expected:?}");
    for told in others {
        let document = diagnosed(rig, parts, told);
        assert_eq!(names(&document), said, "{}", told.name);
        let found = numbers(&document, told);
        assert_eq!(found.len(), expected.len(), "{}", told.name);
        for ((name, found, _), (same, expected, width)) in found.iter().zip(&expected) {
            assert_eq!(name, same, "{}", told.name);
            let factor = if name == "gain" { told.output } else { 1.0 };
            let (expected, width) = (expected * factor, width * factor.abs());
            let apart = (found - expected).abs() / expected.abs().max(width);
            assert!(
                apart <= SAME,
                "{}: {name} = {found}, not {expected}",
                told.name
            );
        }
    }
}

#[test]
fn a_diagnosis_does_not_depend_on_units_zeros_signs_times_order_or_copies() {
    let rig = sampled_with_latent_heat(EVERY);
    let parts = parts(rig.path());
    compare(rig.path(), &parts, &PLAIN, &TOLD);
    let [degrees, kelvins] = SURROUNDED;
    compare(rig.path(), &parts, &degrees, &[kelvins]);
}

#[test]
fn half_of_the_samples_say_the_same() {
    let rig = sampled_with_latent_heat(EVERY / 2);
    let all = parts(rig.path());
    let half = [0, 1].map(|part: usize| all[part].iter().copied().step_by(2).collect());
    let [all, half] = [all, half].map(|parts| names(&diagnosed(rig.path(), &parts, &PLAIN)));
    assert_eq!(all.1, ["latent-heat"]);
    assert_eq!(half, all);
}

/// Time constant of the baseline model by `sma identify`, or its exit code.
fn tau_s(rig: &Path, rows: &[Row], told: &Told) -> Result<f64, Option<i32>> {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    fs::copy(rig.join("rod.toml"), place("rod.toml")).unwrap();
    write(&place("a.csv"), told, rows);
    let output = Command::cargo_bin("sma")
        .unwrap()
        .current_dir(folder.path())
        .args([
            "identify", "rod.toml", "--train", "a.csv", "--quiet", "--json", "-",
        ])
        .output()
        .unwrap();
    if output.status.code() != Some(0) {
        return Err(output.status.code());
    }
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["parameters"][0]["name"], "tau_s");
    Ok(document["parameters"][0]["values"][0].as_f64().unwrap())
}

#[test]
fn an_output_whose_zero_drowns_it_is_refused_or_fitted_as_without_it() {
    let rig = sampled_with_latent_heat(EVERY);
    let [rows, _] = parts(rig.path());
    // Of 16 digits three or four are left behind the point.
    let drowned = Told {
        name: "a zero of 1e12",
        row: |[t, i, y]| [t, i, y + 1e12],
        ..PLAIN
    };
    let expected = tau_s(rig.path(), &rows, &PLAIN).unwrap();
    match tau_s(rig.path(), &rows, &drowned) {
        Ok(found) => assert!((found / expected - 1.0).abs() < 1e-2, "{found} {expected}"),
        Err(code) => assert!(matches!(code, Some(3 | 4)), "{code:?}"),
    }
}
