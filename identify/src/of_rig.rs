use recording::Recording;
use wiener::Block;

use crate::wiener_model::STARTS;
use crate::{ForwardModel, IdentifyError, ParameterInfo, ParameterState, Scope, may_begin_warm};

/// A model whose shared parameters are known; what is left to find is a recording's own.
#[derive(Debug)]
pub struct OfRig<'a> {
    model: &'a dyn ForwardModel,
    /// The parameters, the shared ones fixed: what else is to be fixed or freed may be.
    pub parameters: Vec<ParameterInfo>,
}

impl<'a> OfRig<'a> {
    /// The model with the shared values of a point.
    #[must_use]
    pub fn at(model: &'a dyn ForwardModel, point: &[f64]) -> Self {
        let mut parameters = model.parameters().to_vec();
        for (info, &value) in parameters.iter_mut().zip(point) {
            if info.scope == Scope::Shared {
                info.state = ParameterState::Fixed(value);
            }
        }
        Self { model, parameters }
    }

    /// Fixes what is free to differ from run to run at its ordinary value, 0, in the model and in a point.
    pub fn hold_ordinary(&mut self, point: &mut [f64]) {
        for (info, value) in self.parameters.iter_mut().zip(point) {
            if info.ordinary.is_some() && info.state == ParameterState::Free {
                *value = 0.0;
                info.state = ParameterState::Fixed(0.0);
            }
        }
    }

    /// Leaves the start of each heated rod with its loop open in a recording that may begin warm ([`may_begin_warm`]), and has it begin
    /// at rest in every other. A start that is fixed elsewhere stays, and so do those of other models.
    pub fn begin_as(&mut self, recording: &Recording) {
        let is_warm = may_begin_warm(recording);
        for start in STARTS {
            let place = |name: &str| self.parameters.iter().position(|info| info.name == name);
            let places = start.iter().map(|&(name, _)| place(name));
            let Some(places) = places.collect::<Option<Vec<usize>>>() else {
                continue;
            };
            for (place, (_, at_rest)) in places.into_iter().zip(start) {
                let info = &mut self.parameters[place];
                match info.state {
                    ParameterState::Fixed(value) if (value - at_rest).abs() > 0.0 => {}
                    _ if is_warm => info.state = ParameterState::Free,
                    _ => info.state = ParameterState::Fixed(*at_rest),
                }
            }
        }
    }
}

impl ForwardModel for OfRig<'_> {
    fn parameters(&self) -> &[ParameterInfo] {
        &self.parameters
    }

    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        self.model.simulate(points, recording, visit)
    }
}
