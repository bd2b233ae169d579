//! A model where it was not fitted: in another recording.

use identify::{ForwardModel, IdentifyError, ParameterInfo, Validated, validate_at};
use recording::Recording;

use crate::{Candidate, EffectId, ExtendedModel};

/// Whether the parameters of an effect are those of a recording.
pub(crate) fn is_drift(effect: Candidate) -> bool {
    effect == EffectId::AmbientDrift || effect == EffectId::SensorDrift
}

/// The point for another recording: of a drift of the surroundings it has the mean, which is as a loop that lies
/// lower, and of that of the sensor's zero nothing.
pub(crate) fn without_drifts(model: &ExtendedModel, point: &[f64]) -> Vec<f64> {
    drifts_dropped(ForwardModel::parameters(model), point, |effect| {
        model.first_parameter(effect)
    })
}

/// The same for any model; `first` is the place of the first parameter of an effect.
pub(crate) fn drifts_dropped(
    infos: &[ParameterInfo],
    point: &[f64],
    first: impl Fn(EffectId) -> Option<usize>,
) -> Vec<f64> {
    let mut point = point.to_vec();
    let mut drop = |effect: EffectId| {
        let first = first(effect)?;
        let knots = &mut point[first..first + effect.info().parameters.len()];
        // Straight between knots, from 0 at the start.
        let last = knots.last().copied().unwrap_or(0.0);
        let mean = (knots.iter().sum::<f64>() - 0.5 * last) / knots.len() as f64;
        knots.fill(0.0);
        Some(mean)
    };
    drop(EffectId::SensorDrift);
    let warmer_k = drop(EffectId::AmbientDrift).unwrap_or(0.0);
    let mut infos = infos.iter();
    if let Some(center) = infos.position(|info| info.name == "loop_center_degc") {
        point[center] -= warmer_k;
    }
    point
}

/// A model at a point on recordings that it has not seen; drifts are not carried there.
pub(crate) fn validated(
    model: &ExtendedModel,
    point: &[f64],
    unseen: &[Recording],
) -> Result<Vec<Validated>, IdentifyError> {
    let point = without_drifts(model, point);
    let unseen = unseen.iter();
    unseen
        .map(|recording| validate_at(model, &point, recording))
        .collect()
}
