//! `model.toml`: how a saved model is written.

use std::collections::BTreeMap;
use std::path::Path;

use recording::Columns;
use serde::{Deserialize, Serialize};
use toml::Spanned;
use wiener::hysteresis::{LoopFamily, REVERSAL_DEAD_BAND_K, Rule};

use identify::{
    Enters, FittedParameter, KnownEffects, ModelKind, ModelTemplate, NamedEffect,
    ParameterCovariance, ParameterState, Provenance, RigModel, Role, SavedEffects, SavedModel,
    SavedRecording, Scope, Scores, parameters_of_family,
};

use crate::RigFileError;
use crate::model_entries::Reading;
use crate::recording_table::RecordingTable;
use crate::rod_file::{
    self, DriveTable, LimitsTable, LoadTable, RodFile, RodTable, Surroundings,
    is_what_its_text_says, tables,
};
use crate::source::{Source, read_file};

/// Version of the file's layout.
pub(crate) const SCHEMA_VERSION: i64 = 1;

/// The first lines of a file.
const HEAD: &str = "\
# A model identified by `sma identify`; `sma simulate` and `sma identify --from-model` read it.
# The tables before the parameters are those of the rod file.

";

/// The first lines of a file of a model with effects.
const HEAD_WITH_EFFECTS: &str = "\
# A model with effects found by `sma diagnose`; `sma simulate` and `sma tune` read it.
# The tables before the parameters are those of the rod file.

";

/// Keys before the tables of the rod file.
#[derive(Serialize)]
struct Head<'a> {
    schema_version: i64,
    model: ModelKind,
    memory: Memory,
    temperature_scale: TemperatureScale,
    output_unit: &'a str,
    drive_unit: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    loop_family: Option<&'a str>,
    effects: &'a [String],
}

/// Tables after those of the rod file.
#[derive(Serialize)]
struct Tail<'a> {
    parameter: Vec<ParameterTable>,
    covariance: &'a ParameterCovariance,
    integration: IntegrationTable,
    fit: Scores,
    recording: &'a [SavedRecording],
    provenance: &'a Provenance,
}

/// The whole, as it is read.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelFile {
    schema_version: Spanned<i64>,
    model: ModelKind,
    memory: Memory,
    temperature_scale: TemperatureScale,
    output_unit: String,
    drive_unit: String,
    /// The paper's where nothing is said.
    loop_family: Option<Spanned<String>>,
    #[serde(default)]
    effects: Vec<Spanned<String>>,
    #[serde(default)]
    rod: RodTable,
    #[serde(default)]
    surroundings: Surroundings,
    #[serde(default)]
    drive: DriveTable,
    load: Option<LoadTable>,
    #[serde(default)]
    limits: LimitsTable,
    #[serde(default)]
    columns: Columns,
    #[serde(default)]
    recordings: BTreeMap<String, RecordingTable>,
    parameter: Vec<Spanned<ParameterTable>>,
    covariance: Spanned<ParameterCovariance>,
    integration: Spanned<IntegrationTable>,
    fit: Scores,
    recording: Vec<SavedRecording>,
    provenance: Provenance,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Memory {
    LastReversal,
    Nested,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum TemperatureScale {
    Known,
    Assumed,
}

/// One value of one parameter.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParameterTable {
    pub(crate) name: String,
    /// Whose it is, for what each training recording has its own of.
    pub(crate) recording: Option<String>,
    pub(crate) value: f64,
    pub(crate) unit: String,
    pub(crate) ci95: Option<[f64; 2]>,
    pub(crate) state: State,
    /// Where it was searched; none for what is solved for.
    pub(crate) bounds: Option<[f64; 2]>,
    #[serde(default)]
    pub(crate) at_bound: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum State {
    Free,
    Fixed,
}

/// How the equations were solved.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct IntegrationTable {
    /// How the heat balance is solved, for the reader.
    pub(crate) method: String,
    pub(crate) substeps: usize,
    /// Of a model with effects.
    pub(crate) newton_iterations: Option<usize>,
    pub(crate) reversal_dead_band_k: f64,
}

