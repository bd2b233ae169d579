//! From the plain to the extended model, an effect at a time.

use identify::{IdentifyError, Validated};

use crate::model::case::Node;
use crate::model::elsewhere::predicted;
use crate::model::unseen::Unseen;
use crate::report::diagnosis::{ExtendedStage, Rung, Stage};
use crate::report::errors::Errors;
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, LoopFamily};

/// Mean squares of what lies between the samples on which models are judged: noise, which all models leave alike. 0 where all samples
/// are judged.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Between {
    pub(crate) training: f64,
    pub(crate) unseen: f64,
}

impl Between {
    /// By the baseline model: its errors on all samples, and those where it stands on the judged ones.
    pub(crate) fn of(plain: &Stage, judged: &Node, judged_unseen: &Unseen) -> Self {
        let unseen = Validated::rmse_of_all(&plain.validated).zip(judged_unseen.mean_square());
        Self {
            training: plain.fit.train_rmse.powi(2) - judged.mean_square(),
            unseen: unseen.map_or(0.0, |(all, judged)| all.powi(2) - judged),
        }
    }
}

impl Rung {
    fn of_node(
        added: CandidateSet,
        node: &Node,
        errors: &mut Errors<'_>,
        between: Between,
    ) -> Result<Self, IdentifyError> {
        let of_unseen = |square: f64| (square + between.unseen).max(0.0).sqrt();
        let predicted = predicted(&node.model, &node.points[0], errors.recordings)?;
        Ok(Self {
            added: added.iter().collect(),
            train_rmse: (node.mean_square() + between.training).max(0.0).sqrt(),
            predicted_rmse: predicted.map(|rmse| of_unseen(rmse.powi(2))),
            unseen_rmse: errors.of(node)?.mean_square().map(of_unseen),
        })
    }

    fn of_stage(added: CandidateSet, stage: &Stage) -> Self {
        Self {
            added: added.iter().collect(),
            train_rmse: stage.fit.train_rmse,
            predicted_rmse: stage.predicted_rmse,
            unseen_rmse: Validated::rmse_of_all(&stage.validated),
        }
    }

    /// The baseline model.
    pub(crate) fn plain(stage: &Stage) -> Self {
        Self::of_stage(CandidateSet::EMPTY, stage)
    }
}

/// The baseline model, and the effects of the extended one in the order in which each adds most to those before.
pub(crate) fn ladder(
    search: &mut Search<'_>,
    plain: &Stage,
    extended: Option<&ExtendedStage>,
    (errors, between): (&mut Errors<'_>, Between),
) -> Result<Vec<Rung>, IdentifyError> {
    let mut rungs = Vec::new();
    if let Some(extended) = extended {
        let effects: CandidateSet = extended.effects.iter().copied().collect();
        let mut set = effects;
        while !set.is_empty() {
            // What is left out first is missed least; where nothing can be, the rest came together.
            let mut lesser = Vec::new();
            for effect in set.iter() {
                let less = search.without(set, effect)?;
                let left = less.and_then(|less| Some((less, search.get(less)?.mean_square())));
                lesser.extend(left);
            }
            let least = lesser.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
            let less = least.map_or(CandidateSet::EMPTY, |(less, _)| less);
            let added = set.iter().filter(|&one| !less.contains(one)).collect();
            rungs.push(match search.get(set) {
                Some(node) if set != effects => Rung::of_node(added, node, errors, between)?,
                _ => Rung::of_stage(added, &extended.stage),
            });
            set = less;
        }
    }
    let of_family = search.baseline();
    if of_family.model.loop_family() != LoopFamily::Proximity {
        let shape = CandidateSet::of(Candidate::other_loop());
        rungs.push(Rung::of_node(shape, of_family, errors, between)?);
    }
    rungs.push(Rung::plain(plain));
    rungs.reverse();
    Ok(rungs)
}
