//! A unit of work: one rig in a process of its own, so that no fault of the program in one ends the others.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Output, Stdio};

use serde_json::Value;

use crate::outcome::{BAD_INPUT, DONE, NOT_TO_BE_USED, is_of_the_machine, with_sources};
use workbench::WorkbenchError;
use workbench::fleet::{Failure, Listed, RigFiles, Role, Task, Unit, Units, named};

/// Exit code of a panic, where panics unwind.
const PANIC: i32 = 101;

/// Signals by which a program ends through its own fault, or where it asks for memory that it may not have: ILL, TRAP, ABRT, BUS,
/// FPE, SEGV.
const FAULTS: [i32; 6] = [4, 5, 6, 7, 8, 11];

/// How units are run.
#[derive(Debug)]
pub(crate) struct UnitRun<'a> {
    /// This program.
    pub(crate) program: PathBuf,
    /// SHA-256 of its file, in hexadecimal.
    pub(crate) program_sha256: &'a str,
    /// Command on each rig.
    pub(crate) command: &'static str,
    /// Its flags that can move a result.
    pub(crate) flags: Vec<String>,
    /// Kept results.
    pub(crate) units: &'a Units,
    /// Folder for files that are no results yet.
    pub(crate) place: &'a Path,
    /// True if units that failed are run again.
    pub(crate) is_retried: bool,
    /// False if kept results are looked up only.
    pub(crate) is_run: bool,
}

/// How a unit ended.
#[derive(Debug)]
pub(crate) enum Ended {
    /// There is a file of it.
    Kept {
        /// Name of the unit.
        unit: String,
    },
    /// There is no unit, since the files of the rig are not there.
    Refused(Failure),
    /// There is no file of it.
    Open {
        /// Name of the unit; `None` where a file of the rig cannot be read now.
        unit: Option<String>,
        /// Why.
        failure: Failure,
    },
}

/// A process that ended.
#[derive(Debug)]
enum Ran {
    /// By itself: the same inputs end so again.
    Of(Box<Unit>),
    /// By something else, which is said.
    Else(String),
}

impl UnitRun<'_> {
    /// Runs the unit of a rig, unless its result is kept; with notes for people.
    pub(crate) fn run(&self, number: usize, rig: &Listed) -> (Ended, Vec<String>) {
        let mut notes = Vec::new();
        let ended = self.ended(number, rig, &mut notes);
        (ended, notes)
    }

    fn ended(&self, number: usize, rig: &Listed, notes: &mut Vec<String>) -> Ended {
        let files = match &rig.files {
            Ok(files) => files,
            Err(why) if rig.is_unread => {
                notes.push(why.clone());
                return open(None, why);
            }
            Err(why) => return refused(why, &[], notes),
        };
        let task = match self.task(files) {
            Ok(task) => task,
            Err(error) if is_of_the_machine(&error) => {
                let said = with_sources(&error);
                notes.push(said.clone());
                return open(None, &said);
            }
            Err(error) => {
                let names = named(files).into_iter();
                let names: Vec<String> = names.map(|(_, name, _)| shown(&name)).collect();
                return refused(&with_sources(&error), &names, notes);
            }
        };
        let unit = task.name();
        match self.units.read(&unit) {
            Ok(Some(kept)) if kept.failure.is_none() || !self.is_retried => {
                return Ended::Kept { unit };
            }
            Ok(_) => {}
            Err(fault) => notes.push(format!("{}; it does not count", with_sources(&fault))),
        }
        if !self.is_run {
            return open(Some(unit), "no result in the folders that were merged");
        }
        let folder = self.place.join(number.to_string());
        let ended = match self.in_folder(&folder, files, task) {
            Ok(Ran::Of(result)) => {
                let failure = result.failure.as_ref();
                notes.extend(failure.map(|failure| failure.sentence.clone()));
                match self.units.keep(&result, &folder) {
                    Ok(()) => Ended::Kept { unit },
                    Err(error) => open(Some(unit), &with_sources(&error)),
                }
            }
            Ok(Ran::Else(said)) => open(Some(unit), &said),
            Err(error) => open(Some(unit), &with_sources(error.as_ref())),
        };
        if let Ended::Open { failure, .. } = &ended {
            notes.push(failure.sentence.clone());
        }
        // The whole place is removed at the end.
        let _ = fs::remove_dir_all(folder);
        ended
    }

    /// The task of a rig.
    pub(crate) fn task(&self, files: &RigFiles) -> Result<Task, WorkbenchError> {
        let of = [env!("CARGO_PKG_VERSION"), self.program_sha256];
        Task::of(of, self.command, self.flags.clone(), files)
    }

    /// Runs a task in a folder where its files have the names that they have in the task, so that no result tells where they lie.
    fn in_folder(&self, folder: &Path, files: &RigFiles, task: Task) -> anyhow::Result<Ran> {
        // Not with the folders above it: they are gone where the batch was interrupted, and stay so.
        match fs::create_dir(folder) {
            Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error.into()),
            _ => {}
        }
        let mut rod = PathBuf::new();
        let mut recordings: Vec<OsString> = Vec::new();
        for (role, name, path) in named(files) {
            link(path, &folder.join(&name), folder)?;
            let mut argument = OsString::from(match role {
                Role::Rod => {
                    rod = name;
                    continue;
                }
                Role::Train => "--train=",
                Role::Validate => "--validate=",
            });
            argument.push(name);
            recordings.push(argument);
        }
        let mut command = Command::new(&self.program);
        command
            .args(["batch-unit", self.command, "--quiet"])
            .args(["--threads", "1", "--json", "-"])
            .args(&self.flags)
            .args(recordings)
            .arg("--")
            .arg(rod)
            .current_dir(folder)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        // Ctrl-C is for this process, whose end is theirs.
        apart(&mut command);
        let mut process = command.spawn()?;
        // Held as long as the process runs, which ends when it is closed.
        let held = process.stdin.take();
        let output = process.wait_with_output()?;
        drop(held);
        if self.task(files).ok().as_ref() != Some(&task) {
            let said = "its files were changed while it ran; the same call goes on";
            return Ok(Ran::Else(said.to_owned()));
        }
        Ok(ran(task, &output))
    }
}

