//! One instance of a unit: a model, its variables, and the state that it is in. No pointers here.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use identify::Supply;
use missing_physics::{RestoredModel, known_effects};
use recording::read_text;
use rig_files::{RigFileError, model_file};
use sha2::{Digest, Sha256};
use sma_effects::{EffectValues, ExtendedPlant, ExtendedState, PhysicsError, Setting};
use sma_export::{FMU_TIME, Fmi, FmuVariable, fmu_guid};
use wiener::{Drive, Input, Plant, WienerParams};

/// Most bytes of a model.
const MOST_BYTES: u64 = 1 << 24;

/// Surroundings until they are set, if the model states none, °C.
const USUAL_AMBIENT_DEGC: f64 = 20.0;

/// Errors of an instance, which its log shows.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SlaveError {
    #[error("resource location {uri:?}: expected a file URI with an absolute path")]
    Location { uri: String },
    #[error("{}: cannot be read: {source}", path.display())]
    Unreadable {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{error}")]
    Model { error: Box<RigFileError> },
    #[error("model.toml: expected a model of one rod that a drive heats")]
    Kind,
    #[error("{what} {found}: expected {expected}, of model.toml in the resources")]
    Identity {
        what: &'static str,
        found: String,
        expected: String,
    },
    #[error("the plant is refused: {0}")]
    Plant(#[from] PhysicsError),
    #[error("identity and location of the resources: expected text")]
    Untold,
    #[error("type of the unit: expected co-simulation")]
    Purpose,
    #[error("resource path {}: expected an absolute path", path.display())]
    Path { path: PathBuf },
    #[error("{call}: {count} variables, but no place for their {what}")]
    Null {
        call: &'static str,
        count: usize,
        what: &'static str,
    },
    #[error("value reference {reference}: expected 0 to {last}")]
    Reference { reference: u32, last: u32 },
    #[error("{name} = {value}: must be a finite number")]
    NotFinite { name: &'static str, value: f64 },
    #[error("{name} = {value}: must lie from 0 to 1")]
    Share { name: &'static str, value: f64 },
    #[error("{name}: is {what}")]
    NotNow {
        name: &'static str,
        what: &'static str,
    },
    #[error("communication step of {value} s: must be finite and >= 0")]
    Step { value: f64 },
    #[error("{call}: not while the instance is {phase}")]
    Order { call: &'static str, phase: Phase },
}

/// Phases of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Before the initialization.
    Instantiated,
    /// In it.
    Initializing,
    /// After it.
    Stepping,
    /// Done.
    Terminated,
}

impl std::fmt::Display for Phase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "instantiated",
            Self::Initializing => "in its initialization",
            Self::Stepping => "stepping",
            Self::Terminated => "terminated",
        })
    }
}

/// All that a call may change: what a state of the unit is.
#[derive(Debug, Clone)]
pub(crate) struct Snapshot {
    phase: Phase,
    /// Time of the importer, s, on which nothing depends.
    time_s: f64,
    values: [f64; FmuVariable::ALL.len()],
    /// Plant by the parameters, and its state; none until both are needed.
    running: Option<(ExtendedPlant, ExtendedState)>,
}

/// An instance.
#[derive(Debug)]
pub(crate) struct Slave {
    /// Largest value reference: of FMI 3.0 that of the time.
    last_reference: u32,
    setting: Setting,
    params: WienerParams,
    effects: EffectValues,
    supply: Supply,
    /// Time between samples of the recording that the model was identified from, s.
    sample_time_s: f64,
    first: Snapshot,
    now: Snapshot,
}

/// Most parts of a communication step.
const MOST_PARTS: f64 = 1e6;

