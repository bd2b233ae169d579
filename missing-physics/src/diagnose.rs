//! From a rig and its recordings to a diagnosis.

use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use identify::{
    Fit, FitConfig, ForwardModel, IdentifyError, Limits, ParameterVector, Validated, WienerModel,
    fit,
};
use recording::Recording;

use crate::decide::Verdict;
use crate::decide::{Decided, Known, Named, RuleId, decide, leading};
use crate::evidence::{Block, Population, blocks, disturbed};
use crate::locate::everywhere::{locate, remainder_shape};
use crate::locate::located::Located;
use crate::locate::mismatch::Mismatch;
use crate::model::case::Case;
use crate::model::coarse::coarse;
use crate::model::elsewhere::{spread, validated, validated_alone};
use crate::model::series::Channel;
use crate::model::unseen::{self, Unseen};
use crate::next::rivals::next;
use crate::noise::floor::{Measured, measured};
use crate::noise::kind::{Floor, NoiseClass};
use crate::noise::slip::slip;
use crate::noise::tone::tone;
use crate::noise::whiten::Whitener;
use crate::report::catalogue::{catalogue, finding};
use crate::report::diagnosis::{
    Diagnosis, Explained, ExtendedStage, Finding, Remainder, Rung, Stage,
};
use crate::report::explained::explained;
use crate::report::ladder::ladder;
use crate::search::complete::Completing;
use crate::search::families;
use crate::search::occurs::testable;
use crate::search::promote::promoted;
use crate::search::roads::Search;
use crate::search::weighing::{Weighing, at};
use crate::watch::{Caller, DiagnoseProgress, Watched};
use crate::{Candidate, CandidateSet, EffectBlock, EffectSet, LoopFamily, Setting};

/// Standard deviations up to which an error may be the parameters' uncertainty.
const TWICE: f64 = 2.0;

/// Error on unseen recordings over that on the training's up to which a model does there as well.
const AS_NEAR: f64 = 1.2;

/// Standard error of the share of a change that comes true, from which it says nothing.
const TOLD: f64 = 0.5;

/// Error of the plain model with what belongs to the recordings left open, over that without, from which they do not ask for it.
const ASKED_FOR: f64 = 0.95;

/// Starts of that fit, beside the place where the plain model ended.
const FEW_STARTS: u64 = 4;

/// Gap between what is fitted and what is left out, time constants.
const GAP: f64 = 5.0;

/// Settings of a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagnoseConfig {
    /// What is known of the rig beyond its baseline, and hypotheses of one's own: they compete with the catalogue.
    pub setting: Setting,
    /// Effects of the catalogue that may be found.
    pub catalogue: EffectSet,
    /// What the rig stands: for the run that is proposed.
    pub limits: Limits,
    /// Search of the baseline.
    pub baseline: FitConfig,
    /// Seed of everything that is drawn.
    pub seed: u64,
}

impl Default for DiagnoseConfig {
    fn default() -> Self {
        Self {
            setting: Setting::default(),
            catalogue: EffectSet::all(),
            limits: Limits::default(),
            baseline: FitConfig {
                starts: 16,
                ..FitConfig::default()
            },
            seed: 1,
        }
    }
}

/// Starts of a second fit of the baseline over those of the first, where no two of these agreed.
const HARDER: u64 = 4;

