#![doc = include_str!("../README.md")]

mod advice;
mod attempt;
mod bands;
mod bench;
mod blocks;
mod candidate;
mod case;
mod catalogue;
mod cells;
mod choice;
mod credit;
mod diagnose;
mod diagnosis;
mod drives;
mod elementary_terms;
mod elsewhere;
mod explained;
mod extended_model;
mod families;
mod floor;
mod folds;
mod judge;
mod lack;
mod ladder;
mod local_terms;
mod locate;
mod names;
mod next_experiment;
mod projection;
mod prune;
mod refit;
mod regimes;
mod remainder;
mod ridge;
mod rig;
mod rivals;
mod saved;
mod scene;
mod scores;
mod screening;
mod search;
mod sentence;
mod separation;
mod series;
mod settle;
mod slip;
mod spans;
#[cfg(test)]
mod synthetic;
mod tangent;
mod tone;
mod trial;
mod watch;
mod whiten;

pub use candidate::{Candidate, CandidateSet};
pub use diagnose::{DiagnoseConfig, DiagnoseProgress, diagnose, diagnose_from};
pub use diagnosis::{
    Band, Cell, Curve, Diagnosis, Entry, Estimate, Explained, ExtendedStage, Finding, Floor,
    Mismatch, NextExperiment, NoiseClass, Remainder, Run, Rung, Shape, Span, Stage, Status,
    Verdict,
};
pub use extended_model::ExtendedModel;
pub use rig::setting_of_rod;
pub use saved::{RestoredModel, parse_model, read_model, saved_effects};
pub use screening::{ScreenConfig, Screened, Screening, screen};
pub use sma_effects::{
    AmbientDrift, Backlash, DeadTime, EffectBlock, EffectId, EffectInfo, EffectParameter,
    EffectSet, EffectValues, EndConduction, EndStop, Extended, ExtendedPlant, ExtendedState,
    FunctionalFatigue, Hypothesis, LatentHeat, Literature, LoopAsymmetry, LoopShape, Member,
    NaturalConvection, Need, OutputLag, PhaseDependentResistance, PhysicsError, RPhase, Radiation,
    ReturnPointMemory, Role, SensorDrift, SensorNonlinearity, Setting, Sign, Smoothness,
    StressCoupling, SupplyLag, ThermalExpansion, ThermocoupleLag,
};
pub use wiener::hysteresis::LoopFamily;
