//! Any bytes as the journal of a trial: refused, or kept so that it reads again as it was.
#![no_main]

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use blind_trial::{CaseLine, Journal};
use libfuzzer_sys::fuzz_target;

/// A file that this process alone writes.
fn place() -> &'static PathBuf {
    static PLACE: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = PLACE.get_or_init(|| {
        let folder = tempfile::tempdir().expect("a folder for one file");
        let path = folder.path().join("cases.jsonl");
        (folder, path)
    });
    path
}

fuzz_target!(|data: &[u8]| {
    let path = place();
    fs::write(path, data).expect("one file");
    let opened = Journal::<CaseLine>::open(path).and_then(Journal::sorted);
    match opened {
        Err(error) => assert!(error.to_string().contains("cases.jsonl"), "{error}"),
        Ok(journal) => {
            let lines: Vec<CaseLine> = journal.lines().cloned().collect();
            drop(journal);
            let again = Journal::<CaseLine>::open(path).expect("what was kept can be read");
            assert!(again.lines().eq(&lines));
        }
    }
});
