//! `sma trial`: sealed cases, resumed and put together.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test may end in a panic"
)]

use std::fs;
use std::path::Path;

use assert_cmd::Command;

fn sma(arguments: &[&str]) -> std::process::Output {
    drawn_from("a test", arguments)
}

fn drawn_from(seed: &str, arguments: &[&str]) -> std::process::Output {
    Command::cargo_bin("sma")
        .unwrap()
        .args(["trial", "--quiet", "--seed", seed])
        .args(arguments)
        .output()
        .unwrap()
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap()
}

#[test]
fn shards_put_together_are_the_whole_to_the_byte() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name).display().to_string();
    // Of this seed the cases are small.
    let sma = |arguments: &[&str]| drawn_from("f", arguments);
    let family = ["--family", "clean-white", "--cases", "2"];
    let whole = sma(&[&family[..], &["--out", &place("whole"), "--json", "-"]].concat());
    assert_eq!(whole.status.code(), Some(0));
    let json: serde_json::Value = serde_json::from_slice(&whole.stdout).unwrap();
    assert_eq!(json["cases"], 2);
    let mut rows = json["table"].as_array().unwrap().iter();
    assert!(rows.any(|row| row["n"] == 2), "{json}");
    for (shard, out) in [("1/2", "one"), ("2/2", "other")] {
        let out = place(out);
        let ran = sma(&[&family[..], &["--shard", shard, "--out", &out]].concat());
        assert_eq!(ran.status.code(), Some(0));
    }
    let page = place("page.html");
    let merged = sma(&[
        "--cases",
        "0",
        "--out",
        &place("merged"),
        "--merge",
        &place("one"),
        &place("other"),
        "--report",
        &page,
    ]);
    assert_eq!(merged.status.code(), Some(0));
    for name in ["cases.jsonl", "seals.csv"] {
        let of = |out: &str| text(&folder.path().join(out).join(name));
        assert_eq!(of("whole"), of("merged"), "{name}");
    }
    let page = text(Path::new(&page));
    let tree = roxmltree::Document::parse(page.trim_start_matches("<!DOCTYPE html>")).unwrap();
    let heading = tree
        .descendants()
        .find(|node| node.has_tag_name("h1"))
        .unwrap();
    assert!(heading.text().unwrap().starts_with("2 cases of seed "));
    assert!(page.contains("false alarm, white") && page.contains("--merge"));
    // Nothing is run twice.
    let before = text(&folder.path().join("whole/times.csv"));
    let again = sma(&[&family[..], &["--out", &place("whole")]].concat());
    assert_eq!(again.status.code(), Some(0));
    assert_eq!(text(&folder.path().join("whole/times.csv")), before);
}

#[test]
fn an_answer_that_was_changed_breaks_its_seal() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("t").display().to_string();
    let ran = sma(&["--family", "clean-outliers", "--cases", "1", "--out", &out]);
    assert_eq!(ran.status.code(), Some(0));
    let path = folder.path().join("t/cases.jsonl");
    let whole = text(&path);
    let said_of = |line: &str| {
        fs::write(&path, line).unwrap();
        let ran = sma(&["--cases", "0", "--out", &out]);
        assert_eq!(ran.status.code(), Some(3));
        String::from_utf8(ran.stderr).unwrap()
    };
    // Whoever changes an answer by hand can leave the line's own hash out, but cannot break the seal unseen.
    let (content, _) = whole.split_once(",\"line_sha256\":").unwrap();
    let answered = format!("{content}}}\n").replace("\"l2p\"", "\"preisach\"");
    assert_eq!(
        said_of(&answered),
        "sma: lab-clean-outliers-0000: the answer is not the one that was sealed\n"
    );
    // A verdict that is no longer the one that was written, by whatever damaged the file.
    let verdict = "\"verdict\":\"";
    let damaged = whole.replacen(verdict, "\"verdict\": \"", 1);
    assert_ne!(damaged, whole);
    assert_eq!(
        said_of(&damaged),
        format!(
            "sma: {}:1: was changed since it was written: its hash is that of another line\n",
            path.display()
        )
    );
}

#[test]
fn a_folder_of_another_trial_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("t").display().to_string();
    let empty = sma(&["--cases", "0", "--out", &out]);
    assert_eq!(empty.status.code(), Some(1));
    let other = Command::cargo_bin("sma")
        .unwrap()
        .args(["trial", "--seed", "another", "--cases", "0", "--out", &out])
        .output()
        .unwrap();
    assert_eq!(other.status.code(), Some(3));
    let message = String::from_utf8(other.stderr).unwrap();
    assert!(
        message.contains("holds a trial with seed a test, and this one has another"),
        "{message}"
    );
}

#[test]
fn bad_calls_say_what_would_be_accepted() {
    for (arguments, expected) in [
        (["--family", "clean"], "there are: clean-white clean-ar"),
        (["--shard", "3/2"], "must be i/n with 1 ≤ i ≤ n, as 2/4"),
    ] {
        let ran = sma(&arguments);
        assert_eq!(ran.status.code(), Some(2));
        let message = String::from_utf8(ran.stderr).unwrap();
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn cases_are_drawn_around_a_rig_of_one_s_own() {
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("bundled");
    let file = |name: &str| bundled.join(name).display().to_string();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("mine").display().to_string();
    let (rod, drive) = (file("rod.toml"), file("train.csv"));
    let like = ["--like", &rod, "--drive", &drive, "--out", &out];
    let two = ["--family", "single", "--cases", "2", "--json", "-"];
    let ran = drawn_from("k", &[&like[..], &two].concat());
    assert_eq!(
        ran.status.code(),
        Some(0),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let json: serde_json::Value = serde_json::from_slice(&ran.stdout).unwrap();
    let reach = json["reach"].as_array().unwrap();
    assert_eq!(reach.len(), 2);
    assert!(reach.iter().all(|row| row["sizes"][0]["size"] == 1.0));
    let counted = drawn_from("k", &[&like[..], &["--cases", "0"]].concat());
    let said = String::from_utf8(counted.stdout).unwrap();
    assert!(
        said.starts_with("Of 2 effects of their usual size this experiment would name "),
        "{said}"
    );
    // The folder is of this rig.
    let other = drawn_from("k", &["--out", &out, "--cases", "0"]);
    let said = String::from_utf8(other.stderr).unwrap();
    assert!(said.contains("rig"), "{said}");
    let alone = sma(&["--like", &rod, "--out", &out]);
    assert_eq!(alone.status.code(), Some(2), "a rig without a drive");
}
