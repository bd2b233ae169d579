#![doc = include_str!("../README.md")]

mod error;
mod factor;
mod fit;
mod forward;
mod least_squares;
mod parameter;
mod problem;
mod rod;
mod validate;
mod wiener_model;

pub use error::IdentifyError;
pub use fit::{Fit, FitConfig, FittedParameter, TrainedRecording, fit};
pub use forward::ForwardModel;
pub use least_squares::{LeastSquaresConfig, Termination};
pub use parameter::{Bounds, Enters, ParameterInfo, ParameterState, ParameterVector, Scale, Scope};
pub use rod::{DriveKind, Limits, Load, ModelEntry, Rod};
pub use validate::{OffsetSource, Validated, validate};
pub use wiener_model::WienerModel;
