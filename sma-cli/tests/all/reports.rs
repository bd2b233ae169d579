//! Requirements on every report: one page that says the main thing first, and needs neither network nor script.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use roxmltree::Document;

fn bundled() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("bundled")
}

/// The page that a call writes; `{}` in an argument is a folder for results.
fn page(call: &str, folder: &Path) -> String {
    let here = folder.display().to_string();
    let words = call.split_whitespace();
    let words: Vec<String> = words.map(|word| word.replace("{}", &here)).collect();
    let mut sma = Command::cargo_bin("sma").unwrap();
    let page = folder.join("page.html");
    let run = sma.args(words).arg("--report").arg(&page);
    run.current_dir(bundled()).assert().success();
    fs::read_to_string(page).unwrap()
}

/// Heading and captions of a page that is as every page must be.
fn read(page: &str) -> (String, Vec<String>) {
    assert!(page.len() < 1_000_000, "{}", page.len());
    let tree = Document::parse(page.trim_start_matches("<!DOCTYPE html>")).unwrap();
    let text = |name: &str| -> Vec<String> {
        let nodes = tree.descendants().filter(|node| node.has_tag_name(name));
        nodes
            .filter_map(|node| node.text())
            .map(str::to_owned)
            .collect()
    };
    for attribute in ["src", "href"] {
        let mut nodes = tree.descendants();
        assert!(
            nodes.all(|node| node.attribute(attribute).is_none()),
            "nothing is fetched"
        );
    }
    for figure in tree
        .descendants()
        .filter(|node| node.has_tag_name("figure"))
    {
        let curves = figure.descendants().filter(|node| {
            let points = node.attribute("points").unwrap_or("").split_whitespace();
            node.has_tag_name("polyline") && points.count() > 2
        });
        assert!(curves.count() > 0, "a figure without a curve");
    }
    let [heading] = &text("h1")[..] else {
        panic!("one heading");
    };
    (heading.clone(), text("figcaption"))
}

#[test]
fn an_identified_model_shows_what_it_meets_worst() {
    let folder = tempfile::tempdir().unwrap();
    let call = "identify rod.toml --train train.csv --validate validate.csv --quiet --no-plot";
    let page = page(call, folder.path());
    let (heading, captions) = read(&page);
    assert!(
        heading.starts_with("The model meets the training recordings to 0.00"),
        "{heading}"
    );
    assert_eq!(
        captions,
        [
            "validate.csv: the identified model should lie on the recording, the broad gray line.",
            "validate.csv: the residual. Of a model that lacks nothing it is noise, without a shape.",
            "validate.csv: the drive.",
            "validate.csv: the output over the temperature that the identified model computes. The branches of the recording should lie on \
             those of the model.",
        ]
    );
    assert!(page.contains("and what it has not seen to 0.00"));
    assert!(page.contains("SHA-256") && page.contains("sma identify rod.toml --train train.csv"));
}

#[test]
fn a_controller_shows_every_reference() {
    let folder = tempfile::tempdir().unwrap();
    let identify =
        "identify rod.toml --train train.csv --quiet --no-plot --save-model {}/model.toml";
    page(identify, folder.path());
    let tune = "tune {}/model.toml --step-output 2.5 --drive-max 5.5 --draws 8 --quiet \
                --sine-hz 0.01 --sine-amplitude 0.5 --sine-bias 2.0";
    let (heading, captions) = read(&page(tune, folder.path()));
    assert!(heading.starts_with("kp "), "{heading}");
    let of = |name: &str| captions.iter().filter(|one| one.starts_with(name)).count();
    let counts = ["step: ", "sine: ", "Bode, ", "Nyquist: "].map(of);
    assert_eq!((counts, captions.len()), ([2, 2, 2, 1], 7));
}
