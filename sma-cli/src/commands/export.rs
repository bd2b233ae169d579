//! `sma export`: a model that leaves the program.

use std::io::Read;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use identify::{RigModel, SavedModel};
use missing_physics::{RestoredModel, known_effects};
use pid_tune::{
    AntiWindup, DerivativeOf, GainSchedule, GainScheduleParams, PidGains, PidParams,
    SCHEDULE_LEVELS, TuneError,
};
use recording::{Quantity, open_regular, read_text};
use rig_files::model_file;
use serde::Deserialize;
use sma_effects::{EffectId, Member};
use sma_export::{
    CNumbers, CPrefix, Controller, ExportError, Exported, FMU_LIBRARY, Fmi, Labels, c_header, fmu,
    python_module,
};
use workbench::{Rig, controller, sha256_of};

use crate::commands::tune::TRACKING_SAMPLES;
use crate::outcome::Outcome;
use crate::provenance::call;
use crate::sink::Outputs;
use crate::terminal::say;

/// Most bytes of a model or of a file of gains.
const MOST_BYTES: u64 = 1 << 24;

/// Most bytes of a library.
const MOST_LIBRARY_BYTES: u64 = 1 << 28;

/// Parameters of single recordings that stay behind: how a run differs from the rig.
const OF_RUNS: [&str; 3] = ["ambient_level_k", "run_heat_loss", "run_gain"];

/// Export an identified model to be used without this program: as C99 or Python source, or for FMI 2.0 or 3.0.
///
/// It computes what `sma simulate` and `sma tune` compute. Source holds the plant and its controller; a functional mock-up
/// unit holds the plant, with all effects. A part of a model that has no export is refused by name.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  \
    sma export model.toml --to c --tuned tuned.json --output rod.h\n  \
    sma export model.toml --to python --output rod.py\n  \
    sma export model.toml --to fmu --output rod.fmu\n\n\
    The controller is that of `sma tune --json tuned.json`, or has --gains of your own.")]
pub(crate) struct ExportArgs {
    /// Model, from --save-model of `sma identify` or `sma diagnose`.
    model: PathBuf,
    /// Language that it leaves in.
    #[arg(long, value_enum)]
    to: Language,
    /// Where it goes.
    #[arg(long, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    /// Controller that leaves with it: a file of `sma tune --json`.
    #[arg(long, value_name = "JSON", conflicts_with_all = ["gains", "drive_max"])]
    tuned: Option<PathBuf>,
    /// Controller of these gains, of the structure that `sma tune` has without flags.
    #[arg(long, num_args = 3, value_names = ["KP", "KI", "KD"])]
    gains: Option<Vec<f64>>,
    /// Largest drive of the controller, in its unit [default: limits.drive_max of the model].
    #[arg(
        long,
        value_name = "U",
        requires = "gains",
        allow_negative_numbers = true
    )]
    drive_max: Option<f64>,
    /// Sample time, s [default: that of --tuned, or of the first training recording].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    sample_time_s: Option<f64>,
    /// Numbers of type float instead of double.
    #[arg(long)]
    float: bool,
    /// First word of all names, so that several models stand in one program.
    #[arg(long, value_name = "WORD")]
    prefix: Option<String>,
    /// Library of a functional mock-up unit [default: libsma_fmu.so beside the program].
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
    /// No notes.
    #[arg(long, short)]
    quiet: bool,
}

/// Language that a model leaves in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Language {
    /// A C99 header, without allocation.
    C,
    /// A Python 3 module that imports the standard library alone.
    Python,
    /// A functional mock-up unit: FMI 2.0, co-simulation.
    Fmu,
    /// A functional mock-up unit: FMI 3.0, co-simulation.
    Fmu3,
}

