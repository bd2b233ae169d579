//! Runs a study, or the rest of it, and prints what its cases come to.
//!
//! `study <study> [--cases a..b] [--out FILE]`; see the README.

use std::error::Error;
use std::fs;
use std::io::{self, ErrorKind, Write};
use std::num::NonZero;
use std::ops::{ControlFlow, Range};
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread::available_parallelism;

use blind_trial::{Journal, TrialError, in_order};
use studies::{CaseId, CaseLine, Study, StudyError, run_case, summary};

/// Where results go unless told otherwise, from the workspace's root.
const RESULTS: &str = "dev/studies/results";

/// Exit code of a command line that is none.
const USAGE: u8 = 2;

/// What is to be run.
struct Job {
    study: Study,
    cases: Range<u64>,
    out: PathBuf,
}

fn main() -> ExitCode {
    let job = match job(std::env::args().skip(1)) {
        Ok(job) => job,
        Err(text) => {
            say(&format!(
                "{text}\nusage: study <study> [--cases a..b] [--out FILE]"
            ));
            return ExitCode::from(USAGE);
        }
    };
    match run(&job) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(n_failed) => {
            say(&format!(
                "{n_failed} cases failed; another run tries them again"
            ));
            ExitCode::FAILURE
        }
        Err(error) => {
            say(&with_sources(&error));
            ExitCode::FAILURE
        }
    }
}

fn job(mut args: impl Iterator<Item = String>) -> Result<Job, String> {
    let id = args.next().unwrap_or_default();
    let study = Study::parse(&id).map_err(|error| error.to_string())?;
    let mut job = Job {
        study,
        cases: 0..study.n_cases(),
        out: [RESULTS, &format!("{}.jsonl", study.id())].iter().collect(),
    };
    while let Some(flag) = args.next() {
        let value = args.next().ok_or(format!("{flag}: a value is missing"))?;
        match flag.as_str() {
            "--cases" => job.cases = cases(&value)?,
            "--out" => job.out = value.into(),
            _ => return Err(format!("{flag}: no such flag")),
        }
    }
    Ok(job)
}

fn cases(text: &str) -> Result<Range<u64>, String> {
    let ends = text.split_once("..");
    ends.and_then(|(first, end)| Some(first.parse().ok()?..end.parse().ok()?))
        .ok_or(format!(
            "--cases {text}: must be two whole numbers, as 0..20"
        ))
}

/// Runs what is not in the file yet, prints the summary, and returns how many cases failed.
fn run(job: &Job) -> Result<usize, TrialError> {
    make_folder(&job.out)?;
    let mut journal = Journal::open(&job.out)?;
    let study = job.study;
    let cases = job.cases.clone().map(|case| CaseId { study, case });
    let missing: Vec<CaseId> = cases.filter(|&case| !journal.contains(case)).collect();
    let n_threads = available_parallelism().map_or(1, NonZero::get);
    let (mut n_failed, mut broken) = (0, None);
    in_order(
        &missing,
        n_threads,
        |&case| sound(case),
        |done| {
            let appended = match done {
                Ok(line) => {
                    say(&progress(&line));
                    journal.append(line)
                }
                Err(error) => {
                    n_failed += 1;
                    say(&with_sources(&error));
                    Ok(())
                }
            };
            match appended {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    broken = Some(error);
                    ControlFlow::Break(())
                }
            }
        },
    );
    if let Some(error) = broken {
        return Err(error);
    }
    let journal = journal.sorted()?;
    let lines: Vec<&CaseLine> = journal.lines().filter(|line| line.study == study).collect();
    // A closed pipe is not a fault of the study.
    let _ = io::stdout().write_all(summary(study, &lines).as_bytes());
    Ok(n_failed)
}

/// Makes the folder of the results, and none above it: that would hide that this is not the workspace's root.
fn make_folder(out: &Path) -> Result<(), TrialError> {
    let Some(folder) = out.parent().filter(|folder| folder.starts_with(RESULTS)) else {
        return Ok(());
    };
    match fs::create_dir(folder) {
        Err(source) if source.kind() != ErrorKind::AlreadyExists => {
            let path = folder.to_owned();
            Err(TrialError::File { path, source })
        }
        _ => Ok(()),
    }
}

/// A fault of the program in one case leaves the others alone.
fn sound(case: CaseId) -> Result<CaseLine, StudyError> {
    catch_unwind(|| run_case(case)).unwrap_or(Err(StudyError::Panicked { case }))
}

fn progress(line: &CaseLine) -> String {
    let concealed = line.truth.as_ref().map_or("clean".to_owned(), |truth| {
        format!("{} x {}", truth.effect, truth.multiple)
    });
    let names = line
        .diagnosis
        .findings
        .iter()
        .map(|one| one.effect.as_str());
    format!(
        "{} {}: {concealed}: {} {}",
        line.study.id(),
        line.case,
        line.diagnosis.verdict,
        names.collect::<Vec<_>>().join(" ")
    )
}

fn with_sources(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut source = error.source();
    while let Some(error) = source {
        text += &format!(": {error}");
        source = error.source();
    }
    text
}

/// Notes go to stderr; whoever closes it does not want them.
fn say(text: &str) {
    let _ = writeln!(io::stderr(), "{}", text.trim_end());
}
