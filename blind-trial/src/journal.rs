use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use crate::TrialError;
use crate::answer::hex;

/// A line of a [`Journal`].
pub trait Line: Serialize + DeserializeOwned {
    /// Key that distinguishes the lines and gives their order.
    type Key: Ord + Copy + Display;

    /// That of this line.
    fn key(&self) -> Self::Key;
}

/// The process that has locked a file; `None` where the system does not tell.
#[cfg(target_os = "linux")]
fn owner_of_lock(file: &File) -> Option<u32> {
    use std::os::unix::fs::MetadataExt;

    let made = file.metadata().ok()?;
    let device = made.dev();
    let major = (device >> 8 & 0xfff) | (device >> 32 & !0xfff);
    let minor = (device & 0xff) | (device >> 12 & !0xff);
    let name = format!("{major:02x}:{minor:02x}:{}", made.ino());
    // 1: FLOCK  ADVISORY  WRITE 4711 fe:00:393217 0 EOF
    let locks = fs::read_to_string("/proc/locks").ok()?;
    locks.lines().find_map(|line| {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let is_held = *fields.get(1)? == "FLOCK" && *fields.get(5)? == name;
        // 0 stands for a process of another container.
        is_held.then(|| fields[4].parse().ok().filter(|id| *id != 0))?
    })
}

#[cfg(not(target_os = "linux"))]
fn owner_of_lock(_: &File) -> Option<u32> {
    None
}

/// Last member of a line: the SHA-256 of the line without it.
const HASH: &str = ",\"line_sha256\":\"";
/// End of that member, and of the line.
const HASH_END: &str = "\"}";
/// Digits of a hash.
const DIGITS: usize = 64;

/// A file of results: a JSON object a line, a line a case.
///
/// Each line ends with its own hash, so that a damaged one is seen. Lines without it are from versions that wrote none.
///
/// Opening keeps all lines in it but one: a last line without its end, from a run that was cut off, is removed.
#[derive(Debug)]
pub struct Journal<L: Line> {
    path: PathBuf,
    file: File,
    /// With their text: to read a number and write it again may move its last digit.
    lines: BTreeMap<L::Key, (L, String)>,
    /// True if the lines of the file stand in their order.
    is_sorted: bool,
}

impl<L: Line> Journal<L> {
    /// Opens a file, or makes it.
    ///
    /// # Errors
    ///
    /// [`TrialError::File`], [`TrialError::InUse`], [`TrialError::Line`], [`TrialError::Damaged`], [`TrialError::Twice`].
    pub fn open(path: &Path) -> Result<Self, TrialError> {
        let failed = |source| TrialError::file(path, source);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(failed)?;
        file.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => TrialError::InUse {
                path: path.to_owned(),
                owner: owner_of_lock(&file),
            },
            TryLockError::Error(source) => failed(source),
        })?;
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(failed)?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        file.set_len(whole as u64).map_err(failed)?;
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        let mut journal = Self {
            path: path.to_owned(),
            file,
            lines: BTreeMap::new(),
            is_sorted: true,
        };
        for (index, line) in text[..whole].lines().enumerate() {
            journal.keep(index, line)?;
        }
        Ok(journal)
    }

    fn keep(&mut self, index: usize, text: &str) -> Result<(), TrialError> {
        let content = content_of(text).ok_or_else(|| TrialError::Damaged {
            path: self.path.clone(),
            line: index + 1,
        })?;
        let line: L = serde_json::from_str(&content).map_err(|source| TrialError::Line {
            path: self.path.clone(),
            line: index + 1,
            source,
        })?;
        let key = line.key();
        if self.insert(line, format!("{text}\n")) {
            return Ok(());
        }
        Err(TrialError::Twice {
            path: self.path.clone(),
            line: index + 1,
            key: key.to_string(),
        })
    }

    /// Inserts a line; true if it is new.
    fn insert(&mut self, line: L, text: String) -> bool {
        let key = line.key();
        self.is_sorted &= self
            .lines
            .last_key_value()
            .is_none_or(|(&last, _)| last < key);
        self.lines.insert(key, (line, text)).is_none()
    }

    /// True if a case is in it.
    #[must_use]
    pub fn contains(&self, key: L::Key) -> bool {
        self.lines.contains_key(&key)
    }

    /// Its lines in their order.
    pub fn lines(&self) -> impl Iterator<Item = &L> {
        self.lines.values().map(|(line, _)| line)
    }

    /// Adds a line at the end, and sees it to the disk before it returns.
    ///
    /// # Errors
    ///
    /// [`TrialError::File`].
    pub fn append(&mut self, line: L) -> Result<(), TrialError> {
        let text = serde_json::to_string(&line).map_err(io::Error::from);
        let text = text.map_err(|source| TrialError::file(&self.path, source))?;
        let text = hashed(&text) + "\n";
        self.file
            .write_all(text.as_bytes())
            .and_then(|()| self.file.sync_data())
            .map_err(|source| TrialError::file(&self.path, source))?;
        self.insert(line, text);
        Ok(())
    }

    /// Takes in the lines of another that it does not have.
    ///
    /// # Errors
    ///
    /// [`TrialError::File`].
    pub fn merge(&mut self, other: Self) -> Result<(), TrialError> {
        for (line, _) in other.lines.into_values() {
            if !self.contains(line.key()) {
                self.append(line)?;
            }
        }
        Ok(())
    }

    /// Brings the lines into their order, in whatever order they were run.
    ///
    /// # Errors
    ///
    /// [`TrialError::File`].
    pub fn sorted(self) -> Result<Self, TrialError> {
        if self.is_sorted {
            return Ok(self);
        }
        let texts = self.lines.values().map(|(_, text)| text.as_str());
        let whole: String = texts.collect();
        let beside = beside(&self.path);
        fs::write(&beside, whole)
            .and_then(|()| fs::rename(&beside, &self.path))
            .map_err(|source| TrialError::file(&self.path, source))?;
        Self::open(&self.path)
    }
}

