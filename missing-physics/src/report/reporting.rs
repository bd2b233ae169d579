//! From a finished search to the diagnosis that is told of it.

use identify::{IdentifyError, both};
use recording::order::falling;
use recording::{Recording, RepeatFloor};

use crate::config::{DiagnoseConfig, Part};
use crate::decide::{Decided, Named, Traces, Verdict, leading};
use crate::evidence::{Block, Population};
use crate::locate::everywhere::locate;
use crate::locate::mismatch::Mismatch;
use crate::model::case::Case;
use crate::model::elsewhere::predicted;
use crate::model::unseen::{Unseen, validated_by};
use crate::next::rivals::next;
use crate::next::run::NextExperiment;
use crate::noise::floor::Measured;
use crate::report::catalogue::{catalogue, finding};
use crate::report::diagnosis::{
    Diagnosis, Explained, ExtendedStage, Finding, Otherwise, Remainder, Simulations, Stage,
};
use crate::report::errors::Errors;
use crate::report::explained::explained;
use crate::report::formula::OfFormula;
use crate::report::held::{chosen, extended};
use crate::report::judged::{Judged, Judging};
use crate::report::ladder::{Samples, ladder};
use crate::report::remains::{blocks_of, located, remainder};
use crate::search::known::known;
use crate::search::roads::Search;
use crate::watch::{Caller, DiagnoseProgress, Watch};
use crate::{CandidateSet, ExtendedModel};

/// The baseline model with its error on recordings that were not used.
#[derive(Debug)]
pub(crate) struct Baseline {
    pub(crate) model: ExtendedModel,
    pub(crate) stage: Stage,
    /// Error on stretches of those recordings.
    pub(crate) error: Unseen,
}

impl Baseline {
    /// The baseline model of a case where it was fitted; `unseen` are the recordings that were not used, and those on which models
    /// are judged.
    pub(crate) fn of(
        case: &Case<'_>,
        [unseen, judged]: [&[Recording]; 2],
    ) -> Result<Self, IdentifyError> {
        let point = case.fit.point(0);
        let weight = case.temperature_weight(&case.baseline()?).unwrap_or(0.0);
        let (validated, error) = validated_by(case.base, (&point, weight), [unseen, judged])?;
        let predicted_rmse = predicted(case.base, &point, unseen)?;
        Ok(Self {
            model: case.model(CandidateSet::EMPTY),
            stage: Stage {
                validated,
                predicted_rmse,
                fit: case.fit.clone(),
            },
            error,
        })
    }
}

/// Facts known before the search, for the report.
#[derive(Debug)]
pub(crate) struct Reporting<'a, 'p> {
    /// Blocks on which models are weighed.
    pub(crate) blocks: &'a [Block],
    /// Noise of the samples on which models are judged, and of those that were recorded.
    pub(crate) noise: [Measured; 2],
    pub(crate) repeats: Option<RepeatFloor>,
    pub(crate) baseline: Baseline,
    /// All samples of the training.
    pub(crate) training: &'a [Recording],
    /// The recordings that were not used, and those of them on which models are judged.
    pub(crate) unseen: [&'a [Recording]; 2],
    pub(crate) config: &'a DiagnoseConfig,
    pub(crate) caller: &'a Caller<'p>,
}

impl Reporting<'_, '_> {
    /// The diagnosis where no two starts of the baseline model agree, and no other loop does instead.
    pub(crate) fn not_converged(self) -> Diagnosis {
        Diagnosis::not_converged(
            self.baseline.stage,
            self.repeats,
            &self.noise[1],
            self.config.seed,
        )
    }

