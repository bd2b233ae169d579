//! `sma simulate`: what an identified model says of a drive.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use identify::{IdentifyError, SavedModel, predict};
use recording::{
    Quantity, Recording, RecordingError, RecordingParts, Sampling, read_csv, read_drive_csv,
    write_csv,
};

use crate::outcome::Outcome;
use crate::report::number::significant;
use crate::sink::Sink;

/// Predict what a rig does under a drive, as CSV that is itself a recording.
///
/// The columns of the profile are those of the model's rod file. A profile that also has the output is
/// compared with the prediction, whose offset is then read as for unseen recordings.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  \
    sma simulate model.toml --drive profile.csv --output predicted.csv")]
pub(crate) struct SimulateArgs {
    /// Identified model, from `sma identify --save-model`.
    model: PathBuf,
    /// What the rig is driven by, CSV.
    #[arg(long, value_name = "CSV")]
    drive: PathBuf,
    /// Where the prediction goes.
    #[arg(long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    /// No notes.
    #[arg(long, short)]
    quiet: bool,
}

/// Runs the command.
pub(crate) fn run(args: &SimulateArgs) -> anyhow::Result<Outcome> {
    let sink = Sink::open(&args.output, &[&args.model, &args.drive])?;
    let saved = SavedModel::read(&args.model)?;
    let options = saved.rod().read_options();
    let (recording, point, note) = match read_csv(&args.drive, &options) {
        Ok(recording) => {
            let validated = saved.validate(&recording)?;
            let note = format!(
                "{} has an output too: the prediction meets it to {} {} RMS",
                recording.name(),
                significant(validated.rmse),
                saved.output_unit(),
            );
            (recording, validated.point, note)
        }
        Err(RecordingError::MissingColumn { role: "output", .. }) => {
            let recording = read_drive_csv(&args.drive, &options)?;
            let first = saved.recordings().first();
            let note = format!(
                "start and offset are those of {}",
                first.map_or("the model", |one| one.name.as_str())
            );
            (recording, saved.point(0), note)
        }
        Err(other) => return Err(IdentifyError::from(other).into()),
    };
    let prediction = predict(saved.model(), &point, &recording)?;
    let predicted = Recording::new(RecordingParts {
        name: format!("prediction for {}", recording.name()),
        time_s: match recording.sampling() {
            Sampling::Untimed => None,
            _ => Some(recording.time_s().to_vec()),
        },
        drive_quantity: recording.drive_quantity(),
        drive: recording.drive().to_vec(),
        drive_unit: match recording.drive_quantity() {
            Quantity::Temperature => recording.drive_unit().to_owned(),
            _ => String::new(),
        },
        output_unit: saved.output_unit().to_owned(),
        output: prediction.output,
        temperature_degc: (recording.drive_quantity() != Quantity::Temperature)
            .then_some(prediction.temperature_degc),
        ambient_degc: recording.ambient_degc().map(<[f64]>::to_vec),
    })?;
    let largest = recording
        .drive()
        .iter()
        .fold(0.0_f64, |a, b| a.max(b.abs()));
    if !args.quiet {
        if !saved.scores().converged {
            let note = "the model was NOT CONVERGED when it was identified: do not trust this";
            writeln!(io::stderr(), "note: {note}")?;
        }
        if largest > 1.02 * saved.largest_drive() {
            writeln!(
                io::stderr(),
                "note: the drive reaches {} {unit}, the model was fitted to at most {} {unit}: beyond, it is a guess",
                significant(largest),
                significant(saved.largest_drive()),
                unit = recording.drive_unit(),
            )?;
        }
        writeln!(io::stderr(), "note: {note}")?;
        if !saved.model().knows_temperature() {
            let note = "temperatures are arbitrary: the model does not know their scale";
            writeln!(io::stderr(), "note: {note}")?;
        }
    }
    let mut csv = Vec::new();
    write_csv(&predicted, &mut csv)?;
    sink.write(&String::from_utf8(csv)?)?;
    Ok(Outcome::Done)
}
