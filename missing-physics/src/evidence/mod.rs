//! Evidence for models on data that they have not seen, and the part of their residuals that could still be predicted.
//!
//! Noise cannot be predicted from what drove the rig; missing physics can. So the one measure of a model is the density
//! that it gives to blocks of the recordings that were left out of its fit, and its one anonymous rival is the same model
//! with a curve of any shape on top.

#[cfg(test)]
mod any;
mod audit;
mod blocks;
mod curve;
mod left_out;
mod masses;
mod population;
mod predictive;
mod shifts;
mod weigh;
mod worth;

pub(crate) use audit::Anonymous;
pub use audit::Audit;
pub(crate) use blocks::{Block, blocks};
pub(crate) use masses::{masses, not_above_zero};
pub(crate) use population::{Model, Population, UNLISTED};
pub(crate) use predictive::Memory;
pub(crate) use shifts::{by_chance, centered};
pub(crate) use weigh::{audited, disturbed, weighed};
pub(crate) use worth::Evidence;
