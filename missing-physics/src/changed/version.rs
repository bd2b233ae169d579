//! A rig's model in which something has changed since the reference.

use std::collections::BTreeSet;
use std::sync::Arc;

use identify::{
    Bounds, ForwardModel, IdentifyError, Ordinary, ParameterInfo, ParameterState, Scale, Scope,
};
use recording::Recording;
use wiener::Block;

use crate::{Candidate, ExtendedModel, Role};

/// By how much a law ordinarily changes: a logarithm, a temperature in K, or a share of its value.
const BY_SHARE: f64 = 0.1;
const BY_K: f64 = 5.0;

/// Standard deviation of the size of an effect that has appeared, as a share of the largest that it can have.
const OF_LARGEST: f64 = 0.5;

/// Standard deviations within which a change is sought.
const WITHIN: f64 = 6.0;

/// Candidate change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum What {
    /// An effect that was not there.
    Effect(Candidate),
    /// A parameter of the laws, by its place in the model.
    Law(usize),
}

/// How large an effect is that has appeared: a mount wears as mounts do, or a damper was put on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AsLarge {
    /// As what is typical.
    AsTypical,
    /// As half of the largest.
    AsCanBe,
}

impl AsLarge {
    /// Both, equally likely.
    pub(crate) const ALL: [Self; 2] = [Self::AsTypical, Self::AsCanBe];
}

/// A model with an effect that acts in the changed runs alone, or with a law that is another there.
///
/// Parameters: those of the model, then the change of a law, on its scale.
#[derive(Debug, Clone)]
pub(crate) struct Version {
    model: ExtendedModel,
    changed: Arc<BTreeSet<String>>,
    /// Change that acts in them, if any.
    change: Option<What>,
    parameters: Vec<ParameterInfo>,
}

impl Version {
    /// A model in which nothing has changed; `changed` are the runs that are not of the reference.
    pub(crate) fn unchanged(model: ExtendedModel, changed: &[Recording]) -> Self {
        let changed = changed.iter().map(|run| run.name().to_owned());
        Self {
            parameters: model.parameters().to_vec(),
            model,
            changed: Arc::new(changed.collect()),
            change: None,
        }
    }

    /// This version with an effect that has appeared; `model` has that effect in addition.
    pub(crate) fn with_effect(
        &self,
        model: ExtendedModel,
        effect: Candidate,
        as_large: AsLarge,
    ) -> Self {
        let mut parameters = model.parameters().to_vec();
        with_priors(&model, (effect, as_large), &mut parameters);
        Self {
            parameters,
            model,
            changed: Arc::clone(&self.changed),
            change: Some(What::Effect(effect)),
        }
    }

    /// This version with a law that has changed; `point` has the values of all parameters.
    pub(crate) fn with_law(&self, law: usize, point: &[f64]) -> Self {
        let mut parameters = self.model.parameters().to_vec();
        let info = parameters[law].clone();
        let deviation = match self.model.slot(law) {
            // An effect that grew.
            Some((effect, k)) if effect.info().parameters[k].role == Role::Size => {
                effect.info().parameters[k].typical.abs()
            }
            _ => ordinary_change(&info, point[law]),
        };
        let ends = Bounds {
            lower: -WITHIN * deviation,
            upper: WITHIN * deviation,
        };
        parameters.push(ParameterInfo {
            bounds: ends,
            admissible: ends,
            scale: Scale::Linear,
            scope: Scope::Shared,
            state: ParameterState::Free,
            ordinary: Some(Ordinary {
                deviation,
                from_previous: false,
            }),
            ..info
        });
        Self {
            parameters,
            change: Some(What::Law(law)),
            ..self.clone()
        }
    }

    pub(crate) fn model(&self) -> &ExtendedModel {
        &self.model
    }

    /// Values of the model's parameters in a run.
    fn values(&self, point: &[f64], is_changed: bool) -> Vec<f64> {
        let mut values = point[..self.model.parameters().len()].to_vec();
        match self.change {
            Some(What::Effect(effect)) if !is_changed => {
                if let Some(first) = self.model.first_parameter(effect) {
                    let parameters = effect.info().parameters.iter();
                    for (value, parameter) in values[first..].iter_mut().zip(parameters) {
                        *value = parameter.neutral();
                    }
                }
            }
            Some(What::Law(law)) if is_changed => {
                let (info, change) = (&self.parameters[law], point[values.len()]);
                let moved = match info.scale {
                    Scale::Linear => values[law] + change,
                    Scale::Logarithmic => values[law] * change.exp(),
                };
                values[law] = moved.clamp(info.bounds.lower, info.bounds.upper);
            }
            _ => {}
        }
        values
    }
}

/// Sizes of an effect that may be there are ordinary, or anything that they can be.
fn with_priors(
    model: &ExtendedModel,
    (effect, as_large): (Candidate, AsLarge),
    parameters: &mut [ParameterInfo],
) {
    let Some(first) = model.first_parameter(effect) else {
        return;
    };
    for (k, parameter) in effect.info().parameters.iter().enumerate() {
        let info = &mut parameters[first + k];
        if parameter.role == Role::Size {
            // A drift is a walk from knot to knot, whose end is spread as one size is.
            let steps = match info.ordinary {
                Some(_) => effect.info().parameters.len(),
                None => 1,
            };
            let from_previous = info.ordinary.is_some_and(|own| own.from_previous);
            let deviation = match as_large {
                AsLarge::AsTypical => parameter.typical.abs(),
                AsLarge::AsCanBe => OF_LARGEST * parameter.largest() / (steps as f64).sqrt(),
            };
            info.ordinary = Some(Ordinary {
                deviation,
                from_previous,
            });
        }
    }
}

fn ordinary_change(info: &ParameterInfo, value: f64) -> f64 {
    match info.scale {
        Scale::Logarithmic => BY_SHARE,
        Scale::Linear if info.unit == "degC" || info.unit == "K" => BY_K,
        Scale::Linear if value.abs() > 0.0 => BY_SHARE * value.abs(),
        Scale::Linear => BY_SHARE * (info.bounds.upper - info.bounds.lower),
    }
}

impl ForwardModel for Version {
    fn parameters(&self) -> &[ParameterInfo] {
        &self.parameters
    }

    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        let is_changed = self.changed.contains(recording.name());
        let points = points.iter().map(|point| self.values(point, is_changed));
        let points: Vec<Vec<f64>> = points.collect();
        self.model.simulate(&points, recording, visit)
    }
}
