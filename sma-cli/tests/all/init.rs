//! `sma init`: a rod file to begin with.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::{Path, PathBuf};

use crate::folder::sma;

fn bundled(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("bundled")
        .join(name)
}

/// The bundled recording as a spreadsheet of another country saves it.
fn as_german(name: &str) -> String {
    let text = fs::read_to_string(bundled(name)).unwrap();
    let (_, rows) = text.split_once("displacement_mm\n").unwrap();
    let rows = rows.replace(',', ";").replace('.', ",");
    format!("Messung vom 5. Mai\n\nZeit [s];Strom [A];Weg [mm]\n{rows}")
}

#[test]
fn from_a_file_to_a_fit_in_two_commands() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("lauf1.csv"), as_german("train.csv")).unwrap();
    fs::write(folder.join("lauf2.csv"), as_german("validate.csv")).unwrap();
    let (code, said, stderr) = sma(folder, "init lauf1.csv lauf2.csv");
    assert_eq!((code, stderr.as_str()), (0, ""), "{said}");
    for expected in [
        "read as: numbers have a decimal comma",
        "drive, current",
        "? ambient_degc = 22.0: what was the temperature of the room?",
        "sma identify rod.toml --train lauf1.csv --validate lauf2.csv",
    ] {
        assert!(said.contains(expected), "{expected}:\n{said}");
    }
    let call = "identify rod.toml --train lauf1.csv --validate lauf2.csv --no-plot";
    let (code, said, stderr) = sma(folder, call);
    assert_eq!(code, 0, "{said}{stderr}");
    assert!(stderr.contains("decimal comma"), "{stderr}");
}

/// The bundled training recording, in which somebody held the sensor from 150 to 170 s.
fn held_by_somebody() -> String {
    let text = fs::read_to_string(bundled("train.csv")).unwrap();
    let held = |line: &str| {
        let time_s = line.split(',').next()?.parse::<f64>().ok()?;
        let (before, _) = line.rsplit_once(',')?;
        (150.0..=170.0)
            .contains(&time_s)
            .then(|| format!("{before},9.5"))
    };
    let (head, rows) = text.split_once("displacement_mm\n").unwrap();
    let head = [head, "displacement_mm"].concat();
    std::iter::once(head.as_str())
        .chain(rows.lines())
        .map(|line| held(line).unwrap_or_else(|| line.to_owned()) + "\n")
        .collect()
}

#[test]
fn a_span_in_the_middle_is_left_out_of_a_fit_and_of_a_diagnosis() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("run.csv"), held_by_somebody()).unwrap();
    let rod = fs::read_to_string(bundled("rod.toml")).unwrap();
    fs::write(folder.join("rod.toml"), &rod).unwrap();
    let json = |call: &str| {
        let (code, said, stderr) = sma(folder, call);
        assert_eq!(code, 0, "{call}: {stderr}");
        serde_json::from_str::<serde_json::Value>(&said).unwrap()
    };
    let call = "identify rod.toml --train run.csv --no-plot --quiet --json -";
    let rmse = |document: &serde_json::Value| document["fit"]["train_rmse"].as_f64().unwrap();
    let (_, whole, _) = sma(folder, call);
    let whole = rmse(&serde_json::from_str(&whole).unwrap());
    let call = format!("{call} --save-model model.toml");
    let by_flag = json(&format!("{call} --exclude run.csv:150..170"));
    assert!(rmse(&by_flag) < 0.01 && whole > 0.1, "{by_flag} {whole}");
    let values = by_flag["parameters"].as_array().unwrap();
    let tau = values.iter().find(|one| one["name"] == "tau_s").unwrap();
    let tau_s = tau["values"][0].as_f64().unwrap();
    assert!((tau_s / 12.38 - 1.0).abs() < 0.01, "{tau_s}");
    // The rod file says the same, and the model keeps it.
    let kept = "[recordings.\"run.csv\"]\nexclude_s = [[150, 170]]\n";
    fs::write(folder.join("rod.toml"), format!("{rod}\n{kept}")).unwrap();
    let by_file = json(&call);
    assert_eq!(by_file["parameters"], by_flag["parameters"]);
    let model = fs::read_to_string(folder.join("model.toml")).unwrap();
    assert!(
        model.contains("[recordings.\"run.csv\"]\nexclude_s = [[\n    150,\n    170,\n]]\n")
            || model.contains("[recordings.\"run.csv\"]\nexclude_s = [[150, 170]]\n"),
        "{model}"
    );
    let (code, simulated, notes) = sma(folder, "simulate model.toml --drive run.csv");
    assert_eq!(code, 0, "{notes}");
    assert!(
        notes.contains("spans that are left out of a fit are simulated with what is around them"),
        "{notes}"
    );
    assert_eq!(simulated.lines().count(), 2001, "every row");
    // Another recording of that name has no such span.
    fs::create_dir(folder.join("other")).unwrap();
    fs::copy(bundled("validate.csv"), folder.join("other/run.csv")).unwrap();
    let (code, _, notes) = sma(folder, "simulate model.toml --drive other/run.csv");
    assert_eq!(code, 0, "{notes}");
    assert!(!notes.contains("left out"), "{notes}");
    let diagnosed = json("diagnose rod.toml --train run.csv --no-plot --quiet --json -");
    assert_eq!(diagnosed["verdict"], "adequate", "{diagnosed}");
}