/// Runs the command.
pub(crate) fn run(args: &ExportArgs) -> anyhow::Result<Outcome> {
    args.checked()?;
    let mut inputs = vec![args.model.as_path()];
    inputs.extend(args.tuned.as_deref());
    inputs.extend(args.library.as_deref());
    let sink = Outputs::beside(&inputs).open(&args.output)?;
    // Read once: a file that changes meanwhile is one model all the same.
    let model_toml = text_of(&args.model)?;
    let saved = model_file::parse_with(
        &args.model.display().to_string(),
        &model_toml,
        &known_effects,
    )?;
    let model = RestoredModel::new(&saved)?;
    let exported = exported(args, &saved, &model, sha256_of(model_toml.as_bytes()))?;
    let result = match args.to {
        Language::C => {
            let numbers = if args.float {
                CNumbers::Float
            } else {
                CNumbers::Double
            };
            let prefix = match &args.prefix {
                Some(text) => CPrefix::new(text)?,
                None => CPrefix::default(),
            };
            c_header(&exported, numbers, &prefix)?.into_bytes()
        }
        Language::Python => python_module(&exported)?.into_bytes(),
        Language::Fmu => fmu(&exported, Fmi::V2, &model_toml, &args.library()?)?,
        Language::Fmu3 => fmu(&exported, Fmi::V3, &model_toml, &args.library()?)?,
    };
    say(args.quiet, &notes(&saved, &exported))?;
    sink.write_bytes(&result)?;
    Ok(Outcome::Done)
}

impl ExportArgs {
    /// Refuses flags that the language has no use for.
    fn checked(&self) -> Result<(), ExportError> {
        let has_controller = self.tuned.is_some() || self.gains.is_some();
        let given = [
            ("--float", self.float, &[Language::C][..]),
            ("--prefix", self.prefix.is_some(), &[Language::C]),
            (
                "--library",
                self.library.is_some(),
                &[Language::Fmu, Language::Fmu3],
            ),
            (
                "--tuned and --gains",
                has_controller,
                &[Language::C, Language::Python],
            ),
        ];
        match given
            .into_iter()
            .find(|(_, is_given, of)| *is_given && !of.contains(&self.to))
        {
            None => Ok(()),
            Some((flag, _, of)) => {
                let names: Vec<&str> = of.iter().map(|language| language.name()).collect();
                Err(ExportError::Flag {
                    flag,
                    to: self.to.name(),
                    accepted: names.join(" or "),
                })
            }
        }
    }

    /// Bytes of the library of a unit.
    fn library(&self) -> anyhow::Result<Vec<u8>> {
        let path = match &self.library {
            Some(path) => path.clone(),
            None => std::env::current_exe()?.with_file_name(format!("lib{FMU_LIBRARY}.so")),
        };
        let unreadable = |error: std::io::Error| ExportError::Unreadable {
            file: path.display().to_string(),
            reason: error.to_string(),
            expected: "the library of a functional mock-up unit, made by `cargo build --release -p sma-fmu`; give it with --library",
        };
        let mut bytes = Vec::new();
        open_regular(&path)
            .and_then(|file| file.take(MOST_LIBRARY_BYTES).read_to_end(&mut bytes))
            .map_err(unreadable)?;
        Ok(bytes)
    }
}

impl Language {
    /// Its name in flags.
    fn name(self) -> &'static str {
        match self {
            Self::C => "c",
            Self::Python => "python",
            Self::Fmu => "fmu",
            Self::Fmu3 => "fmu3",
        }
    }
}

/// Text of an input.
fn text_of(path: &Path) -> Result<String, ExportError> {
    read_text(path, MOST_BYTES).map_err(|error| ExportError::Unreadable {
        file: path.display().to_string(),
        reason: error.to_string(),
        expected: "a text file",
    })
}

/// The model with its controller and its labels.
fn exported(
    args: &ExportArgs,
    saved: &SavedModel,
    model: &RestoredModel<'_>,
    sha256: String,
) -> anyhow::Result<Exported> {
    let tuned = match &args.tuned {
        Some(path) => Some(TunedFile::read(path)?),
        None => None,
    };
    let rod = &saved.rod;
    let file = || args.model.display().to_string();
    let member = member(saved, model).map_err(|kind| ExportError::Kind { file: file(), kind })?;
    let recorded = saved.recordings.iter().find_map(|one| one.sample_time_s);
    let of_tuned = tuned.as_ref().map(|tuned| tuned.content.sample_time_s);
    let Some(dt_s) = args.sample_time_s.or(of_tuned).or(recorded) else {
        return Err(ExportError::NoSampleTime { file: file() }.into());
    };
    let is_turned = member.params.gain < 0.0;
    let controller = match (&tuned, args.gains.as_deref()) {
        (Some(tuned), _) => {
            let units = [&saved.output_unit, drive_unit(rod.drive_kind)];
            Some(tuned.controller(dt_s, is_turned, units)?)
        }
        (None, Some(&[kp, ki, kd])) => {
            let rig = Rig::of(saved, model, args.drive_max)?;
            Some(Controller {
                params: controller(&rig, dt_s),
                gains: PidGains { kp, ki, kd },
                is_turned,
            })
        }
        (None, _) => None,
    };
    let first = saved.recordings.first();
    Ok(Exported {
        setting: model.fleet().setting,
        member,
        dt_s,
        drive_limit: rod.supply.limit,
        controller,
        labels: Labels {
            model_file: file(),
            sha256,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: call(),
            drive_unit: drive_unit(rod.drive_kind).to_owned(),
            output_unit: saved.output_unit.clone(),
            ambient_degc: rod.ambient_degc,
            recording: first.map_or_else(|| "the model".to_owned(), |one| one.name.clone()),
            left_out: left_out(saved, model),
        },
    })
}

