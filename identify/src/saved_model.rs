//! An identified model as a value that can be kept.

use recording::{DriveResolution, Recording, drive_resolution};
use serde::{Deserialize, Serialize};
use wiener::WienerParams;
use wiener::hysteresis::{LoopFamily, Rule};

use crate::fitted::point;
use crate::quantities::{Quantities, same_quantities};
use crate::sensor::{not_negative, positive_if_any};
use crate::validate::validate_at;
use crate::{
    Fit, FittedParameter, ForwardModel, IdentifyError, OfRig, ParameterCovariance, ParameterInfo,
    ParameterVector, RigModel, Rod, Scope, Sensor, Validated,
};

/// Id of the effect that a loop of another family is.
pub const LOOP_SHAPE: &str = "loop-shape";

/// An identified model with all that is needed to use it later: `model.toml`.
///
/// `rig-files` writes and reads the file. It holds the tables of the rod file it came from, every parameter with its interval, their covariance, how
/// well it met which recordings, and how it was made. A written model is read back as it was.
///
/// A model may have effects beyond its baseline part. This crate keeps their ids and parameters, those of the plain
/// part first; what they do others know.
#[derive(Debug, Clone)]
pub struct SavedModel {
    /// Known properties of the rig.
    pub rod: Rod,
    /// The model; with effects its baseline part.
    pub model: RigModel,
    /// Effects beyond the baseline part; `None` for a baseline model.
    pub effects: Option<SavedEffects>,
    /// Rule of the hysteresis' memory.
    pub rule: Rule,
    /// Unit of the output.
    pub output_unit: String,
    /// Unit of the drive.
    pub drive_unit: String,
    /// The parameters: those of the baseline part in its order, then those of each effect.
    pub parameters: Vec<FittedParameter>,
    /// Covariance of the estimates.
    pub covariance: ParameterCovariance,
    /// The recordings it was fitted to, then those it was checked on.
    pub recordings: Vec<SavedRecording>,
    /// How well it did.
    pub scores: Scores,
    /// How it was made.
    pub provenance: Provenance,
}

/// Extension of a saved model beyond its baseline part: effects, a loop of another family, or both, and the solver
/// settings of its samples.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SavedEffects {
    /// Their ids, in the order of their parameters.
    pub ids: Vec<String>,
    /// Curves of the loop.
    pub loop_family: LoopFamily,
    /// Parts into which every sample is divided; ≥ 1.
    pub sub_steps: usize,
    /// Newton iterations of each part; ≥ 1.
    pub newton_iterations: usize,
}

impl SavedEffects {
    /// Ids for people: a loop of another family is another shape of the loop.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        let is_other = self.loop_family != LoopFamily::Proximity;
        let shape = is_other.then_some(LOOP_SHAPE);
        shape
            .into_iter()
            .chain(self.ids.iter().map(String::as_str))
            .collect()
    }
}

/// How well a saved model did.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scores {
    /// Root mean square of recording - model over the training recordings, in the output unit.
    #[serde(deserialize_with = "not_negative")]
    pub train_rmse: f64,
    /// Root mean square of recording - model over the validation recordings, in the output unit; `None` without any.
    pub validate_rmse: Option<f64>,
    /// 1 - RMSE / standard deviation of the output, training.
    pub fit_fraction: f64,
    /// True if the fit converged.
    pub converged: bool,
}

/// A recording that a model was fitted to or checked on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedRecording {
    /// Its name.
    pub name: String,
    /// Role of the recording: fitted to or checked on.
    pub role: Role,
    /// Number of samples.
    pub n_samples: usize,
    /// Median sample time, s; `None` for static data.
    #[serde(default, deserialize_with = "positive_if_any")]
    pub sample_time_s: Option<f64>,
    /// Largest drive in it, in its unit: beyond, the model is extrapolated.
    #[serde(deserialize_with = "not_negative")]
    pub largest_drive: f64,
    /// Step of its supply, in the unit of the drive; `None` where none is seen.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "positive_if_any"
    )]
    pub drive_step: Option<f64>,
    /// Lowest drive of its supply beside nothing, in its unit; `None` where no dead zone is seen.
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "positive_if_any"
    )]
    pub drive_dead_zone: Option<f64>,
    /// Root mean square of recording - model, in the output unit.
    #[serde(deserialize_with = "not_negative")]
    pub rmse: f64,
    /// Step and noise of its sensor; `None` where it does not tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Sensor>,
}

