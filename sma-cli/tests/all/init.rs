//! `sma init`: a rod file to begin with.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fs;
use std::path::Path;

use crate::folder::sma;

/// The bundled recording as a spreadsheet of another country saves it.
fn as_german(name: &str) -> String {
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("bundled");
    let text = fs::read_to_string(bundled.join(name)).unwrap();
    let (_, rows) = text.split_once("displacement_mm\n").unwrap();
    let rows = rows.replace(',', ";").replace('.', ",");
    format!("Messung vom 5. Mai\n\nZeit [s];Strom [A];Weg [mm]\n{rows}")
}

#[test]
fn from_a_file_to_a_fit_in_two_commands() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("lauf1.csv"), as_german("train.csv")).unwrap();
    fs::write(folder.join("lauf2.csv"), as_german("validate.csv")).unwrap();
    let (code, said, stderr) = sma(folder, "init lauf1.csv lauf2.csv");
    assert_eq!((code, stderr.as_str()), (0, ""), "{said}");
    for expected in [
        "read as: numbers have a decimal comma",
        "drive, current",
        "? ambient_degc = 22.0: what was the temperature of the room?",
        "sma identify rod.toml --train lauf1.csv --validate lauf2.csv",
    ] {
        assert!(said.contains(expected), "{expected}:\n{said}");
    }
    let call = "identify rod.toml --train lauf1.csv --validate lauf2.csv --no-plot";
    let (code, said, stderr) = sma(folder, call);
    assert_eq!(code, 0, "{said}{stderr}");
    assert!(stderr.contains("decimal comma"), "{stderr}");
}

#[test]
fn a_window_leaves_the_rest_out_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("run.csv"), as_german("train.csv")).unwrap();
    let (code, ..) = sma(folder, "init run.csv");
    assert_eq!(code, 0);
    let rod = fs::read_to_string(folder.join("rod.toml")).unwrap();
    let window = "[recordings.\"run.csv\"]\nwindow_s = [10, 110]\n";
    fs::write(folder.join("rod.toml"), format!("{rod}\n{window}")).unwrap();
    let (code, said, stderr) = sma(folder, "inspect run.csv --rod rod.toml");
    assert_eq!(code, 0, "{stderr}");
    assert!(said.contains("10 to 110 s of it are used"), "{said}");
    assert!(said.contains(" over 100.0 s"), "{said}");
    // A flag goes before the file, and a span in the middle is no end of it.
    let (code, said, _) = sma(
        folder,
        "inspect run.csv --rod rod.toml --window run.csv:20..60 --decimate 2",
    );
    assert_eq!(code, 0);
    assert!(said.contains("20 to 60 s of it are used"), "{said}");
    assert!(said.contains("one row in 2 is used"), "{said}");
    let (code, _, stderr) = sma(
        folder,
        "inspect run.csv --rod rod.toml --exclude run.csv:33..41",
    );
    assert_eq!(code, 3);
    assert!(
        stderr.contains("expected a span at its start or its end"),
        "{stderr}"
    );
    fs::write(folder.join("rod.toml"), window.replace("110", "5")).unwrap();
    let (code, _, stderr) = sma(folder, "inspect run.csv --rod rod.toml");
    assert_eq!(code, 3);
    assert!(
        stderr.contains("recordings.\"run.csv\".window_s"),
        "{stderr}"
    );
}

#[test]
fn nothing_is_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("run.csv"), as_german("train.csv")).unwrap();
    fs::write(folder.join("other.csv"), "t,u\n0,1\n1,2\n").unwrap();
    fs::write(folder.join("rod.toml"), "mine").unwrap();
    let (code, _, stderr) = sma(folder, "init run.csv");
    let expected =
        "sma: rod.toml: is there already; expected a new file, or --force to write over it\n";
    assert_eq!((code, stderr.as_str()), (3, expected));
    let (code, _, stderr) = sma(folder, "init run.csv other.csv --rod new.toml");
    assert_eq!(code, 3);
    assert!(
        stderr.contains("other.csv: other columns than run.csv"),
        "{stderr}"
    );
    assert!(!folder.join("new.toml").exists());
    assert_eq!(fs::read_to_string(folder.join("rod.toml")).unwrap(), "mine");
    let (code, ..) = sma(folder, "init run.csv --force");
    assert_eq!(code, 0);
    fs::write(folder.join("notes.txt"), "no numbers here\n").unwrap();
    let (code, _, stderr) = sma(folder, "init notes.txt --force");
    assert_eq!(code, 3);
    assert!(stderr.contains("notes.txt: no table"), "{stderr}");
}