/// Unit of a drive for people.
fn drive_unit(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Duty => "duty",
        other => other.unit(),
    }
}

/// The rig with the offset and the start of the first training recording; else what the model is.
fn member(saved: &SavedModel, model: &RestoredModel<'_>) -> Result<Member, &'static str> {
    let kind = match &saved.model {
        RigModel::Wiener(_) | RigModel::Sadeghi(_) => "of a kind without a cascade",
        RigModel::Loop(_) => "a static loop, without a time constant",
        RigModel::Thermal(_) => "a heat balance, whose output is the temperature",
        RigModel::Antagonist(_) => "of two rods with two drives",
    };
    model.first_member().ok_or(kind)
}

/// Parts of a model that belong to single recordings.
fn left_out(saved: &SavedModel, model: &RestoredModel<'_>) -> Vec<String> {
    let drifts = model.drifts().map(EffectId::id);
    let mut left_out: Vec<String> = drifts
        .map(|id| format!("{id} of the recordings that were fitted"))
        .collect();
    let deviates = |name: &&str| {
        let of_runs = saved.parameters.iter();
        of_runs
            .filter(|one| one.info.name == *name)
            .any(|one| one.values.iter().any(|value| value.abs() > 0.0))
    };
    let runs = OF_RUNS.into_iter().filter(deviates);
    left_out.extend(runs.map(|name| format!("{name} of single runs")));
    if !saved.model.knows_temperature() {
        left_out.push(
            "the scale of temperature, which the model does not know: temperatures are arbitrary, and so is the effect of ambient_degc"
                .to_owned(),
        );
    }
    left_out
}

/// Notes on what is assumed, and on what stays behind.
fn notes(saved: &SavedModel, exported: &Exported) -> Vec<String> {
    let labels = &exported.labels;
    let mut notes = vec![format!(
        "offset {} {} and start are those of {}; sample time {} s",
        exported.member.params.offset, labels.output_unit, labels.recording, exported.dt_s
    )];
    if !saved.scores.converged {
        notes.push(
            "the model was NOT CONVERGED when it was identified: do not trust this".to_owned(),
        );
    }
    let left_out = labels.left_out.iter();
    notes.extend(left_out.map(|part| format!("left out: {part}")));
    notes
}

/// A file of `sma tune --json`.
struct TunedFile {
    file: String,
    content: Tuned,
}

/// The part of it that a controller is.
#[derive(Debug, Deserialize)]
struct Tuned {
    command: String,
    output_unit: String,
    drive_unit: String,
    sample_time_s: f64,
    drive_max: f64,
    signs_turned: bool,
    controller: TunedStructure,
    controllers: Vec<TunedGains>,
}

#[derive(Debug, Deserialize)]
struct TunedStructure {
    anti_windup: String,
    derivative_of: String,
    derivative_filter_s: f64,
    setpoint_weight: f64,
    feed_forward: bool,
    gain_schedule: Option<TunedSchedule>,
}

/// Levels as the sensor reads them.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TunedSchedule {
    outputs: [f64; 2],
    turn: f64,
    heating: [f64; SCHEDULE_LEVELS],
    cooling: [f64; SCHEDULE_LEVELS],
}

#[derive(Debug, Deserialize)]
struct TunedGains {
    name: String,
    gains: Gains,
}

#[derive(Debug, Deserialize)]
struct Gains {
    kp: f64,
    ki: f64,
    kd: f64,
}