/// Role of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Role {
    /// Fitted to.
    Train,
    /// Checked on.
    Validate,
}

/// How a model was made.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Version of the program.
    pub version: String,
    /// The call.
    pub command: String,
    /// Seed of the search.
    pub seed: u64,
    /// The input files.
    pub input: Vec<InputFile>,
}

/// A file that went into a model.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputFile {
    /// Its name.
    pub file: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

/// Says which parameters an effect has, or what would be accepted in its place.
pub type KnownEffects<'a> = &'a dyn Fn(&NamedEffect<'_>) -> Result<Vec<ParameterInfo>, String>;

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

/// Components of a saved model.
#[derive(Debug)]
pub struct Identification<'a> {
    /// Known properties of the rig.
    pub rod: &'a Rod,
    /// The model that was fitted; with effects its baseline part.
    pub model: &'a RigModel,
    /// Effects of the model beyond it; `None` for the baseline model.
    pub effects: Option<SavedEffects>,
    /// Rule of its memory.
    pub rule: Rule,
    /// The fit; parameters of effects stand behind those of the baseline part, effect after effect.
    pub fit: &'a Fit,
    /// The recordings that were fitted.
    pub training: &'a [Recording],
    /// The recordings that it was checked on, and the results of that, in one order.
    pub unseen: &'a [Recording],
    /// See `unseen`.
    pub validated: &'a [Validated],
}

impl SavedModel {
    /// The model of an identification, to be kept.
    #[must_use]
    pub fn of(identification: &Identification<'_>, provenance: Provenance) -> Self {
        let &Identification {
            rod,
            model,
            ref effects,
            rule,
            fit,
            training,
            unseen,
            validated,
        } = identification;
        let trained = training.iter().zip(&fit.recordings);
        let checked = unseen.iter().zip(validated);
        let kept = |recording: &Recording, role, rmse| {
            let resolution = drive_resolution(recording);
            SavedRecording {
                name: recording.name().to_owned(),
                role,
                n_samples: recording.len(),
                largest_drive: recording.largest_drive(),
                drive_step: resolution.step,
                drive_dead_zone: resolution.dead_zone,
                sample_time_s: recording.sampling().usual_dt_s(),
                rmse,
                sensor: Sensor::of(recording),
            }
        };
        Self {
            rod: rod.clone(),
            model: model.clone(),
            effects: effects.clone(),
            rule,
            output_unit: fit.output_unit.clone(),
            drive_unit: fit.drive_unit.clone(),
            parameters: fit.parameters.clone(),
            covariance: fit.covariance.clone(),
            recordings: trained
                .map(|(recording, fitted)| kept(recording, Role::Train, fitted.rmse))
                .chain(checked.map(|(recording, one)| kept(recording, Role::Validate, one.rmse)))
                .collect(),
            scores: Scores {
                train_rmse: fit.train_rmse,
                validate_rmse: Validated::rmse_of_all(validated),
                fit_fraction: fit.fit_fraction,
                converged: fit.converged(),
            },
            provenance,
        }
    }

    /// Step and noise of the sensor, by the training recording in which it jumps most; `None` where none tells.
    #[must_use]
    pub fn sensor(&self) -> Option<Sensor> {
        let trained = self.recordings.iter().filter(|one| one.role == Role::Train);
        trained
            .filter_map(|one| one.sensor)
            .max_by(|a, b| a.jump().total_cmp(&b.jump()))
    }

