//! `sma batch-unit`: a command on one rig of a fleet, in a process that ends with that of `sma batch`.

use std::io::Read;

use clap::{Args, Subcommand};

use crate::commands::diagnose::{self, DiagnoseArgs};
use crate::commands::identify::{self, IdentifyArgs};
use crate::outcome::{INTERRUPTED, Outcome, is_of_the_machine, with_sources};

/// One rig of `sma batch`, which calls this itself.
#[derive(Debug, Args)]
pub(crate) struct BatchUnitArgs {
    #[command(subcommand)]
    command: Unit,
}

#[derive(Debug, Subcommand)]
enum Unit {
    /// As `sma diagnose`.
    Diagnose(DiagnoseArgs),
    /// As `sma identify`.
    Identify(IdentifyArgs),
}

/// Runs the command.
pub(crate) fn run(args: &BatchUnitArgs) -> anyhow::Result<Outcome> {
    // Without a thread to watch it, this process is none that a batch may trust to end.
    std::thread::Builder::new().spawn(end_with_stdin)?;
    let ended = match &args.command {
        Unit::Diagnose(args) => diagnose::run(args),
        Unit::Identify(args) => identify::run(args),
    };
    ended.map_err(|error| {
        if is_of_the_machine(error.as_ref()) {
            // Not bad input: the batch tries it again.
            anyhow::anyhow!(with_sources(error.as_ref()))
        } else {
            error
        }
    })
}

/// Ends the process once stdin is closed: whoever waits for the result holds its other end, and was killed.
pub(crate) fn end_with_stdin() {
    let mut stdin = std::io::stdin().lock();
    let mut bytes = [0; 64];
    while stdin.read(&mut bytes).is_ok_and(|n_read| n_read > 0) {}
    std::process::exit(i32::from(INTERRUPTED));
}
