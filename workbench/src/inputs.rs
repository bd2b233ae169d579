//! Names and hashes of the input files of a result.

use std::fmt::Write;
use std::io::{self, Read};
use std::path::Path;

use identify::InputFile;
use recording::open_regular;
use sha2::{Digest, Sha256};

use crate::WorkbenchError;

/// Names and hashes of files.
///
/// # Errors
///
/// [`WorkbenchError::Read`].
pub fn hashed(paths: &[&Path]) -> Result<Vec<InputFile>, WorkbenchError> {
    let hashed = |path: &&Path| {
        let sha256 = sha256(path).map_err(|source| WorkbenchError::Read {
            path: path.to_path_buf(),
            source,
        })?;
        Ok(InputFile {
            file: path.display().to_string(),
            sha256,
        })
    };
    paths.iter().map(hashed).collect()
}

/// Of a file of any size.
fn sha256(path: &Path) -> io::Result<String> {
    let mut file = open_regular(path)?;
    let mut hasher = Sha256::new();
    let mut bytes = vec![0; 1 << 16];
    loop {
        match file.read(&mut bytes)? {
            0 => return Ok(hexadecimal(&hasher.finalize())),
            n => hasher.update(&bytes[..n]),
        }
    }
}

/// SHA-256 of bytes, in hexadecimal.
#[must_use]
pub fn sha256_of(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hexadecimal(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(2 * bytes.len());
    for byte in bytes {
        // Writing to a string does not fail.
        let _ = write!(text, "{byte:02x}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_everybody() {
        assert_eq!(
            sha256_of(b"abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
