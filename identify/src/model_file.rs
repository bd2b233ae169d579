//! `model.toml`: how a saved model is written.

use std::collections::BTreeMap;
use std::path::Path;

use recording::Columns;
use serde::{Deserialize, Serialize};
use toml::Spanned;
use wiener::hysteresis::{LoopFamily, REVERSAL_DEAD_BAND_K, Rule};

use crate::model_entries::Reading;
use crate::recording_use::RecordingTable;
use crate::rod::{DriveTable, LimitsTable, LoadTable, RodFile, RodTable, Surroundings};
use crate::saved_model::{Provenance, Role, SavedModel, SavedRecording, Scores};
use crate::source::{Source, read};
use crate::{
    AntagonistModel, Enters, FittedParameter, IdentifyError, LoopModel, ParameterCovariance,
    ParameterInfo, ParameterState, RigModel, Rod, SadeghiModel, SavedEffects, Scope, ThermalModel,
    WienerModel, parameters_of_family,
};

/// Says which parameters an effect has, or what would be accepted in its place.
pub type KnownEffects<'a> = &'a dyn Fn(&NamedEffect<'_>) -> Result<Vec<ParameterInfo>, String>;

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

/// An effect that a model file names, for those who know what parameters it has.
#[derive(Debug, Clone, Copy)]
pub struct NamedEffect<'a> {
    /// Its id, as written.
    pub id: &'a str,
    /// Rig, as the file describes it.
    pub rod: &'a Rod,
    /// Unit of the output.
    pub output_unit: &'a str,
}

/// Keys before the tables of the rod file.
#[derive(Serialize)]
struct Head<'a> {
    schema_version: i64,
    model: Kind,
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
    model: Kind,
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
enum Kind {
    Wiener,
    Sadeghi,
    StaticLoop,
    Thermal,
    Antagonist,
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

impl SavedModel {
    /// Reads the file of a baseline model.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Unreadable`], and as [`SavedModel::parse`].
    pub fn read(path: &Path) -> Result<Self, IdentifyError> {
        let (file, text) = read(path)?;
        Self::parse(&file, &text)
    }

    /// Reads a model file that may have effects; see [`SavedModel::parse_with`].
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Unreadable`], and as [`SavedModel::parse_with`].
    pub fn read_with(path: &Path, known: KnownEffects<'_>) -> Result<Self, IdentifyError> {
        let (file, text) = read(path)?;
        Self::parse_with(&file, &text, known)
    }

    /// Reads the text of the file of a baseline model; `file` is its name for errors.
    ///
    /// # Errors
    ///
    /// As [`SavedModel::parse_with`]; any effect is refused.
    pub fn parse(file: &str, text: &str) -> Result<Self, IdentifyError> {
        Self::parse_with(file, text, &|_| {
            Err("must be empty: only baseline models are read here".to_owned())
        })
    }

    /// Reads the text of a model file; `known` says which parameters an effect has, or what would be accepted in
    /// its place.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Toml`] for what is not such a file, [`IdentifyError::Value`] and
    /// [`IdentifyError::Saved`] for what cannot be, each with line and column; [`IdentifyError::Untrained`].
    pub fn parse_with(
        file: &str,
        text: &str,
        known: KnownEffects<'_>,
    ) -> Result<Self, IdentifyError> {
        let source = Source { file, text };
        if !text.contains("schema_version") {
            return Err(IdentifyError::NoModel {
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
            return Err(IdentifyError::Untrained {
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
        let rod = Rod::of(&source, rod)?;
        let assumed = parsed.temperature_scale == TemperatureScale::Assumed;
        let mut model = match parsed.model {
            Kind::Wiener => {
                let model = WienerModel::template(&rod, rule, assumed, &|_| Vec::new())?;
                RigModel::Wiener(model.with_reference(trained.first().copied()))
            }
            Kind::Antagonist => {
                let reference = trained.first().copied();
                RigModel::Antagonist(AntagonistModel::template(&rod, rule, assumed, reference)?)
            }
            Kind::Sadeghi => RigModel::Sadeghi(SadeghiModel::template(&rod, rule, &[])?),
            Kind::StaticLoop => RigModel::Loop(LoopModel::template(rule, &parsed.drive_unit)),
            Kind::Thermal => RigModel::Thermal(ThermalModel::template(&rod, &parsed.output_unit)?),
        };
        let parameters_of = |id: &str| match parsed.model {
            Kind::Wiener => known(&NamedEffect {
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
        Ok(Self {
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
    /// [`IdentifyError::Unwritable`] if a value has no form in TOML: an integer beyond its range.
    pub fn to_toml(&self) -> Result<String, IdentifyError> {
        let head = Head {
            schema_version: SCHEMA_VERSION,
            model: match self.model {
                RigModel::Wiener(_) => Kind::Wiener,
                RigModel::Sadeghi(_) => Kind::Sadeghi,
                RigModel::Loop(_) => Kind::StaticLoop,
                RigModel::Thermal(_) => Kind::Thermal,
                RigModel::Antagonist(_) => Kind::Antagonist,
            },
            memory: match self.rule {
                Rule::LastReversal => Memory::LastReversal,
                Rule::Nested => Memory::Nested,
            },
            temperature_scale: if self.model.knows_temperature() {
                TemperatureScale::Known
            } else {
                TemperatureScale::Assumed
            },
            output_unit: &self.output_unit,
            drive_unit: &self.drive_unit,
            loop_family: self.effects.as_ref().and_then(|effects| {
                let family = effects.loop_family;
                (family != LoopFamily::Proximity).then(|| family.id())
            }),
            effects: self.effects.as_ref().map_or(&[], |effects| &effects.ids),
        };
        let names: Vec<&str> = self
            .recordings
            .iter()
            .map(|one| one.name.as_str())
            .collect();
        let tail = Tail {
            parameter: self
                .parameters
                .iter()
                .flat_map(|parameter| parameter_tables(parameter, &names))
                .collect(),
            covariance: &self.covariance,
            integration: IntegrationTable::of(self.effects.as_ref()),
            fit: self.scores,
            recording: &self.recordings,
            provenance: &self.provenance,
        };
        let parts = [
            toml::to_string(&head),
            toml::to_string(&self.rod.tables()),
            toml::to_string(&tail),
        ];
        let parts = parts
            .into_iter()
            .collect::<Result<Vec<_>, _>>()
            .map_err(|source| IdentifyError::Unwritable {
                file: self.rod.file().to_owned(),
                source,
            })?;
        let head = match self.effects {
            None => HEAD,
            Some(_) => HEAD_WITH_EFFECTS,
        };
        Ok(head.to_owned() + &parts.join("\n"))
    }
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
