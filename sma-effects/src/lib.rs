#![doc = include_str!("../README.md")]

mod advance;
mod bracket;
mod conduction;
mod effect;
mod effects;
mod elementary;
mod error;
mod extended_plant;
mod fleet;
mod heat;
mod hypothesis;
mod info;
mod knots;
mod lag;
mod loop_scale;
mod parameter;
mod part;
mod past;
mod plant;
mod play;
mod prior;
mod sense;
mod set;
mod setting;
mod shown;
mod solve;
mod spline;
mod start;
mod state;
mod turned;
mod values;

pub use effects::{
    AmbientDrift, Backlash, DeadTime, EffectId, EffectValues, EndConduction, EndStop, FamilyShape,
    FunctionalFatigue, LatentHeat, LoopAsymmetry, LoopShape, NaturalConvection, OutputLag,
    PhaseDependentResistance, RPhase, Radiation, ReturnPointMemory, SensorDrift,
    SensorNonlinearity, StressCoupling, SupplyLag, SupplyLimit, ThermalExpansion, ThermocoupleLag,
};
pub use error::PhysicsError;
pub use extended_plant::{ExtendedPlant, ExtendedState};
pub use fleet::{Extended, Member};
pub use hypothesis::Hypothesis;
pub use info::{ActsAs, Belongs, EffectBlock, EffectInfo, Need, Occurrence, Presence, Smoothness};
pub use parameter::{EffectParameter, Literature, Role, Sign};
pub use prior::SizePrior;
pub use set::EffectSet;
pub use setting::Setting;
pub use turned::Turned;