/// Says which physics the plain model of a rig leaves out.
///
/// The training recordings decide; the unseen ones are opened once, at the end. `progress` is told how far it is, by any
/// thread but by one at a time, and may end it: then no simulation is begun any more.
///
/// # Errors
///
/// What [`identify::fit`] and the models refuse; [`IdentifyError::Stopped`] if `progress` ended it.
pub fn diagnose<'p>(
    base: &WienerModel,
    training: &[Recording],
    unseen: &[Recording],
    config: &DiagnoseConfig,
    progress: &'p mut (dyn FnMut(DiagnoseProgress) -> ControlFlow<()> + Send + 'p),
) -> Result<Diagnosis, IdentifyError> {
    let caller = Caller::new(progress);
    let baseline_config = FitConfig {
        seed: config.seed,
        ..config.baseline.clone()
    };
    let fitted = |config: &FitConfig| {
        let base = Watched {
            model: base,
            watch: &caller,
        };
        fit(&base, training, config, &mut |so_far| {
            // If this ends it, so does the next simulation.
            match caller.tell(DiagnoseProgress::Baseline(so_far.clone())) {
                Ok(()) => ControlFlow::Continue(()),
                Err(_) => ControlFlow::Break(()),
            }
        })
    };
    let mut plain = fitted(&baseline_config)?;
    if !plain.converged() {
        let vector = ParameterVector::new(base.parameters(), training.len());
        plain = fitted(&FitConfig {
            starts: HARDER * baseline_config.starts,
            seed: config.seed.wrapping_add(1),
            from: vec![plain.coordinates(&vector)],
            ..baseline_config
        })?;
    }
    from_baseline(base, plain, [training, unseen], config, &caller)
}

/// The plain model with what belongs to each recording left open, fitted from where it ended without and from elsewhere; as
/// it was, where nothing is open or the recordings do not ask for it.
fn with_unknowns(
    base: &WienerModel,
    plain: Fit,
    training: &[Recording],
    config: &DiagnoseConfig,
    caller: &Caller<'_>,
) -> Result<(WienerModel, Fit), IdentifyError> {
    let open = base.with_unknowns(training);
    if open.parameters() == base.parameters() {
        return Ok((open, plain));
    }
    let vector = ParameterVector::new(open.parameters(), training.len());
    let fit_config = FitConfig {
        seed: config.seed,
        from: vec![plain.coordinates(&vector)],
        starts: FEW_STARTS,
        ..config.baseline.clone()
    };
    let watched = Watched {
        model: &open,
        watch: caller,
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let fitted = fit(&watched, training, &fit_config, go_on)?;
    if fitted.train_rmse < ASKED_FOR * plain.train_rmse {
        Ok((open, fitted))
    } else {
        Ok((base.clone(), plain))
    }
}

/// The same from a baseline that is fitted; `recordings` are the training and the unseen ones.
///
/// # Errors
///
/// What [`identify::fit`] and the models refuse; [`IdentifyError::Stopped`] if `progress` ended it.
pub fn diagnose_from<'p>(
    base: &WienerModel,
    plain: Fit,
    recordings: [&[Recording]; 2],
    config: &DiagnoseConfig,
    progress: &'p mut (dyn FnMut(DiagnoseProgress) -> ControlFlow<()> + Send + 'p),
) -> Result<Diagnosis, IdentifyError> {
    from_baseline(base, plain, recordings, config, &Caller::new(progress))
}

