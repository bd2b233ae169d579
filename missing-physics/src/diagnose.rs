//! From a rig and its recordings to a diagnosis.

use std::ops::ControlFlow;

use identify::{Fit, FitConfig, IdentifyError, WienerModel};
use recording::order::falling;
use recording::{Recording, RepeatFloor, repeat_floor};

use crate::agreed::agreed;
use crate::baseline::{opened, with_state_of_runs, with_unknowns};
use crate::config::{DiagnoseConfig, Effort, Part};
use crate::decide::{Named, Traces, Verdict, leading};
use crate::evidence::blocks;
use crate::locate::everywhere::locate;
use crate::model::case::Case;
use crate::model::coarse::coarse;
use crate::model::elsewhere::predicted;
use crate::model::unseen::validated;
use crate::next::rivals::next;
use crate::noise::floor::measured;
use crate::report::catalogue::{catalogue, finding};
use crate::report::diagnosis::{Diagnosis, Explained, Finding, Otherwise, Simulations, Stage};
use crate::report::errors::Errors;
use crate::report::explained::explained;
use crate::report::held::extended;
use crate::report::judged::{Judged, Judging};
use crate::report::ladder::ladder;
use crate::report::remains::{blocks_of, located, remainder};
use crate::search::complete::Completing;
use crate::search::families::{self, begun, is_anything, is_described, may_be_the_loop};
use crate::search::known::known;
use crate::search::occurs::testable;
use crate::search::promote::promoted;
use crate::search::roads::Search;
use crate::search::weighing::{Weighing, at};
use crate::watch::{Caller, DiagnoseProgress, Watch, Watched};
use crate::{Candidate, CandidateSet};

/// Gap between what is fitted and what is left out, time constants.
const GAP: f64 = 5.0;

/// Says which physics the baseline model of a rig leaves out.
///
/// The training recordings decide; the unseen ones are opened once, at the end. `progress` is told how far it is, by any
/// thread but by one at a time, and may end it: then no simulation is begun any more.
///
/// # Errors
///
/// Errors of [`identify::fit`] and of the models; [`IdentifyError::Stopped`] if `progress` ended it.
pub fn diagnose<'p>(
    base: &WienerModel,
    training: &[Recording],
    unseen: &[Recording],
    config: &DiagnoseConfig,
    progress: &'p mut (dyn FnMut(DiagnoseProgress) -> ControlFlow<()> + Send + 'p),
) -> Result<Diagnosis, IdentifyError> {
    let caller = Caller::new(progress, config);
    let plain = plain_fit(base, training, config, &caller)?;
    from_baseline(base, plain, [training, unseen], config, &caller)
}

/// The baseline model fitted as it is.
fn plain_fit(
    base: &WienerModel,
    training: &[Recording],
    config: &DiagnoseConfig,
    caller: &Caller<'_>,
) -> Result<Fit, IdentifyError> {
    let baseline_config = FitConfig {
        seed: config.seed,
        ..config.baseline.clone()
    };
    let watched = Watched {
        model: base,
        watch: caller,
    };
    agreed(&watched, training, &baseline_config, &mut |so_far| {
        // If this ends it, so does the next simulation.
        match caller.tell(DiagnoseProgress::Baseline(so_far.clone())) {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    })
}

/// Diagnosis from a baseline that is fitted already; `recordings` are the training and the unseen ones.
///
/// # Errors
///
/// Errors of [`identify::fit`] and of the models; [`IdentifyError::Stopped`] if `progress` ended it.
pub fn diagnose_from<'p>(
    base: &WienerModel,
    plain: Fit,
    recordings: [&[Recording]; 2],
    config: &DiagnoseConfig,
    progress: &'p mut (dyn FnMut(DiagnoseProgress) -> ControlFlow<()> + Send + 'p),
) -> Result<Diagnosis, IdentifyError> {
    let caller = Caller::new(progress, config);
    from_baseline(base, plain, recordings, config, &caller)
}

fn from_baseline(
    base: &WienerModel,
    plain: Fit,
    [training, unseen]: [&[Recording]; 2],
    config: &DiagnoseConfig,
    caller: &Caller<'_>,
) -> Result<Diagnosis, IdentifyError> {
    let has_converged = plain.converged();
    let all: Vec<Recording> = [training, unseen].concat();
    let repeats = repeat_floor(&all);
    let (base, plain) = with_unknowns(base, plain, training, config, caller)?;
    let (base, plain) =
        with_state_of_runs(&base, plain, training, repeats.as_ref(), (config, caller))?;
    let opened = Opened {
        base: &base,
        plain: &plain,
        has_converged,
        repeats,
    };
    opened.diagnosed([training, unseen], config, caller)
}

