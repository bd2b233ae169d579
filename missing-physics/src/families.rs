//! Loops of other families, where no effect beside the paper's loop accounts for the mismatch.

use std::ops::ControlFlow;

use identify::{Fit, FitConfig, ForwardModel, IdentifyError, ParameterVector, fit};

use crate::attempt::{Attempt, Terms};
use crate::case::{Case, Node};
use crate::choice::visited;
use crate::credit::{BEYOND_DOUBT_NATS, OUTDONE};
use crate::diagnosis::Verdict;
use crate::judge::{GATE, Judged};
use crate::names::{Named, OF_FLEXIBLE};
use crate::prune::OWN_SHARE;
use crate::search::Search;
use crate::{CandidateSet, EffectId, LoopFamily};

/// Families beside the paper's.
const OTHERS: [LoopFamily; 2] = [LoopFamily::Relays, LoopFamily::Kinetics];

/// Starts of the fit of a plain model of another family, beside the place where the paper's ended.
const STARTS: u64 = 4;

/// Error of a plain model over that of the nearest family's up to which a family is tried, too.
const NEARLY: f64 = 2.0;

/// Plain models of the families that come nearer than the paper's, the nearest first.
pub(crate) fn fits(case: &Case<'_>, seed: u64) -> Result<Vec<(LoopFamily, Fit)>, IdentifyError> {
    let fitted = OTHERS.into_iter().map(|family| {
        let model = case.of_family(family, case.fit).model(CandidateSet::EMPTY);
        let vector = ParameterVector::new(model.parameters(), case.training.len());
        let config = FitConfig {
            from: vec![case.fit.coordinates(&vector)],
            starts: STARTS,
            seed,
            ..FitConfig::default()
        };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        Ok((
            family,
            fit(&case.watched(&model), case.training, &config, go_on)?,
        ))
    });
    let mut fits = fitted.collect::<Result<Vec<_>, IdentifyError>>()?;
    fits.sort_by(|(_, a), (_, b)| a.train_rmse.total_cmp(&b.train_rmse));
    let nearest = fits[0].1.train_rmse;
    let most = (NEARLY * nearest).min(case.fit.train_rmse);
    fits.retain(|(_, fit)| fit.train_rmse < most);
    Ok(fits)
}

/// The rig with each of these loops.
pub(crate) fn cases<'a>(case: &Case<'a>, fits: &'a [(LoopFamily, Fit)]) -> Vec<Case<'a>> {
    fits.iter()
        .map(|(family, fit)| case.of_family(*family, fit))
        .collect()
}

/// What was tried with other families.
#[derive(Debug)]
pub(crate) struct Tried<'a> {
    /// What speaks for itself, the most credible first.
    pub(crate) attempts: Vec<Attempt<'a>>,
    pub(crate) simulations: u64,
}

/// Searches with each of these loops, until one explains all.
pub(crate) fn tried<'a>(
    cases: &'a [Case<'a>],
    papers: &Search<'_>,
    terms: &Terms<'_>,
) -> Result<Tried<'a>, IdentifyError> {
    let rigid = terms.catalogue.without(EffectId::LoopShape);
    let terms = Terms {
        catalogue: rigid,
        ..*terms
    };
    let mut simulations: u64 = cases.iter().map(|case| case.fit.simulations).sum();
    let mut attempts = Vec::new();
    let begun = cases.iter().map(|case| terms.begun(case));
    let mut begun = begun.collect::<Result<Vec<_>, _>>()?;
    // What comes nearest with one effect is the likeliest to explain all.
    begun.sort_by(|a, b| least(a).total_cmp(&least(b)));
    let mut begun = begun.into_iter();
    for mut search in begun.by_ref() {
        search.grow()?;
        // Far from the noise, and no nearer than with the paper's loop: the long search would be as vain.
        let is_vain = search.is_misfit() && OUTDONE * least(&search) > least(papers);
        let judged = if is_vain {
            None
        } else {
            let (judged, floor) = terms.judged(&mut search)?;
            let judged = with_loop(&search, judged, papers, &terms)?;
            judged.map(|judged| (judged, floor))
        };
        simulations += search.simulations();
        let Some((judged, floor)) = judged else {
            continue;
        };
        let is_explained = judged.verdict == Verdict::Explained;
        attempts.push(Attempt {
            search,
            judged,
            floor,
        });
        if is_explained {
            break;
        }
    }
    simulations += begun.map(|search| search.simulations()).sum::<u64>();
    attempts.sort_by(|a, b| worth(papers, b.chosen()).total_cmp(&worth(papers, a.chosen())));
    Ok(Tried {
        attempts,
        simulations,
    })
}

