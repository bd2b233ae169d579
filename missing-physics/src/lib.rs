#![doc = include_str!("../README.md")]

mod agreed;
mod baseline;
mod changed;
mod config;
mod decide;
mod diagnose;
mod evidence;
mod locate;
mod model;
mod next;
mod noise;
mod other_loops;
mod pullback;
mod report;
mod screen;
mod search;
mod watch;

pub use changed::{
    Change, ChangeEvidence, ChangeVerdict, Changed, Changing, Considered, FEWEST_COOLINGS,
    FEWEST_RUNS, LEAST_EXCESS, LEAST_EXPLAINED, LEAST_UNCHANGED, LeftOut, MOST_EXCESS, Reference,
    Standing, StateSpread, TracedRun,
};
pub use config::{DiagnoseConfig, Effort, Part};
pub use decide::Verdict;
pub use decide::{Basis, Comparison, RULES, Rule, RuleId, Trace};
pub use diagnose::{diagnose, diagnose_from};
pub use evidence::Audit;
pub use locate::mismatch::{Band, Cell, Curve, Mismatch, Shape, Span};
pub use model::candidate::{Candidate, CandidateSet};
pub use model::extended_model::ExtendedModel;
pub use model::rig::setting_of_rod;
pub use next::run::{NextExperiment, Run};
pub use noise::kind::{Floor, NoiseClass};
pub use other_loops::{OtherLoop, carry_loop_shape, other_loops};
pub use report::diagnosis::{
    Diagnosis, Entry, Estimate, Explained, ExtendedStage, Finding, Otherwise, Remainder, Rung,
    Simulations, Stage, Status,
};
pub use report::saved::{RestoredModel, known_effects, saved_effects};
pub use screen::screening::{ScreenConfig, Screened, Screening, screen};
pub(crate) use sma_effects::{
    Belongs, EffectBlock, EffectId, EffectInfo, EffectParameter, EffectSet, EffectValues, Extended,
    ExtendedPlant, FamilyShape, Hypothesis, Member, Need, Occurrence, PhysicsError, Role, Setting,
    Sign, Smoothness,
};
pub use watch::{DiagnoseProgress, SearchStep};
pub use wiener::hysteresis::LoopFamily;
