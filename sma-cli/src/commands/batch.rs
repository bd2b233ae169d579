//! `sma batch`: one command on every rig of a fleet.

use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::thread::available_parallelism;

use anyhow::bail;
use blind_trial::in_order;
use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use crate::commands::batch_unit::end_with_stdin;
use crate::commands::trial::shard;
use crate::memory::Memory;
use crate::outcome::{Outcome, with_sources};
use crate::provenance::quoted;
use crate::resume::on_interrupt;
use crate::sink::{Delivery, Outputs, Sink, deliver};
use crate::terminal::{bar, say, write_stdout};
use crate::unit_run::{Ended, UnitRun};
use crate::workplace::Workplace;
use workbench::fleet::{Failure, Fleet, FleetError, Listed, Task, Units};
use workbench::report::fleet::{FleetReport, Row, RowStatus, named};
use workbench::{hashed, page};

/// Diagnose or identify every rig of a fleet: what is done is kept, and a failure is a row.
///
/// A fleet is a folder, or a manifest. In a folder with train*.csv these are the training recordings of one rig, and
/// validate*.csv, held*.csv and unseen*.csv its unseen ones; in any other folder each *.csv is a rig of its own. The rod file
/// is rod.toml in the same folder, or else in the nearest one above. A manifest has a row a rig: name,rod,train,validate as
/// CSV, or [[rig]] tables of these as TOML; several recordings are divided by semicolons.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  \
    sma batch rigs --out night --csv night/table.csv --report night/fleet.html\n\n\
    The same call goes on where it was stopped. To spread it over machines, and put it together:\n  \
    sma batch rigs --out a --shard 1/2\n  \
    sma batch rigs --out b --shard 2/2\n  \
    sma batch rigs --out whole --merge a b --csv whole/table.csv\n\n\
    A result is a file units/HASH.json in the folder of --out, named by the SHA-256 of program, inputs and flags. The table\n\
    is made of these files, so it has the same bytes however they came there.\n\n\
    Exit codes: 0 every rig has a result or a failure of its own, 1 some have neither: the same call goes on, 2 usage, 3 the fleet\n\
    cannot be read, 130 interrupted")]
pub(crate) struct BatchArgs {
    /// Folder of rigs, or manifest (.csv, .toml).
    fleet: PathBuf,
    /// Folder for results; it is made if it is not there.
    #[arg(long, value_name = "DIR", required_unless_present = "list")]
    out: Option<PathBuf>,
    /// Command that is run on each rig.
    #[arg(long = "do", value_enum, default_value_t = Do::Diagnose)]
    command: Do,
    /// Say which rigs and files would be taken, and stop; as JSON with --json, which names their units and what --out has of them.
    #[arg(long)]
    list: bool,
    /// Rigs under way at a time, each on one thread; 0 takes as many as there are processors. No result depends on it.
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=1024))]
    jobs: u16,
    /// Take every n-th rig, from the i-th: i/n, i from 1.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<(usize, usize)>,
    /// Folders of other calls to take results from; nothing is run.
    #[arg(long, num_args = 1.., value_name = "DIR")]
    merge: Vec<PathBuf>,
    /// Try rigs again that failed.
    #[arg(long, conflicts_with = "merge")]
    retry: bool,
    /// Which reversals the hysteresis of the model remembers.
    #[arg(long, value_enum, default_value_t = Memory::LastReversal)]
    memory: Memory,
    /// Seed: same seed and inputs, same results.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write the table as CSV, a row a rig.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write table and picture of the fleet as one HTML page, to read and to mail.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write the result as JSON to a file, or to stdout instead of the text if it is "-".
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// No progress and no notes.
    #[arg(long, short)]
    quiet: bool,
    /// End once stdin is closed, for programs that may be killed while they wait for this one.
    #[arg(long, hide = true)]
    end_with_stdin: bool,
}

/// Command that is run on each rig.
#[derive(Debug, Clone, Copy, PartialEq, ValueEnum)]
enum Do {
    /// Physics that the baseline model leaves out.
    Diagnose,
    /// The baseline model.
    Identify,
}

impl Do {
    fn name(self) -> &'static str {
        match self {
            Self::Diagnose => "diagnose",
            Self::Identify => "identify",
        }
    }
}

/// Places for results.
#[derive(Debug)]
struct Places {
    csv: Option<Sink>,
    report: Option<Sink>,
    json: Option<Sink>,
}

