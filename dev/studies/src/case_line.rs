//! A line of a file of results.

use std::fmt;

use blind_trial::{Errors, Line};
use identify::Validated;
use missing_physics::{Candidate, Diagnosis, EffectId, Finding, Role, Stage};
use serde::{Deserialize, Serialize};

use crate::{Made, Study};

/// A case of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct CaseId {
    /// The study.
    pub study: Study,
    /// Number of the case.
    pub case: u64,
}

impl fmt::Display for CaseId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, case {}", self.study.id(), self.case)
    }
}

/// What came out of a case; no times, so that equal seeds give equal bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseLine {
    /// The study.
    pub study: Study,
    /// Number of the case.
    pub case: u64,
    /// Seed of rig and noise.
    pub seed: u64,
    /// The concealed effect; `None` in a clean rig.
    pub truth: Option<Truth>,
    /// The diagnosis with the whole catalogue.
    pub diagnosis: Outcome,
    /// The same rig with effects struck from the catalogue, one more a step; empty but in [`Study::Removed`].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<Step>,
}

/// A concealed effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// Its id.
    pub effect: String,
    /// How many times its typical size it was to have.
    pub multiple: f64,
    /// Its sizes, in their units: where the multiple leaves the bounds, the bound.
    pub sizes: Vec<f64>,
}

/// A diagnosis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outcome {
    /// Its verdict.
    pub verdict: String,
    /// Score of the concealed effect at the plain model, standard deviations.
    pub t: Option<f64>,
    /// What was found, the strongest first.
    pub findings: Vec<Named>,
    /// Ids of what helps without a licensed name.
    pub suspects: Vec<String>,
    /// Errors of the plain model, over the standard deviation of the noise.
    pub baseline: Errors,
    /// Those of the extended one.
    pub extended: Option<Errors>,
    /// Shares of the explainable error that it explains.
    pub explained: Option<Shares>,
    /// First size of the concealed effect, where the extended model has it.
    pub interval: Option<Interval>,
    /// Simulations of the whole training set.
    pub simulations: u64,
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
}

/// Shares of the explainable error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shares {
    /// On the training recordings, each part held out in turn.
    pub train: Option<f64>,
    /// On the unseen ones.
    pub unseen: Option<f64>,
    /// 95 % interval of the latter.
    pub unseen_interval: Option<[f64; 2]>,
}

/// An estimate with the value that it estimates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    /// Name of the parameter.
    pub name: String,
    /// Its value in the rig.
    pub truth: f64,
    /// Its estimate.
    pub value: f64,
    /// 95 % interval; `None` if the diagnosis gives none.
    pub ci95: Option<[f64; 2]>,
}

/// A diagnosis with a smaller catalogue.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Ids of what was struck, the concealed effect first.
    pub removed: Vec<String>,
    /// What came out.
    pub diagnosis: Outcome,
}

impl Outcome {
    pub(crate) fn new(
        diagnosis: &Diagnosis,
        made: &Made,
        truth: Option<EffectId>,
        noise: f64,
    ) -> Self {
        let of = |stage: &Stage| Errors {
            train: stage.fit.train_rmse / noise,
            unseen: Validated::rmse_of_all(&stage.validated).map(|rmse| rmse / noise),
        };
        let named = |finding: &Finding| Named {
            effect: finding.effect.id().to_owned(),
            could_also_be: ids(finding.could_also_be.iter().copied()),
            probability: finding.probability,
        };
        Self {
            verdict: diagnosis.verdict.id().to_owned(),
            t: truth.and_then(|effect| score(diagnosis, effect)),
            findings: diagnosis.findings.iter().map(named).collect(),
            suspects: ids(diagnosis.suspects.iter().map(|suspect| suspect.effect)),
            baseline: of(&diagnosis.baseline),
            extended: diagnosis.extended.as_ref().map(|one| of(&one.stage)),
            explained: diagnosis.explained.map(|shares| Shares {
                train: shares.train,
                unseen: shares.validate,
                unseen_interval: shares.validate_interval,
            }),
            interval: truth.and_then(|effect| interval(diagnosis, made, effect)),
            simulations: diagnosis.simulations,
        }
    }

    /// Whether an effect has been named.
    pub(crate) fn names(&self, effect: &str) -> bool {
        self.findings.iter().any(|finding| finding.effect == effect)
    }

    /// Whether an effect is said to be among those that would do as well.
    pub(crate) fn states(&self, effect: &str) -> bool {
        let mut stated = self.findings.iter().flat_map(|one| &one.could_also_be);
        stated.any(|other| other == effect)
    }

    /// Errors of the model that the diagnosis ends with.
    pub(crate) fn errors(&self) -> Errors {
        self.extended.unwrap_or(self.baseline)
    }
}

impl Named {
    /// Whether it is, or could also be, one of these.
    pub(crate) fn meets(&self, effects: &[String]) -> bool {
        effects.contains(&self.effect) || self.could_also_be.iter().any(|one| effects.contains(one))
    }
}

impl Line for CaseLine {
    type Key = CaseId;

    fn key(&self) -> CaseId {
        let Self { study, case, .. } = *self;
        CaseId { study, case }
    }
}

impl CaseLine {
    /// Whether the whole catalogue led to the concealed effect, by its name or as one of a set.
    #[must_use]
    pub fn is_found(&self) -> bool {
        let found = |truth: &Truth| {
            self.diagnosis.names(&truth.effect) || self.diagnosis.states(&truth.effect)
        };
        self.truth.as_ref().is_some_and(found)
    }
}

pub(crate) fn ids(effects: impl IntoIterator<Item = impl Into<Candidate>>) -> Vec<String> {
    let id = |effect| Into::<Candidate>::into(effect).id().to_owned();
    effects.into_iter().map(id).collect()
}

fn score(diagnosis: &Diagnosis, effect: EffectId) -> Option<f64> {
    let mut entries = diagnosis.catalogue.iter();
    entries.find(|entry| entry.effect == effect)?.t
}

fn interval(diagnosis: &Diagnosis, made: &Made, effect: EffectId) -> Option<Interval> {
    let first = |parameter: &missing_physics::EffectParameter| parameter.role == Role::Size;
    let index = effect.info().parameters.iter().position(first)?;
    let mut named = diagnosis.findings.iter().chain(&diagnosis.suspects);
    let estimate = named
        .find(|finding| finding.effect == effect)?
        .parameters
        .get(index)?;
    Some(Interval {
        name: estimate.name.to_owned(),
        truth: made.values.get(effect, index)?,
        value: estimate.value,
        ci95: estimate.ci95,
    })
}
