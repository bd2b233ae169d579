//! `sma inspect`: what is in a recording, before anybody fits anything to it.

use std::path::{Path, PathBuf};

use clap::Args;
use recording::{
    Adaptation, Inspection, Meaning, ReadOptions, Recording, RecordingError, inspect,
    inspect_as_recorded, mended, read_csv, repeat_floor, survey,
};
use rig_files::rod_file;
use serde_json::json;

use crate::commands::used::UseArgs;
use crate::outcome::Outcome;
use crate::terminal::write_stdout;
use workbench::report::{inspected, repeated};
use workbench::{as_fitted, first_rod, in_its_window};

/// Say what is in recordings: sampling, gaps, units, converter steps, noise, cycles, and what stands in
/// the way of identification.
#[derive(Debug, Args)]
#[command(before_help = "Example:\n  sma inspect run1.csv run2.csv --rod rod.toml")]
pub(crate) struct InspectArgs {
    /// Recordings, CSV.
    #[arg(required = true, value_name = "CSV")]
    recordings: Vec<PathBuf>,
    /// Rod file: known properties of the rig, names of the columns, kind of drive.
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
        Some(path) => rod_file::read(path)?,
        None => rod_file::parse("(no rod file)", "")?,
    };
    args.used.apply(&mut rod, &args.recordings)?;
    let parts = args
        .recordings
        .iter()
        .map(|path| {
            let (recording, guess) = match (read(path, &rod.read_options()), &args.rod) {
                (Err(fault), None) if is_of_columns(&fault) => guessed(path, fault)?,
                (read, _) => (read?, None),
            };
            let wish = rod.use_of(path);
            // Fewer rows, or another output, are those of what is mended.
            let used = match wish.decimate.is_some() || wish.detrend {
                true => as_fitted(&rod, path, recording)?,
                false => in_its_window(&rod, path, recording)?,
            };
            let inspected = |used: Recording| {
                let (mut inspection, used) = match rod.columns.may_mend() {
                    true => (inspect(&used), mended(&used)),
                    false => (inspect_as_recorded(&used), used),
                };
                inspection.adaptations.extend(guess.clone());
                (inspection, used)
            };
            Ok(used.into_iter().map(inspected).collect())
        })
        .collect::<anyhow::Result<Vec<Vec<(Inspection, Recording)>>>>()?;
    let inspected = parts.into_iter().flatten();
    let (inspections, used): (Vec<Inspection>, Vec<Recording>) = inspected.unzip();
    let floor = repeat_floor(&used);
    let text = if args.json {
        let document = json!({
            "schema_version": 1,
            "command": "inspect",
            "version": env!("CARGO_PKG_VERSION"),
            "seed": null,
            "recordings": inspections.iter().map(inspected::json).collect::<Vec<_>>(),
            "repeats": floor.as_ref().map(repeated::json),
        });
        serde_json::to_string_pretty(&document)? + "\n"
    } else {
        inspections
            .iter()
            .map(inspected::text)
            .chain(floor.as_ref().map(repeated::text))
            .collect::<Vec<_>>()
            .join("\n")
    };
    write_stdout(&text)?;
    Ok(Outcome::Done)
}

/// Reads a recording; what has no time is static data.
fn read(path: &Path, timed: &ReadOptions) -> Result<Recording, RecordingError> {
    match read_csv(path, timed) {
        Err(
            RecordingError::MissingColumn { role: "time", .. }
            | RecordingError::NoHeader { role: "time", .. },
        ) => {
            let untimed = ReadOptions {
                allow_untimed: true,
                ..timed.clone()
            };
            read_csv(path, &untimed)
        }
        read => read,
    }
}

/// True if a rod file could resolve the fault, since it names columns and units.
fn is_of_columns(fault: &RecordingError) -> bool {
    matches!(
        fault,
        RecordingError::MissingColumn { .. }
            | RecordingError::NoHeader { .. }
            | RecordingError::MissingUnit { .. }
            | RecordingError::MissingFullScale { .. }
    )
}

/// The recording whose columns are taken for what `sma init` takes them for, and what that is; the first fault, if they are not
/// enough, either.
fn guessed(path: &Path, fault: RecordingError) -> anyhow::Result<(Recording, Option<Adaptation>)> {
    let survey = survey(path)?;
    let rod = rod_file::parse("(a guess)", &first_rod(&survey).text)?;
    let Ok(recording) = read(path, &rod.read_options()) else {
        return Err(fault.into());
    };
    let drive = survey.drive().map(|(column, _)| column);
    let taken = [
        ("time", survey.column(Meaning::Time)),
        (rod.drive_kind.name(), drive),
        ("output", survey.column(Meaning::Output)),
        ("temperature", survey.column(Meaning::Temperature)),
        ("ambient", survey.column(Meaning::Ambient)),
        ("stress", survey.column(Meaning::Stress)),
        ("resistance", survey.column(Meaning::Resistance)),
    ];
    let taken = taken.into_iter().filter_map(|(role, column)| {
        let column = column?;
        Some(match &column.name {
            Some(name) => format!("\"{name}\" is the {role}"),
            None => format!("column {} is the {role}", column.number),
        })
    });
    let what = format!(
        "{}: a guess, which sma init writes into a rod file",
        taken.collect::<Vec<_>>().join(", ")
    );
    let guess = Adaptation {
        what,
        n_lines: 0,
        first_line: 0,
    };
    Ok((recording, Some(guess)))
}
