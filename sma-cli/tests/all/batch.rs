//! `sma batch`: kept units, shards, interruptions, failures as rows.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use roxmltree::Document;
use serde_json::Value;
use tempfile::TempDir;

use crate::folder::sma;
use crate::make_fleet::{damaged, make, recording};

/// Samples of a recording: an identification takes milliseconds.
const SAMPLES: usize = 300;

/// Flags of the tables in a folder of results.
fn tables(out: &str) -> String {
    format!("--quiet --csv {out}/table.csv --report {out}/fleet.html --json {out}/fleet.json")
}

/// A folder with `fleet`, of which so many rigs are damaged.
fn fleet(n_rigs: usize, n_damaged: usize) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    make(&folder.path().join("fleet"), n_rigs, n_damaged, SAMPLES).unwrap();
    folder
}

/// All files below a folder, hidden ones as well.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            let below = files(&path).into_iter();
            all.extend(below.map(|(file, bytes)| (format!("{name}/{file}"), bytes)));
        } else {
            all.insert(name, fs::read(path).unwrap());
        }
    }
    all
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[track_caller]
fn succeeds(folder: &Path, call: &str) -> (String, String) {
    let (code, said, notes) = sma(folder, call);
    assert_eq!(code, 0, "{call}: {said}{notes}");
    (said, notes)
}

