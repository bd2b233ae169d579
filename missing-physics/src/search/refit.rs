//! From where a model with one effect more is fitted.

use identify::{ForwardModel, IdentifyError, ParameterVector};
use pso::Bound;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::model::case::{Case, Node};
use crate::model::elsewhere::is_drift;
use crate::model::tangent::of_partner;
use crate::screen::scores::{Score, sizes_of};
use crate::{ExtendedModel, Role, Sign};

/// Sizes, as shares of the typical one, between which a refit starts.
const START: [f64; 2] = [0.05, 2.0];

/// How far toward a bound a refit of one effect may start.
const FAR: f64 = 0.9;

/// Share of its range by which a parameter of the baseline is moved from a place to one nearby, either way.
const NEARBY: f64 = 0.05;

/// Places nearby from which a loop that jumps is fitted, too: no derivative tells of a jump, and one place alone often has one between
/// it and the minimum.
const BEYOND_JUMPS: usize = 4;

/// The model of a node with one effect more; `None` where no start leads anywhere.
pub(crate) fn refit(
    case: &Case<'_>,
    node: &Node,
    score: &Score,
    seed: u64,
) -> Result<Option<Node>, IdentifyError> {
    let effect = score.effect;
    let parameters = effect.info().parameters;
    let model = case.model(node.effects.with(effect));
    // Where the linear view points, and from a typical size: it is blind to what bends.
    let within = |most: [f64; 2]| -> Vec<f64> {
        sizes_of(effect)
            .zip(&score.sizes)
            .map(|(k, &size)| {
                let typical = parameters[k].typical;
                let [lower, upper] = parameters[k].bounds;
                // What cannot be negative starts small: from a bound there is no way.
                let size = match parameters[k].sign() {
                    Sign::NonNegative => size.max(0.0),
                    Sign::Either => size,
                };
                let magnitude = size.abs().clamp(most[0] * typical, most[1] * typical);
                magnitude.copysign(size).clamp(FAR * lower, FAR * upper)
            })
            .collect()
    };
    let first = within(START);
    let start = |sizes: &[f64], scale: f64| {
        case.moved(node, &model, |other, k| {
            let own = (other == effect).then_some(k)?;
            match parameters[own].role {
                Role::Size => sizes.get(own).map(|size| scale * size),
                Role::Partner { .. } => of_partner(effect, own, score.partner),
            }
        })
    };
    let mut starts = vec![start(&first, 1.0)];
    if score.partner.is_some() {
        starts.push(start(&first, 0.3));
    }
    let far = within([START[0], f64::INFINITY]);
    // A drift bends to whatever is there as the baseline does.
    let is_bare = node.effects.iter().all(is_drift);
    if is_bare && far != first {
        starts.push(start(&far, 1.0));
    }
    // A large size may have bent the baseline to where the linear view has the wrong sign.
    let sizes: Vec<usize> = sizes_of(effect).collect();
    if let (true, [k]) = (is_bare, &sizes[..])
        && parameters[*k].sign() == Sign::Either
    {
        let typical = parameters[*k].typical;
        let sizes = [typical, START[1] * typical].into_iter();
        starts.extend(sizes.flat_map(|size| [size, -size].map(|size| start(&[size], 1.0))));
    }
    let effects = node.effects.with(effect);
    let found = led(case.refined(node, effects, &starts))?;
    if !case.setting.loop_family.jumps() {
        return Ok(found);
    }
    // By themselves: in one race they would leave behind who is slower and ends lower.
    let nearby = places_nearby(case, &model, &starts[0], seed);
    let other = led(case.refined(node, effects, &nearby))?;
    Ok(lower(found, other))
}

/// The lower of two ends, with the simulations of both; of equal ones the first.
fn lower(first: Option<Node>, second: Option<Node>) -> Option<Node> {
    let (first, second) = match (first, second) {
        (Some(first), Some(second)) => (first, second),
        (first, second) => return first.or(second),
    };
    let is_second = second.noise.deviance() < first.noise.deviance();
    Some(Node {
        simulations: first.simulations + second.simulations,
        ..if is_second { second } else { first }
    })
}

/// Places of a model with the baseline nearby and effects as they are.
fn places_nearby(
    case: &Case<'_>,
    model: &ExtendedModel,
    from: &[f64],
    seed: u64,
) -> [Vec<f64>; BEYOND_JUMPS] {
    let vector = ParameterVector::new(model.parameters(), case.training.len());
    let bounds = vector.bounds();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    core::array::from_fn(|_| {
        let coordinates = from.iter().zip(&bounds).enumerate();
        let moved = coordinates.map(|(j, (&at, bound))| match model.slot(vector.parameter(j)) {
            None => nearby(at, bound, &mut rng).clamp(bound.lower, bound.upper),
            Some(_) => at,
        });
        moved.collect()
    })
}

/// A coordinate of the baseline near another.
pub(crate) fn nearby(at: f64, bound: &Bound, rng: &mut ChaCha8Rng) -> f64 {
    at + (bound.upper - bound.lower) * drawn(-NEARBY, NEARBY, rng)
}

/// A number between two others.
pub(crate) fn drawn(low: f64, high: f64, rng: &mut ChaCha8Rng) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

/// Where a search led, if anywhere: from some starts a simulation has no numbers, or the plant refuses its parameters. Any other
/// fault is one.
pub(crate) fn led<T>(ended: Result<T, IdentifyError>) -> Result<Option<T>, IdentifyError> {
    match ended {
        Ok(end) => Ok(Some(end)),
        Err(
            IdentifyError::NothingFinite | IdentifyError::Model(_) | IdentifyError::Simulation(_),
        ) => Ok(None),
        Err(fault) => Err(fault),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_that_leads_nowhere_is_none_and_one_that_is_stopped_stops() {
        assert!(led::<()>(Err(IdentifyError::NothingFinite)).is_ok_and(|end| end.is_none()));
        assert!(matches!(
            led::<()>(Err(IdentifyError::Stopped)),
            Err(IdentifyError::Stopped)
        ));
        assert!(led(Ok(1)).is_ok_and(|end| end == Some(1)));
    }
}
