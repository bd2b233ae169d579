use crate::error::TruthError;
use crate::{CosineLoop, L2pLoop, PreisachLoop, RelayLoop, TanakaLoop};

/// From the temperature, less the shift by stress, to the transformed (austenite) fraction.
///
/// The path between two committed temperatures is straight. Whatever the family: the fraction is in 0..1, and
/// continuous and nowhere falling in `temperature_degc`, from any memory.
pub trait Hysteresis {
    /// Memory of the path.
    type Memory: Clone + std::fmt::Debug;
    /// Cooled to `temperature_degc` from far above.
    fn rest(&self, temperature_degc: f64) -> Self::Memory;
    /// The fraction to which a straight path from the committed temperature leads.
    fn fraction(&self, memory: &Self::Memory, temperature_degc: f64) -> f64;
    /// Goes there, and tells the fraction.
    fn commit(&self, memory: &mut Self::Memory, temperature_degc: f64) -> f64;
}

/// Which loop the rod has, and with it which of the two plants it is: the first three go with finite volumes, the last
/// two with the lumped mass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoopFamily {
    /// Limiting-loop proximity.
    L2p(L2pLoop),
    /// Preisach's sum of relays.
    Preisach(PreisachLoop),
    /// Cosine kinetics of Liang and Rogers.
    Cosine(CosineLoop),
    /// Explicit relays, in the lumped plant.
    Relays(RelayLoop),
    /// Exponential kinetics, in the lumped plant.
    Tanaka(TanakaLoop),
}

impl Default for LoopFamily {
    fn default() -> Self {
        Self::L2p(L2pLoop::default())
    }
}

impl LoopFamily {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        match self {
            Self::L2p(parameters) => parameters.check(),
            Self::Preisach(parameters) => parameters.check(),
            Self::Cosine(parameters) => parameters.check(),
            Self::Relays(parameters) => parameters.check(),
            Self::Tanaka(parameters) => parameters.check(),
        }
    }

    /// The loop whose branches spread differently: heating by 1/√ratio, cooling by √ratio of what they did.
    pub(crate) fn with_spread_ratio(self, ratio: f64) -> Self {
        match self {
            Self::L2p(parameters) => Self::L2p(L2pLoop {
                cooling_over_heating_spread: ratio * parameters.cooling_over_heating_spread,
                ..parameters
            }),
            Self::Preisach(parameters) => Self::Preisach(parameters.with_spread_ratio(ratio)),
            Self::Cosine(parameters) => Self::Cosine(parameters.with_spread_ratio(ratio)),
            Self::Relays(parameters) => Self::Relays(parameters.with_spread_ratio(ratio)),
            Self::Tanaka(parameters) => Self::Tanaka(parameters.with_spread_ratio(ratio)),
        }
    }

    /// Temperature above which hardly anything is left to transform on heating, °C.
    #[must_use]
    pub fn hot_degc(&self) -> f64 {
        match self {
            Self::L2p(l) => l.loop_center_degc + l.loop_half_width_k + 8.0 * l.loop_spread_k,
            Self::Preisach(l) => l.heating_center_degc + 2.5 * l.heating_deviation_k,
            Self::Cosine(l) => l.austenite_finish_degc + 2.0,
            Self::Relays(l) => l.heating_center_degc + l.reach() * l.heating_deviation_k,
            // A hundredth is left.
            Self::Tanaka(l) => l.austenite_start_degc + 4.6 / l.austenite_rate_per_k,
        }
    }

    /// Temperature below which hardly anything is left to transform on cooling, °C.
    #[must_use]
    pub fn cold_degc(&self) -> f64 {
        match self {
            Self::L2p(l) => l.loop_center_degc - l.loop_half_width_k - 8.0 * l.loop_spread_k,
            Self::Preisach(l) => l.cooling_center_degc - 2.5 * l.cooling_deviation_k,
            Self::Cosine(l) => l.martensite_finish_degc - 2.0,
            Self::Relays(l) => l.cooling_center_degc - l.reach() * l.cooling_deviation_k,
            Self::Tanaka(l) => l.martensite_start_degc - 4.6 / l.martensite_rate_per_k,
        }
    }
}
