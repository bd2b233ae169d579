//! `model.toml`: how a saved model is written.

use std::ops::Range;
use std::path::Path;

use recording::Columns;
use serde::{Deserialize, Serialize};
use toml::Spanned;
use wiener::hysteresis::{REVERSAL_DEAD_BAND_K, Rule};

use crate::rod::{DriveTable, LimitsTable, LoadTable, RodFile, RodTable, Surroundings};
use crate::saved_model::{Provenance, Role, SavedModel, SavedRecording, Scores};
use crate::source::{Source, read};
use crate::{
    Bounds, Enters, FittedParameter, ForwardModel, IdentifyError, LoopModel, ParameterCovariance,
    ParameterInfo, ParameterState, RigModel, Rod, SadeghiModel, Scope, WienerModel,
};

/// Version of the file's layout.
const SCHEMA_VERSION: i64 = 1;

/// The first lines of a file.
const HEAD: &str = "\
# A model identified by `sma identify`; `sma simulate` and `sma identify --from-model` read it.
# The tables from [rod] to [columns] are those of the rod file.

";

/// What comes before the tables of the rod file.
#[derive(Serialize)]
struct Head<'a> {
    schema_version: i64,
    model: Kind,
    memory: Memory,
    temperature_scale: TemperatureScale,
    output_unit: &'a str,
    drive_unit: &'a str,
    effects: [&'a str; 0],
}

/// What comes after them.
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
    parameter: Vec<Spanned<ParameterTable>>,
    covariance: Spanned<ParameterCovariance>,
    #[expect(
        dead_code,
        reason = "there is one way so far; it is written for the reader"
    )]
    integration: IntegrationTable,
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
struct ParameterTable {
    name: String,
    /// Whose it is, for what each training recording has its own of.
    recording: Option<String>,
    value: f64,
    unit: String,
    ci95: Option<[f64; 2]>,
    state: State,
    /// Where it was searched; none for what is solved for.
    bounds: Option<[f64; 2]>,
    #[serde(default)]
    at_bound: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum State {
    Free,
    Fixed,
}

/// How the equations were solved.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct IntegrationTable {
    /// The heat balance: exact over a sample.
    method: String,
    substeps: u32,
    reversal_dead_band_k: f64,
}

impl Default for IntegrationTable {
    fn default() -> Self {
        Self {
            method: "exact over a sample".to_owned(),
            substeps: 1,
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
    /// Reads a model file.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Unreadable`], and as [`SavedModel::parse`].
    pub fn read(path: &Path) -> Result<Self, IdentifyError> {
        let (file, text) = read(path)?;
        Self::parse(&file, &text)
    }

    /// Reads the text of a model file; `file` is its name for errors.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Toml`] for what is not such a file, [`IdentifyError::Value`] and
    /// [`IdentifyError::Saved`] for what cannot be, each with line and column.
    pub fn parse(file: &str, text: &str) -> Result<Self, IdentifyError> {
        let source = Source { file, text };
        if !text.contains("schema_version") {
            return Err(IdentifyError::NoModel {
                file: file.to_owned(),
            });
        }
        let parsed: ModelFile = toml::from_str(text).map_err(|error| source.toml(&error, ""))?;
        let reading = Reading { source: &source };
        reading.version(&parsed)?;
        let rule = parsed.memory.into();
        let trained: Vec<&str> = parsed
            .recording
            .iter()
            .filter(|one| one.role == Role::Train)
            .map(|one| one.name.as_str())
            .collect();
        let rod = RodFile {
            rod: parsed.rod,
            surroundings: parsed.surroundings,
            drive: parsed.drive,
            load: parsed.load,
            limits: parsed.limits,
            columns: parsed.columns,
            ..RodFile::default()
        };
        let rod = Rod::of(&source, rod)?;
        let mut model = match parsed.model {
            Kind::Wiener => {
                let assumed = parsed.temperature_scale == TemperatureScale::Assumed;
                RigModel::Wiener(WienerModel::template(&rod, rule, assumed)?)
            }
            Kind::Sadeghi => RigModel::Sadeghi(SadeghiModel::template(&rod, rule, &[])?),
            Kind::StaticLoop => RigModel::Loop(LoopModel::template(rule, &parsed.drive_unit)),
        };
        for entry in &parsed.parameter {
            reading.parameter(entry, &mut model, &trained)?;
        }
        let parameters = model
            .parameters()
            .iter()
            .map(|info| reading.fitted(info, &parsed.parameter, &trained))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
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

    /// The text of the model's file. What is read back from it gives the same text again.
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
            effects: [],
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
            integration: IntegrationTable::default(),
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
        Ok(HEAD.to_owned() + &parts.join("\n"))
    }
}

/// Checks of what stands in a file beyond its layout.
struct Reading<'a> {
    source: &'a Source<'a>,
}

impl Reading<'_> {
    fn fault(
        &self,
        place: Range<usize>,
        what: String,
        accepted: impl Into<String>,
    ) -> IdentifyError {
        let (line, column) = self.source.position(place.start);
        IdentifyError::Saved {
            file: self.source.file.to_owned(),
            line,
            column,
            what,
            accepted: accepted.into(),
        }
    }

