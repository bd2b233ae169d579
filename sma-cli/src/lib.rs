//! The program `sma`: its commands, what they print, and how they end. The program's help says how to use it.

mod commands;
mod demo_rig;
mod earlier;
mod memory;
mod outcome;
mod provenance;
mod resume;
mod sink;
mod terminal;
mod unit_run;
mod workplace;

use std::process::ExitCode;

use clap::Parser;

use commands::batch::BatchArgs;
use commands::batch_unit::BatchUnitArgs;
use commands::demo::DemoArgs;
use commands::diagnose::DiagnoseArgs;
use commands::identify::IdentifyArgs;
use commands::init::InitArgs;
use commands::inspect::InspectArgs;
use commands::shell::{CompletionsArgs, ManArgs};
use commands::simulate::SimulateArgs;
use commands::trial::TrialArgs;
use commands::tune::TuneArgs;

/// Identify the model of a shape-memory-alloy actuator from recordings of drive and displacement, tune a
/// controller on it, and say which physics it leaves out.
#[derive(Debug, Parser)]
#[command(name = "sma", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    Demo(DemoArgs),
    Init(InitArgs),
    Inspect(InspectArgs),
    Identify(IdentifyArgs),
    Simulate(SimulateArgs),
    Tune(TuneArgs),
    Diagnose(DiagnoseArgs),
    Batch(BatchArgs),
    #[command(hide = true)]
    BatchUnit(BatchUnitArgs),
    Trial(TrialArgs),
    Completions(CompletionsArgs),
    Man(ManArgs),
}

/// Runs the call of this process to its end.
#[must_use]
pub fn run() -> ExitCode {
    let cli = Cli::parse();
    let result = match &cli.command {
        Command::Demo(args) => commands::demo::run(args),
        Command::Init(args) => commands::init::run(args),
        Command::Inspect(args) => commands::inspect::run(args),
        Command::Identify(args) => commands::identify::run(args),
        Command::Simulate(args) => commands::simulate::run(args),
        Command::Tune(args) => commands::tune::run(args),
        Command::Diagnose(args) => commands::diagnose::run(args),
        Command::Batch(args) => commands::batch::run(args),
        Command::BatchUnit(args) => commands::batch_unit::run(args),
        Command::Trial(args) => commands::trial::run(args),
        Command::Completions(args) => commands::shell::completions(args),
        Command::Man(args) => commands::shell::man(args),
    };
    outcome::report(&result)
}
