use super::relays::{RelayLoop, Relays};
use super::tanaka::{Kinetics, TanakaLoop};

/// The loop of a lumped plant, as it is described.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum LumpedLoop {
    Relays(RelayLoop),
    Tanaka(TanakaLoop),
}

/// The material of a wire with its memory.
#[derive(Debug, Clone)]
pub(super) enum Material {
    Relays(Relays),
    Kinetics(Kinetics),
}

impl LumpedLoop {
    /// The material, cooled to a temperature from far above.
    pub(super) fn cooled_to(self, temperature_degc: f64) -> Material {
        match self {
            Self::Relays(loops) => {
                let mut relays = loops.domains();
                relays.rest(temperature_degc);
                Material::Relays(relays)
            }
            Self::Tanaka(loops) => Material::Kinetics(loops.cooled_to(temperature_degc)),
        }
    }
}

impl Material {
    pub(super) fn fraction(&self) -> f64 {
        match self {
            Self::Relays(relays) => relays.fraction(),
            Self::Kinetics(kinetics) => kinetics.fraction,
        }
    }

    /// dξ/dT of what transforms continuously, 1/K.
    pub(super) fn slope_per_k(&self, fraction: f64, degc: f64, is_heating: bool) -> f64 {
        match self {
            Self::Relays(_) => 0.0,
            Self::Kinetics(kinetics) => kinetics.slope_per_k(fraction, degc, is_heating),
        }
    }
}