impl IntegrationTable {
    fn of(effects: Option<&SavedEffects>) -> Self {
        let method = match effects {
            None => "exact over a sample",
            Some(_) => "exact over a sample, the heat of effects by Newton's method",
        };
        Self {
            method: method.to_owned(),
            substeps: effects.map_or(1, |effects| effects.sub_steps),
            newton_iterations: effects.map(|effects| effects.newton_iterations),
            reversal_dead_band_k: REVERSAL_DEAD_BAND_K,
        }
    }
}

impl From<Memory> for Rule {
    fn from(memory: Memory) -> Self {
        match memory {
            Memory::LastReversal => Self::LastReversal,
            Memory::Nested => Self::Nested,
        }
    }
}

/// Reads the file of a baseline model.
///
/// # Errors
///
/// [`RigFileError::Unreadable`], and as [`parse`].
pub fn read(path: &Path) -> Result<SavedModel, RigFileError> {
    let (file, text) = read_file(path)?;
    parse(&file, &text)
}

/// Reads a model file that may have effects; see [`parse_with`].
///
/// # Errors
///
/// [`RigFileError::Unreadable`], and as [`parse_with`].
pub fn read_with(path: &Path, known: KnownEffects<'_>) -> Result<SavedModel, RigFileError> {
    let (file, text) = read_file(path)?;
    parse_with(&file, &text, known)
}

/// Reads the text of the file of a baseline model; `file` is its name for errors.
///
/// # Errors
///
/// As [`parse_with`]; any effect is refused.
pub fn parse(file: &str, text: &str) -> Result<SavedModel, RigFileError> {
    parse_with(file, text, &|_| {
        Err("must be empty: only baseline models are read here".to_owned())
    })
}

/// Reads the text of a model file; `known` says which parameters an effect has, or what would be accepted in
/// its place.
///
/// # Errors
///
/// [`RigFileError::NoModel`] and [`RigFileError::Toml`] for what is not such a file, [`RigFileError::Value`] and [`RigFileError::Saved`] for
/// what cannot be, each with line and column; [`RigFileError::Untrained`]; [`RigFileError::Model`] for a rig that its kind of model cannot be of.
pub fn parse_with(
    file: &str,
    text: &str,
    known: KnownEffects<'_>,
) -> Result<SavedModel, RigFileError> {
    let source = Source { file, text };
    if !text.contains("schema_version") {
        return Err(RigFileError::NoModel {
            file: file.to_owned(),
        });
    }
    let parsed: ModelFile = toml::from_str(text).map_err(|error| source.toml(&error, ""))?;
    let reading = Reading { source: &source };
    reading.version(&parsed.schema_version)?;
    let rule = parsed.memory.into();
    let trained: Vec<&str> = parsed
        .recording
        .iter()
        .filter(|one| one.role == Role::Train)
        .map(|one| one.name.as_str())
        .collect();
    if trained.is_empty() {
        return Err(RigFileError::Untrained {
            file: file.to_owned(),
        });
    }
    let rod = RodFile {
        rod: parsed.rod,
        surroundings: parsed.surroundings,
        drive: parsed.drive,
        load: parsed.load,
        limits: parsed.limits,
        columns: parsed.columns,
        recordings: parsed.recordings,
        ..RodFile::default()
    };
    let rod = rod_file::of(&source, rod)?;
    let mut model = RigModel::of_template(&ModelTemplate {
        kind: parsed.model,
        rod: &rod,
        rule,
        rise_is_assumed: parsed.temperature_scale == TemperatureScale::Assumed,
        reference: trained.first().copied(),
        output_unit: &parsed.output_unit,
        drive_unit: &parsed.drive_unit,
    })?;
    let parameters_of = |id: &str| match parsed.model {
        ModelKind::Wiener => known(&NamedEffect {
            id,
            rod: &rod,
            output_unit: &parsed.output_unit,
        }),
        _ => Err("only a model = \"wiener\" may have effects".to_owned()),
    };
    let loop_family = reading.loop_family(parsed.loop_family.as_ref(), &parameters_of)?;
    let mut extra = parameters_of_family(loop_family);
    extra.extend(reading.parameters_of_effects(&parsed.effects, &parameters_of)?);
    let parameters = reading.parameters(
        &parsed.parameter,
        (&trained, &parsed.output_unit),
        &mut model,
        extra,
    )?;
    Ok(SavedModel {
        effects: reading.effects(parsed.effects, loop_family, &parsed.integration)?,
        covariance: reading.covariance(parsed.covariance)?,
        rod,
        model,
        rule,
        output_unit: parsed.output_unit,
        drive_unit: parsed.drive_unit,
        parameters,
        recordings: parsed.recording.clone(),
        scores: parsed.fit,
        provenance: parsed.provenance,
    })
}