fn from_baseline(
    base: &WienerModel,
    plain: Fit,
    [training, unseen]: [&[Recording]; 2],
    config: &DiagnoseConfig,
    caller: &Caller<'_>,
) -> Result<Diagnosis, IdentifyError> {
    let has_converged = plain.converged();
    let (base, plain) = &with_unknowns(base, plain, training, config, caller)?;
    let baseline = Stage {
        validated: unseen
            .iter()
            .map(|recording| validated_alone(base, &plain.point(0), recording))
            .collect::<Result<_, _>>()?,
        fit: plain.clone(),
    };
    let tau_s = plain.parameter("tau_s").map_or(0.0, |tau| tau.values[0]);
    let noise = measured(training, tau_s);
    if !has_converged && !plain.converged() {
        return Ok(not_converged(baseline, &noise, config.seed));
    }
    let fine_case = Case::new(base, plain, training, config.setting).watched_by(caller);
    caller.tell(DiagnoseProgress::Search { simulations: 0 })?;
    let few = coarse(base, plain, training)?;
    let case = Case::new(base, plain, &few, config.setting).watched_by(caller);
    let few_noise = measured(&few, tau_s);
    let all = CandidateSet::all(config.catalogue, config.setting.hypotheses);
    let catalogue_set = testable(&fine_case, &fine_case.baseline()?, all)?;
    let begun = |case, catalogue| begun(case, catalogue, &few_noise, config.seed);
    let few_blocks = blocks(&case.layout, &few, GAP * tau_s);
    let mut completing = Completing::new(&few_blocks, config.seed);
    let mut coarse_searches = vec![begun(&case, catalogue_set)?];
    caller.tell_of_search()?;
    // More effects than one are worth their search where a curve finds more than one has.
    let population = completing.completed(&mut coarse_searches)?;
    // A loop of another family bends what is found of the rest: it comes before more effects do.
    let goes_on = may_be_the_loop(&population);
    let fits = if goes_on && catalogue_set.contains(Candidate::other_loop()) {
        families::fits(&case, config.seed)?
    } else {
        Vec::new()
    };
    let cases = families::cases(&case, &fits);
    for case in &cases {
        coarse_searches.push(begun(case, catalogue_set.without(Candidate::other_loop()))?);
    }
    if goes_on {
        families::grow(&mut coarse_searches)?;
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
    let (place, effects) = at(&searches, leading(&population));
    let known = known(
        &searches[place],
        effects,
        &population,
        &noise,
        &blocks,
        config,
    )?;
    let mut decided = decide(&population, &known);
    let ceiling = population.ceiling()[0] / case.layout.n_outputs() as f64;
    let mut simulations =
        plain.simulations + fits.iter().map(|(_, fit)| fit.simulations).sum::<u64>();
    simulations += searches.iter().map(Search::simulations).sum::<u64>();
    simulations += coarse_searches.iter().map(Search::simulations).sum::<u64>();
    let mut search = searches.swap_remove(place);
    simulations -= search.simulations();
    let extended = extended(&mut search, effects, unseen)?;
    let mut shares = None;
    if let Some(extended) = &extended {
        let after = unseen::unseen(&extended.model, &extended.stage.fit.point(0), unseen)?;
        let before = unseen::unseen(base, &plain.point(0), unseen)?;
        let own = explained([&before, &after], decided.explained, ceiling, config.seed);
        shares = Some(own);
        decided = held_to(decided, &mut search, extended, (own, &after), unseen)?;
    }
    let explained = shares;
    caller.tell(DiagnoseProgress::Locate)?;
    let setting = search.case.setting;
    let written = |named: &[Named]| {
        let mut findings: Vec<Finding> = named
            .iter()
            .map(|named| finding(named, &setting, extended.as_ref()))
            .collect();
        findings.sort_by(|a, b| b.contribution.total_cmp(&a.contribution));
        findings
    };
    let (findings, suspects) = (written(&decided.named), written(&decided.suspects));
    let catalogue = catalogue(&mut search, &decided, effects, config.seed)?;
    if !decided.named.is_empty() {
        mismatch.blocks = blocks_of(&decided.named);
        mismatch.block = mismatch.blocks.first().copied();
    }
    let explainable =
        population.plain().evidence.squares()[0] / case.layout.n_outputs() as f64 - ceiling;
    let of_leading = population.get(leading(&population).names);
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
    let next_experiment = next(&search, &decided, effects, &config.limits)?;
    let best = search.get(effects).unwrap_or(search.baseline());
    let noise_floor = noise.floor(search.case, best);
    // Last: it may visit models that are no rivals.
    let ladder = ladder(&mut search, &baseline, extended.as_ref(), unseen)?;
    simulations += search.simulations();
    Ok(Diagnosis {
        verdict: decided.verdict,
        noise_floor,
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
        traces: decided.traces.0,
        simulations,
        seed: config.seed,
    })
}

/// The models of a case with one effect at most.
fn begun<'c>(
    case: &'c Case<'c>,
    catalogue: CandidateSet,
    noise: &Measured,
    seed: u64,
) -> Result<Search<'c>, IdentifyError> {
    let mut search = Search::new(case, case.baseline()?, catalogue, noise.highest(), seed)?;
    search.grow_by_one()?;
    Ok(search)
}

/// Whether a loop of another family may do instead: a curve finds more than the leading model has, or a name is of the loop.
fn may_be_the_loop(population: &Population) -> bool {
    let model = leading(population);
    let is_of_loop = |name: Candidate| name.info().block == EffectBlock::Transformation;
    !model.is_whole() || model.names.iter().any(is_of_loop)
}