impl Slave {
    /// Reads `model.toml` in the folder of resources; its identity must be the one that the importer was told.
    pub(crate) fn new(fmi: Fmi, guid: &str, resources: &Path) -> Result<Self, SlaveError> {
        let path = resources.join("model.toml");
        let text = read_text(&path, MOST_BYTES).map_err(|source| SlaveError::Unreadable {
            path: path.clone(),
            source,
        })?;
        let expected = fmu_guid(&sha256(&text));
        if guid != expected {
            return Err(SlaveError::Identity {
                what: match fmi {
                    Fmi::V2 => "GUID",
                    Fmi::V3 => "instantiation token",
                },
                found: guid.to_owned(),
                expected,
            });
        }
        let model = |error| SlaveError::Model {
            error: Box::new(error),
        };
        let saved = model_file::parse_with("model.toml", &text, &known_effects).map_err(model)?;
        let restored = RestoredModel::new(&saved).map_err(|error| model(error.into()))?;
        let member = restored.first_member().ok_or(SlaveError::Kind)?;
        let mut values = [0.0; FmuVariable::ALL.len()];
        let ambient_degc = saved.rod.ambient_degc.unwrap_or(USUAL_AMBIENT_DEGC);
        for (variable, value) in [
            (FmuVariable::AmbientDegc, ambient_degc),
            (FmuVariable::Offset, member.params.offset),
            (FmuVariable::StartRiseK, member.start.temperature_degc),
            (FmuVariable::StartShare, member.start.share),
        ] {
            values[variable as usize] = value;
        }
        let recorded = saved.recordings.first().and_then(|one| one.sample_time_s);
        let first = Snapshot {
            phase: Phase::Instantiated,
            time_s: 0.0,
            values,
            running: None,
        };
        Ok(Self {
            last_reference: match fmi {
                Fmi::V2 => FMU_TIME - 1,
                Fmi::V3 => FMU_TIME,
            },
            setting: restored.fleet().setting,
            params: member.params,
            effects: member.effects,
            supply: saved.rod.supply,
            sample_time_s: recorded.filter(|dt_s| *dt_s > 0.0).unwrap_or(f64::INFINITY),
            now: first.clone(),
            first,
        })
    }

    /// Fails unless the instance is in one of some phases.
    fn only(&self, call: &'static str, phases: &[Phase]) -> Result<(), SlaveError> {
        let phase = self.now.phase;
        if phases.contains(&phase) {
            Ok(())
        } else {
            Err(SlaveError::Order { call, phase })
        }
    }

    /// Takes note of the start of the importer's time, s.
    pub(crate) fn setup(&mut self, call: &'static str, start_s: f64) -> Result<(), SlaveError> {
        self.only(call, &[Phase::Instantiated])?;
        if !start_s.is_finite() {
            let name = "start time";
            return Err(SlaveError::NotFinite {
                name,
                value: start_s,
            });
        }
        self.now.time_s = start_s;
        Ok(())
    }

    pub(crate) fn begin_initialization(&mut self) -> Result<(), SlaveError> {
        self.only("EnterInitializationMode", &[Phase::Instantiated])?;
        self.now.phase = Phase::Initializing;
        Ok(())
    }

    /// The rod starts, by its parameters and its surroundings of this moment.
    pub(crate) fn end_initialization(&mut self) -> Result<(), SlaveError> {
        self.only("ExitInitializationMode", &[Phase::Initializing])?;
        self.start()?;
        self.now.phase = Phase::Stepping;
        Ok(())
    }

    pub(crate) fn terminate(&mut self) -> Result<(), SlaveError> {
        self.only("Terminate", &[Phase::Stepping])?;
        self.now.phase = Phase::Terminated;
        Ok(())
    }

    pub(crate) fn reset(&mut self) -> Result<(), SlaveError> {
        self.now = self.first.clone();
        Ok(())
    }

    pub(crate) fn snapshot(&self) -> Snapshot {
        self.now.clone()
    }

    pub(crate) fn restore(&mut self, snapshot: &Snapshot) {
        self.now = snapshot.clone();
    }

    fn variable(&self, reference: u32) -> Result<FmuVariable, SlaveError> {
        let all = FmuVariable::ALL.into_iter();
        let mut found = all.filter(|variable| *variable as u32 == reference);
        let last = self.last_reference;
        found
            .next()
            .ok_or(SlaveError::Reference { reference, last })
    }

    fn value(&self, variable: FmuVariable) -> f64 {
        self.now.values[variable as usize]
    }

    fn start(&mut self) -> Result<(), SlaveError> {
        let params = WienerParams {
            offset: self.value(FmuVariable::Offset),
            ..self.params
        };
        let plant = ExtendedPlant::new(&self.setting, &params, &self.effects)?;
        let ambient_degc = self.value(FmuVariable::AmbientDegc);
        let state = plant.between_limiting_curves(
            ambient_degc + self.value(FmuVariable::StartRiseK),
            self.value(FmuVariable::StartShare),
        );
        self.now.running = Some((plant, state));
        Ok(())
    }

    /// Sets an input, or before the end of the initialization a parameter.
    pub(crate) fn set(&mut self, reference: u32, value: f64) -> Result<(), SlaveError> {
        if reference == FMU_TIME && self.last_reference == FMU_TIME {
            let what = "the time of the importer: it cannot be set";
            return Err(SlaveError::NotNow { name: "time", what });
        }
        let variable = self.variable(reference)?;
        let name = variable.name();
        if !value.is_finite() {
            return Err(SlaveError::NotFinite { name, value });
        }
        if variable.is_output() {
            let what = "an output: it cannot be set";
            return Err(SlaveError::NotNow { name, what });
        }
        let started = matches!(self.now.phase, Phase::Stepping | Phase::Terminated);
        if variable.is_parameter() && started {
            let what = "a parameter: it is fixed after the initialization";
            return Err(SlaveError::NotNow { name, what });
        }
        if variable == FmuVariable::StartShare && !(0.0..=1.0).contains(&value) {
            return Err(SlaveError::Share { name, value });
        }
        self.now.values[variable as usize] = value;
        Ok(())
    }