/// The text of the model's file. A model read back from it gives the same text again.
///
/// # Errors
///
/// [`RigFileError::Unwritable`] if a value has no form in TOML: an integer beyond its range. [`RigFileError::OtherRod`] if the rod was made or
/// changed without its text, whose tables the file takes over; what is used of recordings may have changed.
///
/// # Panics
///
/// If a parameter that each recording has its own of has more values than there are recordings, or not as many intervals as values.
pub fn to_toml(saved: &SavedModel) -> Result<String, RigFileError> {
    let head = Head {
        schema_version: SCHEMA_VERSION,
        model: saved.model.kind(),
        memory: match saved.rule {
            Rule::LastReversal => Memory::LastReversal,
            Rule::Nested => Memory::Nested,
        },
        temperature_scale: if saved.model.knows_temperature() {
            TemperatureScale::Known
        } else {
            TemperatureScale::Assumed
        },
        output_unit: &saved.output_unit,
        drive_unit: &saved.drive_unit,
        loop_family: saved.effects.as_ref().and_then(|effects| {
            let family = effects.loop_family;
            (family != LoopFamily::Proximity).then(|| family.id())
        }),
        effects: saved.effects.as_ref().map_or(&[], |effects| &effects.ids),
    };
    let names: Vec<&str> = saved
        .recordings
        .iter()
        .map(|one| one.name.as_str())
        .collect();
    let tail = Tail {
        parameter: saved
            .parameters
            .iter()
            .flat_map(|parameter| parameter_tables(parameter, &names))
            .collect(),
        covariance: &saved.covariance,
        integration: IntegrationTable::of(saved.effects.as_ref()),
        fit: saved.scores,
        recording: &saved.recordings,
        provenance: &saved.provenance,
    };
    if !is_what_its_text_says(&saved.rod) {
        return Err(RigFileError::OtherRod {
            file: saved.rod.file.clone(),
        });
    }
    let parts = [
        toml::to_string(&head),
        toml::to_string(&tables(&saved.rod)),
        toml::to_string(&tail),
    ];
    let parts = parts
        .into_iter()
        .collect::<Result<Vec<_>, _>>()
        .map_err(|source| RigFileError::Unwritable {
            file: saved.rod.file.clone(),
            source,
        })?;
    let head = match saved.effects {
        None => HEAD,
        Some(_) => HEAD_WITH_EFFECTS,
    };
    Ok(head.to_owned() + &parts.join("\n"))
}

/// The entries of a parameter: one, or one for each training recording.
fn parameter_tables<'a>(
    parameter: &'a FittedParameter,
    names: &'a [&str],
) -> impl Iterator<Item = ParameterTable> + 'a {
    let info = &parameter.info;
    parameter
        .values
        .iter()
        .enumerate()
        .map(|(r, &value)| ParameterTable {
            name: info.name.to_owned(),
            recording: (info.scope == Scope::PerRecording).then(|| names[r].to_owned()),
            value,
            unit: info.unit.clone(),
            ci95: parameter.intervals[r].map(|one| [one.lower, one.upper]),
            state: match info.state {
                ParameterState::Free => State::Free,
                ParameterState::Fixed(_) => State::Fixed,
            },
            bounds: (info.enters == Enters::Nonlinear)
                .then_some([info.bounds.lower, info.bounds.upper]),
            at_bound: parameter.at_bound,
        })
}
