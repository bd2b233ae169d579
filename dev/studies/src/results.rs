use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::{CaseLine, Study, StudyError};

/// A file of results: a JSON object a line, a line a case.
///
/// What is in it when it is opened stays; a last line without its end, from a run that was cut off, does not.
#[derive(Debug)]
pub struct Results {
    path: PathBuf,
    file: File,
    /// With their text: to read a number and write it again may move its last digit.
    lines: BTreeMap<(Study, u64), (CaseLine, String)>,
    /// Whether the lines of the file stand in their order.
    is_sorted: bool,
}

impl Results {
    /// Opens a file, or makes it.
    ///
    /// # Errors
    ///
    /// [`StudyError::File`], [`StudyError::InUse`], [`StudyError::Line`], [`StudyError::Twice`].
    pub fn open(path: &Path) -> Result<Self, StudyError> {
        let failed = |source| failed(path, source);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(failed)?;
        file.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => StudyError::InUse {
                path: path.to_owned(),
            },
            TryLockError::Error(source) => failed(source),
        })?;
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(failed)?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        file.set_len(whole as u64).map_err(failed)?;
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        let mut results = Self {
            path: path.to_owned(),
            file,
            lines: BTreeMap::new(),
            is_sorted: true,
        };
        for (index, line) in text[..whole].lines().enumerate() {
            results.keep(index, line)?;
        }
        Ok(results)
    }

    fn keep(&mut self, index: usize, text: &str) -> Result<(), StudyError> {
        let line: CaseLine = serde_json::from_str(text).map_err(|source| StudyError::Line {
            path: self.path.clone(),
            line: index + 1,
            source,
        })?;
        let (study, case) = (line.study, line.case);
        if self.insert(line, format!("{text}\n")) {
            return Ok(());
        }
        Err(StudyError::Twice {
            path: self.path.clone(),
            line: index + 1,
            study: study.id(),
            case,
        })
    }

    /// Whether the line is new.
    fn insert(&mut self, line: CaseLine, text: String) -> bool {
        let key = (line.study, line.case);
        self.is_sorted &= self
            .lines
            .last_key_value()
            .is_none_or(|(&last, _)| last < key);
        self.lines.insert(key, (line, text)).is_none()
    }

    /// Whether a case is in it.
    #[must_use]
    pub fn contains(&self, study: Study, case: u64) -> bool {
        self.lines.contains_key(&(study, case))
    }

    /// The cases of a study, by number.
    pub fn of(&self, study: Study) -> impl Iterator<Item = &CaseLine> {
        self.lines
            .range((study, 0)..=(study, u64::MAX))
            .map(|(_, (line, _))| line)
    }

    /// Adds a line at the end, and sees it to the disk's cache before it returns.
    ///
    /// # Errors
    ///
    /// [`StudyError::File`].
    pub fn append(&mut self, line: CaseLine) -> Result<(), StudyError> {
        let text = serde_json::to_string(&line).map_err(io::Error::from);
        let text = text.map_err(|source| failed(&self.path, source))? + "\n";
        self.file
            .write_all(text.as_bytes())
            .and_then(|()| self.file.flush())
            .map_err(|source| failed(&self.path, source))?;
        self.insert(line, text);
        Ok(())
    }

    /// Brings the lines into the order of studies and cases, in whatever order they were run.
    ///
    /// # Errors
    ///
    /// [`StudyError::File`].
    pub fn sorted(self) -> Result<Self, StudyError> {
        if self.is_sorted {
            return Ok(self);
        }
        let failed = |source| failed(&self.path, source);
        let texts = self.lines.values().map(|(_, text)| text.as_str());
        let whole: String = texts.collect();
        let beside = self.path.with_extension("jsonl.new");
        fs::write(&beside, whole)
            .and_then(|()| fs::rename(&beside, &self.path))
            .map_err(failed)?;
        Self::open(&self.path)
    }
}

fn failed(path: &Path, source: io::Error) -> StudyError {
    StudyError::File {
        path: path.to_owned(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Errors, Outcome};

    fn line(case: u64) -> CaseLine {
        CaseLine {
            study: Study::CleanWhite,
            case,
            seed: 7,
            truth: None,
            diagnosis: Outcome {
                verdict: "adequate".to_owned(),
                t: None,
                findings: Vec::new(),
                suspects: Vec::new(),
                baseline: Errors {
                    train: 1.0 / 3.0,
                    unseen: Some(1.1),
                },
                extended: None,
                explained: None,
                interval: None,
                simulations: 12_345,
            },
            steps: Vec::new(),
        }
    }

    fn written(path: &Path, cases: &[u64]) -> String {
        let mut results = Results::open(path).unwrap();
        for &case in cases {
            results.append(line(case)).unwrap();
        }
        results.sorted().unwrap();
        fs::read_to_string(path).unwrap()
    }

    #[test]
    fn a_half_written_line_is_run_again_and_the_bytes_are_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cut.jsonl");
        let whole = written(&path, &[0, 1, 2]);
        fs::write(&path, &whole[..whole.len() - 9]).unwrap();
        let results = Results::open(&path).unwrap();
        assert!(results.contains(Study::CleanWhite, 1));
        assert!(!results.contains(Study::CleanWhite, 2));
        assert!(results.of(Study::CleanWhite).eq(&[line(0), line(1)]));
        drop(results);
        assert_eq!(written(&path, &[2]), whole);
    }

    #[test]
    fn lines_are_sorted_in_whatever_order_they_came() {
        let folder = tempfile::tempdir().unwrap();
        let straight = written(&folder.path().join("straight.jsonl"), &[0, 1, 2]);
        let path = folder.path().join("turned.jsonl");
        written(&path, &[2]);
        assert_eq!(written(&path, &[0, 1]), straight);
    }

    #[test]
    fn a_whole_line_that_is_none_of_ours_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bad.jsonl");
        let whole = written(&path, &[0]);
        fs::write(&path, format!("{whole}{{}}\n")).unwrap();
        let text = Results::open(&path).unwrap_err().to_string();
        assert!(text.ends_with("bad.jsonl:2: not a result"), "{text}");
        fs::write(&path, format!("{whole}{whole}")).unwrap();
        let text = Results::open(&path).unwrap_err().to_string();
        let end = "bad.jsonl:2: clean-white, case 0, is there twice";
        assert!(text.ends_with(end), "{text}");
    }

    #[test]
    fn two_runs_do_not_write_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("both.jsonl");
        let _first = Results::open(&path).unwrap();
        let text = Results::open(&path).unwrap_err().to_string();
        assert!(
            text.ends_with("both.jsonl: another run is writing it"),
            "{text}"
        );
    }
}
