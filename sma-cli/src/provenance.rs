//! How a model was made: the call, and what its inputs were.

use std::path::Path;

use identify::Provenance;
use workbench::{WorkbenchError, hashed};

/// The call of this program and the hashes of its inputs.
pub(crate) fn provenance(seed: u64, inputs: &[&Path]) -> Result<Provenance, WorkbenchError> {
    Ok(Provenance {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        command: call(),
        seed,
        input: hashed(inputs)?,
    })
}

/// The call of this program, but for what it was resumed from: the result is the same.
pub(crate) fn call() -> String {
    // A name that is not UTF-8 has no spelling; what stands for it says so.
    let arguments = std::env::args_os().skip(1);
    spelled(arguments.map(|argument| argument.to_string_lossy().into_owned()))
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
pub(crate) fn quoted(argument: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,".contains(c);
    if !argument.is_empty() && argument.chars().all(plain) {
        argument.to_owned()
    } else {
        format!("'{}'", argument.replace('\'', "'\\''"))
    }
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
}
