//! Where a model and its recordings part.

use crate::EffectBlock;

/// Where model and recordings part.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mismatch {
    /// Block of the cascade in which what is missing most likely sits, and the probability of that; `None` if
    /// nothing is missing.
    pub block: Option<(EffectBlock, f64)>,
    /// Probability of every block, the likeliest first.
    pub blocks: Vec<(EffectBlock, f64)>,
    /// Regimes with more than their share of the error, the largest share first.
    pub cells: Vec<Cell>,
    /// Stretches of time with most of it, the largest share first.
    pub spans: Vec<Span>,
    /// Bands of frequency.
    pub bands: Vec<Band>,
}

/// A regime.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Description, for people.
    pub at: String,
    /// Its share of the explainable error.
    pub share: f64,
    /// Its share of the samples.
    pub occupancy: f64,
    /// Probability that noise alone concentrates as much anywhere.
    pub p_value: f64,
}

/// A stretch of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Name of the recording.
    pub recording: String,
    /// Its start, s on the recording's clock.
    pub start_s: f64,
    /// Its end, s.
    pub end_s: f64,
    /// Its share of the explainable error.
    pub share: f64,
}

/// A band of frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Its ends, Hz.
    pub hz: [f64; 2],
    /// Its share of the explainable error.
    pub share: f64,
}

/// A missing term as a function of one variable of the model, on one branch or both.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Where it acts.
    pub block: EffectBlock,
    /// Name of the variable, with its unit.
    pub variable: &'static str,
    /// Name of the value, with its unit.
    pub value: String,
    /// Share of the remainder that it describes.
    pub share: f64,
    /// The curves: on heating, then on cooling.
    pub curves: Vec<Curve>,
}

/// A curve with a simultaneous 95 % band.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Branch.
    pub heating: bool,
    /// Variable, value, and half of the width of the band: a row a knot.
    pub points: Vec<[f64; 3]>,
}
