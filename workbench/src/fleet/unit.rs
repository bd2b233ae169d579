//! A unit of work: one rig, one command, and its result as a file.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::RigFiles;
use crate::WorkbenchError;
use crate::inputs::{hashed, sha256_of};

/// Version of the document of a unit.
const SCHEMA_VERSION: u32 = 2;

/// Everything that the result of a unit depends on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// Version of the program.
    pub version: String,
    /// SHA-256 of its file, in hexadecimal: two builds of one version may differ in their last digits.
    pub program: String,
    /// The command: `diagnose` or `identify`.
    pub command: String,
    /// Flags that can move the result.
    pub flags: Vec<String>,
    /// The files, in the order of the call.
    pub input: Vec<Input>,
}

/// An input of a unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Part that the file plays.
    pub role: Role,
    /// Its name from the rig's own folder, as the result and its errors name it.
    pub file: String,
    /// SHA-256 of its content.
    pub sha256: String,
}

/// Part that a file plays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Known properties of the rig.
    Rod,
    /// A recording that decides.
    Train,
    /// An unseen recording.
    Validate,
}

/// Result of a unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unit {
    schema_version: u32,
    /// Task, whose hash is the name of the unit.
    pub task: Task,
    /// State of the unit.
    pub status: UnitStatus,
    /// Exit code of the command; `None` where it crashed.
    pub exit_code: Option<i32>,
    /// Reason for there being no result.
    pub failure: Option<Failure>,
    /// The command's own document; null if it failed.
    pub result: Value,
}

/// State of a unit that ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum UnitStatus {
    /// There is a result.
    Done,
    /// There is a failure.
    Failed,
}

/// Reason why a rig has no result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Failure {
    /// Message of the program.
    pub sentence: String,
    /// The input that is wrong, if it is one.
    pub file: Option<String>,
    /// Line in it, from 1.
    pub line: Option<u64>,
}

impl Task {
    /// A task on the files of a rig as they are now, for a program of a version and of a SHA-256.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError::Read`].
    pub fn of(
        [version, program]: [&str; 2],
        command: &str,
        flags: Vec<String>,
        files: &RigFiles,
    ) -> Result<Self, WorkbenchError> {
        let input = named(files).into_iter().map(|(role, name, path)| {
            let hashes = hashed(&[path]).map_err(|error| match error {
                // As the task names it, wherever the rig lies.
                WorkbenchError::Read { source, .. } => {
                    let path = name.clone();
                    WorkbenchError::Read { path, source }
                }
                other => other,
            })?;
            let sha256 = hashes.into_iter().map(|one| one.sha256).collect();
            Ok(Input {
                role,
                file: name.to_string_lossy().into_owned(),
                sha256,
            })
        });
        Ok(Self {
            version: version.to_owned(),
            program: program.to_owned(),
            command: command.to_owned(),
            flags,
            input: input.collect::<Result<_, WorkbenchError>>()?,
        })
    }

    /// Name of the unit: the SHA-256 of its task as JSON, in hexadecimal digits.
    #[must_use]
    pub fn name(&self) -> String {
        // Texts and names are always JSON.
        let text = serde_json::to_string(self).unwrap_or_default();
        sha256_of(text.as_bytes())
    }
}

/// The files of a rig with their names within it: those of recordings from the deepest folder that holds them all, wherever
/// that lies.
#[must_use]
pub fn named(files: &RigFiles) -> Vec<(Role, PathBuf, &Path)> {
    let train = files.train.iter().map(|path| (Role::Train, path));
    let validate = files.validate.iter().map(|path| (Role::Validate, path));
    let recordings: Vec<(Role, PathBuf, &Path)> = train
        .chain(validate)
        .map(|(role, path)| (role, from_the_root(path), path.as_path()))
        .collect();
    let home = recordings
        .iter()
        .map(|(_, whole, _)| whole.parent().unwrap_or(whole).to_owned())
        .reduce(|home, other| {
            let mut above = home.ancestors();
            let both = above.find(|folder| other.starts_with(folder));
            both.unwrap_or(Path::new("")).to_owned()
        })
        .unwrap_or_default();
    let rod_name = files.rod.file_name().unwrap_or(files.rod.as_os_str());
    let rod = (Role::Rod, PathBuf::from(rod_name), files.rod.as_path());
    let recordings = recordings.into_iter().map(|(role, whole, path)| {
        let name = whole.strip_prefix(&home).unwrap_or(&whole);
        (role, name.to_owned(), path)
    });
    std::iter::once(rod).chain(recordings).collect()
}

