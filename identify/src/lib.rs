#![doc = include_str!("../README.md")]

mod error;
mod factor;
mod fit;
mod forward;
mod identifiability;
mod least_squares;
mod moments;
mod parameter;
mod problem;
mod residual_noise;
mod rod;
mod uncertainty;
mod validate;
mod wiener_model;

pub use error::IdentifyError;
pub use fit::{
    Correlation, Fit, FitConfig, FitProgress, FittedParameter, Loss, TrainedRecording, fit,
};
pub use forward::ForwardModel;
pub use identifiability::UnfixedDirection;
pub use least_squares::{LeastSquaresConfig, Termination};
pub use parameter::{Bounds, Enters, ParameterInfo, ParameterState, ParameterVector, Scale, Scope};
pub use residual_noise::ResidualNoise;
pub use rod::{Limits, Load, ModelEntry, Rod};
pub use validate::{OffsetSource, Validated, validate};
pub use wiener_model::WienerModel;
