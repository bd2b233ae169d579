//! `sma identify`: recordings in, an identified model out.

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use clap::{Args, ValueEnum};
use identify::{FitConfig, Rod, WienerModel, fit, validate};
use indicatif::{ProgressBar, ProgressStyle};
use recording::Recording;
use wiener::hysteresis::Rule;

use crate::outcome::Outcome;
use crate::report::identified::Identified;

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
    /// Independent starts of the search.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..))]
    starts: u64,
    /// Seed: same seed and inputs, same result.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads; 0 takes all. The result does not depend on it.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Write the result as JSON to a file, or to stdout instead of the text if it is "-".
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// No progress and no notes.
    #[arg(long, short)]
    quiet: bool,
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
        .num_threads(args.threads)
        .build()?;
    threads.install(|| identify(args))
}

fn identify(args: &IdentifyArgs) -> anyhow::Result<Outcome> {
    let rod = Rod::read(&args.rod)?;
    let training = read_all(&rod, &args.train)?;
    let unseen = read_all(&rod, &args.validate)?;
    let model = WienerModel::new(&rod, args.memory.rule(), &training)?;
    let config = FitConfig {
        starts: args.starts,
        seed: args.seed,
        ..FitConfig::default()
    };
    let progress = progress(args);
    let fit = fit(&model, &training, &config, &mut |start, mean_square| {
        progress.set_position(start);
        progress.set_message(format!("RMSE {:.4}", mean_square.sqrt()));
    })?;
    progress.finish_and_clear();
    let validated = unseen
        .iter()
        .map(|recording| validate(&model, &fit, recording))
        .collect::<Result<Vec<_>, _>>()?;
    let identified = Identified {
        fit: &fit,
        validated: &validated,
        output_unit: training.first().map_or("", Recording::output_unit),
        knows_temperature: model.knows_temperature(),
        seed: args.seed,
    };
    print(args, &identified)?;
    Ok(if fit.termination.is_minimum() {
        Outcome::Done
    } else {
        Outcome::NotConverged
    })
}

fn read_all(rod: &Rod, paths: &[PathBuf]) -> anyhow::Result<Vec<Recording>> {
    let options = rod.read_options();
    paths
        .iter()
        .map(|path| Ok(recording::read_csv(path, &options)?))
        .collect()
}

fn print(args: &IdentifyArgs, identified: &Identified<'_>) -> anyhow::Result<()> {
    let json = || serde_json::to_string_pretty(&identified.json()).map(|text| text + "\n");
    let to_stdout = args.json.as_deref() == Some(Path::new("-"));
    let text = if to_stdout {
        json()?
    } else {
        identified.text()
    };
    if let Some(file) = args.json.as_deref().filter(|_| !to_stdout) {
        write_whole(file, &json()?)?;
    }
    // A closed pipe comes back as an io::Error and ends the program quietly.
    io::stdout().write_all(text.as_bytes())?;
    io::stdout().flush()?;
    Ok(())
}

/// Writes a file whole or not at all.
fn write_whole(file: &Path, text: &str) -> anyhow::Result<()> {
    let folder = match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let cannot = || format!("{}: cannot be written", file.display());
    let mut temporary = tempfile::NamedTempFile::new_in(folder).with_context(cannot)?;
    temporary.write_all(text.as_bytes()).with_context(cannot)?;
    temporary.persist(file).with_context(cannot)?;
    Ok(())
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