#[test]
fn a_window_leaves_the_rest_out_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("run.csv"), as_german("train.csv")).unwrap();
    let (code, ..) = sma(folder, "init run.csv");
    assert_eq!(code, 0);
    let rod = fs::read_to_string(folder.join("rod.toml")).unwrap();
    let window = "[recordings.\"run.csv\"]\nwindow_s = [10, 110]\n";
    fs::write(folder.join("rod.toml"), format!("{rod}\n{window}")).unwrap();
    let (code, said, stderr) = sma(folder, "inspect run.csv --rod rod.toml");
    assert_eq!(code, 0, "{stderr}");
    assert!(said.contains("10 to 110 s of it are used"), "{said}");
    assert!(said.contains(" over 100.0 s"), "{said}");
    // A flag goes before the file, and a span in the middle leaves two parts.
    let (code, said, _) = sma(
        folder,
        "inspect run.csv --rod rod.toml --window run.csv:20..60 --decimate 2",
    );
    assert_eq!(code, 0);
    assert!(said.contains("20 to 60 s of it are used"), "{said}");
    assert!(said.contains("one row in 2 is used"), "{said}");
    let (code, said, _) = sma(
        folder,
        "inspect run.csv --rod rod.toml --exclude run.csv:33..41",
    );
    assert_eq!(code, 0);
    assert!(said.contains("33 to 41 s of it are left out"), "{said}");
    let parts = said.lines().filter(|line| line.starts_with("run.csv:"));
    assert_eq!(parts.count(), 2, "{said}");
    fs::write(folder.join("rod.toml"), window.replace("110", "5")).unwrap();
    let (code, _, stderr) = sma(folder, "inspect run.csv --rod rod.toml");
    assert_eq!(code, 3);
    assert!(
        stderr.contains("recordings.\"run.csv\".window_s"),
        "{stderr}"
    );
}

#[test]
fn nothing_is_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("run.csv"), as_german("train.csv")).unwrap();
    fs::write(folder.join("other.csv"), "t,u\n0,1\n1,2\n").unwrap();
    fs::write(folder.join("rod.toml"), "mine").unwrap();
    let (code, _, stderr) = sma(folder, "init run.csv");
    let expected =
        "sma: rod.toml: is there already; expected a new file, or --force to write over it\n";
    assert_eq!((code, stderr.as_str()), (3, expected));
    let (code, _, stderr) = sma(folder, "init run.csv other.csv --rod new.toml");
    assert_eq!(code, 3);
    assert!(
        stderr.contains("other.csv: other columns than run.csv"),
        "{stderr}"
    );
    assert!(!folder.join("new.toml").exists());
    assert_eq!(fs::read_to_string(folder.join("rod.toml")).unwrap(), "mine");
    let (code, ..) = sma(folder, "init run.csv --force");
    assert_eq!(code, 0);
    fs::write(folder.join("notes.txt"), "no numbers here\n").unwrap();
    let (code, _, stderr) = sma(folder, "init notes.txt --force");
    assert_eq!(code, 3);
    assert!(stderr.contains("notes.txt: no table"), "{stderr}");
}
