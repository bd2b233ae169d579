//! Shell completions and manual pages.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests")]

use assert_cmd::Command;

#[test]
fn every_subcommand_can_be_completed() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let run = Command::cargo_bin("sma")
            .unwrap()
            .args(["completions", shell])
            .assert()
            .success();
        let script = String::from_utf8(run.get_output().stdout.clone()).unwrap();
        for word in [
            "demo",
            "identify",
            "diagnose",
            "trial",
            "without",
            "save-model",
        ] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
}

#[test]
fn every_subcommand_has_a_page_with_an_example() {
    let folder = tempfile::tempdir().unwrap();
    let mut sma = Command::cargo_bin("sma").unwrap();
    sma.arg("man").arg(folder.path()).assert().success();
    for name in [
        "demo",
        "inspect",
        "identify",
        "simulate",
        "tune",
        "diagnose",
        "batch",
        "trial",
        "completions",
        "man",
    ] {
        let page = folder.path().join(format!("sma-{name}.1"));
        let page = std::fs::read_to_string(page).unwrap();
        assert!(page.contains(".TH") && page.contains("Example:"), "{name}");
    }
    let mut sma = Command::cargo_bin("sma").unwrap();
    let run = sma
        .arg("man")
        .arg(folder.path().join("none"))
        .assert()
        .failure();
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    assert!(said.contains("no such folder; make it first"), "{said}");
}
