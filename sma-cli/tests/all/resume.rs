//! Ctrl-C, and going on from what was kept.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const IDENTIFY: [&str; 8] = [
    "identify",
    "rod.toml",
    "--train",
    "train.csv",
    "--starts",
    "48",
    "--save-model",
    "model.toml",
];
const DIAGNOSE: [&str; 8] = [
    "diagnose",
    "rod.toml",
    "--train",
    "train.csv",
    "--validate",
    "validate.csv",
    "--save-model",
    "model.toml",
];

/// A folder with the bundled rod and recordings.
fn rig() -> tempfile::TempDir {
    let bundled = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("bundled");
    let folder = tempfile::tempdir().unwrap();
    for name in ["rod.toml", "train.csv", "validate.csv"] {
        fs::copy(bundled.join(name), folder.path().join(name)).unwrap();
    }
    folder
}

fn sma(folder: &Path, call: &[&str]) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("sma"));
    command
        .current_dir(folder)
        .args(call)
        .args(["--json", "out.json", "--threads", "1"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    command
}

/// Sends what Ctrl-C sends.
fn interrupt(child: Child) -> Output {
    end_by("-INT", child)
}

fn end_by(signal: &str, child: Child) -> Output {
    let sent = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
    child.wait_with_output().unwrap()
}

fn lines(path: &Path) -> usize {
    fs::read_to_string(path).map_or(0, |text| text.lines().count())
}

/// The results of a call that is not interrupted.
fn whole(call: &[&str]) -> [String; 2] {
    let folder = rig();
    assert!(sma(folder.path(), call).status().unwrap().success());
    results(folder.path())
}

fn results(folder: &Path) -> [String; 2] {
    ["out.json", "model.toml"].map(|name| fs::read_to_string(folder.join(name)).unwrap())
}

fn goes_on(call: &[&str]) {
    let folder = rig();
    let kept = folder.path().join("kept");
    let resumed = [call, &["--resume", "kept"]].concat();
    let child = sma(folder.path(), &resumed).spawn().unwrap();
    let begun = Instant::now();
    // Its first line says of what it is.
    while lines(&kept) < 4 {
        assert!(
            begun.elapsed() < Duration::from_secs(300),
            "nothing is kept"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    let output = interrupt(child);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(
        said.contains(" starts are kept. To go on from there:\n  sma "),
        "{said}"
    );
    assert!(said.trim_end().ends_with("--resume kept"), "{said}");
    let names = |folder: &Path| {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    assert_eq!(
        names(folder.path()),
        ["kept", "rod.toml", "train.csv", "validate.csv"]
    );
    // A cost that somebody has changed is not believed: that start is made again.
    let text = fs::read_to_string(&kept).unwrap();
    let key = "\"sum_of_squares\":";
    let start = text.find(key).unwrap() + key.len();
    let end = start + text[start..].find([',', '}']).unwrap();
    let text = format!("{}1e-9{}", &text[..start], &text[end..]);
    // As if it had been cut off in a line.
    fs::write(&kept, text + "{\"seed\":1,\"sta").unwrap();
    assert!(sma(folder.path(), &resumed).status().unwrap().success());
    assert_eq!(results(folder.path()), whole(call));
    assert!(!kept.exists(), "nothing is left to go on from");
}

#[test]
fn an_interrupted_identification_ends_with_the_same_bytes() {
    goes_on(&IDENTIFY);
}

#[test]
fn an_interrupted_diagnosis_ends_with_the_same_bytes() {
    goes_on(&DIAGNOSE);
}

#[test]
fn without_a_file_one_is_written_at_the_interruption() {
    let folder = rig();
    let call = IDENTIFY.map(|word| if word == "48" { "100000" } else { word });
    // Nothing says from outside when the first starts have ended.
    let said = (0..10)
        .find_map(|k| {
            let child = sma(folder.path(), &call).spawn().unwrap();
            std::thread::sleep(Duration::from_millis(500 << k));
            // As a batch system ends a job.
            let output = end_by("-TERM", child);
            let said = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(130), "{said}");
            (!said.contains("nothing was kept yet")).then_some(said)
        })
        .unwrap();
    assert!(said.contains("--resume sma-identify.resume"), "{said}");
    assert!(lines(&folder.path().join("sma-identify.resume")) > 1);
}

#[test]
fn a_file_of_another_call_is_refused() {
    let folder = rig();
    let refusal = |kept: &str, what: &str| {
        fs::write(folder.path().join("kept"), kept).unwrap();
        let call = [&IDENTIFY[..], &["--resume", "kept"]].concat();
        let output = sma(folder.path(), &call).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{said}");
        assert!(said.contains(what), "{said}");
    };
    refusal(
        "no file of ours\n",
        "kept:1: no line of a file that --resume wrote",
    );
    refusal(
        "an only line without its end",
        "kept:1: no line of a file that --resume wrote",
    );
    refusal(
        "{\"version\":\"0\",\"command\":\"sma identify\",\"inputs\":[]}\n",
        "kept: is of another call, sma identify; give that one, or another file",
    );
}