impl TunedSchedule {
    /// The schedule as the controller sees the output.
    fn schedule(&self, is_turned: bool) -> Result<GainSchedule, TuneError> {
        let sign = if is_turned { -1.0 } else { 1.0 };
        GainSchedule::new(GainScheduleParams {
            outputs: self.outputs.map(|output| sign * output),
            turn: self.turn,
            heating: self.heating,
            cooling: self.cooling,
        })
    }
}

impl TunedFile {
    fn read(path: &Path) -> anyhow::Result<Self> {
        let file = path.display().to_string();
        let text = text_of(path)?;
        let content = serde_json::from_str(&text).map_err(|error| ExportError::Tuned {
            file: file.clone(),
            line: error.line(),
            column: error.column(),
            message: message(&error),
        })?;
        Ok(Self { file, content })
    }

    fn refused(
        &self,
        key: &'static str,
        value: impl ToString,
        accepted: impl ToString,
    ) -> ExportError {
        ExportError::TunedValue {
            file: self.file.clone(),
            key,
            value: value.to_string(),
            accepted: accepted.to_string(),
        }
    }

    /// The tuned controller, for a model of this sample time and sign.
    fn controller(
        &self,
        dt_s: f64,
        is_turned: bool,
        [output_unit, drive_unit]: [&str; 2],
    ) -> Result<Controller, ExportError> {
        let Tuned {
            command,
            output_unit: own_output,
            drive_unit: own_drive,
            sample_time_s,
            drive_max,
            signs_turned,
            controller,
            controllers,
        } = &self.content;
        if command != "tune" {
            return Err(self.refused("command", command, "expected tune"));
        }
        let units = [
            ("output_unit", own_output, output_unit),
            ("drive_unit", own_drive, drive_unit),
        ];
        for (key, own, expected) in units {
            if own != expected {
                let accepted =
                    format!("expected {expected}, as of this model: was it tuned on another one?");
                return Err(self.refused(key, own, accepted));
            }
        }
        if sample_time_s.to_bits() != dt_s.to_bits() {
            let accepted = format!(
                "expected {dt_s}, that of --sample-time-s; tune with that sample time, or leave it out here"
            );
            return Err(self.refused("sample_time_s", sample_time_s, accepted));
        }
        if *signs_turned != is_turned {
            let accepted =
                format!("expected {is_turned}, as of this model: was it tuned on another one?");
            return Err(self.refused("signs_turned", signs_turned, accepted));
        }
        if controller.feed_forward {
            let accepted = "the inverse of a model has no export; tune without --feed-forward";
            return Err(self.refused("controller.feed_forward", true, accepted));
        }
        let anti_windup = match controller.anti_windup.as_str() {
            "off" => AntiWindup::Off,
            "clamping" => AntiWindup::Clamping,
            "back-calculation" => AntiWindup::BackCalculation {
                tracking_s: TRACKING_SAMPLES * dt_s,
            },
            other => {
                let accepted = "expected off, clamping or back-calculation";
                return Err(self.refused("controller.anti_windup", other, accepted));
            }
        };
        let derivative_of = match controller.derivative_of.as_str() {
            "measurement" => DerivativeOf::Measurement,
            "error" => DerivativeOf::Error,
            other => {
                let accepted = "expected measurement or error";
                return Err(self.refused("controller.derivative_of", other, accepted));
            }
        };
        let Some(tuned) = controllers.iter().find(|one| one.name == "tuned") else {
            let names: Vec<&str> = controllers.iter().map(|one| one.name.as_str()).collect();
            let accepted = "expected one of the name tuned";
            return Err(self.refused("controllers", names.join(", "), accepted));
        };
        let Gains { kp, ki, kd } = tuned.gains;
        let scheduled = controller.gain_schedule.as_ref();
        let gain_schedule = scheduled.map(|one| one.schedule(is_turned)).transpose();
        let gain_schedule = gain_schedule.map_err(ExportError::Controller)?;
        Ok(Controller {
            params: PidParams {
                dt_s,
                limits: pid_tune::DriveLimits {
                    lower: 0.0,
                    upper: *drive_max,
                },
                anti_windup,
                derivative_of,
                derivative_filter_s: controller.derivative_filter_s,
                setpoint_weight: controller.setpoint_weight,
                gain_schedule,
            },
            gains: PidGains { kp, ki, kd },
            is_turned,
        })
    }
}

/// Message of a reader without the place that it ends with.
fn message(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.rfind(" at line ") {
        Some(place) => text[..place].to_owned(),
        None => text,
    }
}
