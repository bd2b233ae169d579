//! From a rig and its recordings to a diagnosis.

use std::ops::ControlFlow;
use std::sync::Arc;

use identify::{
    Fit, FitConfig, FitProgress, ForwardModel, IdentifyError, Limits, ParameterVector, Validated,
    WienerModel, fit, validate,
};
use recording::Recording;

use crate::case::{Case, Node};
use crate::catalogue::{catalogue, finding};
use crate::diagnosis::{
    Diagnosis, Explained, ExtendedStage, Finding, Floor, Mismatch, NextExperiment, NoiseClass,
    Remainder, Rung, Stage, Verdict,
};
use crate::elsewhere::validated;
use crate::explained::explained;
use crate::floor::{Measured, measured};
use crate::judge::{GATE, Judged, LARGE, Named, judge, without_effects};
use crate::ladder::ladder;
use crate::locate::{Located, locate, remainder_shape};
use crate::next_experiment::{Rival, next_experiment};
use crate::search::Search;
use crate::whiten::Whitener;
use crate::{CandidateSet, EffectBlock, EffectId, EffectSet, Setting};

/// Most explanations that a run is sought for.
const RIVALS: usize = 3;

/// Factor by which a run must part models that are all far off more than the recordings at hand do.
const FURTHER: f64 = 2.0;

/// Factor by which a drift must lower the mean square to be told from noise with a memory.
const LOWERED: f64 = 2.0;

/// Mean square over that of the noise at rest from which a law from cycle to cycle leaves too much to be it.
const MUCH: f64 = 5.0;

/// Share of the explainable error of the unseen recordings below which names do not hold there.
const HELD: f64 = 0.4;

/// Error on unseen recordings over that on the training's up to which a model does there as well.
const AS_NEAR: f64 = 1.2;

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

/// How far a diagnosis is.
#[derive(Debug, Clone, PartialEq)]
pub enum DiagnoseProgress {
    /// The baseline is being fitted.
    Baseline(FitProgress),
    /// Effects are being tried.
    Search,
    /// The chosen model is being refitted from many starts.
    Refit,
    /// The mismatch is being located.
    Locate,
}