/// What the judge is to know beside the population.
fn known(
    search: &Search<'_>,
    effects: CandidateSet,
    population: &Population,
    noise: &Measured,
    blocks: &[Block],
    config: &DiagnoseConfig,
) -> Result<Known, IdentifyError> {
    let case = search.case;
    let Some(node) = search.get(effects) else {
        unreachable!("the leading model was visited");
    };
    let outputs = || case.layout.of_channel(Channel::Output);
    let own_squares = |range: &Range<usize>| {
        let own = &case.recorded()[range.clone()];
        let mean = own.iter().sum::<f64>() / own.len() as f64;
        own.iter().map(|y| (y - mean).powi(2)).sum::<f64>()
    };
    let rounding = noise.rounding.map_or(0.0, |rounding| rounding.powi(2));
    let plain = search.baseline();
    let disturbed = if plain.mean_square() > 2.0 * rounding {
        let sensitivities = search.sensitivities(plain)?;
        let evidence = &population.plain().evidence;
        disturbed(case, plain, evidence, &sensitivities, blocks, config.seed)?
    } else {
        // All of it may be rounding, which is a function of the output.
        0.0
    };
    let tones = outputs().map(|one| tone(&node.residual[one.range.clone()]));
    let coarse = noise.is_coarse(node.mean_square());
    let all = CandidateSet::all(config.catalogue, config.setting.hypotheses);
    Ok(Known {
        segments: case
            .layout
            .segments
            .iter()
            .map(|one| one.range.clone())
            .collect(),
        output_squares: outputs().map(|one| own_squares(&one.range)).sum(),
        rounding,
        catalogue: all,
        untried: all
            .iter()
            .filter(|&one| case.missing(one).is_some())
            .collect(),
        disturbed,
        tone: if coarse {
            0.0
        } else {
            tones.fold(0.0, f64::max)
        },
        slip: slip(case, node)?,
        seed: config.seed,
    })
}

/// What was decided, held to the recordings that were not used: names that make them worse do not hold, and what is not
/// explained there is not explained.
fn held_to(
    mut decided: Decided,
    search: &mut Search<'_>,
    extended: &ExtendedStage,
    (shares, with): (Explained, &Unseen),
    unseen: &[Recording],
) -> Result<Decided, IdentifyError> {
    if unseen.is_empty() || decided.named.is_empty() {
        return Ok(decided);
    }
    let effects: CandidateSet = extended.effects.iter().copied().collect();
    let mut fallen = CandidateSet::EMPTY;
    for named in &decided.named {
        let less = if effects.contains(named.effect) {
            search.exchanged(effects, named.effect, None)?
        } else {
            None
        };
        let Some(node) = less.and_then(|less| search.get(less)) else {
            continue;
        };
        let without = unseen::unseen(&node.model, &node.points[0], unseen)?;
        // What is not exercised there, or lost in the noise, says nothing.
        let told = with.comes_true(&without).filter(|[_, error]| *error < TOLD);
        let Some([share, _]) = told else {
            continue;
        };
        let id = named.effect.id();
        if !decided.traces.ask(RuleId::UnseenGain, id, share) {
            fallen = fallen.with(named.effect);
        }
    }
    let (fallen, named): (Vec<Named>, Vec<Named>) = decided
        .named
        .into_iter()
        .partition(|named| fallen.contains(named.effect));
    decided.named = named;
    decided.suspects.extend(fallen);
    let share = shares.validate.unwrap_or(1.0);
    let is_explained =
        decided.traces.ask(RuleId::UnseenShare, "", share) || is_as_near(extended, unseen)?;
    if decided.named.is_empty() {
        // They made these recordings worse: what is left to say is what the plain model leaves.
        decided.verdict = decided.nameless;
    } else if !is_explained && share > 0.5 {
        decided.verdict = Verdict::ExplainedInPart;
    } else if !is_explained {
        decided.verdict = Verdict::Unexplained;
        decided.suspects.append(&mut decided.named);
    }
    Ok(decided)
}

