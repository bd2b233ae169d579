use crate::air::{Correlation, ZERO_DEGC_K, free_convection_w_per_m2_k};
use crate::error::{TruthError, within};

/// Stefan–Boltzmann constant, W/(m² K⁴), CODATA 2018.
const STEFAN_BOLTZMANN_W_PER_M2_K4: f64 = 5.670_374_419e-8;

/// A part of the convection is free: it grows with the temperature, as a correlation says.
///
/// ```text
/// h → h ((1 - s) + s h_c(T, T_amb)/h_c(T_0 + ΔT, T_0))        T_0 the ambient at the start
/// ```
///
/// The plant's coefficient holds at the reference: walls, mount and tilt make any rig's differ from that of a free
/// horizontal cylinder by a factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeConvection {
    /// Which correlation gives the free part.
    pub correlation: Correlation,
    /// Share of the correlation in the coefficient, 0 to 1; the rest is the plant's constant one. Typical: 1.
    pub share: f64,
    /// Rise above the surroundings at which the plant's coefficient holds ΔT, K; 1 to 300.
    pub reference_rise_k: f64,
}

/// The rod radiates to surroundings of one temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radiation {
    /// Emissivity, 0 to 1. Typical: 0.6, an oxidized wire.
    pub emissivity: f64,
}

/// The convective coefficient falls over a range of temperatures, as where a plume detaches or a fan's controller
/// acts: no loss law of a textbook.
///
/// ```text
/// h → h (1 - d exp(-((T - T_amb - c)/w)²))
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvectionDip {
    /// Relative depth d, 0 to 0.9. Typical: 0.25.
    pub depth: f64,
    /// Rise above the surroundings at which it is deepest c, K; 0 to 200.
    pub center_k: f64,
    /// Width w, K; 1 to 100.
    pub width_k: f64,
}

/// The law with its value at the reference, which stands fast in a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ScaledConvection {
    law: FreeConvection,
    at_reference_w_per_m2_k: f64,
}

/// Heat losses of a surface of the rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Loss {
    pub(crate) diameter_m: f64,
    pub(crate) convective_coefficient_w_per_m2_k: f64,
    pub(crate) free: Option<ScaledConvection>,
    pub(crate) radiation: Option<Radiation>,
    pub(crate) dip: Option<ConvectionDip>,
}

impl Loss {
    /// Heat flux, W/m²; `draught` multiplies convection.
    pub(crate) fn flux_w_per_m2(
        &self,
        temperature_degc: f64,
        (ambient_degc, draught): (f64, f64),
    ) -> f64 {
        let rise_k = temperature_degc - ambient_degc;
        let mut coefficient = self.convective_coefficient_w_per_m2_k;
        if let Some(free) = &self.free {
            let correlated = free
                .law
                .correlated_w_per_m2_k(self.diameter_m, (temperature_degc, ambient_degc));
            let relative = correlated / free.at_reference_w_per_m2_k;
            coefficient *= 1.0 + free.law.share * (relative - 1.0);
        }
        if let Some(dip) = self.dip {
            let x = (rise_k - dip.center_k) / dip.width_k;
            coefficient *= 1.0 - dip.depth * (-x * x).exp();
        }
        let mut flux = coefficient * draught * rise_k;
        if let Some(radiation) = self.radiation {
            let fourth = |degc: f64| (degc + ZERO_DEGC_K).powi(4);
            flux += radiation.emissivity
                * STEFAN_BOLTZMANN_W_PER_M2_K4
                * (fourth(temperature_degc) - fourth(ambient_degc));
        }
        flux
    }
}

impl FreeConvection {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("share", self.share, 0.0..=1.0)?;
        within("reference_rise_k", self.reference_rise_k, 1.0..=300.0)
    }

    pub(crate) fn scaled(self, diameter_m: f64, ambient_degc: f64) -> ScaledConvection {
        let hot_degc = ambient_degc + self.reference_rise_k;
        ScaledConvection {
            law: self,
            at_reference_w_per_m2_k: self
                .correlated_w_per_m2_k(diameter_m, (hot_degc, ambient_degc)),
        }
    }

    fn correlated_w_per_m2_k(&self, diameter_m: f64, ends_degc: (f64, f64)) -> f64 {
        free_convection_w_per_m2_k(self.correlation, diameter_m, ends_degc)
    }
}

impl Radiation {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("emissivity", self.emissivity, 0.0..=1.0)
    }
}

impl ConvectionDip {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("depth", self.depth, 0.0..=0.9)?;
        within("center_k", self.center_k, 0.0..=200.0)?;
        within("width_k", self.width_k, 1.0..=100.0)
    }
}
