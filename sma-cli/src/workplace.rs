//! A folder for files that are no results yet.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context;
use tempfile::{Builder, TempDir};

/// Beginning of the names of such folders.
const PREFIX: &str = ".run-";

/// Times that a folder is tried to be removed.
const LEAVING: usize = 100;

/// File that its call holds locked; it says on which machine.
const LOCK: &str = "lock";

/// Name of this machine, where it has one.
const MACHINE: &str = "/proc/sys/kernel/hostname";

/// Folder of one call, in that of its results. It is removed at the end; that of a call that was killed is removed by the next
/// one on the same machine, since not every file system tells others of its locks.
#[derive(Debug)]
pub(crate) struct Workplace {
    folder: TempDir,
    /// Locked as long as the call runs.
    _lock: File,
}

/// The folder of a call that is interrupted.
#[derive(Debug)]
pub(crate) struct Leaving(PathBuf);

impl Workplace {
    /// Makes one, and removes those of calls that were killed.
    pub(crate) fn make(out: &Path) -> anyhow::Result<Self> {
        let cannot = || format!("{}: cannot be written", out.display());
        remove_left(out).with_context(cannot)?;
        let folder = Builder::new().prefix(PREFIX).tempdir_in(out);
        let folder = folder.with_context(cannot)?;
        let lock = locked(folder.path()).with_context(cannot)?;
        Ok(Self {
            folder,
            _lock: lock,
        })
    }

    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// For a handler of signals.
    pub(crate) fn leaving(&self) -> Leaving {
        Leaving(self.path().to_owned())
    }
}

impl Drop for Workplace {
    /// Looks once more for what a call has left that was killed just before this one began: until the process that it was starting runs a
    /// program of its own, that process holds its locks. What cannot be removed now, the next call removes.
    fn drop(&mut self) {
        if let Some(out) = self.path().parent() {
            let _ = remove_left(out);
        }
    }
}

impl Leaving {
    /// Removes the folder; again, if somebody has put a file into it meanwhile. What cannot be removed now, the next call removes.
    pub(crate) fn leave(&self) {
        for _ in 0..LEAVING {
            let removed = fs::remove_dir_all(&self.0);
            if removed.is_ok() || !self.0.exists() {
                return;
            }
        }
    }
}

/// A locked file in a folder. It gets its name when it is locked: a file of that name without a lock is that of a call that
/// was killed.
fn locked(folder: &Path) -> io::Result<File> {
    let opening = folder.join("opening");
    fs::write(&opening, machine())?;
    let lock = to_lock(&opening)?;
    match lock.lock() {
        // Without locks nobody can say whose call was killed: its folder stays.
        Err(error) if error.kind() == io::ErrorKind::Unsupported => return Ok(lock),
        locked => locked?,
    }
    fs::rename(opening, folder.join(LOCK))?;
    Ok(lock)
}

/// Opens a file to be locked: network file systems lock only what may be written.
fn to_lock(path: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).write(true).open(path)
}

fn machine() -> Vec<u8> {
    fs::read(MACHINE).unwrap_or_default()
}

fn remove_left(out: &Path) -> io::Result<()> {
    for entry in fs::read_dir(out)? {
        let entry = entry?;
        let lock = entry.path().join(LOCK);
        let is_ours = entry.file_name().to_string_lossy().starts_with(PREFIX)
            && fs::read(&lock).is_ok_and(|made_on| made_on == machine());
        if is_ours && to_lock(&lock).is_ok_and(|lock| lock.try_lock().is_ok()) {
            // Another call may be removing it.
            let _ = fs::remove_dir_all(entry.path());
        }
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may end in a panic")]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_nobody_holds_is_removed_by_the_next_call() {
        let out = tempfile::tempdir().unwrap();
        let held = Workplace::make(out.path()).unwrap();
        let left = out.path().join(".run-left");
        fs::create_dir(&left).unwrap();
        fs::write(left.join(LOCK), machine()).unwrap();
        let elsewhere = out.path().join(".run-elsewhere");
        fs::create_dir(&elsewhere).unwrap();
        fs::write(elsewhere.join(LOCK), "another machine\n").unwrap();
        let opening = out.path().join(".run-opening");
        fs::create_dir(&opening).unwrap();
        let next = Workplace::make(out.path()).unwrap();
        assert!(!left.exists());
        assert!(elsewhere.exists(), "of another machine");
        assert!(opening.exists(), "of a call that has just begun");
        assert!(held.path().is_dir() && next.path().is_dir());
        let gone = next.path().to_owned();
        let late = out.path().join(".run-late");
        fs::create_dir(&late).unwrap();
        fs::write(late.join(LOCK), machine()).unwrap();
        drop(next);
        assert!(!gone.exists() && !late.exists());
        held.leaving().leave();
        assert!(!held.path().exists());
    }
}