    /// How finely the supply can be set: a duty in counts as they are, else the largest step and the largest dead zone of the training.
    #[must_use]
    pub fn drive_resolution(&self) -> DriveResolution {
        let drive = self.rod.columns.drive.as_ref();
        let counts = drive.and_then(|drive| drive.full_scale);
        let largest = |value: fn(&SavedRecording) -> Option<f64>| {
            let trained = self.recordings.iter().filter(|one| one.role == Role::Train);
            trained.filter_map(value).max_by(f64::total_cmp)
        };
        DriveResolution {
            step: counts.map(f64::recip).or(largest(|one| one.drive_step)),
            dead_zone: largest(|one| one.drive_dead_zone),
        }
    }

    /// Largest drive of the training, in its unit.
    #[must_use]
    pub fn largest_drive(&self) -> f64 {
        let trained = self.recordings.iter().filter(|one| one.role == Role::Train);
        trained.fold(0.0, |largest, one| largest.max(one.largest_drive))
    }

    /// Values of all parameters in a training recording, in the order of [`SavedModel::parameters`].
    ///
    /// # Panics
    ///
    /// If there is no such recording.
    #[must_use]
    pub fn point(&self, recording: usize) -> Vec<f64> {
        point(&self.parameters, recording)
    }

    /// Predicts a recording by the baseline part, as [`validate`](crate::validate()) does after the fit.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Units`], [`IdentifyError::Drives`], and what the model refuses.
    pub fn validate(&self, recording: &Recording) -> Result<Validated, IdentifyError> {
        self.validate_by(&self.model, &self.point(0), recording)
    }

    /// Predicts a recording by the model with its effects, at a point of its parameters. What differs from run to run is as it
    /// ordinarily is: the rest of a recording does not tell it.
    ///
    /// # Errors
    ///
    /// As [`SavedModel::validate`].
    pub fn validate_by(
        &self,
        model: &dyn ForwardModel,
        point: &[f64],
        recording: &Recording,
    ) -> Result<Validated, IdentifyError> {
        let expected = Quantities {
            output_unit: &self.output_unit,
            drive: self.rod.drive_kind,
            drive_unit: &self.drive_unit,
        };
        same_quantities(recording, &self.rod.file, &expected)?;
        let mut point = point.to_vec();
        let mut ordinary = OfRig::at(model, &point);
        ordinary.hold_ordinary(&mut point);
        validate_at(&ordinary, &point, recording)
    }

    /// The parameters of the plain cascade, with the offset of the first training recording; `None` for a
    /// static loop.
    #[must_use]
    pub fn wiener_params(&self) -> Option<WienerParams> {
        self.model.wiener_params(&self.point(0))
    }

    /// Coordinates from which a fit of the same baseline model to other recordings can start: shared values as they
    /// are, those of a recording where it has been fitted before, under the same name. Effects are left out.
    ///
    /// # Errors
    ///
    /// [`IdentifyError::OtherParameters`] if the models do not have the same parameters.
    pub fn coordinates(
        &self,
        model: &RigModel,
        training: &[Recording],
    ) -> Result<Vec<f64>, IdentifyError> {
        let names = |model: &RigModel| -> Vec<&str> {
            model.parameters().iter().map(|info| info.name).collect()
        };
        let (kept, wanted) = (names(&self.model), names(model));
        if kept != wanted {
            return Err(IdentifyError::OtherParameters {
                file: self.rod.file.clone(),
                found: kept.join(", "),
                expected: wanted.join(", "),
            });
        }
        let vector = ParameterVector::new(model.parameters(), training.len());
        Ok(vector.coordinates(|parameter, r| {
            let fitted = &self.parameters[parameter];
            match fitted.info.scope {
                Scope::Shared => Some(fitted.values[0]),
                Scope::PerRecording => {
                    let name = training[r].name();
                    let known = self.recordings.iter().position(|one| one.name == name)?;
                    fitted.values.get(known).copied()
                }
            }
        }))
    }
}
