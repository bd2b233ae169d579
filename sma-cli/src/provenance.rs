//! How a model was made: the call, and what its inputs were.

use std::fmt::Write;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use anyhow::Context;
use identify::{InputFile, Provenance};
use sha2::{Digest, Sha256};

/// The call of this program and the hashes of its inputs.
pub(crate) fn provenance(seed: u64, inputs: &[&Path]) -> anyhow::Result<Provenance> {
    let input = inputs
        .iter()
        .map(|path| {
            let sha256 =
                sha256(path).with_context(|| format!("{}: cannot be read", path.display()))?;
            Ok(InputFile {
                file: path.display().to_string(),
                sha256,
            })
        })
        .collect::<anyhow::Result<_>>()?;
    Ok(Provenance {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        command: call(),
        seed,
        input,
    })
}

/// The call of this program, but for what it was resumed from: the result is the same.
pub(crate) fn call() -> String {
    spelled(std::env::args().skip(1))
}

fn spelled(mut arguments: impl Iterator<Item = String>) -> String {
    let mut call = "sma".to_owned();
    while let Some(argument) = arguments.next() {
        if argument == "--resume" {
            arguments.next();
        } else if !argument.starts_with("--resume=") {
            call += " ";
            call += &quoted(&argument);
        }
    }
    call
}

/// An argument as a shell would take it.
fn quoted(argument: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,".contains(c);
    if !argument.is_empty() && argument.chars().all(plain) {
        argument.to_owned()
    } else {
        format!("'{}'", argument.replace('\'', "'\\''"))
    }
}

/// Of a file of any size.
fn sha256(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hasher = Sha256::new();
    let mut bytes = vec![0; 1 << 16];
    loop {
        match file.read(&mut bytes)? {
            0 => return Ok(hexadecimal(&hasher.finalize())),
            n => hasher.update(&bytes[..n]),
        }
    }
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
    fn arguments_can_be_pasted_into_a_shell() {
        assert_eq!(quoted("--train"), "--train");
        assert_eq!(quoted("run 2.csv"), "'run 2.csv'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
        assert_eq!(quoted(""), "''");
    }

    #[test]
    fn a_call_is_the_same_where_it_goes_on() {
        let spell = |call: &str| spelled(call.split(' ').map(str::to_owned));
        let whole = spell("identify rod.toml --train a.csv --quiet");
        assert_eq!(whole, "sma identify rod.toml --train a.csv --quiet");
        assert_eq!(
            spell("identify --resume x rod.toml --train a.csv --quiet"),
            whole
        );
        assert_eq!(
            spell("identify rod.toml --train a.csv --resume=x --quiet"),
            whole
        );
    }

    #[test]
    fn hashes_are_those_of_everybody() {
        assert_eq!(
            hexadecimal(&Sha256::digest(b"abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
