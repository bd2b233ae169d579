use std::fmt;

use recording::Recording;
use wiener::Block;

use crate::{IdentifyError, ParameterInfo};

/// Any model as a fit sees it: named parameters in, outputs out, a batch of points at a time.
///
/// Fits take a `&dyn ForwardModel`: a call a batch costs nothing, and they are compiled once.
pub trait ForwardModel: fmt::Debug + Sync {
    /// The parameters, in the order of the values that [`ForwardModel::simulate`] takes.
    fn parameters(&self) -> &[ParameterInfo];

    /// Simulates a recording at several points and shows the outputs in blocks, so that memory does
    /// not grow with the recording: see [`Block`], whose members are the points.
    ///
    /// `points` holds a row of parameter values a point, at most 32 of them. Every block must show all
    /// points, and the blocks together all samples in their order; a fit refuses a model that does not.
    /// The output convention is that of the recording: sample k before its drive acts.
    ///
    /// # Errors
    ///
    /// [`IdentifyError`] if a point lies outside the model's range or the recording does not fit it.
    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError>;

    /// Temperatures in the middle of the cooling and of the heating branch of the limiting loop at a point, on the scale of those
    /// that [`ForwardModel::simulate`] shows, °C; `None` if the model has no such loop.
    fn branches_degc(&self, _point: &[f64]) -> Option<[f64; 2]> {
        None
    }
}
