//! Rivals of an effect: candidates that could stand in its place.

use identify::IdentifyError;

use crate::model::projection::dot;
use crate::screen::scores::Score;
use crate::search::roads::Search;
use crate::{Candidate, CandidateSet};

/// Cosine of two traces from which they could be one another's names.
pub(crate) const ALIKE: f64 = 0.5;

/// Scores of what could stand in the place of an effect, with the cosines of their traces with its own.
pub(crate) fn rivals(
    search: &mut Search<'_>,
    effects: CandidateSet,
    effect: Candidate,
) -> Result<Vec<(Score, f64)>, IdentifyError> {
    let Some(less) = search.without(effects, effect)? else {
        return Ok(Vec::new());
    };
    let sifted = search.sifted(less)?;
    let own = sifted
        .found
        .scores
        .iter()
        .find(|score| score.effect == effect);
    let direction = own.map(|own| own.direction.clone()).unwrap_or_default();
    Ok(sifted
        .found
        .scores
        .iter()
        .filter(|score| !effects.contains(score.effect))
        .map(|score| (score.clone(), dot(&score.direction, &direction).abs()))
        .collect())
}
