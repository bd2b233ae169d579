//! Puts effects on the recordings of a measured wire: `cargo run --release -p blind-trial --example injected OUT` diagnoses them,
//! and says which effects are found beyond what is found without; with `--reference` behind it asks what has changed in some runs
//! since the others, as they are. See the README.

mod alone;
mod since_reference;

use std::error::Error;
use std::io::{self, Write};
use std::path::PathBuf;

use blind_trial::injected::stroke;
use fixtures::bologna;
use identify::Rod;
use recording::{Recording, read_csv};
use rig_files::rod_file;

/// Where results of the diagnoses stand, from the workspace's root.
const RESULTS: &str = "blind-trial/results/injected.jsonl";

/// The wire.
struct Wire {
    rod: Rod,
    recorded: Vec<Recording>,
    /// Lowest reading and range of all recordings, mm.
    stroke: [f64; 2],
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let Some(out) = arguments.next().map(PathBuf::from) else {
        let usage = format!(
            "injected OUT [--reference]: where to write, {RESULTS} for one; it takes half an hour"
        );
        writeln!(io::stdout(), "{usage}")?;
        return Ok(());
    };
    let Some(folder) = fixtures::shared::path(bologna::FOLDER) else {
        return Ok(());
    };
    let rod = rod_file::parse("rod.toml", bologna::ROD)?;
    let read = |name: &str| read_csv(folder.join(name), &rod.read_options());
    let names = bologna::TRAINING.into_iter().chain([bologna::UNSEEN]);
    let recorded = names.map(read).collect::<Result<Vec<_>, _>>()?;
    let wire = Wire {
        stroke: stroke(&recorded),
        rod,
        recorded,
    };
    let said = match arguments.next().as_deref() {
        Some("--reference") => since_reference::study(&wire, &out)?,
        _ => alone::study(&wire, &out)?,
    };
    // A closed pipe is not a fault of the study.
    let _ = io::stdout().write_all(said.as_bytes());
    Ok(())
}
