//! The documents say what the program does: their commands are run, and what they quote is looked for.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use identify::{ForwardModel, RigModel};
use recording::{Quantity, Recording, RecordingParts};
use rig_files::rod_file;
use sma_effects::EffectId;
use wiener::hysteresis::Rule;

use crate::demo::demonstrated;

fn document(name: &str) -> String {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let path: PathBuf = docs.join(name);
    fs::read_to_string(&path).unwrap()
}

/// Fenced blocks: their language and text.
fn blocks(text: &str) -> Vec<(&str, &str)> {
    let parts: Vec<&str> = text.split("```").collect();
    let fenced = parts.iter().skip(1).step_by(2);
    fenced.filter_map(|block| block.split_once('\n')).collect()
}

#[test]
fn the_tutorial_can_be_followed() {
    let folder = tempfile::tempdir().unwrap();
    let text = document("tutorial.md");
    let (mut said, mut n_commands) = (String::new(), 0);
    for (language, block) in blocks(&text) {
        match language {
            "sh" => {
                said.clear();
                for line in block.lines() {
                    if line == "sma demo --quiet" {
                        // Another test has run it.
                        let demo = demonstrated();
                        std::fs::create_dir(folder.path().join("sma-demo")).unwrap();
                        for name in ["rod.toml", "train.csv", "unseen.csv"] {
                            let name = Path::new("sma-demo").join(name);
                            let made = demo.folder.path().join(&name);
                            std::fs::copy(made, folder.path().join(&name)).unwrap();
                        }
                        said += &demo.said;
                        n_commands += 1;
                        continue;
                    }
                    let mut words = line.split_whitespace();
                    assert_eq!(words.next(), Some("sma"), "{line}");
                    let mut sma = Command::cargo_bin("sma").unwrap();
                    let run = sma
                        .args(words)
                        .current_dir(folder.path())
                        .assert()
                        .success();
                    let output = run.get_output();
                    said += &String::from_utf8_lossy(&output.stdout);
                    said += &String::from_utf8_lossy(&output.stderr);
                    n_commands += 1;
                }
            }
            _ => {
                for line in block.lines() {
                    assert!(said.contains(line), "not said: {line}\nbut:\n{said}");
                }
            }
        }
    }
    assert!(n_commands >= 6, "{n_commands}");
    for name in ["extended.toml", "diagnosis.html", "predicted.csv"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
}

/// Asserts that a call has the flags that a line of a document gives it.
fn has_flags(line: &str) {
    let mut words = line.split_whitespace().skip(1);
    let command = words.next().unwrap();
    let mut sma = Command::cargo_bin("sma").unwrap();
    let help = sma.args([command, "--help"]).assert().success();
    let help = String::from_utf8_lossy(&help.get_output().stdout).into_owned();
    for flag in words.filter(|word| word.starts_with("--")) {
        assert!(
            help.contains(&format!("{flag} ")),
            "{command} {flag}: {line}"
        );
    }
}

#[test]
fn the_readme_says_what_the_program_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    assert!(readme.lines().count() <= 200);
    let (mut said, mut n_runs) = (String::new(), 0);
    for (language, block) in blocks(&readme) {
        match language {
            "sh" => {
                for line in block.lines() {
                    let Some(call) = line.strip_prefix("cargo run --release -p sma-cli -- ") else {
                        // The check of the whole project runs this one.
                        assert_eq!(line, "cargo test --workspace");
                        continue;
                    };
                    n_runs += 1;
                    if call == "demo" {
                        said.clone_from(&demonstrated().said);
                        continue;
                    }
                    let mut sma = Command::cargo_bin("sma").unwrap();
                    let run = sma
                        .args(call.split(' '))
                        .current_dir(root)
                        .assert()
                        .success();
                    said = String::from_utf8_lossy(&run.get_output().stdout).into_owned();
                }
            }
            "toml" => {
                rod_file::parse("README.md", block).unwrap();
            }
            _ => {
                for line in block.lines() {
                    if line.starts_with("sma ") {
                        has_flags(line);
                    } else {
                        assert!(said.contains(line), "not said: {line}\nbut:\n{said}");
                    }
                }
            }
        }
    }
    assert_eq!(n_runs, 2);
}

#[test]
fn every_effect_is_explained_with_its_equation() {
    let text = document("effects.md");
    for effect in EffectId::ALL {
        let info = effect.info();
        let heading = format!("### `{}`: {}\n", info.id, info.name);
        let (_, behind) = text
            .split_once(&heading)
            .unwrap_or_else(|| panic!("{heading}"));
        let [("text", equation), ..] = blocks(behind)[..] else {
            panic!("{}: no equation", info.id);
        };
        assert_eq!(equation.trim_end(), info.equation, "{}", info.id);
    }
    assert_eq!(text.matches("\n### `").count(), EffectId::ALL.len());
}

