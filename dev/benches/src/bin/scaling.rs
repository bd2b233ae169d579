//! How long a fit and a diagnosis take, over the samples of one run and over threads.
//!
//! `cargo run --release -p benches --bin scaling -- docs/performance` prints two Markdown tables and draws the first into that folder. The
//! run is made up, and recorded more or less often.

#![allow(clippy::print_stdout, reason = "the tables are the result")]

use std::env::args;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;
use std::thread::available_parallelism;
use std::time::Instant;

use benches::{MadeUp, made_up};
use identify::{FitConfig, WienerModel, fit};
use missing_physics::{DiagnoseConfig, diagnose, setting_of_rod};
use peak_alloc::PeakAlloc;
use rayon::{ThreadPool, ThreadPoolBuilder};
use sma_effects::EffectId;
use wiener::hysteresis::Rule;
use workbench::figure::{Figure, Gallery, Series, Style};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

type Failure = Box<dyn Error + Send + Sync>;

const COMMAND: &str = "cargo run --release -p benches --bin scaling -- docs/performance";
const N_REPETITIONS: usize = 5;
/// Times between samples of the run, s.
const DT_S: [f64; 4] = [1.0, 0.1, 0.01, 0.001];
/// That of the run that is given to more threads or fewer, s.
const THREADS_DT_S: f64 = 0.1;

/// Median times of one run, and what they took.
struct Row {
    n_samples: usize,
    fit_s: f64,
    diagnosis_s: f64,
    /// Most bytes in use at a time, beside the recordings.
    peak_bytes: usize,
    verdict: &'static str,
}

/// Median of the times of several repetitions, s, and what the last of them gave.
fn timed<T>(work: impl Fn() -> Result<T, Failure>) -> Result<(f64, T), Failure> {
    let mut times_s = Vec::new();
    let mut last = None;
    for _ in 0..N_REPETITIONS {
        let begin = Instant::now();
        last = Some(work()?);
        times_s.push(begin.elapsed().as_secs_f64());
    }
    times_s.sort_by(f64::total_cmp);
    Ok((times_s[N_REPETITIONS / 2], last.ok_or("no repetition")?))
}

fn row(rig: &MadeUp, pool: &ThreadPool) -> Result<Row, Failure> {
    let base = WienerModel::new(&rig.rod, Rule::LastReversal, &rig.training)?;
    let fitting = || {
        fit(&base, &rig.training, &FitConfig::default(), &mut |_| {
            ControlFlow::Continue(())
        })
    };
    let (fit_s, _) = timed(|| Ok(pool.install(fitting)?))?;
    let config = DiagnoseConfig {
        setting: setting_of_rod(&rig.rod, "mm"),
        ..DiagnoseConfig::default()
    };
    let diagnosing = || {
        diagnose(&base, &rig.training, &rig.unseen, &config, &mut |_| {
            ControlFlow::Continue(())
        })
    };
    ALLOCATOR.reset_peak_usage();
    let before = ALLOCATOR.current_usage();
    let (diagnosis_s, diagnosis) = timed(|| Ok(pool.install(diagnosing)?))?;
    Ok(Row {
        n_samples: rig.training[0].len(),
        fit_s,
        diagnosis_s,
        peak_bytes: ALLOCATOR.peak_usage() - before,
        verdict: diagnosis.verdict.id(),
    })
}

fn pool(n_threads: usize) -> Result<ThreadPool, Failure> {
    Ok(ThreadPoolBuilder::new().num_threads(n_threads).build()?)
}

/// Times over samples.
fn figure(rows: &[Row]) -> Figure {
    let points = |time_s: fn(&Row) -> f64| -> Vec<[f64; 2]> {
        let of_row = |row: &Row| [(row.n_samples as f64).log10(), time_s(row)];
        rows.iter().map(of_row).collect()
    };
    Figure {
        name: "time-over-samples",
        caption: "One run of 717 s, recorded more or less often: models are searched on about 1,000 samples and judged on about 4,000."
            .to_owned(),
        across: "samples of the training recording, powers of ten".to_owned(),
        up: "time, s".to_owned(),
        series: vec![
            Series::new("diagnosis", Style::Extended, points(|row| row.diagnosis_s)),
            Series::new("fit of the baseline model", Style::Plain, points(|row| row.fit_s)),
        ],
        log_up: true,
        ..Figure::default()
    }
}

fn main() -> Result<(), Failure> {
    let folder = args()
        .nth(1)
        .ok_or("the folder for the figure is missing")?;
    let gallery = Gallery::at(Path::new(&folder), &[])?;
    let n_threads = available_parallelism()?.get();
    let all = pool(n_threads)?;
    let rows = DT_S.map(|dt_s| row(&made_up(EffectId::LatentHeat, dt_s), &all));
    let rows: Vec<Row> = rows.into_iter().collect::<Result<_, Failure>>()?;
    let reference = &rows[1];
    println!(
        "| samples, {n_threads} threads | fit, s | diagnosis, s | over that of {} | bytes a sample | verdict |\n\
         | --- | --- | --- | --- | --- | --- |",
        reference.n_samples
    );
    for row in &rows {
        println!(
            "| {} | {:.2} | {:.2} | {:.2} | {:.0} | {} |",
            row.n_samples,
            row.fit_s,
            row.diagnosis_s,
            row.diagnosis_s / reference.diagnosis_s,
            row.peak_bytes as f64 / row.n_samples as f64,
            row.verdict,
        );
    }
    let rig = made_up(EffectId::LatentHeat, THREADS_DT_S);
    println!(
        "\n| threads, {} samples | fit, s | diagnosis, s | as fast as one |\n| --- | --- | --- | --- |",
        rig.training[0].len()
    );
    let mut one_s = f64::NAN;
    for n_threads in 1..=n_threads {
        let row = row(&rig, &pool(n_threads)?)?;
        if n_threads == 1 {
            one_s = row.diagnosis_s;
        }
        println!(
            "| {n_threads} | {:.2} | {:.2} | {:.2} |",
            row.fit_s,
            row.diagnosis_s,
            one_s / row.diagnosis_s
        );
    }
    println!("\nCommand: `{COMMAND}`; medians of {N_REPETITIONS}.");
    gallery.hang(&[figure(&rows)])?;
    Ok(())
}