    /// The diagnosis. `searches` are those of the population at the judged samples, the paper's loop first; `place` and `effects` say where
    /// the leading model stands in them. A model that is needed and was not searched is fitted. `simulations` are those before.
    pub(crate) fn reported(
        self,
        (mut searches, population): (Vec<Search<'_>>, &Population),
        (place, effects): (usize, CandidateSet),
        simulations: Simulations,
    ) -> Result<Diagnosis, IdentifyError> {
        self.caller.tell(DiagnoseProgress::Refit)?;
        let Baseline {
            model,
            stage: baseline,
            error: before,
        } = &self.baseline;
        let seed = self.config.seed;
        let looked = (self.noise[0].gate.sqrt(), seed);
        let mut mismatch = located(&mut searches[0], CandidateSet::EMPTY, looked, locate)?;
        let chosen = chosen(&mut searches[place], effects)?;
        let leader = (&searches[place], effects);
        // The last fit to all samples takes long, and knows nothing of the rest.
        let (known, extended) = both(
            || {
                let of_samples = (self.training, &self.noise[0]);
                known(leader, population, of_samples, self.blocks, self.config)
            },
            || chosen.map(|fit| extended(leader, fit, self.training, self.unseen)),
        );
        let (known, (mut extended, error_after)) = (known?, extended.transpose()?.unzip());
        let search = &mut searches[place];
        let ceiling = population.ceiling()[0] / search.case.layout.n_outputs() as f64;
        let of_formula = OfFormula::beside(search, effects, self.noise[0].lower.powi(2))?;
        let of_both = error_after.as_ref().map(|after| [before, after]);
        let mut errors = Errors::on(self.unseen[1], search.case);
        let judging = Judging {
            population,
            known: &known,
            extended: extended.as_ref(),
            of_formula: &of_formula,
            plain: (model, baseline),
            errors: of_both,
            ceiling,
        };
        let Judged { decided, by_names } =
            judging.judged(search, &mut errors, Traces::default())?;
        let explained = of_both.map(|of_both| Explained {
            by_findings: by_names,
            ..explained(of_both, decided.explained, ceiling, seed)
        });
        self.caller.tell(DiagnoseProgress::Locate)?;
        // What a curve finds beyond the leading model, if only the error of a formula, may be any effect.
        let hidden_rms = leading(population).found_by_curve().sqrt();
        let n_outputs = search.case.layout.n_outputs();
        let least_rms = known.least_that_matters(n_outputs).max(hidden_rms);
        let of_population = (population, &decided);
        let catalogue = catalogue(search, of_population, effects, least_rms, seed)?;
        if !decided.named.is_empty() {
            mismatch.blocks = blocks_of(&decided.named);
            mismatch.block = mismatch.blocks.first().copied();
        }
        let remainder = self.remainder(
            (search, effects),
            (population, &decided),
            &mismatch,
            ceiling,
        )?;
        let next_experiment = self.next_experiment((search, effects), &decided)?;
        let best = search.get(effects).unwrap_or(search.baseline());
        let mut noise_floor = match search.case.whole(self.training) {
            Some(whole) => self.noise[1].floor(&whole, &whole.stands(best)?),
            None => self.noise[1].floor(search.case, best),
        };
        noise_floor.of_drive = known.of_drive.sqrt();
        // Last: it may visit models that are no rivals.
        let samples = Samples {
            training: self.training,
            unseen: self.unseen,
        };
        let ladder = ladder(search, baseline, extended.as_ref(), samples)?;
        // As it may, too, where an answer would be another one.
        let otherwise = judging.otherwise(search, &mut errors, &decided)?;
        if let Some(extended) = &mut extended {
            of_formula.widen(&mut extended.stage.fit);
        }
        let findings = written(&decided.named, search, extended.as_ref());
        let suspects = written(&decided.suspects, search, extended.as_ref());
        let otherwise = otherwise
            .into_iter()
            .map(|(rule, factor, decided)| Otherwise {
                rule,
                factor,
                verdict: decided.verdict,
                findings: written(&decided.named, search, extended.as_ref()),
            })
            .collect();
        let audit_of_plain = population.plain().anonymous.as_ref();
        Ok(Diagnosis {
            verdict: decided.verdict,
            noise_floor,
            repeats: self.repeats,
            ladder,
            explained,
            mismatch,
            findings,
            suspects,
            remainder,
            catalogue,
            next_experiment,
            audit: decided.audit,
            baseline_audit: audit_of_plain.map(|one| one.audit),
            traces: decided.traces.steps,
            otherwise,
            left_out: self.caller.left_out(),
            simulations: Simulations {
                judged: searches.iter().map(Search::simulations).sum(),
                ..simulations
            },
            baseline: self.baseline.stage,
            extended,
            seed,
        })
    }

    /// Residual error after the leading model, where a part of it is not explained.
    fn remainder(
        &self,
        (search, effects): (&mut Search<'_>, CandidateSet),
        (population, decided): (&Population, &Decided),
        mismatch: &Mismatch,
        ceiling: f64,
    ) -> Result<Option<Remainder>, IdentifyError> {
        if !matches!(
            decided.verdict,
            Verdict::ExplainedInPart | Verdict::Unexplained
        ) {
            return Ok(None);
        }
        let n_outputs = search.case.layout.n_outputs() as f64;
        let of_both = [population.plain(), leading(population)]
            .map(|model| model.evidence.squares()[0] / n_outputs - ceiling);
        let looked = (self.noise[0].gate.sqrt(), self.config.seed);
        remainder(search, effects, mismatch, of_both, looked)
    }

    /// The run that would tell apart what these recordings could not, unless it is left out.
    fn next_experiment(
        &self,
        (search, effects): (&Search<'_>, CandidateSet),
        decided: &Decided,
    ) -> Result<Option<NextExperiment>, IdentifyError> {
        let has_rivals = decided.named.iter().any(|named| !named.others.is_empty());
        let may_differ = has_rivals || !decided.suspects.is_empty();
        if may_differ && self.caller.leaves_out(Part::NextRun) {
            return Ok(None);
        }
        next(search, decided, effects, &self.config.limits)
    }
}

/// Names with their numbers, the strongest first.
fn written(named: &[Named], search: &Search<'_>, extended: Option<&ExtendedStage>) -> Vec<Finding> {
    let setting = &search.case.setting;
    let findings = named.iter().map(|named| finding(named, setting, extended));
    let mut findings: Vec<Finding> = findings.collect();
    falling(&mut findings, |finding| finding.contribution);
    findings
}