/// A line with its hash, which stands in the place of its last brace.
fn hashed(content: &str) -> String {
    let open = content.strip_suffix('}').unwrap_or(content);
    format!("{open}{HASH}{}{HASH_END}", sha256(content))
}

/// A line without its hash; `None` if the hash is that of another line.
fn content_of(text: &str) -> Option<Cow<'_, str>> {
    // What has the name of a hash and not its form is damaged, too.
    let Some((open, rest)) = text.rsplit_once(HASH) else {
        let end = text.strip_suffix(HASH_END);
        let last = end.and_then(|end| end.get(end.len().checked_sub(DIGITS)?..));
        let is_hash = last.is_some_and(|last| last.bytes().all(|byte| byte.is_ascii_hexdigit()));
        return (!is_hash).then_some(Cow::Borrowed(text));
    };
    let hash = rest.strip_suffix(HASH_END)?;
    let content = format!("{open}}}");
    (hash.len() == DIGITS && hash == sha256(&content)).then_some(Cow::Owned(content))
}

fn sha256(text: &str) -> String {
    hex(&Sha256::digest(text.as_bytes()))
}

/// Place of a file that has not its name yet.
pub(crate) fn beside(path: &Path) -> PathBuf {
    path.with_extension(match path.extension() {
        Some(extension) if extension == "jsonl" => "jsonl.new",
        _ => "new",
    })
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    struct Number {
        case: u64,
        value: f64,
    }

    impl Line for Number {
        type Key = u64;

        fn key(&self) -> u64 {
            self.case
        }
    }

    fn line(case: u64) -> Number {
        let value = 1.0 / 3.0;
        Number { case, value }
    }

    fn written(path: &Path, cases: &[u64]) -> String {
        let mut journal = Journal::open(path).unwrap();
        for &case in cases {
            journal.append(line(case)).unwrap();
        }
        journal.sorted().unwrap();
        fs::read_to_string(path).unwrap()
    }

    #[test]
    fn a_half_written_line_is_run_again_and_the_bytes_are_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cut.jsonl");
        let whole = written(&path, &[0, 1, 2]);
        fs::write(&path, &whole[..whole.len() - 9]).unwrap();
        let journal: Journal<Number> = Journal::open(&path).unwrap();
        assert!(journal.contains(1));
        assert!(!journal.contains(2));
        assert!(journal.lines().eq(&[line(0), line(1)]));
        drop(journal);
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
    fn shards_merge_into_the_whole() {
        let folder = tempfile::tempdir().unwrap();
        let whole = written(&folder.path().join("whole.jsonl"), &[0, 1, 2]);
        let [one, other] = ["one.jsonl", "other.jsonl"].map(|name| folder.path().join(name));
        written(&one, &[0, 2]);
        written(&other, &[1, 2]);
        let mut journal: Journal<Number> = Journal::open(&one).unwrap();
        journal.merge(Journal::open(&other).unwrap()).unwrap();
        journal.sorted().unwrap();
        assert_eq!(fs::read_to_string(&one).unwrap(), whole);
    }

    #[test]
    fn a_whole_line_that_is_none_of_ours_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bad.jsonl");
        let whole = written(&path, &[0]);
        let opened = |text: &str| {
            fs::write(&path, text).unwrap();
            Journal::<Number>::open(&path).unwrap_err().to_string()
        };
        let text = opened(&format!("{whole}{{}}\n"));
        assert!(text.ends_with("bad.jsonl:2: not a result"), "{text}");
        let text = opened(&format!("{whole}{whole}"));
        assert!(text.ends_with("bad.jsonl:2: 0 is there twice"), "{text}");
    }

    #[test]
    fn a_line_with_another_content_than_was_written_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cases.jsonl");
        let whole = written(&path, &[3, 4]);
        let second = whole.lines().nth(1).unwrap();
        // Each byte in turn, but for the digits of the case itself: a damaged line is none of ours, or is seen.
        for at in 0..second.len() {
            let mut bytes = second.as_bytes().to_vec();
            bytes[at] = if bytes[at] == b'5' { b'6' } else { b'5' };
            let damaged = String::from_utf8(bytes).unwrap();
            fs::write(&path, whole.replace(second, &damaged)).unwrap();
            let text = Journal::<Number>::open(&path).unwrap_err().to_string();
            let is_seen = text.ends_with(
                "cases.jsonl:2: was changed since it was written: its hash is that of another line",
            ) || text.ends_with("cases.jsonl:2: not a result");
            assert!(is_seen, "{at}: {text}");
        }
    }

    #[test]
    fn lines_of_older_versions_have_no_hash_and_are_kept_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("old.jsonl");
        let old = "{\"case\":0,\"value\":0.3333333333333333}\n";
        fs::write(&path, old).unwrap();
        let text = written(&path, &[1]);
        assert!(text.starts_with(old), "{text}");
        assert_eq!(text.matches(HASH).count(), 1, "{text}");
        let journal: Journal<Number> = Journal::open(&path).unwrap();
        assert!(journal.lines().eq(&[line(0), line(1)]));
    }

    #[test]
    fn two_runs_do_not_write_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("both.jsonl");
        let _first: Journal<Number> = Journal::open(&path).unwrap();
        let text = Journal::<Number>::open(&path).unwrap_err().to_string();
        let said = "both.jsonl: another run is writing it";
        // Not every system tells, nor every file system as it tells of its files.
        let owner = format!("{said}, process {}", std::process::id());
        assert!(text.ends_with(&owner) || text.ends_with(said), "{text}");
    }
}
