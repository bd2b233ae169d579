use std::ops::ControlFlow;

use std::path::{Path, PathBuf};

use identify::{Validated, WienerModel};
use missing_physics::{Audit, DiagnoseConfig, Diagnosis, Finding, Stage, diagnose, setting_of_rod};
use recording::Recording;
use rig_files::rod_file;
use serde::{Deserialize, Serialize};
use sma_effects::EffectSet;
use wiener::hysteresis::Rule;

use crate::folder::Folder;
use crate::{CaseId, TrialError};

/// Verdict of a diagnosis on a case: made from its files alone, and written before the seal is opened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Verdict {
    /// Its name.
    pub verdict: String,
    /// Class of the noise.
    pub noise_class: String,
    /// Missing effects, the strongest first.
    pub findings: Vec<Named>,
    /// Ids of what helps without a licensed name.
    pub suspects: Vec<String>,
    /// Block that is blamed, and how surely.
    pub block: Option<(String, f64)>,
    /// Stretches of the training recording with most of the mismatch, s.
    pub spans_s: Vec<[f64; 2]>,
    /// Errors of the baseline model, mm.
    pub plain: Errors,
    /// Errors of the model with what was found, mm.
    pub extended: Option<Errors>,
    /// Share of the explainable error of the unseen recording that is explained.
    pub explained: Option<f64>,
    /// True if a run is recommended.
    pub recommends_run: bool,
    /// Share of the baseline model's residual that a curve predicts on blocks which it has not seen, and the probability of that
    /// by chance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub audit: Option<[f64; 2]>,
    /// Both of the residual of the model with what was found.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub audit_of_extended: Option<[f64; 2]>,
    /// Other verdicts that the threshold of a rule a quarter less or more would give.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub otherwise: Vec<Otherwise>,
}

/// A verdict as another threshold of a rule would give it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Otherwise {
    /// Name of the rule.
    pub rule: String,
    /// Factor of its threshold; of a share or a probability above a half, of what that lacks of 1.
    pub factor: f64,
    /// Id of the verdict.
    pub verdict: String,
    /// Findings, the strongest first.
    pub findings: Vec<Named>,
}

/// A finding.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Named {
    /// Id of the effect.
    pub effect: String,
    /// Ids of those that would do as well.
    pub could_also_be: Vec<String>,
    /// Probability of the name.
    pub probability: f64,
    /// Its parameters.
    pub parameters: Vec<Estimate>,
}

/// A parameter of a finding.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// 95 % interval.
    pub ci95: Option<[f64; 2]>,
}

/// Root mean squares of the errors, in the unit that their place says.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Errors {
    /// On the training recording.
    pub train: f64,
    /// On the unseen one.
    pub unseen: Option<f64>,
}

impl Named {
    /// The effect and what would do as well.
    pub fn set(&self) -> impl Iterator<Item = &str> {
        std::iter::once(&self.effect)
            .chain(&self.could_also_be)
            .map(String::as_str)
    }
}

impl From<&Diagnosis> for Verdict {
    fn from(diagnosis: &Diagnosis) -> Self {
        let errors = |stage: &Stage| Errors {
            train: stage.fit.train_rmse,
            unseen: Validated::rmse_of_all(&stage.validated),
        };
        let mismatch = &diagnosis.mismatch;
        let block = mismatch.block;
        let numbers = |audit: Audit| [audit.share, audit.p_value];
        let next = diagnosis.next_experiment.as_ref();
        Self {
            verdict: diagnosis.verdict.id().to_owned(),
            noise_class: diagnosis.noise_floor.class.id().to_owned(),
            findings: diagnosis.findings.iter().map(Named::from).collect(),
            suspects: diagnosis
                .suspects
                .iter()
                .map(|suspect| suspect.effect.id().to_owned())
                .collect(),
            block: block.map(|(block, probability)| (block.id().to_owned(), probability)),
            spans_s: mismatch
                .spans
                .iter()
                .map(|span| [span.start_s, span.end_s])
                .collect(),
            plain: errors(&diagnosis.baseline),
            extended: diagnosis.extended.as_ref().map(|one| errors(&one.stage)),
            explained: diagnosis.explained.and_then(|shares| shares.validate),
            recommends_run: next.is_some_and(|next| next.run.is_some()),
            audit: diagnosis.baseline_audit.map(numbers),
            audit_of_extended: diagnosis
                .audit
                .filter(|_| !diagnosis.findings.is_empty())
                .map(numbers),
            otherwise: diagnosis.otherwise.iter().map(Otherwise::from).collect(),
        }
    }
}

impl From<&missing_physics::Otherwise> for Otherwise {
    fn from(other: &missing_physics::Otherwise) -> Self {
        Self {
            rule: other.rule.name.to_owned(),
            factor: other.factor,
            verdict: other.verdict.id().to_owned(),
            findings: other.findings.iter().map(Named::from).collect(),
        }
    }
}

impl From<&Finding> for Named {
    fn from(finding: &Finding) -> Self {
        let parameters = finding.parameters.iter().map(|parameter| Estimate {
            name: parameter.name.to_owned(),
            value: parameter.value,
            ci95: parameter.ci95,
        });
        Self {
            effect: finding.effect.id().to_owned(),
            could_also_be: finding
                .could_also_be
                .iter()
                .map(|other| other.id().to_owned())
                .collect(),
            probability: finding.probability,
            parameters: parameters.collect(),
        }
    }
}

/// The files of a case, read as `sma diagnose` reads them.
#[derive(Debug)]
pub(crate) struct Opened {
    case: CaseId,
    pub(crate) base: WienerModel,
    pub(crate) config: DiagnoseConfig,
    pub(crate) training: Vec<Recording>,
    pub(crate) unseen: Vec<Recording>,
}

impl Opened {
    pub(crate) fn read(folder: &Folder) -> Result<Self, TrialError> {
        Self::of(folder, &folder.training())
    }

    /// Reads the files of a case with the recommended run as one more training recording.
    pub(crate) fn with_next(folder: &Folder) -> Result<Self, TrialError> {
        let mut training = folder.training();
        training.push(folder.next());
        Self::of(folder, &training)
    }

    fn of(folder: &Folder, training: &[PathBuf]) -> Result<Self, TrialError> {
        let case = folder.case;
        let refused = TrialError::diagnosis(case);
        let rod = rod_file::read(&folder.rod()).map_err(|source| TrialError::RodFile {
            case,
            source: Box::new(source),
        })?;
        let options = rod.read_options();
        let read = |path: &Path| {
            recording::read_csv(path, &options).map_err(|source| TrialError::Files {
                case,
                source: Box::new(source),
            })
        };
        let training = training
            .iter()
            .map(|path| read(path))
            .collect::<Result<Vec<_>, _>>()?;
        let unseen = vec![read(&folder.unseen())?];
        Ok(Self {
            case,
            base: WienerModel::new(&rod, Rule::LastReversal, &training).map_err(&refused)?,
            config: DiagnoseConfig {
                setting: setting_of_rod(&rod, training[0].output_unit()),
                limits: rod.limits,
                ..DiagnoseConfig::default()
            },
            training,
            unseen,
        })
    }

    pub(crate) fn diagnosed(&self, catalogue: EffectSet) -> Result<Diagnosis, TrialError> {
        let config = DiagnoseConfig {
            catalogue,
            ..self.config.clone()
        };
        diagnose(
            &self.base,
            &self.training,
            &self.unseen,
            &config,
            &mut |_| ControlFlow::Continue(()),
        )
        .map_err(TrialError::diagnosis(self.case))
    }
}
