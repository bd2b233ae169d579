//! Starts of an interrupted search, kept so that the next run goes on from them.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::Context;
use identify::{EndedStart, InputFile, Provenance};
use recording::read_text;
use serde::{Deserialize, Serialize};

/// Most bytes of a file of `--resume`: far more than any search writes.
const MOST_BYTES: u64 = 1 << 28;

/// At Ctrl-C, and where the machine or the terminal ends the program (SIGTERM, SIGHUP), says how to go on, and ends.
#[cfg(not(target_family = "wasm"))]
pub(crate) fn on_interrupt(said: impl Fn() -> String + Send + 'static) -> anyhow::Result<()> {
    use crate::outcome::INTERRUPTED;
    use crate::terminal::harmless;

    let leave = move || {
        // Nobody is left to tell if stderr is closed too.
        let _ = writeln!(io::stderr(), "\nsma: interrupted; {}", harmless(&said()));
        std::process::exit(i32::from(INTERRUPTED));
    };
    ctrlc::set_handler(leave).context("Ctrl-C cannot be caught")
}

/// A browser ends the program without asking.
#[cfg(target_family = "wasm")]
#[allow(clippy::unnecessary_wraps, reason = "elsewhere it can fail")]
pub(crate) fn on_interrupt(_: impl Fn() -> String + Send + 'static) -> anyhow::Result<()> {
    Ok(())
}

/// Why a file cannot be gone on from.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ResumeError {
    #[error("{}:{line}: no line of a file that --resume wrote", path.display())]
    Line {
        path: PathBuf,
        line: usize,
        source: serde_json::Error,
    },
    #[error("{}: cannot be read", path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("{}: is of another call, {command}; give that one, or another file", path.display())]
    OtherCall { path: PathBuf, command: String },
    #[error("{}: is of other recordings, or of another version of this program; give another file", path.display())]
    OtherFiles { path: PathBuf },
}

/// First line of the file: of what search it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Of {
    version: String,
    command: String,
    /// Files that were read: name and SHA-256.
    inputs: Vec<(String, String)>,
}

/// The starts of a fit that have ended: in memory, and in the file of `--resume`, line by line. If the program is
/// interrupted they are there, and it says how to go on.
#[derive(Debug, Clone)]
pub(crate) struct Starts(Arc<Mutex<Kept>>);

#[derive(Debug)]
struct Kept {
    /// The file of `--resume`, or where they are put if that was not given.
    path: PathBuf,
    file: Option<File>,
    of: Of,
    ended: Vec<EndedStart>,
    /// Why the file is not whole.
    failed: Option<io::Error>,
}

impl Starts {
    /// Those of an earlier run, from the file of `--resume` if it is there; `command` names the file if none was given.
    pub(crate) fn open(
        path: Option<&Path>,
        command: &str,
        made: &Provenance,
    ) -> anyhow::Result<Self> {
        let of = Of::from(made);
        let kept = match path {
            Some(path) => Kept::open(path, of)?,
            None => Kept {
                path: PathBuf::from(format!("sma-{command}.resume")),
                file: None,
                of,
                ended: Vec::new(),
                failed: None,
            },
        };
        let starts = Self(Arc::new(Mutex::new(kept)));
        let at_hand = starts.clone();
        on_interrupt(move || at_hand.with(Kept::leave))?;
        Ok(starts)
    }

    /// Those that are known.
    pub(crate) fn ended(&self) -> Vec<EndedStart> {
        self.with(|kept| kept.ended.clone())
    }

    /// Keeps one more, unless it is known.
    pub(crate) fn keep(&self, ended: &EndedStart) {
        self.with(|kept| {
            // It may still be said at the end that the file could not be written; the search goes on.
            if let Err(error) = kept.keep(ended) {
                kept.failed = Some(error);
            }
        });
    }

    /// The result is there: nothing is left to go on from.
    pub(crate) fn finish(self) -> anyhow::Result<()> {
        self.with(|kept| {
            kept.ended.clear();
            if kept.file.take().is_some() {
                let cannot = || format!("{}: cannot be removed", kept.path.display());
                fs::remove_file(&kept.path).with_context(cannot)?;
            }
            match kept.failed.take() {
                Some(error) => Err(error).with_context(|| kept.cannot_be_written()),
                None => Ok(()),
            }
        })
    }

    fn with<T>(&self, work: impl FnOnce(&mut Kept) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl From<&Provenance> for Of {
    fn from(made: &Provenance) -> Self {
        let pair = |input: &InputFile| (input.file.clone(), input.sha256.clone());
        Self {
            version: made.version.clone(),
            command: made.command.clone(),
            inputs: made.input.iter().map(pair).collect(),
        }
    }
}

impl Kept {
    fn open(path: &Path, of: Of) -> anyhow::Result<Self> {
        let text = match read_text(path, MOST_BYTES) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(source) => {
                let path = path.to_owned();
                return Err(ResumeError::Read { path, source }.into());
            }
        };
        // A last line without its end is from a run that was cut off; the first was written at once.
        let whole = &text[..text.rfind('\n').map_or(text.len(), |end| end + 1)];
        let mut lines = (1..).zip(whole.lines());
        let no_line = |line, source| ResumeError::Line {
            path: path.to_owned(),
            line,
            source,
        };
        if let Some((n, first)) = lines.next() {
            let kept: Of = serde_json::from_str(first).map_err(|source| no_line(n, source))?;
            let path = path.to_owned();
            if kept.command != of.command {
                let command = kept.command;
                return Err(ResumeError::OtherCall { path, command }.into());
            }
            if kept != of {
                return Err(ResumeError::OtherFiles { path }.into());
            }
        }
        let ended = lines
            .map(|(n, line)| serde_json::from_str(line).map_err(|source| no_line(n, source)))
            .collect::<Result<_, _>>()?;
        let mut kept = Self {
            path: path.to_owned(),
            file: None,
            of,
            ended,
            failed: None,
        };
        kept.write().with_context(|| kept.cannot_be_written())?;
        Ok(kept)
    }

    /// Writes the file from its beginning, to go on at its end.
    fn write(&mut self) -> io::Result<()> {
        let mut text = serde_json::to_string(&self.of)? + "\n";
        for ended in &self.ended {
            text += &(serde_json::to_string(ended)? + "\n");
        }
        let mut file = OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(true)
            .open(&self.path)?;
        file.write_all(text.as_bytes())?;
        self.file = Some(file);
        Ok(())
    }

    fn keep(&mut self, ended: &EndedStart) -> io::Result<()> {
        let line = serde_json::to_string(ended)?;
        // What is no number is no JSON either: such a start is made again.
        let is_whole = serde_json::from_str(&line).is_ok_and(|read: EndedStart| read == *ended);
        if !is_whole || self.ended.contains(ended) {
            return Ok(());
        }
        if let Some(file) = &mut self.file {
            file.write_all((line + "\n").as_bytes())?;
        }
        self.ended.push(ended.clone());
        Ok(())
    }

    fn cannot_be_written(&self) -> String {
        format!("{}: cannot be written", self.path.display())
    }

    /// Message of an interrupted run. Starts that were not on the disk go there.
    fn leave(&mut self) -> String {
        if self.ended.is_empty() {
            return "nothing was kept yet".to_owned();
        }
        if self.file.is_none()
            && let Err(error) = self.write()
        {
            return format!("{}: {error}", self.cannot_be_written());
        }
        format!(
            "{} starts are kept. To go on from there:\n  {} --resume {}",
            self.ended.len(),
            self.of.command,
            self.path.display()
        )
    }
}