/// Whether a model is no further off the unseen recordings than where it was fitted, where the noise is larger than it was
/// measured, and than the uncertainty of its parameters makes it where the training did not go.
fn is_as_near(extended: &ExtendedStage, unseen: &[Recording]) -> Result<bool, IdentifyError> {
    let ExtendedStage { model, stage, .. } = extended;
    let spread = spread(model, &stage.fit, &stage.validated, unseen)?;
    let most = (AS_NEAR * stage.fit.train_rmse).powi(2) + TWICE.powi(2) * spread;
    let rmse = Validated::rmse_of_all(&stage.validated);
    Ok(rmse.is_some_and(|rmse| rmse.powi(2) < most))
}

/// A look at what a model that was visited leaves; `at` holds the noise's standard deviation and the seed.
fn located<T>(
    search: &mut Search<'_>,
    effects: CandidateSet,
    at: (f64, u64),
    look: impl FnOnce(&Located<'_>) -> Result<T, IdentifyError>,
) -> Result<T, IdentifyError> {
    let sifted = search.sifted(effects)?;
    let Some(node) = search.get(effects) else {
        unreachable!("its scores were just taken");
    };
    let (floor, seed) = at;
    look(&Located {
        case: search.case,
        node,
        sensitivities: &sifted.sensitivities,
        whitener: &Whitener::new(&search.case.layout, &node.noise),
        floor,
        seed,
    })
}

/// Blocks of what was found, with the probabilities of the names: what an effect can do is known better than
/// where a residual sits.
fn blocks_of(named: &[Named]) -> Vec<(EffectBlock, f64)> {
    let all: f64 = named.iter().map(|named| named.contribution.max(0.0)).sum();
    let mut blocks: Vec<(EffectBlock, f64)> = Vec::new();
    for named in named {
        let weight = if all > 0.0 {
            named.contribution.max(0.0) / all
        } else {
            0.0
        };
        let others = named.others.iter().copied();
        for (effect, probability) in others.chain([(named.effect, named.probability)]) {
            let block = effect.info().block;
            match blocks.iter_mut().find(|(known, _)| *known == block) {
                Some((_, sum)) => *sum += weight * probability,
                None => blocks.push((block, weight * probability)),
            }
        }
    }
    blocks.sort_by(|a, b| b.1.total_cmp(&a.1));
    blocks
}

/// What is left after the chosen model: `left` of what is explainable, mean squares on blocks that were left out.
fn remainder(
    search: &mut Search<'_>,
    effects: CandidateSet,
    plain: &Mismatch,
    [explainable, left]: [f64; 2],
    at: (f64, u64),
) -> Result<Option<Remainder>, IdentifyError> {
    let family = search.case.setting.loop_family;
    let mismatch = if effects.is_empty() && family == LoopFamily::Proximity {
        plain.clone()
    } else {
        located(search, effects, at, locate)?
    };
    let shape = match mismatch.block {
        Some((block, _)) => located(search, effects, at, |located| {
            remainder_shape(located, block)
        })?,
        None => None,
    };
    Ok((left > 0.0 && explainable > 0.0).then(|| Remainder {
        rms: left.sqrt(),
        share: left / explainable,
        mismatch,
        shape,
    }))
}

fn not_converged(baseline: Stage, noise: &Measured, seed: u64) -> Diagnosis {
    Diagnosis {
        verdict: Verdict::NotConverged,
        noise_floor: Floor {
            lower: noise.lower,
            upper: noise.upper,
            class: NoiseClass::Colored,
        },
        simulations: baseline.fit.simulations,
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
        traces: Vec::new(),
        seed,
    }
}

/// The chosen model, fitted from many places and validated.
fn extended(
    search: &mut Search<'_>,
    effects: CandidateSet,
    unseen: &[Recording],
) -> Result<Option<ExtendedStage>, IdentifyError> {
    if effects.is_empty() && search.case.setting.loop_family == LoopFamily::Proximity {
        return Ok(None);
    }
    let fit = Arc::unwrap_or_clone(search.settle(effects)?);
    let model = search.case.model(effects);
    let validated = validated(&model, &fit.point(0), unseen)?;
    Ok(Some(ExtendedStage {
        effects: effects.iter().collect(),
        model,
        stage: Stage { fit, validated },
    }))
}
