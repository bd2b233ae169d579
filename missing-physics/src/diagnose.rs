//! From a rig and its recordings to a diagnosis.

use std::ops::ControlFlow;
use std::sync::Arc;

use identify::{
    Fit, FitConfig, FitProgress, ForwardModel, IdentifyError, Limits, ParameterVector, Validated,
    WienerModel, fit, validate,
};
use recording::Recording;

use crate::attempt::{Attempt, Terms};
use crate::case::{Case, Node};
use crate::catalogue::{catalogue, finding};
use crate::diagnosis::{
    Diagnosis, Explained, ExtendedStage, Finding, Floor, Mismatch, NoiseClass, Remainder, Rung,
    Stage, Verdict,
};
use crate::elsewhere::{is_rigid, spread, validated};
use crate::explained::explained;
use crate::families::{self, Tried};
use crate::floor::{Measured, measured};
use crate::judge::{GATE, Judged};
use crate::ladder::ladder;
use crate::locate::{Located, locate, remainder_shape};
use crate::names::Named;
use crate::rivals::next;
use crate::search::Search;
use crate::watch::{Caller, Watched};
use crate::whiten::Whitener;
use crate::{CandidateSet, EffectBlock, EffectId, EffectSet, LoopFamily, Setting};

/// Share of the explainable error of the unseen recordings below which names that account for all do not hold there.
const HELD: f64 = 0.4;

/// Standard deviations up to which an error may be the parameters' uncertainty.
const TWICE: f64 = 2.0;

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
    /// Effects are being tried; told several times a second.
    Search {
        /// Points that were simulated so far, the baseline's not counted.
        simulations: u64,
    },
    /// The chosen model is being refitted from many starts.
    Refit,
    /// The mismatch is being located.
    Locate,
}

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
    let case = Case::new(base, &plain, training, config.setting).watched_by(caller);
    caller.tell(DiagnoseProgress::Search { simulations: 0 })?;
    let terms = Terms {
        noise: &noise,
        tau_s,
        catalogue: CandidateSet::all(config.catalogue, config.setting.hypotheses),
        seed: config.seed,
    };
    let mut papers = terms.begun(&case)?;
    papers.grow()?;
    let at = (noise.gate.sqrt(), config.seed);
    let mut mismatch = located(&mut papers, CandidateSet::EMPTY, at, locate)?;
    let explainable = papers.baseline().mean_square() - noise.gate;
    // Far from the noise a loop of another family may account for all at once: the long search waits.
    let mut judged = if papers.is_misfit() {
        None
    } else {
        Some(terms.judged(&mut papers)?)
    };
    let may_be = judged
        .as_ref()
        .is_none_or(|(judged, _)| judged.may_be_the_loop());
    let fits = if may_be && config.catalogue.contains(EffectId::LoopShape) {
        families::fits(&case, config.seed)?
    } else {
        Vec::new()
    };
    let cases = families::cases(&case, &fits);
    let Tried {
        mut attempts,
        mut simulations,
    } = families::tried(&cases, &papers, &terms)?;
    if judged.is_none() && !families::outdo(&attempts, &mut papers)? {
        judged = Some(terms.judged(&mut papers)?);
    }
    caller.tell(DiagnoseProgress::Refit)?;
    simulations += plain.simulations + papers.simulations();
    if let Some((judged, floor)) = judged {
        families::keep_ahead(&mut attempts, &papers, &judged);
        attempts.push(Attempt {
            search: papers,
            judged,
            floor,
        });
    }
    let Some(Settled {
        mut search,
        judged,
        floor,
        extended,
        explained,
    }) = settled(attempts, &baseline, unseen, &noise, base, &mut simulations)?
    else {
        unreachable!("where none outdoes it, the paper's loop is among them");
    };
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
    let (findings, suspects) = (written(&judged.named), written(&judged.suspects));
    let catalogue = catalogue(&mut search, &judged, config.seed)?;
    if !judged.named.is_empty() {
        mismatch.blocks = blocks_of(&judged.named);
        mismatch.block = mismatch.blocks.first().copied();
    }
    let has_remainder = matches!(
        judged.verdict,
        Verdict::ExplainedInPart | Verdict::Unexplained
    );
    let remainder = if has_remainder {
        remainder(&mut search, &judged, &mismatch, explainable, at)?
    } else {
        None
    };
    let next_experiment = next(&search, &judged, &config.limits)?;
    // Last: it may visit models that are no rivals.
    let ladder = ladder(&mut search, &baseline, extended.as_ref(), unseen)?;
    simulations += search.simulations();
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

/// What is said in the end.
struct Settled<'a> {
    search: Search<'a>,
    judged: Judged,
    floor: Floor,
    extended: Option<ExtendedStage>,
    explained: Option<Explained>,
}

/// The first of some attempts that holds on the unseen recordings; if none does, the last, without names. All are
/// counted in `simulations`; what is returned goes on, and no longer is.
fn settled<'a>(
    attempts: Vec<Attempt<'a>>,
    baseline: &Stage,
    unseen: &[Recording],
    noise: &Measured,
    base: &WienerModel,
    simulations: &mut u64,
) -> Result<Option<Settled<'a>>, IdentifyError> {
    let mut last: Option<Settled<'_>> = None;
    for mut attempt in attempts {
        *simulations += last.take().map_or(0, |last| last.search.simulations());
        *simulations -= attempt.search.simulations();
        let judged = attempt.judged;
        let extended = extended(&mut attempt.search, judged.effects, unseen)?;
        let explained = extended
            .as_ref()
            .map(|extended| explained(baseline, extended, &judged, unseen, noise, base))
            .transpose()?;
        let holds = holds(&judged, extended.as_ref(), explained.as_ref(), unseen)?;
        last = Some(Settled {
            search: attempt.search,
            judged: if holds {
                judged
            } else {
                judged.demoted(Verdict::Unexplained)
            },
            floor: attempt.floor,
            extended,
            explained,
        });
        if holds {
            break;
        }
    }
    Ok(last)
}

/// Whether names hold on the unseen recordings. Drifts and fatigue need not: they stay with their recording.
fn holds(
    judged: &Judged,
    extended: Option<&ExtendedStage>,
    explained: Option<&Explained>,
    unseen: &[Recording],
) -> Result<bool, IdentifyError> {
    let stays = |named: &Named| !is_rigid(named.effect);
    let fails = explained.is_some_and(|shares| {
        // Where hardly anything was to be explained the share says nothing.
        let interval = shares.validate_interval;
        let tells = interval.is_none_or(|[_, upper]| upper < GATE);
        shares.validate.is_some_and(|share| match judged.verdict {
            Verdict::ExplainedInPart => share < GATE,
            _ => share < HELD && tells,
        })
    });
    if !fails || judged.named.iter().any(stays) {
        return Ok(true);
    }
    extended.map_or(Ok(false), |extended| is_as_near(extended, unseen))
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

/// What is left after the chosen model.
fn remainder(
    search: &mut Search<'_>,
    judged: &Judged,
    plain: &Mismatch,
    all: f64,
    at: (f64, u64),
) -> Result<Option<Remainder>, IdentifyError> {
    let family = search.case.setting.loop_family;
    let mismatch = if judged.effects.is_empty() && family == LoopFamily::Proximity {
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
    let left = search.get(judged.effects).map_or(0.0, Node::mean_square) - noise;
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
    if effects.is_empty() && search.case.setting.loop_family == LoopFamily::Proximity {
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
