use recording::Recording;
use wiener::Block;

use crate::{ForwardModel, IdentifyError, ParameterInfo, ParameterState, Scope};

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