    fn version(&self, parsed: &ModelFile) -> Result<(), IdentifyError> {
        let version = parsed.schema_version.get_ref();
        if *version != SCHEMA_VERSION {
            let what = format!("schema_version = {version}");
            return Err(self.fault(parsed.schema_version.span(), what, "must be 1"));
        }
        match parsed.effects.first() {
            None => Ok(()),
            Some(effect) => {
                let what = format!("effects: \"{}\"", effect.get_ref());
                Err(self.fault(effect.span(), what, "no such effect in this version"))
            }
        }
    }

    /// Puts what an entry says of a parameter's unit, bounds and state into the model.
    fn parameter(
        &self,
        entry: &Spanned<ParameterTable>,
        model: &mut RigModel,
        trained: &[&str],
    ) -> Result<(), IdentifyError> {
        let table = entry.get_ref();
        let fault = |accepted: String| {
            let what = format!("parameter {} = {}", table.name, table.value);
            Err(self.fault(entry.span(), what, accepted))
        };
        let known: Vec<&str> = model.parameters().iter().map(|info| info.name).collect();
        let Some(k) = known.iter().position(|&name| name == table.name) else {
            return fault(format!(
                "no such parameter; this model has {}",
                known.join(", ")
            ));
        };
        let info = &mut model.parameters_mut()[k];
        let Bounds { lower, upper } = info.admissible;
        if !(lower..=upper).contains(&table.value) {
            return fault(format!(
                "must lie from {lower:e} to {upper:e} {}",
                table.unit
            ));
        }
        let rises = |[lower, upper]: [f64; 2]| lower <= upper;
        if !table.ci95.is_none_or(rises) || !table.bounds.is_none_or(rises) {
            return fault("ci95 and bounds must rise".to_owned());
        }
        match (info.scope, &table.recording) {
            (Scope::Shared, None) => {}
            (Scope::PerRecording, Some(name)) if trained.contains(&name.as_str()) => {}
            (Scope::Shared, Some(_)) => {
                return fault("is shared: must not name a recording".to_owned());
            }
            (Scope::PerRecording, _) => {
                return fault(format!("must name its recording: {}", trained.join(" or ")));
            }
        }
        info.unit.clone_from(&table.unit);
        info.bounds = match table.bounds {
            Some([lower, upper]) => Bounds { lower, upper },
            None if info.enters == Enters::Nonlinear => {
                return fault("must have bounds = [low, high]".to_owned());
            }
            None => Bounds::NONE,
        };
        info.state = match table.state {
            State::Free => ParameterState::Free,
            State::Fixed => ParameterState::Fixed(table.value),
        };
        Ok(())
    }

    /// The values of a parameter, one a training recording if it is not shared.
    fn fitted(
        &self,
        info: &ParameterInfo,
        entries: &[Spanned<ParameterTable>],
        trained: &[&str],
    ) -> Result<FittedParameter, IdentifyError> {
        let own: Vec<Option<&str>> = match info.scope {
            Scope::Shared => vec![None],
            Scope::PerRecording => trained.iter().copied().map(Some).collect(),
        };
        let mut fitted = FittedParameter {
            info: info.clone(),
            values: Vec::new(),
            intervals: Vec::new(),
            at_bound: false,
        };
        for recording in own {
            let mut found = entries.iter().filter(|entry| {
                let table = entry.get_ref();
                table.name == info.name && table.recording.as_deref() == recording
            });
            let (Some(entry), None) = (found.next(), found.next()) else {
                let of = recording.map_or(String::new(), |name| format!(" of {name}"));
                let what = format!("parameter {}{of}", info.name);
                return Err(self.fault(0..0, what, "must be there once"));
            };
            let table = entry.get_ref();
            fitted.values.push(table.value);
            let interval = table.ci95.map(|[lower, upper]| Bounds { lower, upper });
            fitted.intervals.push(interval);
            fitted.at_bound |= table.at_bound;
        }
        Ok(fitted)
    }

    fn covariance(
        &self,
        covariance: Spanned<ParameterCovariance>,
    ) -> Result<ParameterCovariance, IdentifyError> {
        let place = covariance.span();
        let covariance = covariance.into_inner();
        let n = covariance.names.len();
        let is_square = covariance.scales.len() == n
            && covariance.matrix.len() == n
            && covariance.matrix.iter().all(|row| row.len() == n);
        if is_square {
            return Ok(covariance);
        }
        let what = format!("covariance of {n} names");
        Err(self.fault(place, what, "must have as many scales, rows and columns"))
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
