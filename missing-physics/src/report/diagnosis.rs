//! Result of a diagnosis.

use identify::{Fit, Validated};
use recording::RepeatFloor;

use crate::config::Part;
use crate::decide::{Rule, Trace, Verdict};
use crate::evidence::Audit;
use crate::locate::mismatch::{Mismatch, Shape};
use crate::next::run::NextExperiment;
use crate::noise::floor::Measured;
use crate::noise::kind::{Floor, NoiseClass};
use crate::search::roads::Search;
use crate::search::survey::Loops;
use crate::{Candidate, ExtendedModel, LoopFamily, Need};

/// The result of `diagnose`.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// Noise of the output, in its unit.
    pub noise_floor: Floor,
    /// Difference between recordings of the same drive, training and unseen; `None` if no drive is repeated.
    pub repeats: Option<RepeatFloor>,
    /// The baseline model.
    pub baseline: Stage,
    /// The model with what was found; that with the suspects, where there is no finding but some; `None` if
    /// there is neither.
    pub extended: Option<ExtendedStage>,
    /// From the baseline model to the extended one, an effect at a time.
    pub ladder: Vec<Rung>,
    /// How much of what could be explained is; `None` without an extended model.
    pub explained: Option<Explained>,
    /// Where the baseline model and the recordings part.
    pub mismatch: Mismatch,
    /// Effects that are missing, the strongest first.
    pub findings: Vec<Finding>,
    /// Effects that help, and whose name is not licensed, the strongest first.
    pub suspects: Vec<Finding>,
    /// Residual error after the findings; `None` if it is no more than noise.
    pub remainder: Option<Remainder>,
    /// Status of each effect by the recordings, in the order of the catalogue.
    pub catalogue: Vec<Entry>,
    /// The run that would tell apart what these could not.
    pub next_experiment: Option<NextExperiment>,
    /// Prediction by a curve of any shape of the residual of the model that was judged: the leading one, or the baseline model if nothing
    /// is named and a suspect is no drift; `None` where nothing was judged.
    pub audit: Option<Audit>,
    /// Prediction of the baseline model's residual by a curve of any shape; `None` where nothing was judged.
    pub baseline_audit: Option<Audit>,
    /// The rules that were asked, in order, and what they said.
    pub traces: Vec<Trace>,
    /// Other verdicts that the threshold of one rule a quarter less or more would give.
    pub otherwise: Vec<Otherwise>,
    /// Parts of the search that were left out, by the effort that was asked for or since the time was over.
    pub left_out: Vec<Part>,
    /// Simulations of the whole training set.
    pub simulations: Simulations,
    /// Seed of the searches.
    pub seed: u64,
}

impl Diagnosis {
    /// Diagnosis where no two starts of the baseline model agree.
    pub(crate) fn not_converged(
        baseline: Stage,
        repeats: Option<RepeatFloor>,
        noise: &Measured,
        seed: u64,
    ) -> Self {
        Self {
            verdict: Verdict::NotConverged,
            noise_floor: Floor {
                lower: noise.lower,
                upper: noise.upper,
                class: NoiseClass::Colored,
                of_drive: 0.0,
            },
            repeats,
            simulations: Simulations {
                baseline: baseline.fit.simulations,
                ..Simulations::default()
            },
            ladder: vec![Rung::plain(&baseline)],
            baseline,
            extended: None,
            explained: None,
            mismatch: Mismatch::default(),
            findings: Vec::new(),
            suspects: Vec::new(),
            remainder: None,
            catalogue: Vec::new(),
            next_experiment: None,
            audit: None,
            baseline_audit: None,
            traces: Vec::new(),
            otherwise: Vec::new(),
            left_out: Vec::new(),
            seed,
        }
    }
}

/// Numbers of simulations of the whole training set, by purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Simulations {
    /// Of the fit of the baseline model.
    pub baseline: u64,
    /// Of the baseline models with loops of other families, at few samples.
    pub other_loops: u64,
    /// Of the search for effects, at few samples.
    pub search: u64,
    /// Of the models that were judged, at the judged samples.
    pub judged: u64,
}

impl Simulations {
    /// Those of the baseline model and at few samples.
    pub(crate) fn before(plain: &Fit, loops: &Loops, at_few: &[Search<'_>]) -> Self {
        let of_loops = loops.fits.iter().map(|other| other.fit.simulations);
        Self {
            baseline: plain.simulations,
            other_loops: of_loops.sum(),
            search: at_few.iter().map(Search::simulations).sum(),
            judged: 0,
        }
    }

    /// All of them.
    #[must_use]
    pub fn total(self) -> u64 {
        self.baseline + self.other_loops + self.search + self.judged
    }
}

/// A fitted model and how it does on what it has not seen.
#[derive(Debug, Clone)]
pub struct Stage {
    /// The fit.
    pub fit: Fit,
    /// The unseen recordings, in their order, each calibrated: what belongs to it is found on every other stretch of it, and the
    /// stretches between count.
    pub validated: Vec<Validated>,
    /// Error on all of them as they are predicted, each with the offset that its rest tells and nothing else of its own, in the
    /// unit of the output; `None` without one.
    pub predicted_rmse: Option<f64>,
}

/// The model with effects.
#[derive(Debug, Clone)]
pub struct ExtendedStage {
    /// Its effects, beside the loop of its model.
    pub effects: Vec<Candidate>,
    /// The model.
    pub model: ExtendedModel,
    /// Its fit and validation.
    pub stage: Stage,
}

impl ExtendedStage {
    /// Ids of what it has beyond the baseline model: a loop of another family is another shape of the loop.
    #[must_use]
    pub fn names(&self) -> Vec<&'static str> {
        let is_other = self.model.loop_family() != LoopFamily::Proximity;
        let shape = is_other.then(|| Candidate::other_loop().id());
        let effects = self.effects.iter().map(|effect| effect.id());
        shape.into_iter().chain(effects).collect()
    }
}