    /// Reads a variable; an output in the initialization is that of the start by what is set so far.
    pub(crate) fn get(&mut self, reference: u32) -> Result<f64, SlaveError> {
        if reference == FMU_TIME && self.last_reference == FMU_TIME {
            return Ok(self.now.time_s);
        }
        let variable = self.variable(reference)?;
        if !variable.is_output() {
            return Ok(self.value(variable));
        }
        if self.now.phase == Phase::Initializing {
            self.start()?;
        }
        let Some((plant, state)) = &self.now.running else {
            let what = "an output: it is known from the initialization on";
            let name = variable.name();
            return Err(SlaveError::NotNow { name, what });
        };
        let output = plant.output(state);
        Ok(match variable {
            FmuVariable::Displacement => output.displacement[0],
            _ => output.temperature_degc[0],
        })
    }

    /// Moves the rod on by a communication step from a time of the importer, s, under the inputs that are set.
    pub(crate) fn step(&mut self, time_s: f64, length_s: f64) -> Result<(), SlaveError> {
        self.only("DoStep", &[Phase::Stepping])?;
        if !time_s.is_finite() {
            let name = "time of the step";
            return Err(SlaveError::NotFinite {
                name,
                value: time_s,
            });
        }
        if !(length_s >= 0.0 && length_s.is_finite()) {
            return Err(SlaveError::Step { value: length_s });
        }
        // No part is longer than the samples that the model was identified from: over longer ones some effects are cut short.
        let parts = (length_s / self.sample_time_s - 1e-9)
            .ceil()
            .clamp(1.0, MOST_PARTS);
        let part_s = length_s / parts;
        let drive = self.supply.limited(self.value(FmuVariable::Drive));
        let input = Input {
            drive: [match self.setting.drive {
                // A bridge is never on for less than none of the time, nor for more than all of it.
                Drive::Duty { .. } => drive.clamp(0.0, 1.0),
                _ => drive,
            }],
            ambient_degc: self.value(FmuVariable::AmbientDegc),
        };
        if let Some((plant, state)) = &mut self.now.running {
            for _ in 0..parts as usize {
                plant.step(state, &input, part_s);
            }
        }
        self.now.time_s = time_s + length_s;
        Ok(())
    }
}

/// SHA-256 of a text, in hexadecimal.
fn sha256(text: &str) -> String {
    let mut hexadecimal = String::new();
    for byte in Sha256::digest(text.as_bytes()) {
        // Writing to a string does not fail.
        let _ = write!(hexadecimal, "{byte:02x}");
    }
    hexadecimal
}

/// Path of a file URI: file:/path, file:///path or file://localhost/path, with escaped bytes.
pub(crate) fn path_of(uri: &str) -> Result<PathBuf, SlaveError> {
    let refused = || SlaveError::Location {
        uri: uri.to_owned(),
    };
    let rest = uri.strip_prefix("file:").ok_or_else(refused)?;
    let path = match rest.strip_prefix("//") {
        Some(behind) => behind.strip_prefix("localhost").unwrap_or(behind),
        None => rest,
    };
    if !path.starts_with('/') {
        return Err(refused());
    }
    let mut bytes = Vec::with_capacity(path.len());
    let mut rest = path.as_bytes();
    while let Some((&byte, behind)) = rest.split_first() {
        rest = behind;
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let digits = rest.get(..2).ok_or_else(refused)?;
        let digit = |byte: u8| char::from(byte).to_digit(16).ok_or_else(refused);
        let value = 16 * digit(digits[0])? + digit(digits[1])?;
        bytes.push(u8::try_from(value).map_err(|_| refused())?);
        rest = &rest[2..];
    }
    let path = String::from_utf8(bytes).map_err(|_| refused())?;
    Ok(Path::new(&path).to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locations_are_file_uris() {
        for (uri, path) in [
            ("file:///a/resources", "/a/resources"),
            ("file:/a/resources", "/a/resources"),
            ("file://localhost/a%20b/%C3%A4", "/a b/ä"),
        ] {
            assert_eq!(path_of(uri).unwrap(), Path::new(path));
        }
        for uri in [
            "/a",
            "http://a/b",
            "file://host/a",
            "file:a",
            "file:///a%2",
            "file:///a%zz",
            "file:///%ff",
        ] {
            let error = path_of(uri).unwrap_err().to_string();
            assert!(error.contains("expected a file URI"), "{error}");
        }
    }
}