/// Says which physics the plain model of a rig leaves out.
///
/// The training recordings decide; the unseen ones are opened once, at the end.
///
/// # Errors
///
/// What [`identify::fit`] and the models refuse.
pub fn diagnose(
    base: &WienerModel,
    training: &[Recording],
    unseen: &[Recording],
    config: &DiagnoseConfig,
    progress: &mut dyn FnMut(DiagnoseProgress),
) -> Result<Diagnosis, IdentifyError> {
    let baseline_config = FitConfig {
        seed: config.seed,
        ..config.baseline.clone()
    };
    let mut fitted = |config: &FitConfig| {
        fit(base, training, config, &mut |so_far| {
            progress(DiagnoseProgress::Baseline(so_far.clone()));
            ControlFlow::Continue(())
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
    diagnose_from(base, plain, [training, unseen], config, progress)
}

/// The same from a baseline that is fitted; `recordings` are the training and the unseen ones.
///
/// # Errors
///
/// What [`identify::fit`] and the models refuse.
pub fn diagnose_from(
    base: &WienerModel,
    plain: Fit,
    [training, unseen]: [&[Recording]; 2],
    config: &DiagnoseConfig,
    progress: &mut dyn FnMut(DiagnoseProgress),
) -> Result<Diagnosis, IdentifyError> {
    let baseline = Stage {
        validated: unseen
            .iter()
            .map(|recording| validate(base, &plain, recording))
            .collect::<Result<_, _>>()?,
        fit: plain.clone(),
    };
    let tau_s = plain.parameter("tau_s").map_or(0.0, |tau| tau.values[0]);
    let noise = measured(training, tau_s);
    if !plain.converged() {
        return Ok(not_converged(baseline, &noise, config.seed));
    }
    let case = Case::new(base, &plain, training, config.setting);
    progress(DiagnoseProgress::Search);
    let start = case.baseline()?;
    let may_be = CandidateSet::all(config.catalogue, config.setting.hypotheses);
    let mut search = Search::new(&case, start, may_be, noise.highest(), config.seed)?;
    search.grow()?;
    let judged = judge(&mut search, &noise, tau_s)?;
    let (judged, floor) = licensed(&search, judged, &noise);
    progress(DiagnoseProgress::Refit);
    let extended = extended(&mut search, judged.effects, unseen)?;
    progress(DiagnoseProgress::Locate);
    let explained = extended
        .as_ref()
        .map(|extended| explained(&baseline, extended, &judged, unseen, &noise, base))
        .transpose()?;
    let judged = if holds(&judged, extended.as_ref(), explained.as_ref()) {
        judged
    } else {
        judged.demoted(Verdict::Unexplained)
    };
    let written = |named: &[Named]| {
        let mut findings: Vec<Finding> = named
            .iter()
            .map(|named| finding(named, extended.as_ref()))
            .collect();
        findings.sort_by(|a, b| b.contribution.total_cmp(&a.contribution));
        findings
    };
    let (findings, suspects) = (written(&judged.named), written(&judged.suspects));
    let catalogue = catalogue(&mut search, &judged, config.seed)?;
    let at = (noise.gate.sqrt(), config.seed);
    let mut mismatch = located(&mut search, CandidateSet::EMPTY, at, locate)?;
    if !judged.named.is_empty() {
        mismatch.blocks = blocks_of(&judged.named);
        mismatch.block = mismatch.blocks.first().copied();
    }
    let has_remainder = matches!(
        judged.verdict,
        Verdict::ExplainedInPart | Verdict::Unexplained
    );
    let remainder = if has_remainder {
        remainder(&mut search, &judged, &mismatch, at)?
    } else {
        None
    };
    let next_experiment = next(&search, &judged, &config.limits)?;
    // Last: it may visit models that are no rivals.
    let ladder = ladder(&mut search, &baseline, extended.as_ref(), unseen)?;
    let simulations = plain.simulations + search.simulations();
    Ok(Diagnosis {
        verdict: judged.verdict,
        noise_floor: floor,
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
        simulations,
        seed: config.seed,
    })
}

/// Whether names hold on the unseen recordings. Drifts and fatigue need not: they stay with their recording.
fn holds(judged: &Judged, extended: Option<&ExtendedStage>, explained: Option<&Explained>) -> bool {
    // As far off as where the model was fitted: the noise is larger than it was measured.
    let as_near = extended.is_some_and(|extended| {
        let unseen = Validated::rmse_of_all(&extended.stage.validated);
        let most = AS_NEAR * extended.stage.fit.train_rmse;
        unseen.is_some_and(|rmse| rmse < most)
    });
    let stays =
        |named: &Named| named.effect.info().flexible || named.effect == EffectId::FunctionalFatigue;
    let fails = explained.is_some_and(|shares| {
        let is_low = shares.validate.is_some_and(|share| share < HELD);
        // Where hardly anything was to be explained the share says nothing.
        let interval = shares.validate_interval;
        is_low && interval.is_none_or(|[_, upper]| upper < GATE)
    });
    !fails || as_near || judged.named.iter().any(stays)
}

/// What the noise lets be said of what was judged, and the noise.
fn licensed(search: &Search<'_>, judged: Judged, noise: &Measured) -> (Judged, Floor) {
    let plain = search.baseline();
    let best = search.get(judged.effects).unwrap_or(plain);
    let floor = noise.floor(search.case, best);
    let gained = plain.mean_square() - best.mean_square();
    // The zero of a sensor moves slowly and smoothly, a loop by the same law from cycle to cycle: what leaves noise that
    // grows toward low frequencies, or in the second case much of it, is not that, and repeated cycles do not tell noise
    // from what tells them apart. And whatever is flexible follows noise with a memory for a part of the way.
    let is_far = plain.mean_square() > LOWERED * best.mean_square();
    let leaves_much = best.mean_square() > MUCH * noise.gate;
    let may_be_noise = |named: &Named| match floor.class {
        NoiseClass::OneOverF => {
            named.effect == EffectId::SensorDrift
                || (named.effect == EffectId::FunctionalFatigue && leaves_much)
        }
        NoiseClass::Colored => named.effect.info().flexible && !is_far,
        NoiseClass::White | NoiseClass::Quantized => false,
    };
    if judged.named.iter().any(may_be_noise) {
        let is_large = plain.mean_square() > LARGE * best.mean_square();
        let verdict = if is_large {
            Verdict::Unexplained
        } else {
            without_effects(search, noise, 1.0)
        };
        return (judged.demoted(verdict), floor);
    }
    if !noise.forbids(floor.class, gained) {
        return (judged, floor);
    }
    // In such noise tests cry wolf: only the size of the error tells.
    let verdict = without_effects(search, noise, 1.0);
    (judged.demoted(verdict), floor)
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

/// The run that would tell apart a name that is not sure and what else it could be; where nothing accounts for the
/// mismatch, the models that come nearest.
fn next(
    search: &Search<'_>,
    judged: &Judged,
    limits: &Limits,
) -> Result<Option<NextExperiment>, IdentifyError> {
    let unsure = judged.named.iter().filter(|named| !named.others.is_empty());
    let strongest = unsure.max_by(|a, b| a.contribution.total_cmp(&b.contribution));
    let mut rivals = match strongest {
        Some(named) => in_its_place(search, judged.effects, named),
        None if judged.verdict == Verdict::Unexplained => nearest(search, judged.effects),
        None => Vec::new(),
    };
    rivals.truncate(RIVALS);
    let Some(best) = rivals.first() else {
        return Ok(None);
    };
    let next = next_experiment(search.case, &rivals, limits, &best.node.noise)?;
    // Between models that are all far off, a run counts that parts them further than these recordings do.
    let tells_more = |next: &NextExperiment| {
        let run = next.run.as_ref();
        strongest.is_some() || run.is_some_and(|run| run.separation > FURTHER * run.separation_now)
    };
    Ok(next.filter(tells_more))
}

/// A model with a name, and those with what else it could be.
fn in_its_place<'a>(
    search: &'a Search<'_>,
    effects: CandidateSet,
    named: &Named,
) -> Vec<Rival<'a>> {
    let less = effects.without(named.effect);
    let others = named.others.iter().map(|(effect, _)| *effect);
    std::iter::once(named.effect)
        .chain(others)
        .filter_map(|effect| {
            let node = search.get(less.with(effect))?;
            Some(Rival { effect, node })
        })
        .collect()
}

/// The chosen model, or the most credible with effects, and the most credible others, each by an effect that the
/// first does not have.
fn nearest<'a>(search: &'a Search<'_>, chosen: CandidateSet) -> Vec<Rival<'a>> {
    let with_effects = |node: &&Node| search.admits(node) && !node.effects.is_empty();
    let mut nodes: Vec<&Node> = search.nodes().filter(with_effects).collect();
    let rank = |node: &Node| (node.effects == chosen, search.credit(node.effects));
    nodes.sort_by(|a, b| {
        let (a, b) = (rank(a), rank(b));
        b.0.cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    let own = |node: &Node, other: &Node| {
        let mut own = node.effects.iter();
        own.find(|&effect| !other.effects.contains(effect))
    };
    let Some((best, others)) = nodes.split_first() else {
        return Vec::new();
    };
    let mut rivals: Vec<Rival<'_>> = Vec::new();
    for &node in others {
        let (Some(of_best), Some(effect)) = (own(best, node), own(node, best)) else {
            continue;
        };
        if rivals.is_empty() {
            rivals.push(Rival {
                effect: of_best,
                node: best,
            });
        }
        if rivals.iter().all(|rival| rival.effect != effect) {
            rivals.push(Rival { effect, node });
        }
    }
    rivals
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

/// What is left after the chosen model.
fn remainder(
    search: &mut Search<'_>,
    judged: &Judged,
    plain: &Mismatch,
    at: (f64, u64),
) -> Result<Option<Remainder>, IdentifyError> {
    let mismatch = if judged.effects.is_empty() {
        plain.clone()
    } else {
        located(search, judged.effects, at, locate)?
    };
    let shape = match mismatch.block {
        Some((block, _)) => located(search, judged.effects, at, |located| {
            remainder_shape(located, block)
        })?,
        None => None,
    };
    let noise = at.0.powi(2);
    let of = |effects| search.get(effects).map_or(0.0, Node::mean_square) - noise;
    let (left, all) = (of(judged.effects), of(CandidateSet::EMPTY));
    Ok((left > 0.0 && all > 0.0).then(|| Remainder {
        rms: left.sqrt(),
        share: left / all,
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
        seed,
    }
}

/// The chosen model, fitted from many places and validated.
fn extended(
    search: &mut Search<'_>,
    effects: CandidateSet,
    unseen: &[Recording],
) -> Result<Option<ExtendedStage>, IdentifyError> {
    if effects.is_empty() {
        return Ok(None);
    }
    let fit = Arc::unwrap_or_clone(search.settle(effects)?.fit);
    let model = search.case.model(effects);
    let validated = validated(&model, &fit.point(0), unseen)?;
    Ok(Some(ExtendedStage {
        effects: effects.iter().collect(),
        model,
        stage: Stage { fit, validated },
    }))
}
