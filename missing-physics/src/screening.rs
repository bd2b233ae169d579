//! Which effects could explain what a fitted model leaves, before anything is refitted.

use std::sync::Arc;

use identify::{Fit, IdentifyError, WienerModel};
use rayon::prelude::*;
use recording::Recording;

use crate::case::{Case, Node};
use crate::projection::dot;
use crate::scores::{Ground, Scores, scores};
use crate::tangent::{Sensitivity, Trace, sensitivities, traces};
use crate::whiten::Whitener;
use crate::{Candidate, CandidateSet, EffectSet, Need, Setting};

/// Standard normal quantiles of the power with which a size counts as detectable: 95 %.
pub(crate) const POWER: f64 = 1.645;

/// Cosine of two traces from which they are alike.
const ALIKE: f64 = 0.9;

/// Settings of a screening.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenConfig {
    /// What all extended plants have in common.
    pub setting: Setting,
    /// Seed of the null distribution.
    pub seed: u64,
}

/// What screening says of one effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Screened {
    /// The effect.
    pub effect: Candidate,
    /// Score in standard deviations, whitened by the residuals' own memory: that of its best value of the
    /// partner; of several sizes together, the score of one that is as unlikely. It hides large effects,
    /// whose trace is part of that memory.
    pub whitened: f64,
    /// The same of the series as they are, with the variance of correlated residuals.
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
/// Each effect's secant at a quarter of its typical size is freed of what the baseline's own parameters could
/// do, and compared with what is left of the recording (score test, DIAGNOSIS 2.5). Nothing is refitted: a
/// score is a reason to refit, never a name.
///
/// # Errors
///
/// What the models refuse.
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
    let screened = sifted.found.scores.iter().map(|score| Screened {
        effect: score.effect,
        whitened: score.whitened,
        plain: score.plain,
        size: score.sizes[0],
        minimum_detectable: (sifted.found.critical + POWER) * score.errors[0],
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
    let traces: Vec<Trace> = wanted
        .par_iter()
        .map(|&effect| traces(case, node, effect))
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .flatten()
        .collect();
    let sensitivities = sensitivities(case, node)?;
    let fitted: Vec<&Vec<f64>> = sensitivities
        .iter()
        .filter(|one| !one.held)
        .map(|one| &one.column)
        .collect();
    let whitener = Whitener::new(&case.layout, &node.noise);
    let ground = Ground {
        residual: &node.residual,
        fitted: &fitted,
        whitener: &whitener,
    };
    let found = scores(&traces, &ground, seed);
    Ok(Sifted {
        found,
        sensitivities: sensitivities.into(),
    })
}
