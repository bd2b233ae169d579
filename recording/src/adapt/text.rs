//! From bytes to lines.

use encoding_rs::{Encoding, WINDOWS_1252};

use crate::adapt::Done;
use crate::error::RecordingError;

/// How files of other programs begin, what they are, and what to save instead.
const OTHERS: [(&[u8], &str, &str); 8] = [
    (
        b"PK\x03\x04",
        "an Excel workbook or another archive",
        "the sheet saved as CSV",
    ),
    (
        b"\xd0\xcf\x11\xe0",
        "an Excel workbook",
        "the sheet saved as CSV",
    ),
    (
        b"MATLAB ",
        "a MATLAB file",
        "a table written by writetable or writematrix",
    ),
    (
        b"\x89HDF",
        "an HDF5 or MATLAB file",
        "a table written as CSV",
    ),
    (b"TDSm", "a TDMS file", "the group exported as CSV"),
    (b"PAR1", "a Parquet file", "a table written as CSV"),
    (b"\x1f\x8b", "compressed", "the file unpacked"),
    (b"{", "JSON", "a table with one row a sample, saved as CSV"),
];

/// Checks that the bytes may be a table of text.
pub(crate) fn check(bytes: &[u8], file: &str) -> Result<(), RecordingError> {
    let begins = bytes.trim_ascii_start();
    let other = OTHERS.iter().find(|(magic, ..)| begins.starts_with(magic));
    match other {
        None => Ok(()),
        Some((_, what, expected)) => Err(RecordingError::NotText {
            file: file.to_owned(),
            what,
            expected,
        }),
    }
}

/// The lines of a file, without their ends; they end with `\n`, `\r\n` or `\r`.
pub(super) fn lines(bytes: &[u8], done: &mut Done) -> Vec<String> {
    let text = match (Encoding::for_bom(bytes), std::str::from_utf8(bytes)) {
        (None, Ok(text)) => text.to_owned(),
        (Some((encoding, _)), _) => {
            let (text, encoding, _) = encoding.decode(bytes);
            if encoding != encoding_rs::UTF_8 {
                done.of_file(format!("the text is {}, not UTF-8", encoding.name()));
            }
            text.into_owned()
        }
        (None, Err(_)) => {
            done.of_file("the text is not UTF-8: read as windows-1252 (Latin-1)");
            WINDOWS_1252.decode(bytes).0.into_owned()
        }
    };
    let unix = text.replace("\r\n", "\n");
    if unix.contains('\r') {
        done.of_file("lines end with carriage returns");
    }
    let unix = unix.replace('\r', "\n");
    unix.split('\n').map(ToOwned::to_owned).collect()
}
