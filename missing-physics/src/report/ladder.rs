//! From the plain to the extended model, an effect at a time.

use identify::{IdentifyError, Validated};
use recording::Recording;

use crate::model::elsewhere::validated;
use crate::report::diagnosis::{ExtendedStage, Rung, Stage};
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet, LoopFamily};

impl Rung {
    fn new(added: CandidateSet, train_rmse: f64, unseen: &[Validated]) -> Self {
        Self {
            added: added.iter().collect(),
            train_rmse,
            unseen_rmse: Validated::rmse_of_all(unseen),
        }
    }

    /// The plain model.
    pub(crate) fn plain(stage: &Stage) -> Self {
        Self::new(CandidateSet::EMPTY, stage.fit.train_rmse, &stage.validated)
    }
}

/// The plain model, and the effects of the extended one in the order in which each adds most to those before.
pub(crate) fn ladder(
    search: &mut Search<'_>,
    plain: &Stage,
    extended: Option<&ExtendedStage>,
    unseen: &[Recording],
) -> Result<Vec<Rung>, IdentifyError> {
    let mut rungs = Vec::new();
    if let Some(extended) = extended {
        let effects: CandidateSet = extended.effects.iter().copied().collect();
        let mut set = effects;
        while !set.is_empty() {
            // What is left out first is missed least; where nothing can be, the rest came together.
            let mut lesser = Vec::new();
            for effect in set.iter() {
                let less = search.exchanged(set, effect, None)?;
                let left = less.and_then(|less| Some((less, search.get(less)?.mean_square())));
                lesser.extend(left);
            }
            let least = lesser.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
            let less = least.map_or(CandidateSet::EMPTY, |(less, _)| less);
            let added = set.iter().filter(|&one| !less.contains(one)).collect();
            rungs.push(match search.get(set) {
                Some(node) if set != effects => {
                    let unseen = validated(&node.model, &node.points[0], unseen)?;
                    Rung::new(added, node.mean_square().sqrt(), &unseen)
                }
                _ => {
                    let stage = &extended.stage;
                    Rung::new(added, stage.fit.train_rmse, &stage.validated)
                }
            });
            set = less;
        }
    }
    let of_family = search.baseline();
    if of_family.model.loop_family() != LoopFamily::Proximity {
        let unseen = validated(&of_family.model, &of_family.points[0], unseen)?;
        let rmse = of_family.mean_square().sqrt();
        let shape = CandidateSet::of(Candidate::other_loop());
        rungs.push(Rung::new(shape, rmse, &unseen));
    }
    rungs.push(Rung::plain(plain));
    rungs.reverse();
    Ok(rungs)
}
