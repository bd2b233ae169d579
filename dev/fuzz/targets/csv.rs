//! Any bytes as a recording: refused with their place, or samples that are finite and rise in time.
#![no_main]

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use libfuzzer_sys::fuzz_target;
use recording::{Columns, Quantity, ReadOptions, Recording, parse_csv, read_csv, survey};

/// A file that this process alone writes.
fn place() -> &'static PathBuf {
    static PLACE: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = PLACE.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder for one file");
        let path = folder.path().join("run.csv");
        (folder, path)
    });
    path
}

fn check(recording: &Recording) {
    assert!(recording.len() >= 2);
    for series in [recording.drive(), recording.output(), recording.time_s()] {
        assert!(series.iter().all(|value| value.is_finite()));
    }
    assert!(recording.time_s().windows(2).all(|pair| pair[0] < pair[1]));
}

fuzz_target!(|data: &[u8]| {
    let Some((&first, text)) = data.split_first() else {
        return;
    };
    let quantities = [
        Quantity::Current,
        Quantity::Duty,
        Quantity::Voltage,
        Quantity::Power,
        Quantity::Temperature,
    ];
    let options = ReadOptions {
        columns: Columns {
            skip: usize::from(first >> 6),
            decimal: (first & 16 != 0).then_some(','),
            ..Columns::default()
        },
        allow_untimed: first & 8 != 0,
        max_samples: 10_000,
        ..ReadOptions::new(quantities[usize::from(first & 7) % 5])
    };
    // As the format says, from memory; or, with all that loggers write, from a file.
    if first & 32 == 0 {
        match parse_csv(text, "run.csv", &options) {
            Ok(recording) => check(&recording),
            Err(error) => assert!(error.to_string().starts_with("run.csv"), "{error}"),
        }
        return;
    }
    let path = place();
    fs::write(path, text).expect("one file");
    match read_csv(path, &options) {
        Ok(recording) => check(&recording),
        Err(error) => assert!(error.to_string().contains("run.csv"), "{error}"),
    }
    if let Ok(survey) = survey(path) {
        let _ = workbench::first_rod(&survey);
    }
});
