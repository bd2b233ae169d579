//! `sma simulate`, and what `sma identify` keeps for it.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use rig_files::model_file;

fn bundled() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("bundled")
}

fn sma(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::cargo_bin("sma").unwrap();
    command.current_dir(folder).args(args);
    command
}

/// stdout and stderr of a call that does its work.
fn output(command: &mut Command) -> (String, String) {
    let assert = command.assert().success();
    let output = assert.get_output().clone();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr))
}

/// A folder with the bundled files and the model identified from them.
fn identified() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["rod.toml", "train.csv", "validate.csv"] {
        std::fs::copy(bundled().join(name), folder.path().join(name)).unwrap();
    }
    let args = [
        "identify",
        "rod.toml",
        "--train",
        "train.csv",
        "--save-model",
        "model.toml",
        "--quiet",
    ];
    output(&mut sma(folder.path(), &args));
    folder
}

#[test]
fn a_saved_model_says_how_it_was_made() {
    let folder = identified();
    let model = std::fs::read_to_string(folder.path().join("model.toml")).unwrap();
    let command =
        "command = \"sma identify rod.toml --train train.csv --save-model model.toml --quiet\"";
    assert!(model.contains(command), "{model}");
    // The rod file and the recording.
    assert_eq!(model.matches("sha256 = \"").count(), 2);
    assert_eq!(
        model_file::to_toml(&model_file::parse("model.toml", &model).unwrap()).unwrap(),
        model
    );
}

#[test]
fn a_prediction_is_a_recording() {
    let folder = identified();
    let args = [
        "simulate",
        "model.toml",
        "--drive",
        "validate.csv",
        "--output",
        "predicted.csv",
    ];
    let (text, notes) = output(&mut sma(folder.path(), &args));
    assert_eq!(text, "");
    assert_eq!(
        notes,
        "note: validate.csv has an output too: the prediction meets it to 0.005067 mm RMS\n"
    );
    // Of what it was fitted to, the error that the fit reported.
    let args_of_training = [
        "simulate",
        "model.toml",
        "--drive",
        "train.csv",
        "--output",
        "again.csv",
    ];
    let (_, notes) = output(&mut sma(folder.path(), &args_of_training));
    assert_eq!(
        notes,
        "note: train.csv has an output too, and the model was fitted to it: with the offset and state that the fit found in it, the \
         prediction meets it to 0.004996 mm RMS\n"
    );
    let csv = std::fs::read_to_string(folder.path().join("predicted.csv")).unwrap();
    let header = csv.lines().next().unwrap();
    assert_eq!(header, "time_s,current_a,displacement_mm,temperature_degc");
    let rows = |name: &str| {
        std::fs::read_to_string(folder.path().join(name))
            .unwrap()
            .lines()
            .count()
    };
    assert_eq!(rows("predicted.csv") - 1, recorded_rows(folder.path()));
    // It can be fitted in turn, to next to nothing: its temperature is the model's own.
    let args = [
        "identify",
        "rod.toml",
        "--train",
        "predicted.csv",
        "--json",
        "-",
    ];
    let json: serde_json::Value =
        serde_json::from_str(&output(&mut sma(folder.path(), &args)).0).unwrap();
    assert!(json["fit"]["train_rmse"].as_f64().unwrap() < 1e-6);
    assert!(json["fit"]["temperature_rmse_k"].as_f64().unwrap() < 1e-4);
}

/// Rows of the bundled validation recording.
fn recorded_rows(folder: &Path) -> usize {
    let text = std::fs::read_to_string(folder.join("validate.csv")).unwrap();
    text.lines().filter(|line| !line.starts_with('#')).count() - 1
}

#[test]
fn a_profile_needs_no_output() {
    let folder = identified();
    std::fs::write(
        folder.path().join("profile.csv"),
        "time_s,current_a\n0,0\n0.287,2\n0.574,2\n",
    )
    .unwrap();
    let args = ["simulate", "model.toml", "--drive", "profile.csv"];
    let (csv, notes) = output(&mut sma(folder.path(), &args));
    assert_eq!(notes, "note: start and offset are those of train.csv\n");
    assert_eq!(csv.lines().count(), 4);
    let quiet = [args.as_slice(), &["--quiet"]].concat();
    assert_eq!(
        output(&mut sma(folder.path(), &quiet)),
        (csv, String::new())
    );
}

#[test]
fn an_earlier_model_is_one_more_start() {
    let folder = identified();
    let args = [
        "identify",
        "rod.toml",
        "--train",
        "train.csv",
        "--from-model",
        "model.toml",
        "--starts",
        "1",
        "--json",
        "-",
    ];
    let json: serde_json::Value =
        serde_json::from_str(&output(&mut sma(folder.path(), &args)).0).unwrap();
    assert_eq!(json["fit"]["starts"], 2);
    assert_eq!(json["fit"]["agreeing_starts"], 2);
    // A model of another rig is none.
    std::fs::write(
        folder.path().join("other.toml"),
        "[surroundings]\nambient_degc = 22.0\n",
    )
    .unwrap();
    let args = [
        "identify",
        "other.toml",
        "--train",
        "train.csv",
        "--from-model",
        "model.toml",
    ];
    let assert = sma(folder.path(), &args).assert().code(3);
    let error = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(
        error.starts_with("sma: model.toml: a model of tau_s, "),
        "{error}"
    );
}
