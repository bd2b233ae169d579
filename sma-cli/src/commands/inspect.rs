//! `sma inspect`: what is in a recording, before anybody fits anything to it.

use std::path::PathBuf;

use clap::Args;
use identify::Rod;
use recording::{Inspection, ReadOptions, RecordingError, inspect, inspect_as_recorded, read_csv};
use serde_json::json;

use crate::commands::used::UseArgs;
use crate::outcome::Outcome;
use crate::terminal::write_stdout;
use workbench::report::inspected;
use workbench::{as_fitted, in_its_window};

/// Say what is in recordings: sampling, gaps, units, converter steps, noise, cycles, and what stands in
/// the way of identification.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  sma inspect run1.csv run2.csv --rod rod.toml")]
pub(crate) struct InspectArgs {
    /// Recordings, CSV.
    #[arg(required = true, value_name = "CSV")]
    recordings: Vec<PathBuf>,
    /// What is known of the rig: names the columns and the kind of drive.
    #[arg(long, value_name = "TOML")]
    rod: Option<PathBuf>,
    #[command(flatten)]
    used: UseArgs,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &InspectArgs) -> anyhow::Result<Outcome> {
    let mut rod = match &args.rod {
        Some(path) => Rod::read(path)?,
        None => Rod::parse("(no rod file)", "")?,
    };
    args.used.apply(&mut rod, &args.recordings)?;
    let timed = rod.read_options();
    let untimed = ReadOptions {
        allow_untimed: true,
        ..timed.clone()
    };
    let inspections = args
        .recordings
        .iter()
        .map(|path| {
            let read = match read_csv(path, &timed) {
                // What has no time is static data.
                Err(
                    RecordingError::MissingColumn { role: "time", .. }
                    | RecordingError::NoHeader { role: "time", .. },
                ) => read_csv(path, &untimed),
                read => read,
            };
            let wish = rod.use_of(path);
            // Fewer rows, or another output, are those of what is mended.
            let used = match wish.decimate.is_some() || wish.detrend {
                true => as_fitted(&rod, path, read?)?,
                false => in_its_window(&rod, path, read?)?,
            };
            Ok(match rod.columns.may_mend() {
                true => inspect(&used),
                false => inspect_as_recorded(&used),
            })
        })
        .collect::<anyhow::Result<Vec<Inspection>>>()?;
    let text = if args.json {
        let document = json!({
            "schema_version": 1,
            "command": "inspect",
            "version": env!("CARGO_PKG_VERSION"),
            "seed": null,
            "recordings": inspections.iter().map(inspected::json).collect::<Vec<_>>(),
        });
        serde_json::to_string_pretty(&document)? + "\n"
    } else {
        inspections
            .iter()
            .map(inspected::text)
            .collect::<Vec<_>>()
            .join("\n")
    };
    write_stdout(&text)?;
    Ok(Outcome::Done)
}
