//! How a command ends, as an exit code.

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use blind_trial::{LikeError, TrialError};
use identify::IdentifyError;
use pid_tune::{TaskError, TuneError};
use recording::RecordingError;
use rig_files::RigFileError;
use sma_effects::PhysicsError;
use sma_export::ExportError;
use wiener::WienerError;
use workbench::fleet::FleetError;
use workbench::{RigError, WorkbenchError};

use crate::resume::ResumeError;
use crate::terminal::harmless;

/// How a command that did its work ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Done.
    Done,
    /// Done, but the search did not converge.
    NotConverged,
    /// Done, but no rig can be what came out.
    Implausible,
    /// Done, but the model does not describe the recordings.
    NotDescribed,
    /// Done, but the rig did not do what was promised of it.
    NotAsPromised,
}

pub(crate) const DONE: u8 = 0;
const FAILED: u8 = 1;
pub(crate) const BAD_INPUT: u8 = 3;
/// The result is not to be used.
pub(crate) const NOT_TO_BE_USED: u8 = 4;
/// Interrupted by Ctrl-C, as shells have it.
pub(crate) const INTERRUPTED: u8 = 130;

/// Says on stderr why a command failed, and maps how it ended to the exit code.
pub(crate) fn report(result: &anyhow::Result<Outcome>) -> ExitCode {
    if let Err(error) = result
        && !is_closed_pipe(error)
    {
        // Nobody is left to tell if stderr is closed too.
        let _ = writeln!(
            io::stderr(),
            "sma: {}",
            harmless(&with_sources(error.as_ref()))
        );
    }
    ExitCode::from(code(result))
}

/// An error and what is behind it.
pub(crate) fn with_sources(error: &dyn Error) -> String {
    let chain = std::iter::successors(Some(error), |&error| error.source());
    let texts: Vec<String> = chain.map(ToString::to_string).collect();
    texts.join(": ")
}

/// True for a file that is there and cannot be read: no permission, no answer of a disk, too many open files. It may be read the next
/// time, so it says nothing of the input.
pub(crate) fn is_of_the_machine(error: &(dyn Error + 'static)) -> bool {
    /// ENOENT, ENOTDIR, EISDIR, ENAMETOOLONG, ELOOP: there is no such file.
    const NO_FILE: [i32; 5] = [2, 20, 21, 36, 40];
    let chain = std::iter::successors(Some(error), |&error| error.source());
    let mut codes = chain.filter_map(|error| error.downcast_ref::<io::Error>()?.raw_os_error());
    codes.any(|code| !NO_FILE.contains(&code))
}

/// Exit codes; clap itself ends with 2 for a call that is no call of this program.
fn code(result: &anyhow::Result<Outcome>) -> u8 {
    match result {
        Ok(Outcome::Done) => DONE,
        Ok(
            Outcome::NotConverged
            | Outcome::Implausible
            | Outcome::NotDescribed
            | Outcome::NotAsPromised,
        ) => NOT_TO_BE_USED,
        Err(error) if is_closed_pipe(error) => DONE,
        Err(error) if finds_no_controller(error.as_ref()) => NOT_TO_BE_USED,
        Err(error) if is_bad_input(error.as_ref()) => BAD_INPUT,
        Err(_) => FAILED,
    }
}

/// Whoever read our output has seen enough: not an error.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<io::Error>()
        .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// The input is sound, and no gains are.
fn finds_no_controller(error: &(dyn Error + 'static)) -> bool {
    let of_task = error.downcast_ref::<TaskError<PhysicsError>>();
    let tuned = match of_task {
        Some(TaskError::Tune(error)) => Some(error),
        _ => error.downcast_ref::<TuneError>(),
    };
    matches!(tuned, Some(TuneError::Unmet | TuneError::NoRest))
}

fn is_bad_input(error: &(dyn Error + 'static)) -> bool {
    error.is::<IdentifyError>()
        || error.is::<RigFileError>()
        || error.is::<RecordingError>()
        || error.is::<RigError>()
        || error
            .downcast_ref::<WorkbenchError>()
            .is_some_and(WorkbenchError::is_bad_input)
        || error.is::<FleetError>()
        || error.is::<ExportError>()
        || error.is::<ResumeError>()
        || error.is::<TuneError>()
        || error.is::<TaskError<PhysicsError>>()
        || error.is::<PhysicsError>()
        || error.is::<TrialError>()
        || error.is::<LikeError>()
        || error.is::<WienerError>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_end_has_its_code() {
        assert_eq!(code(&Ok(Outcome::Done)), 0);
        assert_eq!(code(&Err(anyhow::anyhow!("no space left"))), 1);
        assert_eq!(code(&Err(IdentifyError::NoRecordings.into())), 3);
        assert_eq!(code(&Ok(Outcome::NotConverged)), 4);
        assert_eq!(code(&Ok(Outcome::Implausible)), 4);
        assert_eq!(code(&Ok(Outcome::NotDescribed)), 4);
        assert_eq!(code(&Err(TuneError::NoRest.into())), 4);
        assert_eq!(code(&Err(TuneError::NoStarts.into())), 3);
        for (os_error, expected) in [(2, false), (21, false), (5, true), (13, true), (24, true)] {
            let error = WorkbenchError::Read {
                path: "run.csv".into(),
                source: io::Error::from_raw_os_error(os_error),
            };
            assert_eq!(is_of_the_machine(&error), expected, "{os_error}");
        }
        assert!(!is_of_the_machine(&IdentifyError::NoRecordings));
        let closed = io::Error::from(io::ErrorKind::BrokenPipe);
        assert_eq!(code(&Err(closed.into())), 0);
    }
}