/// Runs the command.
pub(crate) fn run(args: &BatchArgs) -> anyhow::Result<Outcome> {
    if args.end_with_stdin {
        std::thread::Builder::new().spawn(end_with_stdin)?;
    }
    let out = args.out.as_deref();
    let others: Vec<&Path> = args.merge.iter().map(PathBuf::as_path).collect();
    let without: Vec<&Path> = out.into_iter().chain(others).collect();
    let fleet = Fleet::read(&args.fleet, &without)?;
    let rigs = args.of_shard(&fleet.rigs);
    let Some(out) = out.filter(|_| !args.list) else {
        say(args.quiet, &fleet.left_out)?;
        match &args.json {
            Some(path) => {
                let place = Outputs::beside(&[]).open(path)?;
                place.write(&(args.listed_json(&fleet, &rigs)?.to_string() + "\n"))?;
            }
            None => write_stdout(&listed(&rigs))?,
        }
        return Ok(Outcome::Done);
    };
    let merged = args.merge.iter().map(|folder| Units::of(folder));
    let merged = merged.collect::<Result<Vec<_>, _>>()?;
    let units = Units::make(out)?;
    let inputs: Vec<&Path> = rigs
        .iter()
        .filter_map(|rig| rig.files.as_ref().ok())
        .flat_map(|files| files.all())
        .collect();
    let places = args.places(out, &inputs)?;
    say(args.quiet, &taken(&rigs))?;
    say(args.quiet, &fleet.left_out)?;
    let ended = args.work(out, &units, &merged, &rigs)?;
    let rows = rigs.iter().zip(ended);
    let report = FleetReport {
        command: args.command.name(),
        seed: args.seed,
        rows: rows.map(|(rig, ended)| row(rig, ended, &units)).collect(),
        left_out: &fleet.left_out,
    };
    let mut delivery = Delivery::default();
    if let Some(sink) = places.csv {
        delivery.of(|| sink.write(&report.csv()));
    }
    if let Some(sink) = places.report {
        let seed = args.seed.to_string();
        delivery.of(|| sink.write(&page::fleet(&report).made(&args.call(), &seed, &[])));
    }
    delivery.of(|| deliver(&report.text(), &report.json(), places.json));
    delivery.end()?;
    let n_open = report.of(RowStatus::Open).count();
    if n_open > 0 {
        let again = if args.merge.is_empty() {
            "the same call goes on"
        } else {
            "a call without --merge runs them"
        };
        bail!(
            "{n_open} of {} rigs have no result yet; {again}",
            rigs.len()
        );
    }
    Ok(Outcome::Done)
}

