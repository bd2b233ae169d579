use wiener::hysteresis::Memory;
use wiener::thermal::Sample;

use crate::conduction::Ends;
use crate::effects::{RodMemory, ZoneMemory};
use crate::hypothesis::OwnMemory;

/// A zone of the rod with one temperature.
#[derive(Debug, Clone, PartialEq)]
#[repr(align(64))]
pub(crate) struct Zone<const L: usize> {
    pub(crate) temperature_degc: [f64; L],
    /// Temperature that drives the hysteresis: the rod's less what shifts the loop.
    pub(crate) driving_degc: [f64; L],
    pub(crate) fraction: [f64; L],
    /// Transformed share and its slope over the driving temperature, 1/K, as last seen.
    pub(crate) transformed: [f64; L],
    pub(crate) slope_per_k: [f64; L],
    /// Fraction and temperature in the middle of the last sample, where they are wanted.
    pub(crate) middle_fraction: [f64; L],
    pub(crate) middle_degc: [f64; L],
    pub(crate) memory: Memory<L>,
    pub(crate) effects: ZoneMemory<L>,
}

/// State of [`Plants`](crate::plant::Plants), and of no others: coefficients of these plants are kept in it.
#[derive(Debug, Clone, PartialEq)]
#[repr(align(64))]
pub(crate) struct PlantsState<const L: usize> {
    pub(crate) middle: Zone<L>,
    /// Boxed: they are large, and most plants do without.
    pub(crate) ends: Option<Box<Ends<L>>>,
    /// Coefficients of a sample of the length of the last.
    pub(crate) sample: Sample<L>,
    pub(crate) rod: RodMemory<L>,
    /// Only where there are own hypotheses.
    pub(crate) own: Option<Box<OwnMemory<L>>>,
    pub(crate) time_s: f64,
    pub(crate) displacement: [f64; L],
    pub(crate) recorded_degc: [f64; L],
    pub(crate) residual_k: [f64; L],
}
