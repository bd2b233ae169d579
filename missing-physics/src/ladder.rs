//! From the plain to the extended model, an effect at a time.

use identify::{IdentifyError, Validated, validate_at};
use recording::Recording;

use crate::CandidateSet;
use crate::case::Node;
use crate::diagnosis::{Rung, Stage};
use crate::elsewhere::without_drifts;
use crate::search::Search;

/// The effects of the extended model in the order in which each adds most to those before, with the errors with it; the
/// last has those of the extended model.
pub(crate) fn ladder(
    search: &mut Search<'_>,
    effects: CandidateSet,
    extended: &Stage,
    unseen: &[Recording],
) -> Result<Vec<Rung>, IdentifyError> {
    let mut rungs = Vec::new();
    let mut errors = (
        extended.fit.train_rmse,
        Validated::rmse_of_all(&extended.validated),
    );
    let mut set = effects;
    while !set.is_empty() {
        // What is left out first is missed least.
        let lesser = set.iter().filter_map(|effect| {
            let less = search.exchanged(set, effect, None)?;
            Some((effect, less, search.get(less)?.mean_square()))
        });
        let Some((effect, less, _)) = lesser.min_by(|a, b| a.2.total_cmp(&b.2)) else {
            break;
        };
        rungs.push(Rung {
            effect,
            train_rmse: errors.0,
            unseen_rmse: errors.1,
        });
        let Some(node) = search.get(less) else { break };
        errors = (node.mean_square().sqrt(), unseen_rmse(node, unseen)?);
        set = less;
    }
    rungs.reverse();
    Ok(rungs)
}

fn unseen_rmse(node: &Node, unseen: &[Recording]) -> Result<Option<f64>, IdentifyError> {
    let point = without_drifts(&node.model, &node.points[0]);
    let validated = unseen
        .iter()
        .map(|recording| validate_at(&node.model, &point, recording))
        .collect::<Result<Vec<Validated>, _>>()?;
    Ok(Validated::rmse_of_all(&validated))
}
