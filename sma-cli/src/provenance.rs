//! How a model was made: the call, and what its inputs were.

use std::path::Path;

use identify::{InputFile, Provenance};
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

/// Inputs as they are before they are read, with the hashes of what stands there then.
#[derive(Debug)]
pub(crate) struct Unread(Vec<Option<InputFile>>);

impl Unread {
    /// Looks at the inputs. One that cannot be read is left to whoever reads it, who says more.
    pub(crate) fn of(inputs: &[&Path]) -> Self {
        let seen = |path: &&Path| hashed(&[path]).ok()?.into_iter().next();
        Self(inputs.iter().map(seen).collect())
    }

    /// How a result was made of the inputs, after they were read: the hashes are those of what was read, since the files were
    /// the same before.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::Changed`] for one that is another one now, [`WorkbenchError::Read`].
    pub(crate) fn read(self, seed: u64, inputs: &[&Path]) -> Result<Provenance, WorkbenchError> {
        let made = provenance(seed, inputs)?;
        let now = made.input.iter().zip(inputs).zip(&self.0);
        match now
            .into_iter()
            .find(|((now, _), before)| before.as_ref() != Some(*now))
        {
            None => Ok(made),
            Some(((_, path), _)) => Err(WorkbenchError::Changed {
                path: path.to_path_buf(),
            }),
        }
    }
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
#[allow(clippy::unwrap_used, reason = "a test may end in a panic")]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_changes_while_it_is_read_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.csv");
        std::fs::write(&path, "time_s").unwrap();
        let made = Unread::of(&[&path]).read(1, &[&path]).unwrap();
        assert_eq!(made.input, hashed(&[&path]).unwrap());
        let unread = Unread::of(&[&path]);
        std::fs::write(&path, "time_ms").unwrap();
        let text = unread.read(1, &[&path]).unwrap_err().to_string();
        assert!(
            text.ends_with("run.csv: was changed while it was read; run the command again"),
            "{text}"
        );
    }

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
