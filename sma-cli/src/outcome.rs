//! How a command ends, as an exit code.

use std::error::Error;
use std::io::{self, Write};
use std::process::ExitCode;

use identify::IdentifyError;
use recording::RecordingError;

/// How a command that did its work ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Done.
    Done,
    /// Done, but the search did not converge.
    NotConverged,
}

/// Exit code of bad input.
const BAD_INPUT: u8 = 3;
/// Exit code of a search that did not converge.
const NOT_CONVERGED: u8 = 4;

/// Maps how a command ended to the exit code, and says on stderr why it failed.
pub(crate) fn report(result: anyhow::Result<Outcome>) -> ExitCode {
    let error = match result {
        Ok(Outcome::Done) => return ExitCode::SUCCESS,
        Ok(Outcome::NotConverged) => return ExitCode::from(NOT_CONVERGED),
        Err(error) => error,
    };
    if is_closed_pipe(&error) {
        return ExitCode::SUCCESS;
    }
    let chain: Vec<String> = error.chain().map(ToString::to_string).collect();
    // Nobody is left to tell if stderr is closed too.
    let _ = writeln!(io::stderr(), "sma: {}", chain.join(": "));
    if is_bad_input(error.as_ref()) {
        ExitCode::from(BAD_INPUT)
    } else {
        ExitCode::FAILURE
    }
}

/// Whoever read our output has seen enough: not an error.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<io::Error>()
        .is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

fn is_bad_input(error: &(dyn Error + 'static)) -> bool {
    error.is::<IdentifyError>() || error.is::<RecordingError>()
}
