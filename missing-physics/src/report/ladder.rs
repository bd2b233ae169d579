//! From the plain to the extended model, an effect at a time.

use identify::{IdentifyError, Validated, try_in_parallel};
use recording::Recording;

use crate::model::case::{Case, Node};
use crate::model::elsewhere::predicted;
use crate::model::unseen::validated_by;
use crate::report::diagnosis::{ExtendedStage, Rung, Stage};
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, LoopFamily};

/// All samples of the training, the recordings that were not used, and those of them on which models are judged.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Samples<'a> {
    pub(crate) training: &'a [Recording],
    pub(crate) unseen: [&'a [Recording]; 2],
}

impl Rung {
    /// A model of a search where it stands, on all samples.
    fn of_node(
        added: CandidateSet,
        (case, node): (&Case<'_>, &Node),
        samples: Samples<'_>,
    ) -> Result<Self, IdentifyError> {
        let train_square = match case.whole(samples.training) {
            Some(whole) => whole.stands(node)?.mean_square(),
            None => node.mean_square(),
        };
        let point = &node.points[0];
        let weight = case.temperature_weight(node).unwrap_or(0.0);
        let (validated, _) = validated_by(&node.model, (point, weight), samples.unseen)?;
        Ok(Self {
            added: added.iter().collect(),
            train_rmse: train_square.sqrt(),
            predicted_rmse: predicted(&node.model, point, samples.unseen[0])?,
            unseen_rmse: Validated::rmse_of_all(&validated),
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
    samples: Samples<'_>,
) -> Result<Vec<Rung>, IdentifyError> {
    let of_extended = extended.map(|extended| {
        let effects: CandidateSet = extended.effects.iter().copied().collect();
        (effects, &extended.stage)
    });
    // What each model adds, and its effects.
    let mut steps: Vec<(CandidateSet, CandidateSet)> = Vec::new();
    if let Some((mut set, _)) = of_extended {
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
            steps.push((added, set));
            set = less;
        }
    }
    if search.case.setting.loop_family != LoopFamily::Proximity {
        let shape = CandidateSet::of(Candidate::other_loop());
        steps.push((shape, CandidateSet::EMPTY));
    }
    let search = &*search;
    let mut rungs = try_in_parallel(&steps, |&(added, set)| match of_extended {
        Some((effects, stage)) if set == effects => Ok(Rung::of_stage(added, stage)),
        _ => {
            let node = search.get(set).unwrap_or(search.baseline());
            Rung::of_node(added, (search.case, node), samples)
        }
    })?;
    rungs.push(Rung::plain(plain));
    rungs.reverse();
    Ok(rungs)
}
