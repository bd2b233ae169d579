//! `sma identify`: recordings in, an identified model out.

use std::io::{self, IsTerminal, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, ValueEnum};
use identify::{FitConfig, Loss, Rod, WienerModel, fit, validate};
use indicatif::{ProgressBar, ProgressStyle};
use recording::Recording;
use wiener::hysteresis::Rule;

use crate::outcome::Outcome;
use crate::report::identified::Identified;
use crate::sink::Sink;

/// Fit the grey-box model to recordings, and check it on recordings it has not seen.
///
/// rod.toml says what is known of the rig; what it omits is identified where the data allow. Several
/// training recordings are fitted together, each with its own offset.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  \
    sma identify rod.toml --train ramp01.csv step01.csv --validate ramp02.csv --json fit.json\n\n\
    Exit codes: 0 done, 1 failed, 2 usage, 3 bad input, 4 done but not converged")]
pub(crate) struct IdentifyArgs {
    /// What is known of the rig.
    rod: PathBuf,
    /// Recordings to fit, CSV.
    #[arg(long, num_args = 1.., required = true, value_name = "CSV")]
    train: Vec<PathBuf>,
    /// Recordings to check the fit on, CSV; never used in the fit.
    #[arg(long, num_args = 1.., value_name = "CSV")]
    validate: Vec<PathBuf>,
    /// Which reversals the hysteresis remembers.
    #[arg(long, value_enum, default_value_t = Memory::LastReversal)]
    memory: Memory,
    /// What is made small: the mean square, or Huber's loss, which outliers hardly move.
    #[arg(long, value_enum, default_value_t = LossArg::Squares)]
    loss: LossArg,
    /// Independent starts of the search.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..))]
    starts: u64,
    /// Seed: same seed and inputs, same result.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; 0 takes all. The result does not depend on it.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=256))]
    threads: u16,
    /// Write the result as JSON to a file, or to stdout instead of the text if it is "-".
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// No progress and no notes.
    #[arg(long, short)]
    quiet: bool,
}

/// What is made small.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum LossArg {
    /// The mean square.
    Squares,
    /// Huber's loss.
    Huber,
}

/// Reversals remembered.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Memory {
    /// The last one: the paper's operator.
    LastReversal,
    /// All that enclose the present loop: minor loops close.
    Nested,
}

impl Memory {
    fn rule(self) -> Rule {
        match self {
            Memory::LastReversal => Rule::LastReversal,
            Memory::Nested => Rule::Nested,
        }
    }
}

/// Runs the command.
pub(crate) fn run(args: &IdentifyArgs) -> anyhow::Result<Outcome> {
    let threads = rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(args.threads))
        .build()?;
    threads.install(|| identify(args))
}

fn identify(args: &IdentifyArgs) -> anyhow::Result<Outcome> {
    // Before the long run: a place that cannot be written to is found out now.
    let inputs: Vec<&Path> = std::iter::once(&args.rod)
        .chain(&args.train)
        .chain(&args.validate)
        .map(PathBuf::as_path)
        .collect();
    let json = args
        .json
        .as_deref()
        .map(|path| Sink::open(path, &inputs))
        .transpose()?;
    let rod = Rod::read(&args.rod)?;
    let training = read_all(&rod, &args.train)?;
    let unseen = read_all(&rod, &args.validate)?;
    let model = WienerModel::new(&rod, args.memory.rule(), &training)?;
    let config = FitConfig {
        starts: args.starts,
        seed: args.seed,
        loss: match args.loss {
            LossArg::Squares => Loss::Squares,
            LossArg::Huber => Loss::Huber,
        },
        ..FitConfig::default()
    };
    let bar = progress(args);
    let fit = fit(&model, &training, &config, &mut |progress| {
        bar.set_position(progress.starts);
        bar.set_message(format!("RMSE {:.4}", progress.lowest_rmse));
        ControlFlow::Continue(())
    })?;
    bar.finish_and_clear();
    let validated = unseen
        .iter()
        .map(|recording| validate(&model, &fit, recording))
        .collect::<Result<Vec<_>, _>>()?;
    let missing_for_temperature = if model.knows_temperature() {
        Vec::new()
    } else {
        rod.missing_for_temperature()
    };
    let identified = Identified {
        fit: &fit,
        validated: &validated,
        missing_for_temperature,
        memory: match args.memory {
            Memory::LastReversal => "last-reversal",
            Memory::Nested => "nested",
        },
    };
    if !args.quiet {
        let mut notes = identified.notes();
        notes.extend(input_notes(args, training.iter().chain(&unseen)));
        for note in notes {
            writeln!(io::stderr(), "note: {note}")?;
        }
    }
    let json_text = serde_json::to_string_pretty(&identified.json())? + "\n";
    match json {
        Some(Sink::Stdout) => write_stdout(&json_text)?,
        Some(file) => {
            write_stdout(&identified.text())?;
            file.write(&json_text)?;
        }
        None => write_stdout(&identified.text())?,
    }
    Ok(if fit.converged() {
        Outcome::Done
    } else {
        Outcome::NotConverged
    })
}

/// What is odd about the recordings themselves.
fn input_notes<'a>(
    args: &IdentifyArgs,
    recordings: impl Iterator<Item = &'a Recording>,
) -> Vec<String> {
    let mut notes = Vec::new();
    let real = |path: &PathBuf| path.canonicalize().ok();
    let trained: Vec<_> = args.train.iter().map(real).collect();
    for path in args
        .validate
        .iter()
        .filter(|path| trained.contains(&real(path)))
    {
        notes.push(format!(
            "{} is also a training recording: it is not unseen",
            path.display()
        ));
    }
    for recording in recordings {
        for gap in recording.gaps() {
            notes.push(format!(
                "{}: nothing recorded from {} s for {:.3} s; the drive is taken to have stayed",
                recording.name(),
                gap.start_s,
                gap.dt_s
            ));
        }
    }
    notes
}

fn read_all(rod: &Rod, paths: &[PathBuf]) -> anyhow::Result<Vec<Recording>> {
    let options = rod.read_options();
    paths
        .iter()
        .map(|path| Ok(recording::read_csv(path, &options)?))
        .collect()
}

/// A closed pipe comes back as an `io::Error` and ends the program quietly.
fn write_stdout(text: &str) -> io::Result<()> {
    io::stdout().write_all(text.as_bytes())?;
    io::stdout().flush()
}

/// A bar on a terminal, nothing elsewhere.
fn progress(args: &IdentifyArgs) -> ProgressBar {
    if args.quiet || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(args.starts);
    if let Ok(style) = ProgressStyle::with_template("identify {bar:20} start {pos}/{len}  {msg}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}
