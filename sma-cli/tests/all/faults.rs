//! Files and folders that are not what a call takes them for: nothing is lost, and nothing waits for ever.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use assert_cmd::Command;

/// A folder with the bundled files.
fn folder() -> tempfile::TempDir {
    let bundled = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("bundled");
    let folder = tempfile::tempdir().unwrap();
    for name in ["rod.toml", "train.csv", "validate.csv"] {
        std::fs::copy(bundled.join(name), folder.path().join(name)).unwrap();
    }
    folder
}

/// A call that ends in time.
fn sma(folder: &Path, call: &str) -> Command {
    let mut command = Command::cargo_bin("sma").unwrap();
    command
        .current_dir(folder)
        .args(call.split(' '))
        .timeout(Duration::from_secs(60));
    command
}

/// Exit code and stderr.
fn refusal(folder: &Path, call: &str) -> (i32, String) {
    let output = sma(folder, call).output().unwrap();
    assert!(output.stdout.is_empty(), "stdout is for results");
    (
        output.status.code().unwrap(),
        String::from_utf8(output.stderr).unwrap(),
    )
}

#[test]
fn no_result_goes_where_an_input_or_another_result_is() {
    let folder = folder();
    let before = std::fs::read(folder.path().join("train.csv")).unwrap();
    for (call, expected) in [
        (
            "identify rod.toml --train train.csv --json out --save-model ./out",
            "./out: another result of this command goes there; give each a file of its own",
        ),
        (
            "identify rod.toml --train train.csv --resume out --save-model out",
            "out: another result of this command goes there; give each a file of its own",
        ),
        (
            "identify rod.toml --train train.csv --json - --report -",
            "-: another result of this command goes there; give each a file of its own",
        ),
        (
            "identify rod.toml --train train.csv --resume train.csv",
            "train.csv: is an input of this command; give another file for the result",
        ),
        (
            "diagnose rod.toml --train train.csv --plots .",
            ".: holds inputs of this command; give figures a folder of their own",
        ),
        (
            "diagnose rod.toml --train train.csv --json out --report out",
            "out: another result of this command goes there; give each a file of its own",
        ),
    ] {
        assert_eq!(
            refusal(folder.path(), call),
            (1, format!("sma: {expected}\n"))
        );
    }
    assert_eq!(
        std::fs::read(folder.path().join("train.csv")).unwrap(),
        before
    );
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_report_that_cannot_be_written_loses_no_other_result() {
    let folder = folder();
    let call = "identify rod.toml --train train.csv --no-plot -q --report /dev/full --save-model model.toml --json fit.json";
    let output = sma(folder.path(), call).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.starts_with("sma: /dev/full: cannot be written"),
        "{said}"
    );
    assert!(!output.stdout.is_empty(), "the text is there");
    let model = std::fs::read_to_string(folder.path().join("model.toml")).unwrap();
    assert!(model.contains("[provenance]"));
    let json = std::fs::read_to_string(folder.path().join("fit.json")).unwrap();
    assert!(json.ends_with("}\n"));
}

/// As on a full disk: writing fails within a file, beyond 8 KB of it.
#[test]
fn a_full_disk_costs_what_does_not_fit_and_nothing_else() {
    let folder = folder();
    let call = "identify rod.toml --train train.csv --json out.json --save-model model.toml --report page.html --quiet";
    sma(folder.path(), call).assert().success();
    let results = ["out.json", "model.toml", "page.html"];
    let read = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    let whole = results.map(read);
    assert!(whole[1].len() < 8192 && whole[2].len() > 8192);
    std::fs::remove_file(folder.path().join("model.toml")).unwrap();
    let limited = "trap '' XFSZ; ulimit -f 16; exec \"$@\"";
    let output = Command::new("sh")
        .current_dir(folder.path())
        .args(["-c", limited, "sh"])
        .arg(assert_cmd::cargo::cargo_bin("sma"))
        .args(call.split(' '))
        .timeout(Duration::from_secs(60))
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("page.html: "), "{said}");
    // The page of the call before is whole, what fits is there, and nothing half-written.
    assert!(results.map(read) == whole);
    let names = std::fs::read_dir(folder.path()).unwrap();
    assert_eq!(names.count(), 6);
}

#[test]
fn pipes_devices_and_folders_are_no_inputs() {
    let folder = folder();
    let made = std::process::Command::new("mkfifo")
        .arg(folder.path().join("pipe.csv"))
        .status()
        .unwrap();
    assert!(made.success());
    std::fs::create_dir(folder.path().join("runs.csv")).unwrap();
    for (call, expected) in [
        (
            "identify rod.toml --train pipe.csv",
            "pipe.csv: cannot be read: is a pipe or a device; expected a file",
        ),
        (
            "identify rod.toml --train runs.csv",
            "runs.csv: cannot be read: is a folder; expected a file",
        ),
        (
            "identify /dev/zero --train train.csv",
            "/dev/zero: cannot be read: is a pipe or a device; expected a file",
        ),
        (
            "inspect pipe.csv",
            "pipe.csv: cannot be read: is a pipe or a device; expected a file",
        ),
        (
            "diagnose rod.toml --train train.csv --hypothesis /dev/zero",
            "/dev/zero: cannot be read: is a pipe or a device; expected a file",
        ),
    ] {
        let (code, said) = refusal(folder.path(), call);
        assert_eq!(
            (code, said.as_str()),
            (3, format!("sma: {expected}\n").as_str())
        );
    }
}

#[test]
fn names_that_are_no_text_or_command_a_terminal_do_no_harm() {
    let folder = folder();
    // Not UTF-8.
    let odd = OsStr::from_bytes(b"r\xffn.csv");
    std::fs::copy(folder.path().join("train.csv"), folder.path().join(odd)).unwrap();
    let output = sma(
        folder.path(),
        "identify rod.toml --no-plot -q --save-model model.toml --train",
    )
    .arg(odd)
    .output()
    .unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let model = std::fs::read_to_string(folder.path().join("model.toml")).unwrap();
    assert!(model.contains("r\u{fffd}n.csv"));
    // Moves the cursor, and sets the title of the window.
    let name = "\u{1b}[2J\u{1b}]0;owned\u{7}.csv";
    let output = sma(folder.path(), "identify rod.toml --train")
        .arg(name)
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(3));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.starts_with("sma: \u{fffd}[2J\u{fffd}]0;owned\u{fffd}.csv: "),
        "{said:?}"
    );
}