/// Words in backticks behind what an error of the parser of rod files expected; `wrong` is what it refused.
fn accepted(text: &str, wrong: &str) -> BTreeSet<String> {
    let error = rod_file::parse("rod.toml", text).unwrap_err().to_string();
    assert!(error.contains(wrong), "{error}");
    let (_, expected) = error.split_once(wrong).unwrap();
    let words: BTreeSet<String> = in_backticks(expected).collect();
    assert!(!words.is_empty(), "{error}");
    words
}

fn in_backticks(text: &str) -> impl Iterator<Item = String> {
    text.split('`').skip(1).step_by(2).map(str::to_owned)
}

/// Keys in the first column of the tables of the section whose heading begins with `[table`.
fn listed(page: &str, table: &str) -> BTreeSet<String> {
    let heading = format!("\n## `[{table}");
    assert!(page.contains(&heading), "{table}");
    let (_, section) = page.split_once(&heading).unwrap();
    let section = section.split("\n## ").next().unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    rows.flat_map(|row| in_backticks(row.split('|').nth(1).unwrap()))
        .collect()
}

/// Names of the parameters of every model that a rod file can ask for.
fn parameters() -> BTreeSet<String> {
    let of = |rod: &str, parts: RecordingParts| {
        let rod = rod_file::parse("rod.toml", rod).unwrap();
        let recording = Recording::new(parts).unwrap();
        let model = RigModel::new(&rod, Rule::LastReversal, &[recording]).unwrap();
        let names = model.parameters().iter().map(|info| info.name.to_owned());
        names.collect::<Vec<_>>()
    };
    let wave = |scale: f64| (0..100).map(|k| scale * f64::from((k / 20) % 2)).collect();
    let run = |drive_quantity: Quantity| RecordingParts {
        time_s: Some((0..100).map(f64::from).collect()),
        drive_quantity,
        drive: wave(0.5),
        output: wave(2.0),
        output_unit: "mm".to_owned(),
        ..RecordingParts::default()
    };
    let room = "[surroundings]\nambient_degc = 22.0\n[drive]\nkind = ";
    let mut names = Vec::new();
    for quantity in [
        Quantity::Current,
        Quantity::Duty,
        Quantity::Voltage,
        Quantity::Power,
    ] {
        let rod = format!("{room}\"{}\"\n", quantity.name());
        names.extend(of(&rod, run(quantity)));
    }
    let current = format!("{room}\"current\"\n");
    let pair = RecordingParts {
        antagonist_drive: Some(wave(0.4)),
        ..run(Quantity::Current)
    };
    names.extend(of(&current, pair));
    let thermal = RecordingParts {
        output_unit: "degC".to_owned(),
        ..run(Quantity::Current)
    };
    names.extend(of(&current, thermal));
    for unit in ["", "V"] {
        let looped = RecordingParts {
            time_s: None,
            drive_unit: unit.to_owned(),
            ..run(Quantity::Temperature)
        };
        names.extend(of("drive.kind = \"temperature\"", looped));
    }
    names.into_iter().collect()
}

#[test]
fn every_key_of_a_rod_file_stands_on_its_page() {
    let page = document("rod-toml.md");
    for (_, block) in blocks(&page)
        .iter()
        .filter(|(language, _)| *language == "toml")
    {
        rod_file::parse("rod.toml", block).unwrap();
    }
    let field = "unknown field `wrong`, expected ";
    let tables = accepted("wrong = 1", field);
    for table in &tables {
        // Where a key stands in a table of its own, its keys belong to the section, too.
        let alone = format!("[{table}]\nwrong = 1");
        let texts: &[&str] = match table.as_str() {
            "columns" => &[
                "[columns]\nwrong = 1",
                "[columns]\ntime = { wrong = 1 }",
                "[columns]\nresistance = { wrong = 1 }",
            ],
            "model" => &["[model]\ntau_s = { wrong = 1 }"],
            "recordings" => &["[recordings.\"a.csv\"]\nwrong = 1"],
            _ => &[&alone],
        };
        let mut keys: BTreeSet<String> = texts
            .iter()
            .flat_map(|text| accepted(text, field))
            .collect();
        if table == "model" {
            keys.extend(parameters());
        }
        assert_eq!(listed(&page, table), keys, "[{table}]");
    }
    assert_eq!(tables.len(), page.matches("\n## `[").count());
    let kinds = accepted(
        "[drive]\nkind = \"wrong\"",
        "unknown variant `wrong`, expected ",
    );
    for kind in kinds {
        assert!(page.contains(&format!("`\"{kind}\"`")), "{kind}");
    }
}

#[test]
fn what_documents_link_to_is_there() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let files = fs::read_dir(&docs).unwrap();
    let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
    let pages: Vec<String> = names.filter(|name| name.ends_with(".md")).collect();
    assert!(pages.len() >= 9, "{pages:?}");
    for name in &pages {
        let text = document(name);
        for (_, behind) in text
            .match_indices("](")
            .map(|(at, _)| text.split_at(at + 2))
        {
            let target = behind.split(')').next().unwrap();
            let file = target.split('#').next().unwrap();
            let is_elsewhere = target.contains("://") || file.is_empty();
            assert!(is_elsewhere || docs.join(file).exists(), "{name}: {target}");
        }
    }
}
