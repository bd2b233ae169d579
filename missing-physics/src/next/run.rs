//! A run, or a sensor, that would tell explanations apart.

use std::ops::Range;

use crate::Candidate;

/// A run, or a sensor, that would tell the remaining explanations apart.
#[derive(Debug, Clone, PartialEq)]
pub struct NextExperiment {
    /// The explanations that it separates.
    pub separates: Vec<Candidate>,
    /// Advice on what to do, for people.
    pub sentence: String,
    /// The run; `None` if only another sensor helps.
    pub run: Option<Run>,
}

/// A drive to be played.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Name of its kind.
    pub name: String,
    /// Time between samples, s.
    pub dt_s: f64,
    /// The drive, in its unit; a value a sample.
    pub drive: Vec<f64>,
    /// How far apart the explanations would lie, standard deviations, after each has been refitted.
    pub separation: f64,
    /// How far apart they would lie in a repetition of the training.
    pub separation_now: f64,
    /// Samples in which the explanations differ most, as a range.
    pub decisive: Range<usize>,
}

impl Run {
    /// How long it takes, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.dt_s * self.drive.len() as f64
    }
}
