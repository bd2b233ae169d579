//! `sma trial`: how often a diagnosis is right, on cases whose answer is concealed from it.

use std::path::PathBuf;
use std::thread::available_parallelism;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::bail;
use blind_trial::scores::Scores;
use blind_trial::{CaseLine, Family, Like, Plan, Progress, RunConfig, Trial};
use clap::Args;

use crate::outcome::{Outcome, with_sources};
use crate::provenance::call;
use crate::resume::on_interrupt;
use crate::sink::{Outputs, deliver};
use crate::terminal::{bar, say};
use rig_files::rod_file;
use workbench::page;
use workbench::read_perhaps_without_output;
use workbench::report::trial::Tried;

/// Cases of a trial, where their number is not given.
const CASES: u64 = 60;

/// Try the diagnosis on cases whose answer is concealed from it, and count how often it is right.
///
/// A case is a rig drawn from a seed: recordings of a plant that is simulated by other equations than the diagnosis
/// knows, with one effect, two, none, or one that no catalogue has. The answers are sealed before the first diagnosis,
/// which sees the files of a case alone; then the seals are opened.
#[derive(Debug, Args)]
#[command(
    before_help = "Example:\n  \
    sma trial --cases 60 --out trial --report trial.html",
    after_help = "Before you measure: which effects could an experiment of yours reveal? A drive as CSV, and what you know of the rig:\n  \
    sma trial --like rod.toml --drive my-drive.csv --out mine\n\n\
    What is in the folder is not run again: a trial may be stopped and started as one likes, spread over machines\n\
    (--shard 1/4 --out a, --shard 2/4 --out b, …), and put together (--merge a b --out whole --cases 0).\n\n\
    In the folder: seals.csv (published first), cases.jsonl (verdicts and opened answers), times.csv, runs.csv (a line a\n\
    call of the program).\n\n\
    Families: clean-white clean-ar clean-one-over-f clean-quantized clean-outliers single hard-noise pair other-loop\n\
    other-loop-clean outside deleted"
)]
pub(crate) struct TrialArgs {
    /// Folder of the trial.
    #[arg(long, default_value = "trial", value_name = "DIR")]
    out: PathBuf,
    /// Cases in all, about, in the proportions of the published table; 0 only counts what is there [default: 60; with
    /// --like every effect alone in three sizes].
    #[arg(long)]
    cases: Option<u64>,
    /// All cases of the published table.
    #[arg(long, conflicts_with = "cases")]
    published: bool,

    /// All cases of the first published table: every recording made as the guide asks.
    #[arg(long, conflicts_with = "published")]
    guided: bool,
    /// Families of cases; all, unless given.
    #[arg(long, num_args = 1.., value_name = "FAMILY", value_parser = Family::parse)]
    family: Vec<Family>,
    /// Seed of the cases: any text. That of a published trial is the hash of the program's sources.
    #[arg(long, default_value = "1")]
    seed: String,
    /// Draw the cases around your own rig: a rod file; what it does not say is drawn.
    #[arg(
        long,
        value_name = "ROD",
        requires = "drive",
        conflicts_with = "published"
    )]
    like: Option<PathBuf>,
    /// The drive that your rig would get, a CSV with the columns of the rod file; with the output as well, its noise
    /// counts.
    #[arg(long, value_name = "CSV", requires = "like")]
    drive: Option<PathBuf>,
    /// Run every n-th case, from the i-th: i/n, i from 1.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
    /// Folders of the same trial to take cases from.
    #[arg(long, num_args = 1.., value_name = "DIR")]
    merge: Vec<PathBuf>,
    /// Cases under way at a time; 0 takes as many as there are processors. Times count where it is 1.
    #[arg(long, default_value_t = 0)]
    jobs: usize,
    /// Keep the files of the cases, to diagnose them by hand.
    #[arg(long)]
    keep_files: bool,
    /// Ask other methods as well: residual analysis, forward selection by BIC, a black box; three times as long.
    #[arg(long)]
    competitors: bool,
    /// Write the result as one HTML page with the matrix of names and figures, to read and to mail.
    #[arg(long, value_name = "FILE", alias = "html")]
    report: Option<PathBuf>,
    /// Write the result as JSON to a file, or to stdout instead of the text if it is "-".
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// No progress and no notes.
    #[arg(long, short)]
    quiet: bool,
}

