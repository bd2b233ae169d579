//! `sma simulate`: what an identified model says of a drive.

use std::path::{Path, PathBuf};

use clap::Args;
use identify::{IdentifyError, RigModel, Role, SavedModel, SavedRecording, predict};
use missing_physics::{RestoredModel, known_effects};
use recording::{Quantity, Recording, RecordingParts, Sampling, write_csv};
use rig_files::model_file;
use sma_effects::EffectId;

use crate::commands::used::UseArgs;
use crate::outcome::Outcome;
use crate::sink::Outputs;
use crate::terminal::say;
use workbench::report::number::significant;
use workbench::report::plot::left;
use workbench::{BEYOND, as_simulated, hashed, in_columns_of, read_perhaps_without_output};

/// Predict what a rig does under a drive, as CSV that is itself a recording.
///
/// The columns of the profile and of the prediction are those of the model's rod file. A profile that also has the output is
/// compared with the prediction: if the model was fitted to it, with the offset that the fit found, else with the offset of its rest.
#[derive(Debug, Args)]
#[command(before_help = "Example:\n  \
    sma simulate model.toml --drive profile.csv --output predicted.csv")]
pub(crate) struct SimulateArgs {
    /// Model, from --save-model of `sma identify` or `sma diagnose`.
    model: PathBuf,
    /// Drive profile of the rig, CSV.
    #[arg(long, value_name = "CSV")]
    drive: PathBuf,
    #[command(flatten)]
    used: UseArgs,
    /// Where the prediction goes.
    #[arg(long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    /// No notes.
    #[arg(long, short)]
    quiet: bool,
}

/// Runs the command.
pub(crate) fn run(args: &SimulateArgs) -> anyhow::Result<Outcome> {
    let sink = Outputs::beside(&[&args.model, &args.drive]).open(&args.output)?;
    let saved = model_file::read_with(&args.model, &known_effects)?;
    let model = RestoredModel::new(&saved)?;
    let options = saved.rod.read_options();
    let (recording, has_output) =
        read_perhaps_without_output(&args.drive, &options).map_err(IdentifyError::from)?;
    let mut rod = saved.rod.clone();
    let is_known = is_input(&saved, &args.drive)?;
    if !is_known {
        // What is kept of a recording of this name is of another one.
        rod.uses.clear();
    }
    args.used
        .apply(&mut rod, std::slice::from_ref(&args.drive))?;
    let (recording, as_a_whole) =
        as_simulated(&rod, &args.drive, recording).map_err(IdentifyError::from)?;
    let fitted = fitted_to(&saved, &recording).filter(|_| has_output && is_known);
    let (point, met) = if let Some(r) = fitted {
        let point = saved.point(r);
        let left = left(&recording, &predict(&model, &point, &recording)?);
        let squares: f64 = left.iter().map(|value| value * value).sum();
        let met = format!(
            "{} has an output too, and the model was fitted to it: with the offset and state that the fit found in it, the prediction meets \
             it to {} {} RMS",
            recording.name(),
            significant((squares / left.len() as f64).sqrt()),
            &saved.output_unit,
        );
        (point, met)
    } else if has_output {
        let validated = saved.validate_by(&model, &model.point(), &recording)?;
        let met = format!(
            "{} has an output too: the prediction meets it to {} {} RMS",
            recording.name(),
            significant(validated.rmse),
            &saved.output_unit,
        );
        (validated.point, met)
    } else {
        let first = saved.recordings.first();
        let met = format!(
            "start and offset are those of {}",
            first.map_or("the model", |one| one.name.as_str())
        );
        (model.point(), met)
    };
    let prediction = predict(&model, &point, &recording)?;
    let predicted = Recording::new(RecordingParts {
        name: format!("prediction for {}", recording.name()),
        time_s: match recording.sampling() {
            Sampling::Untimed => None,
            _ => Some(recording.time_s().to_vec()),
        },
        drive_quantity: recording.drive_quantity(),
        drive: recording.drive().to_vec(),
        antagonist_drive: recording.antagonist_drive().map(<[f64]>::to_vec),
        drive_unit: match recording.drive_quantity() {
            Quantity::Temperature => recording.drive_unit().to_owned(),
            _ => String::new(),
        },
        output_unit: saved.output_unit.clone(),
        output: prediction.output,
        temperature_degc: (recording.drive_quantity() != Quantity::Temperature)
            .then_some(prediction.temperature_degc),
        ambient_degc: recording.ambient_degc().map(<[f64]>::to_vec),
        ..RecordingParts::default()
    })?;
    let mut notes = notes(&saved, &recording, met);
    notes.extend(as_a_whole);
    notes.extend(effects(&saved, &model));
    say(args.quiet, &notes)?;
    let mut csv = Vec::new();
    write_csv(&predicted, &mut csv)?;
    sink.write(&in_columns_of(&rod, &String::from_utf8(csv)?))?;
    Ok(Outcome::Done)
}

/// Caveats of a prediction; `met` says how it compares, or where it starts.
fn notes(saved: &SavedModel, recording: &Recording, met: String) -> Vec<String> {
    let adaptations = recording.adaptations().iter();
    let mut notes: Vec<String> = adaptations
        .map(|adaptation| format!("{}: {adaptation}", recording.name()))
        .collect();
    if !saved.scores.converged {
        notes.push(
            "the model was NOT CONVERGED when it was identified: do not trust this".to_owned(),
        );
    }
    let (largest, fitted) = (recording.largest_drive(), saved.largest_drive());
    if largest > BEYOND * fitted {
        notes.push(format!(
            "the drive reaches {} {unit}, the model was fitted to at most {} {unit}: beyond, it is a guess",
            significant(largest),
            significant(fitted),
            unit = recording.drive_unit(),
        ));
    }
    if let RigModel::Loop(one) = &saved.model
        && one.knows_one_branch()
    {
        notes.push(
            "the model knows one branch of its loop: where the input turns back it is a guess"
                .to_owned(),
        );
    }
    notes.push(met);
    if !saved.model.knows_temperature() {
        notes.push("temperatures are arbitrary: the model does not know their scale".to_owned());
    }
    notes
}

/// True if a file is, byte for byte, one that the model was made from.
fn is_input(saved: &SavedModel, path: &Path) -> anyhow::Result<bool> {
    let own = hashed(&[path])?;
    let inputs = &saved.provenance.input;
    Ok(own
        .iter()
        .any(|own| inputs.iter().any(|input| input.sha256 == own.sha256)))
}

/// The training recording of this name and length.
fn fitted_to(saved: &SavedModel, recording: &Recording) -> Option<usize> {
    let is_it = |one: &SavedRecording| {
        one.role == Role::Train && one.name == recording.name() && one.n_samples == recording.len()
    };
    saved.recordings.iter().position(is_it)
}

/// Notes on the effects of the model beyond the baseline.
fn effects(saved: &SavedModel, model: &RestoredModel<'_>) -> Vec<String> {
    let Some(effects) = &saved.effects else {
        return Vec::new();
    };
    let mut notes = vec![format!(
        "the baseline model with {} is simulated",
        effects.names().join(", ")
    )];
    let drifts: Vec<&str> = model.drifts().map(EffectId::id).collect();
    if !drifts.is_empty() {
        notes.push(format!(
            "{}: of the recordings that were fitted, left out here",
            drifts.join(", ")
        ));
    }
    notes
}