/// Whether a loop of another family leaves so much less than any model with the paper's that this need not be followed.
pub(crate) fn outdo(
    attempts: &[Attempt<'_>],
    papers: &mut Search<'_>,
) -> Result<bool, IdentifyError> {
    let Some(best) = attempts.first().map(|one| one.chosen().mean_square()) else {
        return Ok(false);
    };
    if OUTDONE * best < least(papers) {
        // The other was fitted from many places.
        papers.settle(papers.nearest().effects)?;
    }
    Ok(OUTDONE * best < least(papers))
}

/// Mean square of what the nearest model of a search leaves.
fn least(search: &Search<'_>) -> f64 {
    search.nearest().mean_square()
}

/// Leaves those attempts that are far more credible than names beside the paper's loop.
pub(crate) fn keep_ahead(attempts: &mut Vec<Attempt<'_>>, papers: &Search<'_>, judged: &Judged) {
    let least = match papers.get(judged.effects) {
        Some(node) if !judged.named.is_empty() => worth(papers, node) + BEYOND_DOUBT_NATS,
        _ => f64::NEG_INFINITY,
    };
    attempts.retain(|attempt| worth(papers, attempt.chosen()) > least);
}

/// What the search with another loop came to, with the loop itself among the names; `None` if the loop does not account for the
/// mismatch either, or is not needed.
fn with_loop(
    search: &Search<'_>,
    judged: Judged,
    papers: &Search<'_>,
    terms: &Terms<'_>,
) -> Result<Option<Judged>, IdentifyError> {
    let chosen = visited(search, judged.effects);
    // The paper's loop beside the same effects, from where this one stands.
    let model = papers.case.model(judged.effects);
    let start = papers.case.moved(chosen, &model, |_, _| None);
    let refined = papers
        .case
        .refined(papers.baseline(), judged.effects, &[start])?;
    let known = papers.get(judged.effects).map(Node::mean_square);
    let without = refined.mean_square().min(known.unwrap_or(f64::INFINITY));
    let noise = terms.noise.gate;
    let explainable = papers.baseline().mean_square() - noise;
    let contribution = (without - chosen.mean_square()) / explainable;
    let gained = 0.5 * n_independent(papers) * (without / chosen.mean_square()).ln();
    let left = ((search.baseline().mean_square() - noise) / explainable).clamp(0.0, 1.0);
    let by_loop = 1.0 - left;
    let verdict = match judged.verdict {
        Verdict::Adequate => Verdict::Explained,
        Verdict::Unexplained if by_loop < GATE => return Ok(None),
        Verdict::Unexplained => Verdict::ExplainedInPart,
        verdict => verdict,
    };
    if contribution < OWN_SHARE || gained < BEYOND_DOUBT_NATS {
        return Ok(None);
    }
    let rescaled = |named: Vec<Named>| {
        let named = named.into_iter();
        named.map(|named| Named {
            contribution: left * named.contribution,
            ..named
        })
    };
    let own = Named {
        effect: EffectId::LoopShape.into(),
        others: Vec::new(),
        probability: OF_FLEXIBLE,
        contribution,
    };
    Ok(Some(Judged {
        verdict,
        named: rescaled(judged.named).chain([own]).collect(),
        suspects: rescaled(judged.suspects).collect(),
        explained: Some(by_loop + left * judged.explained.unwrap_or(0.0)),
        ..judged
    }))
}

/// Log-likelihood of a model with Schwarz's price of its parameters, by as many samples as are independent in what the
/// paper's plain model leaves: comparable among families.
fn worth(papers: &Search<'_>, node: &Node) -> f64 {
    let n = n_independent(papers);
    -0.5 * (n * node.mean_square().ln() + node.n_free() as f64 * n.ln())
}

fn n_independent(papers: &Search<'_>) -> f64 {
    papers.baseline().noise.n_effective().max(1.0)
}