/// Runs the command.
pub(crate) fn run(args: &TrialArgs) -> anyhow::Result<Outcome> {
    let mut outputs = Outputs::beside(&[]);
    let json = outputs.open_if(args.json.as_deref())?;
    let report = outputs.open_if(args.report.as_deref())?;
    let like = args.like()?;
    let is_own = like.is_some();
    let mut trial = Trial::open(&args.out, &args.seed, like)?;
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH)?.as_secs();
    trial.log(&format!(
        "{seconds},{},{}",
        env!("CARGO_PKG_VERSION"),
        call()
    ))?;
    for folder in &args.merge {
        trial.merge(folder)?;
    }
    let out = args.out.display().to_string();
    on_interrupt(move || format!("the cases that have ended are in {out}; the same call goes on"))?;
    let n_failed = args.run_cases(&mut trial)?;
    let times_s = trial.times_alone_s()?;
    let lines = trial.finished()?;
    if lines.is_empty() {
        bail!("{}: holds no case yet; give --cases", args.out.display());
    }
    let tried = Tried {
        seed: &args.seed,
        n_cases: lines.len(),
        is_own,
        scores: Scores::of(&lines, &times_s),
    };
    if let Some(report) = report {
        report.write(&page::trial(&tried)?.made(&call(), &args.seed, &[]))?;
    }
    deliver(&tried.text(), &tried.json(), json)?;
    if n_failed > 0 {
        bail!("{n_failed} cases failed; another run tries them again");
    }
    Ok(Outcome::Done)
}

impl TrialArgs {
    fn like(&self) -> anyhow::Result<Option<Like>> {
        let (Some(rod), Some(drive)) = (&self.like, &self.drive) else {
            return Ok(None);
        };
        let rod = rod_file::read(rod)?;
        let options = rod.read_options();
        let (recording, _) = read_perhaps_without_output(drive, &options)?;
        Ok(Some(Like::new(&rod, &recording)?))
    }

    fn run_cases(&self, trial: &mut Trial) -> anyhow::Result<usize> {
        let mut plan = match (self.published, self.cases, &self.like) {
            _ if self.guided => Plan::guided(&self.family),
            (true, ..) => Plan::published(&self.family),
            (false, Some(0), _) => return Ok(0),
            (false, Some(n_cases), _) => Plan::of_about(n_cases, &self.family),
            (false, None, None) => Plan::of_about(CASES, &self.family),
            (false, None, Some(_)) => Plan::singles(),
        };
        if let Some((i, n)) = self.shard {
            plan = plan.shard(i - 1, n);
        }
        let config = RunConfig {
            jobs: match self.jobs {
                0 => available_parallelism().map_or(1, std::num::NonZero::get),
                jobs => jobs,
            },
            keep_files: self.keep_files,
            asks_others: self.competitors,
        };
        let bar = bar(
            self.quiet,
            plan.cases().len() as u64,
            "trial {bar:20} {pos}/{len}, {eta} left  {msg}",
        );
        let mut broken = None;
        let n_failed = trial.run(&plan, config, &mut |progress: Progress<'_>| {
            bar.set_position(progress.done as u64);
            match progress.last {
                Ok(line) => bar.set_message(said(line)),
                Err(error) => {
                    let note = [with_sources(error)];
                    broken = broken.take().or(say(self.quiet, &note).err());
                }
            }
        })?;
        bar.finish_and_clear();
        match broken {
            Some(error) => Err(error.into()),
            None => Ok(n_failed),
        }
    }
}

/// A case in a few words; what was concealed stays so until the table.
fn said(line: &CaseLine) -> String {
    let names = line.verdict.findings.iter().map(|one| one.effect.as_str());
    let names: Vec<&str> = names.collect();
    format!(
        "{}: {} {}",
        line.case,
        line.verdict.verdict,
        names.join(" ")
    )
}

/// Part of all, i/n with i from 1.
pub(crate) fn shard(text: &str) -> Result<(usize, usize), String> {
    let parts = text.split_once('/');
    let numbers = parts.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    numbers
        .filter(|&(i, n)| (1..=n).contains(&i))
        .ok_or_else(|| "must be i/n with 1 ≤ i ≤ n, as 2/4".to_owned())
}
