#![doc = include_str!("../README.md")]

mod advance;
mod bands;
mod blocks;
mod bracket;
mod case;
mod catalogue;
mod cells;
mod diagnose;
mod diagnosis;
mod drives;
mod effect;
mod effects;
mod elementary;
mod elementary_terms;
mod elsewhere;
mod error;
mod explained;
mod extended_model;
mod fleet;
mod floor;
mod folds;
mod heat;
mod hypothesis;
mod info;
mod judge;
mod knots;
mod lag;
mod local_terms;
mod locate;
mod loop_scale;
mod next_experiment;
mod part;
mod plant;
mod play;
mod projection;
mod regimes;
mod remainder;
mod ridge;
mod rig;
mod scene;
mod scores;
mod screening;
mod search;
mod sentence;
mod separation;
mod series;
mod set;
mod setting;
mod shown;
mod solve;
mod spans;
mod start;
mod state;
#[cfg(test)]
mod synthetic;
mod tangent;
mod values;
mod whiten;

pub use diagnose::{DiagnoseConfig, DiagnoseProgress, diagnose, diagnose_from};
pub use diagnosis::{
    Band, Cell, Curve, Diagnosis, Entry, Estimate, Explained, ExtendedStage, Finding, Floor, Mismatch,
    NextExperiment, NoiseClass, Remainder, Run, Shape, Span, Stage, Status, Verdict,
};
pub use effects::{
    AmbientDrift, Backlash, DeadTime, EffectId, EffectValues, EndConduction, EndStop,
    FunctionalFatigue, LatentHeat, LoopAsymmetry, LoopShape, NaturalConvection, OutputLag,
    PhaseDependentResistance, RPhase, Radiation, ReturnPointMemory, SensorDrift,
    SensorNonlinearity, StressCoupling, SupplyLag, ThermalExpansion, ThermocoupleLag,
};
pub use error::PhysicsError;
pub use extended_model::ExtendedModel;
pub use fleet::{Extended, Member};
pub use hypothesis::Hypothesis;
pub use info::{
    EffectBlock, EffectInfo, EffectParameter, Literature, Need, Role, Sign, Smoothness,
};
pub use plant::ExtendedPlant;
pub use screening::{ScreenConfig, Screened, Screening, screen};
pub use set::EffectSet;
pub use setting::Setting;
pub use state::ExtendedState;
