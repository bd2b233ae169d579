//! Files that are read: regular ones, of a bounded size.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Opens a regular file. A pipe or a device is refused before it is opened, since it may never give anything, or never end;
/// and inputs are read more than once.
///
/// # Errors
///
/// Those of the operating system; [`ErrorKind::InvalidInput`] for anything but a regular file.
pub fn open_regular(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?;
    if kind.is_file() {
        return File::open(path);
    }
    let found = if kind.is_dir() {
        "a folder"
    } else {
        "a pipe or a device"
    };
    Err(io::Error::new(
        ErrorKind::InvalidInput,
        format!("is {found}; expected a file"),
    ))
}

/// Text of a regular file of at most so many bytes.
///
/// # Errors
///
/// Those of [`open_regular`]; [`ErrorKind::FileTooLarge`]; [`ErrorKind::InvalidData`] for a file that is not UTF-8.
pub fn read_text(path: &Path, most_bytes: u64) -> io::Result<String> {
    let file = open_regular(path)?;
    // One more tells a file that is too large, however large it is, and however it grows.
    let mut bytes = Vec::new();
    file.take(most_bytes.saturating_add(1))
        .read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most_bytes {
        return Err(io::Error::new(
            ErrorKind::FileTooLarge,
            format!("is larger than {most_bytes} bytes, the most that is read of such a file"),
        ));
    }
    String::from_utf8(bytes).map_err(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        io::Error::new(
            ErrorKind::InvalidData,
            format!("line {line} is no text in UTF-8"),
        )
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may end in a panic")]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_bound_and_a_folder_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        fs::write(&path, "12345").unwrap();
        assert_eq!(read_text(&path, 5).unwrap(), "12345");
        let large = read_text(&path, 4).unwrap_err();
        assert_eq!(large.kind(), ErrorKind::FileTooLarge);
        assert!(large.to_string().starts_with("is larger than 4 bytes"));
        let refused = open_regular(folder.path()).unwrap_err();
        assert_eq!(refused.to_string(), "is a folder; expected a file");
        fs::write(&path, b"1\n2\xff").unwrap();
        let no_text = read_text(&path, 4).unwrap_err();
        assert_eq!(no_text.kind(), ErrorKind::InvalidData);
        assert_eq!(no_text.to_string(), "line 2 is no text in UTF-8");
    }
}
