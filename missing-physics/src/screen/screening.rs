//! Which effects could explain what a fitted model leaves, before anything is refitted.

use std::sync::Arc;

use identify::{Fit, IdentifyError, WienerModel, in_parallel};
use recording::Recording;

use crate::model::case::{Case, Node};
use crate::model::projection::dot;
use crate::model::tangent::{
    LARGEST_SECANT, Sensitivity, Trace, secants_of, sensitivities, traces,
};
use crate::noise::whiten::Whitener;
use crate::screen::scores::{Ground, Score, Scores, scores};
use crate::{Candidate, CandidateSet, EffectSet, Need, Setting};

/// Standard normal quantiles of the power with which a size counts as detectable: 95 %.
pub(crate) const POWER: f64 = 1.645;

/// Cosine of two traces from which they are alike.
const ALIKE: f64 = 0.9;

/// Settings of a screening.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenConfig {
    /// Setting that all extended plants have in common.
    pub setting: Setting,
    /// Seed of the null distribution.
    pub seed: u64,
}

/// Result of screening for one effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Screened {
    /// The effect.
    pub effect: Candidate,
    /// Score in standard deviations, whitened by the residuals' own memory: that of its best value of the
    /// partner; of several sizes together, the score of one that is as unlikely. It hides large effects,
    /// whose trace is part of that memory.
    pub whitened: f64,
    /// Score in standard deviations, of the series as they are, with the variance of correlated residuals.
    pub plain: f64,
    /// Size to first order, in the unit of its parameter: of several, the first.
    pub size: f64,
    /// Smallest size that this recording would show in 95 % of cases.
    pub minimum_detectable: f64,
    /// Share of its trace's square that refitting the baseline hides.
    pub absorbed: f64,
    /// Value of its partner at which it scores best.
    pub partner: Option<f64>,
    /// Other effects whose traces here, freed of what refitting hides, point the same way: cosine above 0.9.
    pub alike: Vec<Candidate>,
}

/// Scores of all effects that can be computed for a rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Screening {
    /// In the order of the catalogue.
    pub effects: Vec<Screened>,
    /// Effects that need what is not known of the rig, and what that is.
    pub unknown: Vec<(Candidate, Need)>,
    /// Whitened score that noise alone exceeds in 5 % of files, the number of effects counted.
    pub critical: f64,
}

/// Screens the catalogue at a fitted baseline.
///
/// Each effect's secant is freed of what the baseline's own parameters could
/// do, and compared with what is left of the recording (score test, DIAGNOSIS 2.5). Nothing is refitted: a
/// score is a reason to refit, never a name.
///
/// # Errors
///
/// Any error of simulating the models.
pub fn screen(
    base: &WienerModel,
    fit: &Fit,
    training: &[Recording],
    config: &ScreenConfig,
) -> Result<Screening, IdentifyError> {
    let case = Case::new(base, fit, training, config.setting);
    let node = case.baseline()?;
    let all = CandidateSet::all(EffectSet::all(), config.setting.hypotheses);
    let sifted = sift(&case, &node, all, config.seed)?;
    let at_their_sizes = at_their_sizes(&case, &node, &sifted, config.seed)?;
    let pairs = sifted.found.scores.iter().zip(&at_their_sizes);
    let screened = pairs.map(|(score, at_its_size)| Screened {
        effect: score.effect,
        whitened: score.whitened,
        plain: score.plain,
        size: score.sizes[0],
        minimum_detectable: (sifted.found.critical + POWER) * at_its_size.errors[0],
        absorbed: score.absorbed,
        partner: score.partner,
        alike: sifted
            .found
            .scores
            .iter()
            .filter(|other| other.effect != score.effect)
            .filter(|other| dot(&other.direction, &score.direction).abs() > ALIKE)
            .map(|other| other.effect)
            .collect(),
    });
    Ok(Screening {
        effects: screened.collect(),
        unknown: all
            .iter()
            .filter_map(|effect| Some((effect, case.missing(effect)?)))
            .collect(),
        critical: sifted.found.critical,
    })
}

/// A node with the scores of what it does not have.
#[derive(Debug)]
pub(crate) struct Sifted {
    pub(crate) found: Scores,
    pub(crate) sensitivities: Arc<[Sensitivity]>,
}

/// Scores the effects of a set that a node does not have and that can be computed.
pub(crate) fn sift(
    case: &Case<'_>,
    node: &Node,
    catalogue: CandidateSet,
    seed: u64,
) -> Result<Sifted, IdentifyError> {
    let wanted: Vec<Candidate> = catalogue
        .iter()
        .filter(|&effect| !node.effects.contains(effect) && case.missing(effect).is_none())
        .collect();
    let traces = in_parallel(&wanted, |&effect| {
        traces(case, node, effect, secants_of(case, effect), None)
    });
    let traces = traces
        .into_iter()
        .collect::<Result<Vec<Vec<Trace>>, _>>()?
        .concat();
    let sensitivities = sensitivities(case, node)?;
    Ok(Sifted {
        found: scored(case, node, &sensitivities, &traces, seed),
        sensitivities: sensitivities.into(),
    })
}

fn scored(
    case: &Case<'_>,
    node: &Node,
    sensitivities: &[Sensitivity],
    traces: &[Trace],
    seed: u64,
) -> Scores {
    let fitted: Vec<&Vec<f64>> = sensitivities
        .iter()
        .filter(|one| !one.held)
        .map(|one| &one.column)
        .collect();
    let ground = Ground {
        residual: &node.residual,
        fitted: &fitted,
        whitener: &Whitener::new(&case.layout, &node.noise),
    };
    scores(traces, &ground, seed)
}

/// The scores of a node with secants at the sizes that count as detectable: a size far below that of the screening's
/// secants may be hidden where they are not.
pub(crate) fn at_their_sizes(
    case: &Case<'_>,
    node: &Node,
    sifted: &Sifted,
    seed: u64,
) -> Result<Vec<Score>, IdentifyError> {
    /// Rounds until size and secant agree.
    const ROUNDS: usize = 3;
    /// They agree within this factor.
    const NEAR: f64 = 2.0;
    /// Smallest share of the typical size: below, differences are rounding.
    const SMALLEST: f64 = 1e-4;
    let critical = sifted.found.critical;
    let mut scores = sifted.found.scores.clone();
    for _ in 0..ROUNDS {
        let share = |score: &Score| {
            let size = (critical + POWER) * score.errors[0];
            let wanted = (size / score.effect.info().parameters[0].typical).max(SMALLEST);
            (wanted * NEAR < score.share
                || wanted > NEAR * score.share && score.share < LARGEST_SECANT)
                .then_some(wanted.min(LARGEST_SECANT))
        };
        let moved: Vec<(usize, f64)> = (0..scores.len())
            .filter_map(|k| Some((k, share(&scores[k])?)))
            .collect();
        if moved.is_empty() {
            break;
        }
        let traces = in_parallel(&moved, |&(k, share)| {
            let score = &scores[k];
            traces(case, node, score.effect, &[share], score.partner)
        });
        let traces = traces
            .into_iter()
            .collect::<Result<Vec<Vec<Trace>>, _>>()?
            .concat();
        let found = scored(case, node, &sifted.sensitivities, &traces, seed).scores;
        for ((k, _), score) in moved.into_iter().zip(found) {
            scores[k] = score;
        }
    }
    Ok(scores)
}
