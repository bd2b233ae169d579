#![cfg_attr(not(feature = "std"), no_std)]
#![doc = include_str!("../README.md")]

#[cfg(feature = "std")]
mod bracket;
#[cfg(feature = "std")]
mod chatter;
mod closed_loop;
#[cfg(feature = "std")]
mod complex;
mod cost;
#[cfg(feature = "std")]
mod describing;
#[cfg(feature = "std")]
mod describing_curve;
mod error;
mod feed_forward;
#[cfg(feature = "std")]
mod fraction_response;
#[cfg(feature = "std")]
mod front;
mod gain_schedule;
#[cfg(feature = "std")]
mod goal;
#[cfg(feature = "std")]
mod inverse;
#[cfg(feature = "std")]
mod limit_cycle;
#[cfg(feature = "std")]
mod linear_loop;
#[cfg(feature = "std")]
mod loop_analysis;
#[cfg(feature = "std")]
mod margins;
#[cfg(feature = "std")]
mod open_loop;
#[cfg(feature = "std")]
mod oscillation;
#[cfg(feature = "std")]
mod pace;
mod pid;
#[cfg(feature = "std")]
mod plant_response;
mod reference;
#[cfg(feature = "std")]
mod rest_test;
#[cfg(feature = "std")]
mod robustness;
#[cfg(feature = "std")]
mod rod_loop;
#[cfg(feature = "std")]
mod rules;
mod sample;
#[cfg(feature = "std")]
mod schedule_shape;
#[cfg(feature = "std")]
mod screen;
#[cfg(feature = "std")]
mod second_opinion;
#[cfg(feature = "std")]
mod small_changes;
mod step_response;
#[cfg(feature = "std")]
mod swept;
#[cfg(feature = "std")]
mod task;
#[cfg(feature = "std")]
mod tuner;
#[cfg(feature = "std")]
mod tuner_config;

#[cfg(feature = "std")]
pub use chatter::{ChatterOrbit, MAX_CHATTER_SAMPLES};
pub use closed_loop::{
    ClosedLoop, ClosedLoopParams, Disturbances, MAX_DEAD_TIME_SAMPLES, Snapshot,
};
#[cfg(feature = "std")]
pub use complex::Complex;
pub use cost::{CostWeights, ResponseTerms, Terms};
#[cfg(feature = "std")]
pub use describing::{BiasedSine, SineResponse};
pub use error::TuneError;
pub use feed_forward::feed_forward_a;
#[cfg(feature = "std")]
pub use fraction_response::{
    FractionResponse, MAX_SETTLING_CYCLES, TemperatureSine, fraction_response,
};
#[cfg(feature = "std")]
pub use front::{FrontPoint, front};
pub use gain_schedule::{GainSchedule, GainScheduleParams, SCHEDULE_LEVELS};
#[cfg(feature = "std")]
pub use goal::{Across, Goal};
#[cfg(feature = "std")]
pub use inverse::InverseRun;
#[cfg(feature = "std")]
pub use limit_cycle::{PredictedCycle, RELIABLE_HARMONIC_RATIO};
#[cfg(feature = "std")]
pub use linear_loop::LinearLoop;
#[cfg(feature = "std")]
pub use loop_analysis::{AGREEMENT, Agreement, Forecast, LoopAnalysis, Outcome, Source};
#[cfg(feature = "std")]
pub use margins::Margins;
#[cfg(feature = "std")]
pub use open_loop::{OpenLoop, Passage};
#[cfg(feature = "std")]
pub use oscillation::{Oscillation, StartFrom};
#[cfg(feature = "std")]
pub use pace::Pace;
pub use pid::{AntiWindup, DerivativeOf, DriveLimits, Pid, PidGains, PidParams, PidState};
#[cfg(feature = "std")]
pub use plant_response::{FirstOrder, PlantResponse};
pub use reference::Reference;
#[cfg(feature = "std")]
pub use rest_test::RestTest;
#[cfg(feature = "std")]
pub use robustness::{
    Ending, Percentiles, Robustness, Sensitivity, StepRobustness, Variation, robustness,
    sensitivities,
};
#[cfg(feature = "std")]
pub use rod_loop::{Approach, RodLoop, RodLoopParams};
#[cfg(feature = "std")]
pub use rules::{RelayCycle, RelayTest};
pub use sample::{Command, Sample};
#[cfg(feature = "std")]
pub use schedule_shape::ScheduleShape;
#[cfg(feature = "std")]
pub use screen::{Requirements, Screen};
#[cfg(feature = "std")]
pub use second_opinion::{Opinion, SecondOpinion, Verdict, second_opinion};
#[cfg(feature = "std")]
pub use small_changes::{Answer, Answers, SmallChanges};
pub use step_response::StepTerms;
#[cfg(feature = "std")]
pub use task::{Response, Task, TaskError};
#[cfg(feature = "std")]
pub use tuner::{Plants, TuneProgress, Tuned, tune};
#[cfg(feature = "std")]
pub use tuner_config::{BoundEnd, GainBounds, GainScale, TunerConfig};