/// Meaning of the end of a process.
fn ran(task: Task, output: &Output) -> Ran {
    let said = String::from_utf8_lossy(&output.stderr);
    let said = said.trim();
    let said = said.strip_prefix("sma: ").unwrap_or(said);
    let is = |code: i32, of: u8| code == i32::from(of);
    match (output.status.code(), signal_of(output.status)) {
        (Some(code), _) if is(code, DONE) || is(code, NOT_TO_BE_USED) => {
            match serde_json::from_slice(&output.stdout) {
                Ok(result @ Value::Object(_)) => Ran::Of(Box::new(Unit::done(task, code, result))),
                _ => Ran::Else(format!(
                    "ended with code {code}, but without a result: {said}"
                )),
            }
        }
        (Some(code), _) if is(code, BAD_INPUT) => {
            Ran::Of(Box::new(Unit::failed(task, Some(code), said)))
        }
        (Some(PANIC), _) => Ran::Of(Box::new(Unit::failed(
            task,
            Some(PANIC),
            &crash("panic", said),
        ))),
        (Some(code), _) => Ran::Else(format!("ended with code {code}: {said}")),
        (None, Some(_)) if said.contains("memory allocation of ") => Ran::Else(format!(
            "{said}: the machine had no memory left; the same call goes on"
        )),
        (None, Some(signal)) if FAULTS.contains(&signal) => {
            let said = crash(&format!("signal {signal}"), said);
            Ran::Of(Box::new(Unit::failed(task, None, &said)))
        }
        (None, signal) => Ran::Else(format!(
            "was killed (signal {}), perhaps because the machine had no memory left; the same call goes on",
            signal.unwrap_or_default()
        )),
    }
}

/// Message of a crash, without numbers of threads, which differ from run to run.
fn crash(how: &str, said: &str) -> String {
    let mut lines = said.lines().filter(|line| !line.trim().is_empty());
    let first = lines.clone().next().unwrap_or("it said nothing");
    let behind = lines.find(|line| line.contains(" panicked at "));
    let message = behind.and_then(|_| lines.next()).unwrap_or(first);
    format!("the program crashed ({how}): {message}")
}

fn refused(why: &str, names: &[String], notes: &mut Vec<String>) -> Ended {
    notes.push(why.to_owned());
    let names = names.iter().map(String::as_str);
    Ended::Refused(Failure::said(why, names))
}

fn open(unit: Option<String>, why: &str) -> Ended {
    let failure = Failure::said(why, std::iter::empty());
    Ended::Open { unit, failure }
}

fn shown(name: &Path) -> String {
    name.to_string_lossy().into_owned()
}

/// Gives a file another name. A recording may stand in a task twice.
fn link(path: &Path, name: &Path, place: &Path) -> io::Result<()> {
    if let Some(folder) = name.parent().filter(|folder| *folder != place) {
        fs::create_dir_all(folder)?;
    }
    let whole = std::path::absolute(path)?;
    match stand_for(&whole, name) {
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            if stands_for(&whole, name)? {
                Ok(())
            } else {
                Err(error)
            }
        }
        linked => linked,
    }
}

