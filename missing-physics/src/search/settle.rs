//! A chosen model at the lowest of the ends of searches from many places.

use std::ops::ControlFlow;

use identify::{Fit, FitConfig, ForwardModel, IdentifyError, ParameterVector, fit, in_parallel};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use recording::order::rising;

use crate::model::case::{Case, Node};
use crate::model::elsewhere::is_drift;
use crate::search::refit::{drawn, led, nearby};
use crate::{Role, Sign};

/// Places from which a search could start.
const PLACES: usize = 63;

/// Those of them from which a search is made: with where the model stands, sixteen.
const SEARCHES: usize = 15;

/// Iterations of these searches, round by round, and how many of them go on.
const RACE: [(usize, usize); 2] = [(3, 5), (6, 2)];

/// Iterations in which the other parameters follow a size that was turned around.
const TURNED: usize = 12;

/// Deviance a sample by which the end of a race may be behind to be followed: a mean square 1 % larger.
const BEHIND: f64 = 0.01;

/// How low a place lies, and its coordinates.
type End = (f64, Vec<f64>);

/// Sizes, as multiples of the typical one: up to, and from where there is no other sign.
const SIZES: [f64; 2] = [0.05, 2.0];

/// The fit of a node's model from where it stands, from the lowest ends of short searches from other places (of one that is
/// costly, with its signs turned around only), and from as many swarms.
pub(crate) fn settled(
    case: &Case<'_>,
    node: &Node,
    swarms: u64,
    seed: u64,
    is_costly: bool,
) -> Result<Fit, IdentifyError> {
    let vector = ParameterVector::new(node.model.parameters(), case.training.len());
    let mut ends = if is_costly {
        Vec::new()
    } else {
        lowest(case, node, &vector, places(node, &vector, seed))?
    };
    ends.extend(raced(case, node, &mirrored(node, &vector), TURNED)?);
    for (iterations, followed) in RACE {
        ends = raced(case, node, &ends, iterations)?;
        ends.truncate(followed);
    }
    let near = case.deviance(node) + BEHIND * case.layout.len() as f64;
    let ends = ends.into_iter().filter(|(deviance, _)| *deviance < near);
    let config = FitConfig {
        from: std::iter::once(node.coordinates.clone())
            .chain(ends.map(|(_, end)| end))
            .collect(),
        starts: swarms,
        ..case.fit_config_at(node, seed)
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    fit(&case.watched(&node.model), case.training, &config, go_on)
}

/// The fit of a node's model from where it stands.
pub(crate) fn fitted(case: &Case<'_>, node: &Node, seed: u64) -> Result<Fit, IdentifyError> {
    let config = FitConfig {
        from: vec![node.coordinates.clone()],
        starts: 0,
        ..case.fit_config_at(node, seed)
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    fit(&case.watched(&node.model), case.training, &config, go_on)
}

/// Where a model stands, with each size that has two signs at its opposite, and at a typical one: around the wrong
/// sign the others may have found a minimum. Values of a drift keep their signs: neighbors form one curve.
fn mirrored(node: &Node, vector: &ParameterVector) -> Vec<End> {
    let bounds = vector.bounds();
    let signed = (0..node.coordinates.len()).filter_map(|j| {
        let (effect, k) = node.model.slot(vector.parameter(j))?;
        let parameter = &effect.info().parameters[k];
        let has_signs = parameter.role == Role::Size && parameter.sign() == Sign::Either;
        let is_signed = has_signs && !is_drift(effect);
        is_signed.then_some((j, parameter.typical))
    });
    let opposite = |(j, typical): (usize, f64)| {
        let at = node.coordinates[j];
        [-at, typical.copysign(-at)].map(|size| {
            let mut coordinates = node.coordinates.clone();
            coordinates[j] = size.clamp(bounds[j].lower, bounds[j].upper);
            (f64::INFINITY, coordinates)
        })
    };
    signed.flat_map(opposite).collect()
}

/// The ends of some searches, the lowest first.
fn raced(
    case: &Case<'_>,
    node: &Node,
    starts: &[End],
    iterations: usize,
) -> Result<Vec<End>, IdentifyError> {
    let ends = in_parallel(starts, |(_, start)| {
        let end = led(case.approached(node, start, iterations))?;
        Ok(end.map(|end| (end.deviance, end.coordinates)))
    });
    let ends = ends.into_iter().filter_map(Result::transpose);
    let mut ends = ends.collect::<Result<Vec<End>, IdentifyError>>()?;
    rising(&mut ends, |end| end.0);
    Ok(ends)
}

/// Places around where a node stands: parameters of the baseline nearby, sizes of effects up to twice the
/// typical one, their partners anywhere.
fn places(node: &Node, vector: &ParameterVector, seed: u64) -> Vec<Vec<f64>> {
    let bounds = vector.bounds();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut place = || {
        let coordinates = node.coordinates.iter().zip(&bounds).enumerate();
        let moved = coordinates.map(|(j, (at, bound))| {
            let moved = match node.model.slot(vector.parameter(j)) {
                None => nearby(*at, bound, &mut rng),
                Some((effect, k)) => {
                    let parameter = &effect.info().parameters[k];
                    let [low, high] = parameter.bounds;
                    match parameter.role {
                        Role::Partner { .. } => drawn(low, high, &mut rng),
                        Role::Size => {
                            let [least, most] = SIZES;
                            let least = if low < 0.0 { -most } else { least };
                            parameter.typical * drawn(least, most, &mut rng)
                        }
                    }
                }
            };
            moved.clamp(bound.lower, bound.upper)
        });
        moved.collect()
    };
    (0..PLACES).map(|_| place()).collect()
}

/// The places of the lowest error: as many as short searches are made.
fn lowest(
    case: &Case<'_>,
    node: &Node,
    vector: &ParameterVector,
    places: Vec<Vec<f64>>,
) -> Result<Vec<End>, IdentifyError> {
    let residuals = case.residuals(&node.model, |r| {
        places.iter().map(|place| vector.values(place, r)).collect()
    })?;
    let mut ranked: Vec<End> = residuals.into_iter().zip(places).collect();
    rising(&mut ranked, |one| one.0);
    ranked.truncate(SEARCHES);
    Ok(ranked)
}
