//! Calls of the program in a folder of files.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::path::Path;

use assert_cmd::Command;

/// Exit code, stdout and stderr of a call.
pub(crate) fn sma(folder: &Path, call: &str) -> (i32, String, String) {
    let mut sma = Command::cargo_bin("sma").unwrap();
    let run = sma.args(call.split_whitespace()).current_dir(folder);
    let output = run.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (
        output.status.code().unwrap(),
        text(output.stdout),
        text(output.stderr),
    )
}