/// Diagnosis of runs that may differ from one another as runs of a rig ordinarily do. It is returned with the baseline model in
/// which these differences are left open.
pub(crate) fn diagnose_runs<'p>(
    base: &WienerModel,
    runs: &[Recording],
    config: &DiagnoseConfig,
    progress: &'p mut (dyn FnMut(DiagnoseProgress) -> ControlFlow<()> + Send + 'p),
) -> Result<(WienerModel, Diagnosis), IdentifyError> {
    let caller = Caller::new(progress, config);
    let plain = plain_fit(base, runs, config, &caller)?;
    let has_converged = plain.converged();
    let base = base.without_reference_run();
    let (base, plain) = opened(&base, &plain, runs, (config, &caller))?;
    let opened = Opened {
        base: &base,
        plain: &plain,
        has_converged,
        repeats: repeat_floor(runs),
    };
    let diagnosis = opened.diagnosed([runs, &[]], config, &caller)?;
    Ok((base, diagnosis))
}

/// A baseline model with what belongs to runs open as far as it is asked for.
struct Opened<'a> {
    base: &'a WienerModel,
    plain: &'a Fit,
    /// True if starts agreed before anything was opened.
    has_converged: bool,
    repeats: Option<RepeatFloor>,
}

impl Opened<'_> {
    fn diagnosed(
        self,
        [training, unseen]: [&[Recording]; 2],
        config: &DiagnoseConfig,
        caller: &Caller<'_>,
    ) -> Result<Diagnosis, IdentifyError> {
        let Self {
            base,
            plain,
            has_converged,
            repeats,
        } = self;
        let (validated, error_before) = validated(base, &plain.point(0), unseen)?;
        let baseline = Stage {
            validated,
            predicted_rmse: predicted(base, &plain.point(0), unseen)?,
            fit: plain.clone(),
        };
        let tau_s = plain.tau_s();
        let noise = measured(training, tau_s);
        let is_found = has_converged || plain.converged();
        let fine_case = Case::new(base, plain, training, config.setting).watched_by(caller);
        caller.tell(DiagnoseProgress::Search { simulations: 0 })?;
        let few = coarse(base, plain, training)?;
        let case = Case::new(base, plain, &few, fine_case.setting).watched_by(caller);
        let few_noise = measured(&few, tau_s);
        let all = CandidateSet::all(config.catalogue, config.setting.hypotheses);
        let mut fits = Vec::new();
        if !is_found {
            if all.contains(Candidate::other_loop()) {
                fits = families::instead(&case, config.seed)?;
            }
            if fits.is_empty() {
                return Ok(Diagnosis::not_converged(
                    baseline,
                    repeats,
                    &noise,
                    config.seed,
                ));
            }
        }
        let catalogue_set = testable(&fine_case, &fine_case.baseline()?, all)?;
        let begun = |case, catalogue| begun(case, catalogue, &few_noise, config.seed);
        let few_blocks = blocks(&case.layout, &few, GAP * tau_s);
        let mut completing = Completing::new(&few_blocks, config.seed);
        let mut coarse_searches = vec![begun(&case, catalogue_set)?];
        caller.tell_of_search()?;
        // A loop of another family bends what is found of the rest: it comes before more effects do.
        if fits.is_empty()
            && catalogue_set.contains(Candidate::other_loop())
            && is_anything(&completing.audited(&coarse_searches)?)
            && !case.leaves_out(Part::OtherLoops)
        {
            fits = families::fits(&case, config.seed)?;
        }
        let is_thorough = config.effort == Effort::Thorough && !fits.is_empty();
        let mut goes_on =
            is_thorough || !is_found || families::is_another(&fits, &coarse_searches[0]);
        if !goes_on {
            // More effects than one are worth their search where a curve finds more than one has.
            let population = completing.completed(&mut coarse_searches)?;
            goes_on = may_be_the_loop(&population);
            if !goes_on {
                let named = coarse_searches[0].get(leading(&population).names);
                families::retain_rivals(&mut fits, named);
            }
        }
        let cases = families::cases(&case, &fits);
        let beside = families::beside(catalogue_set);
        for case in &cases {
            coarse_searches.push(begun(case, beside)?);
        }
        if goes_on {
            // Where a loop leaves nothing that a curve finds, by itself or with one effect, more effects are in vain; and where not even
            // a curve describes the output.
            let population = completing.audited(&coarse_searches)?;
            let is_in_vain = leading(&population).is_whole()
                || !is_described(&population, case.output_squares());
            if is_thorough || !is_in_vain {
                families::grow(&mut coarse_searches)?;
            }
            completing.completed(&mut coarse_searches)?;
        }
        let of_families = families::cases(&fine_case, &fits);
        let fine_cases: Vec<&Case<'_>> = std::iter::once(&fine_case).chain(&of_families).collect();
        let blocks = blocks(&fine_case.layout, training, GAP * tau_s);
        let mut weighing = Weighing::new(&blocks, config.seed);
        let (mut searches, population) = promoted(
            &fine_cases,
            &mut coarse_searches,
            &mut completing,
            &mut weighing,
            noise.highest(),
        )?;
        let case = &fine_case;
        let looked = (noise.gate.sqrt(), config.seed);
        let mut mismatch = located(&mut searches[0], CandidateSet::EMPTY, looked, locate)?;
        caller.tell(DiagnoseProgress::Refit)?;
        let leader = leading(&population);
        let (place, effects) = at(&searches, leader);
        if !is_found && place == 0 {
            return Ok(Diagnosis::not_converged(
                baseline,
                repeats,
                &noise,
                config.seed,
            ));
        }
        let known = known(
            &searches[place],
            effects,
            &population,
            &noise,
            &blocks,
            config,
        )?;
        let ceiling = population.ceiling()[0] / case.layout.n_outputs() as f64;
        let of_searches =
            |searches: &[Search<'_>]| searches.iter().map(Search::simulations).sum::<u64>();
        let mut search = searches.swap_remove(place);
        let mut simulations = Simulations {
            baseline: plain.simulations,
            other_loops: fits.iter().map(|other| other.fit.simulations).sum(),
            search: of_searches(&coarse_searches),
            judged: of_searches(&searches),
        };
        let (extended, error_after) = extended(&mut search, effects, unseen)?.unzip();
        let of_both = error_after.map(|after| [error_before, after]);
        let mut errors = Errors::on(unseen);
        let judging = Judging {
            population: &population,
            known: &known,
            extended: extended.as_ref(),
            plain: (&fine_case.model(CandidateSet::EMPTY), &baseline),
            errors: of_both.as_ref(),
            ceiling,
        };
        let Judged { decided, by_names } =
            judging.judged(&mut search, &mut errors, Traces::default())?;
        let explained = of_both.as_ref().map(|[before, after]| Explained {
            by_findings: by_names,
            ..explained([before, after], decided.explained, ceiling, config.seed)
        });
        caller.tell(DiagnoseProgress::Locate)?;
        let setting = search.case.setting;
        let written = |named: &[Named]| {
            let mut findings: Vec<Finding> = named
                .iter()
                .map(|named| finding(named, &setting, extended.as_ref()))
                .collect();
            falling(&mut findings, |finding| finding.contribution);
            findings
        };
        let (findings, suspects) = (written(&decided.named), written(&decided.suspects));
        // What a curve finds beyond the model, if only the error of a formula, may be any effect.
        let hidden_rms = leader.found_by_curve().sqrt();
        let least_rms = known
            .least_that_matters(case.layout.n_outputs())
            .max(hidden_rms);
        let catalogue = catalogue(
            &mut search,
            (&population, &decided),
            effects,
            least_rms,
            config.seed,
        )?;
        if !decided.named.is_empty() {
            mismatch.blocks = blocks_of(&decided.named);
            mismatch.block = mismatch.blocks.first().copied();
        }
        let explainable =
            population.plain().evidence.squares()[0] / case.layout.n_outputs() as f64 - ceiling;
        let of_leading = population.get(leader.names);
        let left = of_leading.map_or(0.0, |model| model.evidence.squares()[0])
            / case.layout.n_outputs() as f64
            - ceiling;
        let remainder = if matches!(
            decided.verdict,
            Verdict::ExplainedInPart | Verdict::Unexplained
        ) {
            remainder(&mut search, effects, &mismatch, [explainable, left], looked)?
        } else {
            None
        };
        let has_rivals = decided.named.iter().any(|named| !named.others.is_empty());
        let may_differ = has_rivals || !decided.suspects.is_empty();
        let next_experiment = if may_differ && caller.leaves_out(Part::NextRun) {
            None
        } else {
            next(&search, &decided, effects, &config.limits)?
        };
        let best = search.get(effects).unwrap_or(search.baseline());
        let noise_floor = noise.floor(search.case, best);
        // Last: it may visit models that are no rivals.
        let ladder = ladder(&mut search, &baseline, extended.as_ref(), &mut errors)?;
        // As it may, too, where an answer would be another one.
        let otherwise = judging.otherwise(&mut search, &mut errors, &decided)?;
        let otherwise = otherwise.into_iter().map(|(rule, factor, decided)| {
            let (verdict, findings) = (decided.verdict, written(&decided.named));
            Otherwise {
                rule,
                factor,
                verdict,
                findings,
            }
        });
        let otherwise = otherwise.collect();
        simulations.judged += search.simulations();
        Ok(Diagnosis {
            verdict: decided.verdict,
            noise_floor,
            repeats,
            baseline,
            extended,
            ladder,
            explained,
            mismatch,
            findings,
            suspects,
            remainder,
            catalogue,
            next_experiment,
            audit: decided.audit,
            baseline_audit: population.plain().anonymous.as_ref().map(|one| one.audit),
            traces: decided.traces.steps,
            otherwise,
            left_out: caller.left_out(),
            simulations,
            seed: config.seed,
        })
    }
}
