#![doc = include_str!("../README.md")]

mod antagonist_model;
mod beginnings;
mod cascade;
mod clocks;
mod cross_check;
mod curvature;
pub mod dense;
mod difference;
mod draws;
mod ended;
mod error;
mod factor;
mod fit;
mod fit_config;
mod fitted;
mod forward;
mod identifiability;
mod input_path;
mod least_squares;
mod loop_model;
mod moments;
mod odd_step;
mod of_family;
mod of_rig;
mod own_anew;
mod parameter;
mod predict;
mod prior;
mod problem;
mod quantities;
mod reach;
mod recording_use;
mod refine;
mod residual_noise;
mod resistance_change;
mod rig_model;
mod rod;
mod sadeghi_model;
mod saved_model;
mod sensor;
mod sensor_lag;
mod specific_heat;
mod start;
mod state_of_run;
mod static_effects;
mod supply;
mod tasks;
mod temperature_unit;
mod thermal_model;
mod thinned;
mod uncertainty;
mod validate;
mod wiener_model;

pub use antagonist_model::AntagonistModel;
pub use beginnings::beginnings_of;
pub use clocks::{EarlyOutput, early_output};
pub use cross_check::{CrossCheck, CrossVerdict, cross_check};
pub use draws::Draws;
pub use ended::EndedStart;

pub use error::IdentifyError;
pub use fit::{FitProgress, fit};
pub use fit_config::{FitConfig, Loss};
pub use fitted::{Fit, FittedParameter, ParameterCovariance, TrainedRecording};
pub use forward::ForwardModel;
pub use identifiability::UnfixedDirection;
pub use input_path::OneWay;
pub use least_squares::{LeastSquaresConfig, Termination};
pub use loop_model::LoopModel;
pub use odd_step::{OddStep, odd_step};
pub use of_family::{
    ONSET_SHARPNESS, SECOND_POPULATION_PARAMETERS, SHAPE_PARAMETERS, is_of_family,
    parameters_of_family,
};
pub use of_rig::OfRig;
pub use parameter::{
    Bounds, Enters, Ordinary, ParameterInfo, ParameterState, ParameterVector, Scale, Scope,
};
pub use predict::{Prediction, predict};
pub use prior::{Prior, PriorRow, prior_rows};
pub use reach::BeyondReach;
pub use recording_use::RecordingUse;
pub use refine::{RefineConfig, Refined, refine};
pub use residual_noise::ResidualNoise;
pub use rig_model::{ModelKind, ModelTemplate, RigModel};
pub use rod::{Limits, Load, ModelEntry, NITI_OHM_M, NITI_RANGE_OHM_M, Rod, Wish};
pub use sadeghi_model::SadeghiModel;
pub use saved_model::{
    Identification, InputFile, KnownEffects, LOOP_SHAPE, NamedEffect, Provenance, Role,
    SavedEffects, SavedModel, SavedRecording, Scores,
};
pub use sensor::{FINEST_THERMOMETER_K, Sensor};
pub use state_of_run::{StateOfRun, in_states};
pub use static_effects::{
    Estimate, NotTestable, StaticEffect, StaticEffects, StaticScore, static_effects,
};
pub use supply::Supply;
pub use tasks::{both, in_order_of, in_parallel, try_in_parallel};
pub use thermal_model::ThermalModel;
pub use thinned::{tell_time_constant, thinned};
pub use validate::{OffsetSource, Validated, validate, validate_at, validated_with};
pub use wiener_model::{
    AMBIENT_LEVEL, RUN_PARAMETERS, SINCE_REVERSAL, WienerModel, may_begin_warm,
};
