//! From the plain to the extended model, an effect at a time.

use identify::{IdentifyError, Validated};

use crate::model::case::Node;
use crate::model::elsewhere::predicted;
use crate::report::diagnosis::{ExtendedStage, Rung, Stage};
use crate::report::errors::Errors;
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, LoopFamily};

impl Rung {
    fn of_node(
        added: CandidateSet,
        node: &Node,
        errors: &mut Errors<'_>,
    ) -> Result<Self, IdentifyError> {
        Ok(Self {
            added: added.iter().collect(),
            train_rmse: node.mean_square().sqrt(),
            predicted_rmse: predicted(&node.model, &node.points[0], errors.recordings)?,
            unseen_rmse: errors.of(node)?.mean_square().map(f64::sqrt),
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
    errors: &mut Errors<'_>,
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
                Some(node) if set != effects => Rung::of_node(added, node, errors)?,
                _ => Rung::of_stage(added, &extended.stage),
            });
            set = less;
        }
    }
    let of_family = search.baseline();
    if of_family.model.loop_family() != LoopFamily::Proximity {
        let shape = CandidateSet::of(Candidate::other_loop());
        rungs.push(Rung::of_node(shape, of_family, errors)?);
    }
    rungs.push(Rung::plain(plain));
    rungs.reverse();
    Ok(rungs)
}
