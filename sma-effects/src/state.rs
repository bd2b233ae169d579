use wiener::hysteresis::Memory;
use wiener::thermal::Sample;

use crate::conduction::{CELLS, Ends};
use crate::effects::{RodMemory, ZoneMemory};
use crate::hypothesis::OwnMemory;

/// A zone of the rod with one temperature.
#[derive(Debug, Clone, PartialEq)]
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

/// State of an [`ExtendedPlant`](crate::ExtendedPlant), and of no other: coefficients of that plant
/// are kept in it.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtendedState<const L: usize = 1> {
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

impl<const L: usize> ExtendedState<L> {
    /// Temperature of the rod, of its middle if the ends are colder, °C.
    #[must_use]
    pub fn temperature_degc(&self) -> [f64; L] {
        self.middle.temperature_degc
    }

    /// Temperature next to the clamps, °C; `None` while end conduction is not active.
    #[must_use]
    pub fn end_temperature_degc(&self) -> Option<[f64; L]> {
        let ends = self.ends.as_ref()?;
        Some(ends.cells[CELLS - 1].temperature_degc)
    }

    /// Fraction, of the middle if the ends differ.
    #[must_use]
    pub fn fraction(&self) -> [f64; L] {
        self.middle.fraction
    }

    /// Time since the start of the run, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// What the Newton search of the last sub-step left: the temperature of the heat balance less that at
    /// which the hysteresis was evaluated, K; of the zones that which is larger in magnitude. Exactly 0
    /// where nothing had to be searched.
    #[must_use]
    pub fn residual_k(&self) -> [f64; L] {
        self.residual_k
    }
}