#[test]
fn a_fleet_has_a_row_a_rig_and_a_failure_is_one() {
    let folder = fleet(12, 10);
    let (said, _) = succeeds(
        folder.path(),
        &format!("batch fleet --do identify --out out {}", tables("out")),
    );
    assert!(
        said.starts_with("12 rigs: 2 with a result, 10 failed.\n"),
        "{said}"
    );
    assert!(
        said.contains("\nwire-002.csv:151: fields: 2; expected 3, as in the first line\n"),
        "{said}"
    );
    let out = folder.path().join("out");
    let table = fs::read_to_string(out.join("table.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split(',').collect())
        .collect();
    assert_eq!(rows.len(), 13);
    for (k, row) in rows[1..].iter().enumerate() {
        assert_eq!(row[0], format!("wire-{k:03}.csv"));
        assert_eq!(row[1], if k < 10 { "failed" } else { "done" }, "{row:?}");
    }
    let tau = rows[0].iter().position(|name| *name == "tau_s").unwrap();
    assert_eq!(rows[0][tau + 1], "tau_s_lower");
    // The second of those that are whole conceals nothing.
    let tau_s: f64 = rows[12][tau].parse().unwrap();
    assert!((8.0..11.0).contains(&tau_s), "{tau_s}");
    let document = json(&out.join("fleet.json"));
    let failure = &document["rigs"][2]["failure"];
    assert_eq!(
        (failure["file"].as_str(), failure["line"].as_u64()),
        (Some("wire-002.csv"), Some(151))
    );
    assert_eq!(document["counts"]["failed"], 10);
    // Twelve units, each of which says of what it is.
    let units = files(&out.join("units"));
    assert_eq!(units.len(), 12);
    for (name, bytes) in &units {
        let unit: Value = serde_json::from_slice(bytes).unwrap();
        assert_eq!(name.len(), 69);
        assert_eq!(unit["task"]["input"][0]["file"], "rod.toml");
        let status = if unit["failure"].is_null() {
            "done"
        } else {
            "failed"
        };
        assert_eq!(
            (unit["status"].as_str(), unit["result"].is_null()),
            (Some(status), status == "failed")
        );
    }
    let page = fs::read_to_string(out.join("fleet.html")).unwrap();
    let tree = Document::parse(page.trim_start_matches("<!DOCTYPE html>")).unwrap();
    let heading = tree.descendants().find(|node| node.has_tag_name("h1"));
    assert_eq!(
        heading.unwrap().text(),
        Some("12 rigs: 2 with a result, 10 failed.")
    );
}

#[test]
fn shards_put_together_and_moved_are_the_whole_to_the_byte() {
    let folder = fleet(9, 2);
    let place = folder.path();
    let whole = format!("batch fleet --do identify --out whole {}", tables("whole"));
    succeeds(place, &whole);
    // The rigs of another machine lie elsewhere.
    let elsewhere = place.join("else/where");
    fs::create_dir_all(&elsewhere).unwrap();
    fs::rename(place.join("fleet"), elsewhere.join("fleet")).unwrap();
    let mut others = String::new();
    for shard in 1..=7 {
        let call = format!("batch fleet --do identify --out s{shard} --shard {shard}/7 --jobs 1");
        let (said, notes) = succeeds(&elsewhere, &call);
        let n_rigs = if shard <= 2 { 2 } else { 1 };
        assert!(said.starts_with(&format!("{n_rigs} rig")), "{said}");
        assert!(notes.contains("--list says which"), "{notes}");
        others += &format!(" s{shard}");
    }
    let merged = "batch fleet --do identify --out merged --merge";
    let (code, _, said) = sma(&elsewhere, &format!("{merged} s1 s2 s3 --quiet"));
    assert_eq!(code, 1);
    assert_eq!(
        said,
        "sma: 4 of 9 rigs have no result yet; a call without --merge runs them\n"
    );
    succeeds(
        &elsewhere,
        &format!("{merged} {others} {}", tables("merged")),
    );
    assert!(files(&elsewhere.join("merged")) == files(&place.join("whole")));
}

/// Starts a call and waits until so many units are kept.
fn started(folder: &Path, call: &str, n_units: usize) -> Child {
    let child = Command::new(assert_cmd::cargo::cargo_bin("sma"))
        .args(call.split_whitespace())
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    let kept = || fs::read_dir(folder.join("out/units")).map_or(0, Iterator::count);
    while kept() < n_units {
        assert!(
            begun.elapsed() < Duration::from_secs(300),
            "nothing is kept"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

fn signaled(child: Child, signal: &str) -> (Option<i32>, String) {
    let sent = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    (output.status.code(), said)
}

/// A recording so many times, one after another.
fn repeated(recording: &str, times: usize) -> String {
    let (header, rows) = recording.split_once('\n').unwrap();
    let mut text = header.to_owned();
    for (k, row) in rows.lines().cycle().take(times * SAMPLES).enumerate() {
        let (_, values) = row.split_once(',').unwrap();
        text += &format!("\n{}.0,{values}", 2 * k);
    }
    text + "\n"
}

#[test]
fn a_run_that_was_stopped_and_killed_ends_with_the_same_bytes() {
    let folder = fleet(14, 2);
    let place = folder.path();
    succeeds(
        place,
        &format!("batch fleet --do identify --out whole {}", tables("whole")),
    );
    // The last of all takes longer than the rest of this test: no call ends by itself before it is stopped.
    let endless = place.join("fleet/wire-endless.csv");
    fs::write(&endless, repeated(&recording(0, SAMPLES).unwrap(), 1000)).unwrap();
    let call = format!(
        "batch fleet --do identify --out out --jobs 1 {}",
        tables("out")
    );
    for (n_units, signal) in [(1, "-TERM"), (3, "-HUP"), (5, "-INT")] {
        let (code, said) = signaled(started(place, &call, n_units), signal);
        assert_eq!(code, Some(130), "{said}");
        assert_eq!(
            said,
            "\nsma: interrupted; what has ended is in out/units; the same call goes on\n"
        );
        let left = fs::read_dir(place.join("out")).unwrap().count();
        assert_eq!(left, 1, "units alone");
    }
    for n_units in [7, 9] {
        let (code, _) = signaled(started(place, &call, n_units), "-KILL");
        assert_eq!(code, None);
    }
    let kept = files(&place.join("out/units"));
    assert!(kept.len() >= 9, "{}", kept.len());
    let whole = files(&place.join("whole"));
    for (name, bytes) in &kept {
        assert!(whole[&format!("units/{name}")] == *bytes, "{name}");
    }
    // A disk that was full.
    let (name, bytes) = kept.first_key_value().unwrap();
    let half = place.join("out/units").join(name);
    fs::write(&half, &bytes[..bytes.len() / 2]).unwrap();
    fs::remove_file(endless).unwrap();
    succeeds(place, &call);
    assert!(files(&place.join("out")) == whole);
}

#[test]
fn two_calls_on_one_folder_leave_whole_files() {
    let folder = fleet(6, 1);
    let place = folder.path();
    succeeds(
        place,
        &format!("batch fleet --do identify --out whole {}", tables("whole")),
    );
    let call = format!("batch fleet --do identify --out out {}", tables("out"));
    let both = [(); 2].map(|()| started(place, &call, 0));
    for child in both {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "{output:?}");
    }
    assert!(files(&place.join("out")) == files(&place.join("whole")));
}

#[test]
fn a_result_is_kept_until_its_inputs_change_and_a_failure_until_it_is_retried() {
    let folder = fleet(2, 0);
    let place = folder.path();
    let wire = place.join("fleet/wire-001.csv");
    let whole = fs::read(&wire).unwrap();
    let broken = damaged(std::str::from_utf8(&whole).unwrap(), 4);
    fs::write(&wire, &broken).unwrap();
    let call = "batch fleet --do identify --out out --json -";
    let units = || files(&place.join("out/units"));
    let (said, notes) = succeeds(place, call);
    assert!(notes.contains("note: wire-001.csv: empty;"), "{notes}");
    let first = units();
    // Nothing is run again: what a file says counts.
    for (name, bytes) in &first {
        let text = String::from_utf8(bytes.clone()).unwrap();
        let text = text.replace("empty;", "EMPTY;");
        fs::write(place.join("out/units").join(name), text).unwrap();
    }
    let (kept, notes) = succeeds(place, call);
    assert_eq!(kept, said.replace("empty;", "EMPTY;"));
    assert!(!notes.contains("wire-001"), "{notes}");
    let (again, _) = succeeds(place, &format!("{call} --retry"));
    assert_eq!(again, said);
    assert!(units() == first);
    // Another input, seed or command is another unit.
    fs::write(&wire, &whole).unwrap();
    let (mended, _) = succeeds(place, call);
    let mended: Value = serde_json::from_str(&mended).unwrap();
    assert_eq!(mended["counts"]["done"], 2);
    assert_eq!(units().len(), 3);
    succeeds(place, &format!("{call} --seed 2"));
    assert_eq!(units().len(), 5);
    // Equal rigs have one unit.
    fs::copy(&wire, place.join("fleet/wire-001-again.csv")).unwrap();
    succeeds(place, call);
    assert_eq!(units().len(), 6, "of another name");
}

#[test]
fn a_rig_has_unseen_recordings_and_missing_physics_in_its_row() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    make(&place.join("fleet"), 2, 0, 600).unwrap();
    let rig = place.join("rigs/bench 1");
    fs::create_dir_all(&rig).unwrap();
    fs::rename(place.join("fleet/rod.toml"), place.join("rigs/wire.toml")).unwrap();
    fs::rename(place.join("fleet/wire-001.csv"), rig.join("-a.csv")).unwrap();
    fs::write(rig.join("u.csv"), recording(31, 600).unwrap()).unwrap();
    let manifest = "name,rod,train,validate\none,wire.toml,bench 1/-a.csv,bench 1/u.csv\n\
                    two,wire.toml,gone.csv,\n";
    fs::write(place.join("rigs/fleet.csv"), manifest).unwrap();
    let (listed, _) = succeeds(place, "batch rigs/fleet.csv --list");
    assert_eq!(
        listed,
        "one: rod rigs/wire.toml, training rigs/bench 1/-a.csv, unseen rigs/bench 1/u.csv\n\
         two: rod rigs/wire.toml, training rigs/gone.csv, unseen none\n"
    );
    let (said, _) = succeeds(
        place,
        &format!("batch rigs/fleet.csv --out out {}", tables("out")),
    );
    assert!(said.contains("two: gone.csv: cannot be read: "), "{said}");
    let document = json(&place.join("out/fleet.json"));
    let row = &document["rigs"][0];
    assert_eq!(row["findings"][0]["effect"], "latent-heat", "{row}");
    assert!(
        row["validate_rmse"].as_f64().unwrap() > row["extended_validate_rmse"].as_f64().unwrap()
    );
    assert_eq!(document["physics"][0]["effect"], "latent-heat");
    assert_eq!(document["physics"][0]["rigs"], 1);
    assert_eq!(document["rigs"][1]["unit"], Value::Null);
    // The unit holds the document of the command itself.
    let call = "diagnose rigs/wire.toml --train=-a.csv --validate=u.csv --quiet --no-plot --json -";
    for name in ["-a.csv", "u.csv"] {
        fs::copy(rig.join(name), place.join(name)).unwrap();
    }
    let (alone, _) = succeeds(place, call);
    let alone: Value = serde_json::from_str(&alone).unwrap();
    let unit = row["unit"].as_str().unwrap();
    let unit = json(&place.join(format!("out/units/{unit}.json")));
    assert_eq!(unit["result"], alone);
    let page = fs::read_to_string(place.join("out/fleet.html")).unwrap();
    let tree = Document::parse(page.trim_start_matches("<!DOCTYPE html>")).unwrap();
    let titles = tree.descendants().filter(|node| {
        let said = node.text().unwrap_or_default();
        node.has_tag_name("title") && said.starts_with("one: latent-heat ")
    });
    assert_eq!(titles.count(), 1, "a mark in the picture");
}

#[test]
fn calls_that_would_harm_or_cannot_be_are_refused() {
    let folder = fleet(1, 0);
    let place = folder.path();
    for (call, code, expected) in [
        ("batch fleet", 2, "--out <DIR>"),
        ("batch fleet --out o --shard 0/2", 2, "must be i/n"),
        ("batch none --out o", 3, "sma: none: cannot be read"),
        (
            "batch fleet --out o --csv fleet/table.csv",
            3,
            "sma: fleet/table.csv: lies among the recordings",
        ),
        (
            "batch fleet --out fleet --csv fleet/table.csv",
            3,
            "sma: fleet/table.csv: lies among the recordings",
        ),
        (
            "batch fleet --out o --json fleet/wire-000.csv",
            1,
            "fleet/wire-000.csv: is an input of this command",
        ),
        (
            "batch fleet --out never --merge none",
            3,
            "none/units: cannot be read; expected a folder of results",
        ),
    ] {
        let (ended, _, said) = sma(place, call);
        assert_eq!(ended, code, "{said}");
        assert!(said.contains(expected), "{call}: {said}");
    }
    assert!(!place.join("never").exists());
}

/// A process that has ended, whose folder in /proc nobody can list.
#[cfg(unix)]
fn ended() -> Child {
    let child = Command::new("true").spawn().unwrap();
    let state = || fs::read_to_string(format!("/proc/{}/stat", child.id())).unwrap();
    while !state().contains(") Z ") {
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

#[cfg(unix)]
#[test]
fn a_rig_that_cannot_be_read_now_is_open_until_it_can() {
    use std::os::unix::fs::symlink;
    let folder = fleet(1, 0);
    let place = folder.path();
    let mut child = ended();
    let unlisted = place.join("fleet/locked");
    symlink(format!("/proc/{}/net", child.id()), &unlisted).unwrap();
    let unread = place.join("fleet/wire-001.csv");
    // Its first byte is of no page: reading it is an error of the machine, for everybody.
    symlink("/proc/self/mem", &unread).unwrap();
    let call = "batch fleet --do identify --out out --json - --quiet";
    let (code, said, error) = sma(place, call);
    assert_eq!(code, 1, "{error}");
    assert!(error.contains("2 of 3 rigs have no result yet"), "{error}");
    let document: Value = serde_json::from_str(&said).unwrap();
    let rows: Vec<[&str; 3]> = document["rigs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| {
            let sentence = row["failure"]["sentence"].as_str().unwrap_or_default();
            [
                row["rig"].as_str().unwrap(),
                row["status"].as_str().unwrap(),
                sentence,
            ]
        })
        .collect();
    assert_eq!(
        rows,
        [
            [
                "locked",
                "open",
                "the folder cannot be read: Invalid argument (os error 22)"
            ],
            ["wire-000.csv", "done", ""],
            [
                "wire-001.csv",
                "open",
                "wire-001.csv: cannot be read: Input/output error (os error 5)"
            ],
        ]
    );
    // The process of a unit says so as well, by another code than that of bad input.
    let mut unit = Command::new(assert_cmd::cargo::cargo_bin("sma"))
        .args("batch-unit identify fleet/rod.toml --train /proc/self/mem".split(' '))
        .current_dir(place)
        .stdin(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let held = unit.stdin.take();
    assert_eq!(unit.wait().unwrap().code(), Some(1));
    drop(held);
    assert_eq!(sma(place, "identify fleet/rod.toml --train none.csv").0, 3);
    child.wait().unwrap();
    fs::remove_file(&unlisted).unwrap();
    fs::remove_file(&unread).unwrap();
    fs::write(&unread, recording(1, SAMPLES).unwrap()).unwrap();
    succeeds(place, call);
}

#[cfg(unix)]
#[test]
fn another_build_of_the_program_makes_other_units() {
    let folder = fleet(2, 0);
    let place = folder.path();
    let own = fs::read(assert_cmd::cargo::cargo_bin("sma")).unwrap();
    let program = place.join("sma");
    // A byte behind all that is run.
    fs::write(&program, [&own[..], b"\n"].concat()).unwrap();
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    fs::set_permissions(&program, mode).unwrap();
    let made = Command::new(&program)
        .args("batch fleet --do identify --out other --quiet".split(' '))
        .current_dir(place)
        .output()
        .unwrap();
    assert!(made.status.success(), "{made:?}");
    let merged = "batch fleet --do identify --out out --merge other";
    let (code, _, notes) = sma(place, merged);
    assert_eq!(code, 1, "{notes}");
    assert!(
        notes.contains(
            "note: other/units: results of another build of the program: 2; they do not count here"
        ),
        "{notes}"
    );
    succeeds(place, "batch fleet --do identify --out out");
    assert_eq!(files(&place.join("out/units")).len(), 4);
}

#[test]
fn a_list_for_programs_names_units_and_what_is_kept() {
    let folder = fleet(3, 1);
    let place = folder.path();
    let listed = |call: &str| {
        let (said, _) = succeeds(place, call);
        serde_json::from_str::<Value>(&said).unwrap()
    };
    let call = "batch fleet --do identify --out out";
    let before = listed(&format!("{call} --list --json -"));
    assert!(!place.join("out").exists());
    succeeds(place, call);
    let after = listed(&format!("{call} --list --json -"));
    let units = files(&place.join("out/units"));
    for (k, kept) in ["done", "failed", "done"].into_iter().enumerate() {
        let (before, after) = (&before["rigs"][k], &after["rigs"][k]);
        assert_eq!(before["rig"], format!("wire-00{k}.csv"));
        assert_eq!(before["train"][0], format!("fleet/wire-00{k}.csv"));
        assert_eq!(before["rod"], "fleet/rod.toml");
        assert_eq!(
            (&before["kept"], &before["failure"]),
            (&Value::Null, &Value::Null)
        );
        assert_eq!(before["unit"], after["unit"]);
        assert_eq!(after["kept"], kept);
        let file = format!("{}.json", after["unit"].as_str().unwrap());
        assert!(units.contains_key(&file), "{file}");
    }
}
