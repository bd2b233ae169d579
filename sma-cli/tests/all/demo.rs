//! `sma demo`, as a user sees it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use assert_cmd::Command;

/// Text of a run on stdout, and its report.
fn demo(threads: &str, folder: &Path) -> (String, String) {
    let mut sma = Command::cargo_bin("sma").unwrap();
    let call = ["demo", "--quiet", "--threads", threads];
    let run = sma.args(call).current_dir(folder).assert().success();
    let said = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    let report = fs::read_to_string(folder.join("sma-demo/report.html")).unwrap();
    (said, report)
}

/// One run for all tests that need its folder or its text.
pub(crate) struct Demonstrated {
    pub(crate) folder: tempfile::TempDir,
    pub(crate) said: String,
    pub(crate) report: String,
}

pub(crate) fn demonstrated() -> &'static Demonstrated {
    static ONCE: OnceLock<Demonstrated> = OnceLock::new();
    ONCE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let (said, report) = demo("1", folder.path());
        Demonstrated {
            folder,
            said,
            report,
        }
    })
}

/// The number before ` ± `, and that behind it, in the line that begins so.
fn estimate(said: &str, beginning: &str) -> [f64; 2] {
    let line = said.lines().find(|line| line.starts_with(beginning));
    let line = line.unwrap_or_else(|| panic!("no line begins with {beginning}:\n{said}"));
    let (before, behind) = line.split_once(" ± ").unwrap();
    let number = |word: Option<&str>| word.unwrap().parse::<f64>().unwrap();
    [
        number(before.split(' ').next_back()),
        number(behind.split(' ').next()),
    ]
}

#[test]
fn what_is_concealed_is_named_and_pays_at_the_controller() {
    let Demonstrated {
        folder,
        said,
        report,
    } = demonstrated();
    for (beginning, concealed) in [
        ("1. Latent heat (probability > 99.9 %): ", 15.0),
        ("2. Dead time (probability > 99.9 %): ", 0.8),
    ] {
        let [value, half] = estimate(said, beginning);
        assert!(
            (value - concealed).abs() <= 2.0 * half,
            "{beginning}{value} ± {half}"
        );
        assert!(half < 0.05 * concealed, "{beginning}{value} ± {half}");
    }
    // The controller of the baseline model never rests; that of the extended one comes to every set point.
    let of = |model: &str| {
        said.lines()
            .rfind(|line| line.trim_start().starts_with(model))
            .unwrap()
    };
    assert!(
        of("baseline model").contains("never, never, never, never"),
        "{said}"
    );
    assert!(!of("extended model").contains("never"), "{said}");
    let tree = roxmltree::Document::parse(report.trim_start_matches("<!DOCTYPE html>")).unwrap();
    let sections: Vec<&str> = tree
        .descendants()
        .filter(|node| node.tag_name().name() == "h2")
        .filter_map(|heading| heading.text())
        .collect();
    assert!(
        sections.contains(&"What the extended model is worth: controllers on the true wire"),
        "{sections:?}"
    );

    // The files are those of a user: what the text proposes can be done.
    let call = said.lines().next_back().unwrap();
    let mut words = call.split_whitespace();
    assert_eq!(words.next(), Some("sma"), "{call}");
    let mut sma = Command::cargo_bin("sma").unwrap();
    let again = sma
        .args(words)
        .args(["--quiet", "--no-plot"])
        .current_dir(folder.path());
    let again = String::from_utf8(again.assert().success().get_output().stdout.clone()).unwrap();
    let verdict = |said: &str| {
        let lines = said
            .lines()
            .skip_while(|line| !line.starts_with("EXPLAINED: latent heat"));
        lines.take(20).map(ToOwned::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(verdict(&again), verdict(said));

    let other = tempfile::tempdir().unwrap();
    let at = |page: &str| {
        page.split("<h2>How this was made</h2>")
            .next()
            .map(ToOwned::to_owned)
    };
    let (said_again, report_again) = demo("3", other.path());
    assert_eq!(&said_again, said, "the same on any number of threads");
    assert_eq!(at(&report_again), at(report));
}

#[test]
fn a_folder_that_cannot_be_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("taken"), "a file").unwrap();
    let mut sma = Command::cargo_bin("sma").unwrap();
    let run = sma
        .args(["demo", "--out", "taken"])
        .current_dir(folder.path());
    let failed = run.assert().failure();
    let said = String::from_utf8_lossy(&failed.get_output().stderr).into_owned();
    assert!(said.contains("taken: cannot be made"), "{said}");
}
