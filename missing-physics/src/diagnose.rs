//! From a rig and its recordings to a diagnosis.

use std::ops::ControlFlow;

use identify::{
    Fit, FitConfig, FitProgress, ForwardModel, IdentifyError, Limits, ParameterVector, Validated,
    WienerModel, fit, validate, validate_at,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use recording::Recording;

use crate::case::{Case, Node};
use crate::catalogue::{catalogue, finding};
use crate::diagnosis::{
    Diagnosis, ExtendedStage, Finding, Floor, Mismatch, NextExperiment, NoiseClass, Remainder,
    Stage, Verdict,
};
use crate::elsewhere::without_drifts;
use crate::explained::explained;
use crate::floor::{Measured, measured};
use crate::judge::{Judged, Named, judge, without_effects};
use crate::locate::{Located, locate, remainder_shape};
use crate::next_experiment::{Rival, next_experiment};
use crate::search::Search;
use crate::whiten::Whitener;
use crate::{EffectBlock, EffectSet, Role, Setting};

/// Places from which the final refit could start.
const PLACES: usize = 63;

/// Those of them from which a short search is made.
const SHORT_SEARCHES: usize = 15;

/// Those of them that are followed to the end.
const FOLLOWED: usize = 3;

/// Most explanations that a run is sought for.
const RIVALS: usize = 3;

/// Settings of a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagnoseConfig {
    /// What is known of the rig beyond its baseline.
    pub setting: Setting,
    /// Effects that may be found.
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

/// How far a diagnosis is.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    let plain = fit(base, training, &baseline_config, &mut |so_far| {
        progress(DiagnoseProgress::Baseline(*so_far));
        ControlFlow::Continue(())
    })?;
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
    let mut search = Search::new(&case, start, config.catalogue, noise.highest(), config.seed);
    search.grow()?;
    let judged = judge(&mut search, &noise, tau_s)?;
    let (judged, floor) = licensed(&search, judged, &noise);
    progress(DiagnoseProgress::Refit);
    let extended = extended(&case, &search, &judged, unseen, config.seed)?;
    progress(DiagnoseProgress::Locate);
    let written = |named: &[Named]| {
        let mut findings: Vec<Finding> = named
            .iter()
            .map(|named| finding(named, extended.as_ref()))
            .collect();
        findings.sort_by(|a, b| b.contribution.total_cmp(&a.contribution));
        findings
    };
    let (findings, suspects) = (written(&judged.named), written(&judged.suspects));
    let explained = extended
        .as_ref()
        .map(|extended| explained(&baseline, extended, &judged, unseen, &noise, base))
        .transpose()?;
    let catalogue = catalogue(&mut search, &judged)?;
    let at = (noise.gate.sqrt(), config.seed);
    let mut mismatch = located(&mut search, EffectSet::EMPTY, at, locate)?;
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
    let simulations = plain.simulations
        + search.simulations()
        + extended.as_ref().map_or(0, |one| one.stage.fit.simulations);
    Ok(Diagnosis {
        verdict: judged.verdict,
        noise_floor: floor,
        baseline,
        extended,
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

/// What the noise lets be said of what was judged, and the noise.
fn licensed(search: &Search<'_>, judged: Judged, noise: &Measured) -> (Judged, Floor) {
    let plain = search.baseline();
    let best = search.get(judged.effects).unwrap_or(plain);
    let floor = noise.floor(search.case, best);
    let gained = plain.mean_square() - best.mean_square();
    if judged.named.is_empty() || !noise.forbids(floor.class, gained) {
        return (judged, floor);
    }
    let verdict = without_effects(search, noise, false);
    (judged.demoted(verdict), floor)
}

/// A look at what a model that was visited leaves; `at` holds the noise's standard deviation and the seed.
fn located<T>(
    search: &mut Search<'_>,
    effects: EffectSet,
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

/// The run that would tell apart a name that is not sure and what else it could be.
fn next(
    search: &Search<'_>,
    judged: &Judged,
    limits: &Limits,
) -> Result<Option<NextExperiment>, IdentifyError> {
    let unsure = judged.named.iter().filter(|named| !named.others.is_empty());
    let strongest = unsure.max_by(|a, b| a.contribution.total_cmp(&b.contribution));
    let (Some(named), Some(best)) = (strongest, search.get(judged.effects)) else {
        return Ok(None);
    };
    let less = judged.effects.without(named.effect);
    let others = named.others.iter().filter_map(|&(effect, _)| {
        let node = search.get(less.with(effect))?;
        Some(Rival { effect, node })
    });
    let own = Rival {
        effect: named.effect,
        node: best,
    };
    let rivals: Vec<Rival<'_>> = std::iter::once(own).chain(others).take(RIVALS).collect();
    next_experiment(search.case, &rivals, limits, &best.noise)
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
    let (left, all) = (of(judged.effects), of(EffectSet::EMPTY));
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

/// The chosen model, refitted from many starts and validated.
fn extended(
    case: &Case<'_>,
    search: &Search<'_>,
    judged: &Judged,
    unseen: &[Recording],
    seed: u64,
) -> Result<Option<ExtendedStage>, IdentifyError> {
    let Some(node) = search
        .get(judged.effects)
        .filter(|node| !node.effects.is_empty())
    else {
        return Ok(None);
    };
    let from = best_starts(case, node, seed);
    let config = FitConfig {
        from,
        starts: 0,
        seed,
        ..FitConfig::default()
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let fit = fit(&node.model, case.training, &config, go_on)?;
    let point = without_drifts(&node.model, &fit.point(0));
    let validated = unseen
        .iter()
        .map(|recording| validate_at(&node.model, &point, recording))
        .collect::<Result<Vec<Validated>, _>>()?;
    Ok(Some(ExtendedStage {
        effects: node.effects.iter().collect(),
        model: node.model.clone(),
        stage: Stage { fit, validated },
    }))
}

/// Where a node stands, and the ends of short searches from elsewhere that got lowest.
fn best_starts(case: &Case<'_>, node: &Node, seed: u64) -> Vec<Vec<f64>> {
    let vector = ParameterVector::new(node.model.parameters(), case.training.len());
    let bounds = vector.bounds();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let starts: Vec<Vec<f64>> = (0..PLACES)
        .map(|_| {
            let drawn = |low: f64, high: f64, rng: &mut ChaCha8Rng| {
                low + (high - low) * rng.random::<f64>()
            };
            (0..node.coordinates.len())
                .map(|j| {
                    let (at, bound) = (node.coordinates[j], &bounds[j]);
                    let moved = match node.model.slot(vector.parameter(j)) {
                        None => {
                            let range = bound.upper - bound.lower;
                            at + range * drawn(-0.05, 0.05, &mut rng)
                        }
                        Some((effect, k)) => {
                            let parameter = &effect.info().parameters[k];
                            let [low, high] = parameter.bounds;
                            match parameter.role {
                                Role::Partner { .. } => drawn(low, high, &mut rng),
                                Role::Size => {
                                    let least = if low < 0.0 { -2.0 } else { 0.05 };
                                    parameter.typical * drawn(least, 2.0, &mut rng)
                                }
                            }
                        }
                    };
                    moved.clamp(bound.lower, bound.upper)
                })
                .collect()
        })
        .collect();
    let starts = lowest(case, node, &vector, starts);
    let mut ends: Vec<(f64, Vec<f64>)> = starts
        .par_iter()
        .filter_map(|start| {
            let end = case.approached(node.effects, start).ok()?;
            Some((end.mean_square, end.coordinates))
        })
        .collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best = vec![node.coordinates.clone()];
    best.extend(ends.into_iter().take(FOLLOWED - 1).map(|(_, end)| end));
    best
}

/// The places of the lowest error: as many as short searches are made.
fn lowest(
    case: &Case<'_>,
    node: &Node,
    vector: &ParameterVector,
    starts: Vec<Vec<f64>>,
) -> Vec<Vec<f64>> {
    let Ok(residuals) = case.residuals(&node.model, |r| {
        starts.iter().map(|start| vector.values(start, r)).collect()
    }) else {
        return starts.into_iter().take(SHORT_SEARCHES).collect();
    };
    let mut ranked: Vec<(f64, Vec<f64>)> = residuals.into_iter().zip(starts).collect();
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked
        .into_iter()
        .take(SHORT_SEARCHES)
        .map(|(_, start)| start)
        .collect()
}