impl BatchArgs {
    fn of_shard<'a>(&self, rigs: &'a [Listed]) -> Vec<&'a Listed> {
        let (i, n) = self.shard.unwrap_or((1, 1));
        rigs.iter().skip(i - 1).step_by(n).collect()
    }

    /// Opens the places for results. A table among the recordings of a folder would be a rig of the next call.
    fn places(&self, out: &Path, inputs: &[&Path]) -> anyhow::Result<Places> {
        let whole = |path: &Path| path.canonicalize().ok();
        let folder = self.csv.as_deref().map(|csv| match csv.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        });
        if let (Some(path), Some(folder), Some(fleet), Some(out)) = (
            &self.csv,
            folder.and_then(whole),
            whole(&self.fleet),
            whole(out),
        ) && folder.starts_with(&fleet)
            && (out == fleet || !folder.starts_with(out))
        {
            let path = path.clone();
            return Err(FleetError::AmongRecordings { path }.into());
        }
        let mut outputs = Outputs::beside(inputs);
        Ok(Places {
            csv: outputs.open_if(self.csv.as_deref())?,
            report: outputs.open_if(self.report.as_deref())?,
            json: outputs.open_if(self.json.as_deref())?,
        })
    }

    /// Runs the rigs that have no result yet; how each ended, in their order.
    fn work(
        &self,
        out: &Path,
        units: &Units,
        merged: &[Units],
        rigs: &[&Listed],
    ) -> anyhow::Result<Vec<Ended>> {
        let place = Workplace::make(out)?;
        let said = format!(
            "what has ended is in {}; the same call goes on",
            out.join("units").display()
        );
        let leaving = place.leaving();
        on_interrupt(move || {
            leaving.leave();
            said.clone()
        })?;
        let program_sha256 = program_sha256()?;
        for others in merged {
            say(
                self.quiet,
                &units.take(others, place.path(), &program_sha256)?,
            )?;
        }
        let run = self.unit_run(units, place.path(), &program_sha256)?;
        let jobs = match self.jobs {
            0 => available_parallelism().map_or(1, std::num::NonZero::get),
            jobs => usize::from(jobs),
        };
        let bar = bar(
            self.quiet,
            rigs.len() as u64,
            "batch {bar:20} {pos}/{len}, {eta} left  {msg}",
        );
        let numbered: Vec<(usize, &Listed)> = rigs.iter().copied().enumerate().collect();
        let (mut ended, mut broken) = (Vec::new(), None);
        in_order(
            &numbered,
            jobs,
            |(number, rig)| run.run(*number, rig),
            |(one, notes)| {
                let rig = &rigs[ended.len()].name;
                bar.inc(1);
                bar.set_message(rig.clone());
                let notes: Vec<String> = notes.iter().map(|note| named(rig, note)).collect();
                ended.push(one);
                match bar.suspend(|| say(self.quiet, &notes)) {
                    Ok(()) => ControlFlow::Continue(()),
                    Err(error) => {
                        broken = Some(error);
                        ControlFlow::Break(())
                    }
                }
            },
        );
        bar.finish_and_clear();
        match broken {
            Some(error) => Err(error.into()),
            None => Ok(ended),
        }
    }

    /// How units are run.
    fn unit_run<'a>(
        &self,
        units: &'a Units,
        place: &'a Path,
        program_sha256: &'a str,
    ) -> anyhow::Result<UnitRun<'a>> {
        let seed = self.seed.to_string();
        let flags = ["--memory", self.memory.name(), "--seed", &seed];
        Ok(UnitRun {
            program: std::env::current_exe()?,
            program_sha256,
            command: self.command.name(),
            flags: flags.map(str::to_owned).to_vec(),
            units,
            place,
            is_retried: self.retry,
            is_run: self.merge.is_empty(),
        })
    }

    /// The rigs, their files and their units, for programs that run them elsewhere.
    fn listed_json(&self, fleet: &Fleet, rigs: &[&Listed]) -> anyhow::Result<Value> {
        let kept = self.out.as_deref().and_then(|out| Units::of(out).ok());
        let program_sha256 = program_sha256()?;
        let nowhere = Units::at(Path::new(""));
        let run = self.unit_run(&nowhere, Path::new(""), &program_sha256)?;
        let listed = rigs.iter().map(|rig| {
            let task = match &rig.files {
                Ok(files) => run.task(files).map_err(|error| with_sources(&error)),
                Err(why) => Err(why.clone()),
            };
            let unit = task.as_ref().ok().map(Task::name);
            let read = unit
                .as_ref()
                .and_then(|unit| kept.as_ref()?.read(unit).ok()?);
            let files = rig.files.as_ref().ok();
            json!({
                "rig": rig.name,
                "unit": unit,
                "kept": read.map(|unit| unit.status),
                "failure": task.err(),
                "rod": files.map(|files| &files.rod),
                "train": files.map_or(&[][..], |files| &files.train),
                "validate": files.map_or(&[][..], |files| &files.validate),
            })
        });
        Ok(json!({
            "schema_version": 1,
            "command": "batch",
            "version": env!("CARGO_PKG_VERSION"),
            "seed": self.seed,
            "do": self.command.name(),
            "program": program_sha256,
            "rigs": listed.collect::<Vec<_>>(),
            "left_out": fleet.left_out,
        }))
    }

    /// The call but for what no result depends on.
    fn call(&self) -> String {
        let mut call = format!("sma batch {}", quoted(&self.fleet.to_string_lossy()));
        let _ = write!(
            call,
            " --do {} --memory {} --seed {}",
            self.command.name(),
            self.memory.name(),
            self.seed
        );
        call
    }
}

/// SHA-256 of this program's file.
fn program_sha256() -> anyhow::Result<String> {
    let own = hashed(&[&std::env::current_exe()?])?;
    Ok(own.into_iter().map(|one| one.sha256).collect())
}

/// The rigs and their files, a line each.
fn listed(rigs: &[&Listed]) -> String {
    let all = |paths: &[PathBuf]| {
        let paths: Vec<String> = paths
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        if paths.is_empty() {
            "none".to_owned()
        } else {
            paths.join(" ")
        }
    };
    let lines = rigs.iter().map(|rig| match &rig.files {
        Ok(files) => format!(
            "{}: rod {}, training {}, unseen {}\n",
            rig.name,
            files.rod.display(),
            all(&files.train),
            all(&files.validate)
        ),
        Err(why) => format!("{}: {why}\n", rig.name),
    });
    lines.collect()
}

/// How many files are taken.
fn taken(rigs: &[&Listed]) -> [String; 1] {
    let files = rigs.iter().filter_map(|rig| rig.files.as_ref().ok());
    let (n_train, n_unseen) = files.fold((0, 0), |(train, unseen), files| {
        (train + files.train.len(), unseen + files.validate.len())
    });
    [format!(
        "{} rigs with {n_train} training and {n_unseen} unseen recordings; --list says which",
        rigs.len()
    )]
}

/// The row of a rig, from the file of its unit.
fn row(rig: &Listed, ended: Ended, units: &Units) -> Row {
    match ended {
        Ended::Refused(failure) => Row::without(&rig.name, None, RowStatus::Failed, failure),
        Ended::Open { unit, failure } => Row::without(&rig.name, unit, RowStatus::Open, failure),
        Ended::Kept { unit } => match units.read(&unit) {
            Ok(Some(kept)) => Row::of(&rig.name, &unit, &kept),
            // Somebody has removed it since.
            Ok(None) | Err(_) => {
                let failure = Failure::said("its result is no longer there", std::iter::empty());
                Row::without(&rig.name, Some(unit), RowStatus::Open, failure)
            }
        },
    }
}
