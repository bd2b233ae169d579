//! Runs cases of the first published table, one plant and recordings as the guide asks, to compare with what was published:
//! `cargo run --release -p blind-trial --example guided FOLDER [FAMILY…]`. What is in the folder is not run again.

use std::error::Error;
use std::io::{self, Write};
use std::path::PathBuf;

use blind_trial::scores::Scores;
use blind_trial::{Family, Plan, RunConfig, Trial};

/// Seed of the first published table.
const SEED: &str = "78df37d2691ed14051715e501e38ee6bccfd9fc6";

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder: PathBuf = arguments.next().ok_or("which FOLDER?")?.into();
    let families = arguments
        .map(|id| Family::parse(&id))
        .collect::<Result<Vec<_>, _>>()?;
    let mut trial = Trial::open(&folder, SEED, None)?;
    let config = RunConfig {
        jobs: std::thread::available_parallelism()?.get(),
        keep_files: false,
        asks_others: false,
    };
    let n_failed = trial.run(&Plan::guided(&families), config, &mut |_| ())?;
    let times_s = trial.times_alone_s()?;
    let mut text = format!("{n_failed} cases failed\n");
    for score in Scores::of(&trial.finished()?, &times_s).table {
        text += &format!("{}: {}\n", score.quantity, score.figure);
    }
    // A closed pipe is not a fault of the trial.
    let _ = io::stdout().write_all(text.as_bytes());
    Ok(())
}
