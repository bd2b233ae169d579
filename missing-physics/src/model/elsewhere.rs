//! A model where it was not fitted: in another recording.

use identify::{
    Fit, ForwardModel, IdentifyError, OfRig, ParameterInfo, Scope, Validated, predict, validate_at,
};
use recording::Recording;

use crate::{Belongs, Candidate, EffectId, ExtendedModel};

/// True for a drift: an effect that moves slowly and on its own, with parameters of each recording.
pub(crate) fn is_drift(effect: Candidate) -> bool {
    effect.info().belongs_to == Belongs::Recording
}

/// The point for another recording: of a drift whose mean acts as another parameter, as that of the surroundings does as a loop
/// that lies lower, it has the mean, and of any other nothing.
pub(crate) fn without_drifts(model: &ExtendedModel, point: &[f64]) -> Vec<f64> {
    drifts_dropped(ForwardModel::parameters(model), point, |effect| {
        model.first_parameter(effect)
    })
}

/// The point of any model for another recording, without drifts; `first` is the place of the first parameter of an effect.
pub(crate) fn drifts_dropped(
    infos: &[ParameterInfo],
    point: &[f64],
    first: impl Fn(EffectId) -> Option<usize>,
) -> Vec<f64> {
    let mut point = point.to_vec();
    let all = EffectId::ALL.into_iter();
    for effect in all.filter(|&effect| is_drift(effect.into())) {
        let Some(first) = first(effect) else {
            continue;
        };
        let knots = &mut point[first..first + effect.info().parameters.len()];
        // Straight between knots, from 0 at the start.
        let last = knots.last().copied().unwrap_or(0.0);
        let mean = (knots.iter().sum::<f64>() - 0.5 * last) / knots.len() as f64;
        knots.fill(0.0);
        let acts_as = effect.info().mean_acts_as;
        let place =
            acts_as.and_then(|one| infos.iter().position(|info| info.name == one.parameter));
        if let (Some(acts_as), Some(place)) = (acts_as, place) {
            point[place] += acts_as.per_unit * mean;
        }
    }
    point
}

/// Root mean square of what a model leaves of recordings that it has not seen, each with its offset alone, from its rest where it has
/// one ([`validate_at`]): in the surroundings that are stated, with no drift and as the rig ordinarily is. `None` without recordings.
pub(crate) fn predicted(
    model: &dyn ForwardModel,
    point: &[f64],
    unseen: &[Recording],
) -> Result<Option<f64>, IdentifyError> {
    let infos = model.parameters();
    let place = |name: &str| infos.iter().position(|info| info.name == name);
    let mut point = drifts_dropped(infos, point, |effect| {
        place(effect.info().parameters[0].name)
    });
    let mut ordinary = OfRig::at(model, &point);
    ordinary.hold_ordinary(&mut point);
    let validated = unseen
        .iter()
        .map(|recording| validate_at(&ordinary, &point, recording));
    let validated = validated.collect::<Result<Vec<Validated>, IdentifyError>>()?;
    Ok(Validated::rmse_of_all(&validated))
}

/// Models as likely as a fit by which its spread is told.
const DRAWS: usize = 16;

/// Mean square of what the uncertainty of a fit's parameters makes of unseen recordings, in the output unit: a run that goes
/// where the training did not shows it, however right the model.
pub(crate) fn spread(
    model: &ExtendedModel,
    fit: &Fit,
    validated: &[Validated],
    unseen: &[Recording],
) -> Result<f64, IdentifyError> {
    let drawn = fit.draws(DRAWS, fit.seed).points;
    let infos = ForwardModel::parameters(model);
    let (mut n, mut sum) = (0, 0.0);
    for (validated, recording) in validated.iter().zip(unseen) {
        let with_its_own = |point: &Vec<f64>| {
            let mut point = point.clone();
            for (k, info) in infos.iter().enumerate() {
                if info.scope == Scope::PerRecording {
                    point[k] = validated.point[k];
                }
            }
            point
        };
        let points: Vec<Vec<f64>> = drawn.iter().map(with_its_own).collect();
        let shown = predict(model, &validated.point, recording)?.output;
        model.simulate(&points, recording, &mut |block| {
            let rows = block.displacement.chunks_exact(block.stride);
            for (row, shown) in rows.zip(&shown[block.first_sample..]) {
                let members = row[..block.members].iter();
                sum += members.map(|other| (other - shown).powi(2)).sum::<f64>();
            }
        })?;
        n += points.len() * recording.len();
    }
    Ok(if n > 0 { sum / n as f64 } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;

    use identify::{FitConfig, fit};

    use super::*;
    use crate::model::synthetic::{NOISE_MM, Synthetic};
    use crate::model::unseen::validated;
    use crate::{EffectSet, EffectValues};

    #[test]
    fn the_spread_over_the_training_is_the_noise_that_the_parameters_took_in() {
        let synthetic = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 1);
        let case = synthetic.case();
        let node = case.baseline().unwrap();
        let config = FitConfig {
            starts: 0,
            from: vec![node.coordinates.clone()],
            ..FitConfig::default()
        };
        let training = &synthetic.training;
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let fitted = fit(&node.model, training, &config, go_on).unwrap();
        let (validated, _) = validated(&node.model, &fitted.point(0), training).unwrap();
        let found = spread(&node.model, &fitted, &validated, training).unwrap();
        let n: usize = training.iter().map(Recording::len).sum();
        let expected = NOISE_MM * NOISE_MM * node.coordinates.len() as f64 / n as f64;
        assert!(
            (0.3..3.0).contains(&(found / expected)),
            "{found} {expected}"
        );
    }
}
