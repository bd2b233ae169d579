//! Parameters of the rod by fits with a loop of another family.

use identify::{Bounds, Fit, FittedParameter, IdentifyError, Scope, WienerModel};
use recording::Recording;

use crate::model::case::Case;
use crate::model::coarse::coarse;
use crate::search::families::{OtherBaseline, plain_fits, retain_one_of_each};
use crate::{LoopFamily, Setting};

/// Error over that of the paper's loop up to which a loop counts: of two that leave errors of one size neither is the rod's, and
/// either may be nearer to it.
const OF_ONE_SIZE: f64 = 2.0;

/// Starts of a fit, beside the place where the paper's loop ended.
const STARTS: u64 = 1;

/// A fit of the baseline model with a loop of another family.
#[derive(Debug, Clone)]
pub struct OtherLoop {
    /// Curves of its branches.
    pub family: LoopFamily,
    /// Where the fit ended.
    pub fit: Fit,
}

/// Fits of the baseline model with loops of the other families, the nearest of each, that leave errors of the size of that in `fit`, or
/// smaller ones; to as many samples as tell about as much as all.
///
/// # Errors
///
/// Errors of [`identify::fit`].
pub fn other_loops(
    base: &WienerModel,
    fit: &Fit,
    training: &[Recording],
    setting: Setting,
    seed: u64,
) -> Result<Vec<OtherLoop>, IdentifyError> {
    let few = coarse(base, fit, training)?;
    let case = Case::new(base, fit, &few, setting);
    let mut others = plain_fits(&case, STARTS, seed)?;
    retain_one_of_each(&mut others);
    Ok(others
        .into_iter()
        .filter(|other| other.fit.train_rmse <= OF_ONE_SIZE * fit.train_rmse)
        .map(|OtherBaseline { family, fit, .. }| OtherLoop { family, fit })
        .collect())
}

/// Widens the intervals of a fit to hold what loops of other families say: where recordings do not tell which family it is, they
/// do not tell its parameters any better. Values stay. Shapes of branches mean another thing in another family, and keep their
/// intervals.
pub fn carry_loop_shape(fit: &mut Fit, others: &[OtherLoop]) {
    for parameter in fit.parameters.iter_mut().filter(|one| is_common(one)) {
        let Some(own) = parameter.intervals[0] else {
            continue;
        };
        let theirs = others
            .iter()
            .filter_map(|other| other.fit.parameter(parameter.info.name));
        parameter.intervals[0] = Some(theirs.fold(own, hull_of));
    }
}

/// True if a parameter is of the rod or of the limiting loop, which all families have.
fn is_common(parameter: &FittedParameter) -> bool {
    parameter.info.scope == Scope::Shared
        && !matches!(parameter.info.name, "zeta" | "loop_spread_k")
}

/// An interval that holds another's, too; its value where it has none.
fn hull_of(hull: Bounds, other: &FittedParameter) -> Bounds {
    let value = other.values[0];
    let own = other.intervals[0].unwrap_or(Bounds {
        lower: value,
        upper: value,
    });
    Bounds {
        lower: hull.lower.min(own.lower),
        upper: hull.upper.max(own.upper),
    }
}
