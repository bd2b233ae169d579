//! From bytes to lines.

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
    let text = match bytes {
        [0xef, 0xbb, 0xbf, text @ ..] => String::from_utf8_lossy(text).into_owned(),
        [0xff, 0xfe, units @ ..] => {
            done.of_file("the text is UTF-16LE, not UTF-8");
            from_utf16(units, u16::from_le_bytes)
        }
        [0xfe, 0xff, units @ ..] => {
            done.of_file("the text is UTF-16BE, not UTF-8");
            from_utf16(units, u16::from_be_bytes)
        }
        _ => match std::str::from_utf8(bytes) {
            Ok(text) => text.to_owned(),
            Err(_) => {
                done.of_file("the text is not UTF-8: read as windows-1252 (Latin-1)");
                bytes.iter().map(|&byte| from_windows_1252(byte)).collect()
            }
        },
    };
    let unix = text.replace("\r\n", "\n");
    if unix.contains('\r') {
        done.of_file("lines end with carriage returns");
    }
    let unix = unix.replace('\r', "\n");
    unix.split('\n').map(ToOwned::to_owned).collect()
}

/// Text of two bytes a unit; what is none, and half a unit at the end, becomes U+FFFD.
fn from_utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let pairs = bytes.chunks(2).map(|pair| match *pair {
        [first, second] => unit([first, second]),
        _ => 0xfffd,
    });
    let chars = char::decode_utf16(pairs);
    chars
        .map(|char| char.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect()
}

/// Characters of windows-1252 where it is not Latin-1, from 0x80 on [WhatwgEncoding].
const BESIDE_LATIN_1: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8d}', 'Ž',
    '\u{8f}', //
    '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9d}', 'ž', 'Ÿ',
];

fn from_windows_1252(byte: u8) -> char {
    match byte {
        0x80..=0x9f => BESIDE_LATIN_1[usize::from(byte - 0x80)],
        _ => char::from(byte),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Vec<String> {
        lines(bytes, &mut Done::default())
    }

    #[test]
    fn marks_and_encodings_are_taken_off() {
        let lines = ["T/°C, 5 µm", "€ 😀"].map(ToOwned::to_owned);
        let text = lines.join("\r\n");
        let units: Vec<u16> = "\u{feff}"
            .encode_utf16()
            .chain(text.encode_utf16())
            .collect();
        let [little, big] = [u16::to_le_bytes, u16::to_be_bytes].map(|bytes| {
            units
                .iter()
                .flat_map(|&unit| bytes(unit))
                .collect::<Vec<u8>>()
        });
        for bytes in [
            text.as_bytes(),
            format!("\u{feff}{text}").as_bytes(),
            &little,
            &big,
        ] {
            assert_eq!(read(bytes), lines);
        }
        // A half pair, and half a unit.
        assert_eq!(read(b"\xff\xfe\x3d\xd8a\0b"), ["\u{fffd}a\u{fffd}"]);
        assert_eq!(read(b"5 \xb5m \x96 \x80"), ["5 µm – €"]);
    }
}