/// Names of the folders from the root to a file, and its own, without links to the folder above.
fn from_the_root(path: &Path) -> PathBuf {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut names = PathBuf::new();
    for component in whole.components() {
        match component {
            Component::Normal(name) => names.push(name),
            Component::ParentDir => {
                names.pop();
            }
            _ => {}
        }
    }
    names
}

impl Unit {
    /// A result.
    #[must_use]
    pub fn done(task: Task, exit_code: i32, result: Value) -> Self {
        Self {
            schema_version: SCHEMA_VERSION,
            task,
            status: UnitStatus::Done,
            exit_code: Some(exit_code),
            failure: None,
            result,
        }
    }

    /// A failure, with what the program said.
    #[must_use]
    pub fn failed(task: Task, exit_code: Option<i32>, said: &str) -> Self {
        let names = task.input.iter().map(|input| input.file.as_str());
        let failure = Some(Failure::said(said, names));
        Self {
            schema_version: SCHEMA_VERSION,
            task,
            status: UnitStatus::Failed,
            exit_code,
            failure,
            result: Value::Null,
        }
    }

    /// True if this version of the program reads it.
    #[must_use]
    pub fn is_known(&self) -> bool {
        let has_failed = self.status == UnitStatus::Failed;
        self.schema_version == SCHEMA_VERSION
            && self.failure.is_some() == has_failed
            && self.result.is_null() == has_failed
    }
}

impl Failure {
    /// A message, with the file and the line that it begins with, if it does.
    pub fn said<'a>(sentence: &str, files: impl Iterator<Item = &'a str>) -> Self {
        let begins = |file: &&str| {
            let rest = sentence.strip_prefix(file);
            rest.is_some_and(|rest| rest.starts_with(':'))
        };
        // One name may begin another.
        let file = files.filter(begins).max_by_key(|file| file.len());
        let line = file.and_then(|file| {
            let rest = sentence.get(file.len() + 1..)?;
            let end = rest.find(|c: char| !c.is_ascii_digit())?;
            rest[..end].parse().ok()
        });
        Self {
            sentence: sentence.to_owned(),
            file: file.map(str::to_owned),
            line,
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may end in a panic")]
mod tests {
    use super::*;

    #[test]
    fn a_failure_knows_file_and_line_of_its_message() {
        let of = |sentence: &str| {
            let failure = Failure::said(sentence, ["rod.toml", "a.csv", "a.csv:1"].into_iter());
            (failure.file, failure.line)
        };
        let file = |name: &str| Some(name.to_owned());
        assert_eq!(
            of("a.csv:118: current_a = \"-\""),
            (file("a.csv"), Some(118))
        );
        assert_eq!(of("rod.toml:2:15: rod"), (file("rod.toml"), Some(2)));
        assert_eq!(of("a.csv: empty"), (file("a.csv"), None));
        assert_eq!(of("a.csv:1:7: empty"), (file("a.csv:1"), Some(7)));
        assert_eq!(of("no space left"), (None, None));
        assert_eq!(of("a.csvx:1: empty"), (None, None));
    }

    #[test]
    fn recordings_are_named_from_the_folder_that_holds_them_all() {
        let names = |train: &[&str], validate: &[&str]| -> Vec<String> {
            let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect();
            let files = RigFiles {
                rod: PathBuf::from("shared/wire.toml"),
                train: paths(train),
                validate: paths(validate),
            };
            let names = named(&files)
                .into_iter()
                .map(|(_, name, _)| name.display().to_string());
            names.collect()
        };
        assert_eq!(names(&["a/b/1.csv"], &[]), ["wire.toml", "1.csv"]);
        assert_eq!(
            names(&["a/may/1.csv", "a/june/1.csv"], &["a/2.csv"]),
            ["wire.toml", "may/1.csv", "june/1.csv", "2.csv"]
        );
        assert_eq!(
            names(&["1.csv", "b/2.csv"], &[]),
            ["wire.toml", "1.csv", "b/2.csv"]
        );
        assert_eq!(
            names(&["a/../b/1.csv", "b/../../c/2.csv"], &[])[2],
            "c/2.csv"
        );
    }
}