/// A model on the way from the plain to the extended one.
#[derive(Debug, Clone, PartialEq)]
pub struct Rung {
    /// Effects that it has beyond the model before: one; none in the baseline model; several where none of them can be
    /// fitted without the others.
    pub added: Vec<Candidate>,
    /// Error on the training recordings, in the unit of the output.
    pub train_rmse: f64,
    /// Error on all recordings that it has not seen, predicted from their rest; `None` without one. A drift is not carried there.
    pub predicted_rmse: Option<f64>,
    /// Error on all recordings that it has not seen, each of them calibrated, see [`Stage::validated`]; `None` without one.
    pub unseen_rmse: Option<f64>,
}

/// Share of the explainable error that the extended model explains.
///
/// ```text
/// (MSE_baseline - MSE_extended)/(MSE_baseline - noise²)
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Explained {
    /// On the training recordings, each part of them held out in turn; `None` where the baseline's error is the noise's.
    pub train: Option<f64>,
    /// On the unseen recordings; `None` without any.
    pub validate: Option<f64>,
    /// 95 % interval of the latter, by blocks.
    pub validate_interval: Option<[f64; 2]>,
    /// On the unseen recordings by the model with the findings alone; `None` without unseen recordings or findings.
    pub by_findings: Option<f64>,
}

/// An effect that is missing from the baseline model.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The effect.
    pub effect: Candidate,
    /// Effects that would explain these recordings as well, the likeliest first.
    pub could_also_be: Vec<Candidate>,
    /// Probability of `effect` against those and against all that is not in the catalogue; of a suspect, against the rest
    /// of the catalogue alone, and not to be quoted.
    pub probability: f64,
    /// Its parameters.
    pub parameters: Vec<Estimate>,
    /// True if all parameters are where the literature has them, or within physical bounds where it says nothing.
    pub plausible: bool,
    /// Share of the explainable error that comes back if it alone is left out.
    pub contribution: f64,
    /// For people.
    pub sentence: String,
}

/// A verdict as another threshold of one rule would give it.
#[derive(Debug, Clone, PartialEq)]
pub struct Otherwise {
    /// The rule.
    pub rule: &'static Rule,
    /// Factor of its threshold: 0.75 or 1.25, see [`Rule::threshold_times`].
    pub factor: f64,
    /// The verdict.
    pub verdict: Verdict,
    /// The findings, the strongest first.
    pub findings: Vec<Finding>,
}

/// A parameter of an effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value; of a drift, that in the recording where it is largest.
    pub value: f64,
    /// 95 % interval; `None` where it stands on a bound or the data do not fix it.
    pub ci95: Option<[f64; 2]>,
    /// Range in the literature, where somebody looked it up.
    pub literature: Option<[f64; 2]>,
}

/// Residual error after the findings.
#[derive(Debug, Clone, PartialEq)]
pub struct Remainder {
    /// Root mean square of it beyond the noise, in the unit of the output.
    pub rms: f64,
    /// Share of the explainable error of the baseline model.
    pub share: f64,
    /// Where it is.
    pub mismatch: Mismatch,
    /// The missing term as a curve in the likeliest block; `None` if no curve describes it.
    pub shape: Option<Shape>,
}

/// Status of an effect by the recordings, with the numbers behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The effect.
    pub effect: Candidate,
    /// Status of the effect.
    pub status: Status,
    /// Its score at the baseline model, standard deviations; `None` if it cannot be computed.
    pub t: Option<f64>,
    /// Share of its trace's square that refitting the baseline model hides.
    pub absorption: Option<f64>,
    /// Smallest size that these recordings would have shown in 95 % of cases, in the unit of the size.
    pub minimum_detectable: Option<f64>,
    /// Unit of the size.
    pub unit: &'static str,
}

/// Status of an effect by the recordings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Status {
    /// It is there.
    Detected,
    /// It may be there, under this name or another: see `could_also_be` and the suspects.
    Ambiguous,
    /// It is at most this large, in the unit of its size.
    Excluded {
        /// Upper end of the size's 95 % interval; of a two-sided size, in magnitude.
        upper: f64,
    },
    /// Even the largest plausible size would not show.
    NotTestable,
    /// It cannot be computed, because this is not known of the rig.
    Unknown {
        /// Need that is not met.
        need: Need,
    },
}

impl Status {
    /// Name in files and reports.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Status::Detected => "detected",
            Status::Ambiguous => "ambiguous",
            Status::Excluded { .. } => "excluded",
            Status::NotTestable | Status::Unknown { .. } => "not_testable",
        }
    }
}
