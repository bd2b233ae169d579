//! The documents say what the program does: their commands are run, and what they quote is looked for.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use missing_physics::EffectId;

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
    for name in ["mended.toml", "diagnosis.html", "predicted.csv"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
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

#[test]
fn what_documents_link_to_is_there() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    for name in [
        "tutorial.md",
        "recording.md",
        "effects.md",
        "glossary.md",
        "walk-through.md",
        "fleets.md",
    ] {
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