/// Where processes come in groups, of its own.
#[cfg(unix)]
fn apart(command: &mut Command) {
    use std::os::unix::process::CommandExt;
    command.process_group(0);
}

#[cfg(windows)]
fn apart(command: &mut Command) {
    use std::os::windows::process::CommandExt;
    /// `CREATE_NEW_PROCESS_GROUP`.
    const NEW_GROUP: u32 = 0x200;
    command.creation_flags(NEW_GROUP);
}

#[cfg(not(any(unix, windows)))]
fn apart(_: &mut Command) {}

/// The signal that ended a process, where there are signals.
#[cfg(unix)]
fn signal_of(status: ExitStatus) -> Option<i32> {
    std::os::unix::process::ExitStatusExt::signal(&status)
}

#[cfg(not(unix))]
fn signal_of(_: ExitStatus) -> Option<i32> {
    None
}

/// Makes a name for a file that is not there yet.
#[cfg(unix)]
fn stand_for(file: &Path, name: &Path) -> io::Result<()> {
    std::os::unix::fs::symlink(file, name)
}

/// A copy: elsewhere links are for administrators, or for one drive.
#[cfg(not(unix))]
fn stand_for(file: &Path, name: &Path) -> io::Result<()> {
    if name.exists() {
        return Err(io::ErrorKind::AlreadyExists.into());
    }
    fs::copy(file, name).map(|_| ())
}

/// True if a name that is there is that of the file.
#[cfg(unix)]
fn stands_for(file: &Path, name: &Path) -> io::Result<bool> {
    Ok(fs::read_link(name)? == file)
}

#[cfg(not(unix))]
fn stands_for(file: &Path, name: &Path) -> io::Result<bool> {
    Ok(fs::read(name)? == fs::read(file)?)
}

#[cfg(all(test, unix))]
#[allow(clippy::unwrap_used, reason = "a test may end in a panic")]
mod tests {
    use std::os::unix::process::ExitStatusExt;

    use super::*;

    /// Kept result of a process that ended so, or the sentence on why there is none.
    fn ended(status: i32, stdout: &str, stderr: &str) -> Result<Unit, String> {
        let task = Task {
            version: "0.1.0".to_owned(),
            program: "0a".repeat(32),
            command: "diagnose".to_owned(),
            flags: Vec::new(),
            input: Vec::new(),
        };
        let output = Output {
            status: ExitStatus::from_raw(status),
            stdout: stdout.into(),
            stderr: stderr.into(),
        };
        match ran(task, &output) {
            Ran::Of(unit) => Ok(*unit),
            Ran::Else(said) => Err(said),
        }
    }

    #[test]
    fn what_would_end_so_again_is_kept_and_what_came_from_outside_is_not() {
        for code in [0, 4] {
            let unit = ended(code << 8, "{\"verdict\": \"adequate\"}", "").unwrap();
            assert_eq!((unit.exit_code, unit.failure), (Some(code), None));
            assert_eq!(unit.result["verdict"], "adequate");
        }
        for (status, exit_code, sentence) in [
            (3 << 8, Some(3), "a.csv: empty"),
            (
                101 << 8,
                Some(101),
                "the program crashed (panic): a.csv: empty",
            ),
            (6, None, "the program crashed (signal 6): a.csv: empty"),
            (11, None, "the program crashed (signal 11): a.csv: empty"),
        ] {
            let unit = ended(status, "", "sma: a.csv: empty\n").unwrap();
            assert_eq!(unit.exit_code, exit_code);
            assert_eq!(unit.failure.unwrap().sentence, sentence);
        }
        for (status, expected) in [
            (1 << 8, "ended with code 1: no space left"),
            (130 << 8, "ended with code 130: no space left"),
            (0, "ended with code 0, but without a result: no space left"),
            (9, "was killed (signal 9), perhaps because"),
            (15, "was killed (signal 15), perhaps because"),
        ] {
            let said = ended(status, "", "sma: no space left").unwrap_err();
            assert!(said.starts_with(expected), "{said}");
        }
    }

    #[test]
    fn the_message_of_a_crash_is_the_same_in_every_run() {
        let panic =
            "thread 'main' (4711) panicked at pso/src/swarm.rs:1:2:\nno particles\nnote: run with";
        assert_eq!(
            crash("panic", panic),
            "the program crashed (panic): no particles"
        );
        assert_eq!(
            crash("signal 6", "memory allocation of 8 bytes failed\n"),
            "the program crashed (signal 6): memory allocation of 8 bytes failed"
        );
        assert_eq!(
            crash("signal 11", ""),
            "the program crashed (signal 11): it said nothing"
        );
    }
}
