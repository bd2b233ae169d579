use core::f64::consts::PI;

use crate::error::positive;
use crate::{HeatBalanceParams, ThermalError};

/// Geometry and material of a round rod or wire.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RodParams {
    /// Diameter d, m; > 0.
    pub diameter_m: f64,
    /// Density ρ, kg/m³; > 0. NiTi: about 6450.
    pub density_kg_per_m3: f64,
    /// Specific heat `C_p`, J/(kg K); > 0. NiTi: 450 to 840, depending on the source.
    pub specific_heat_j_per_kg_k: f64,
    /// Resistance per meter R, Ω/m; > 0.
    pub resistance_ohm_per_m: f64,
    /// Convective coefficient h, W/(m² K); > 0. Still air: 10 to 100, more for thin wires.
    pub convective_coefficient_w_per_m2_k: f64,
}

impl RodParams {
    /// Mass per meter.
    ///
    /// ```text
    /// m = ρ π d²/4     [Sadeghi, under eq. 1]
    /// ```
    ///
    /// # Differs from the source
    ///
    /// Printed "ρπ²d/4", whose unit is not kg/m.
    #[must_use]
    pub fn mass_kg_per_m(&self) -> f64 {
        self.density_kg_per_m3 * PI * self.diameter_m * self.diameter_m / 4.0
    }

    /// Surface per meter.
    ///
    /// ```text
    /// A = π d     [Sadeghi, under eq. 1]
    /// ```
    ///
    /// # Differs from the source
    ///
    /// Printed "πdl", the surface of the whole rod, beside a mass and a resistance per meter.
    #[must_use]
    pub fn surface_m2_per_m(&self) -> f64 {
        PI * self.diameter_m
    }

    /// The three coefficients of eq. 1, per meter of rod.
    ///
    /// # Errors
    ///
    /// [`ThermalError::NotPositive`] for a value that is not finite and > 0.
    pub fn heat_balance(&self) -> Result<HeatBalanceParams, ThermalError> {
        positive("diameter_m", self.diameter_m, "m")?;
        positive("density_kg_per_m3", self.density_kg_per_m3, "kg/m³")?;
        positive(
            "specific_heat_j_per_kg_k",
            self.specific_heat_j_per_kg_k,
            "J/(kg K)",
        )?;
        positive("resistance_ohm_per_m", self.resistance_ohm_per_m, "Ω/m")?;
        positive(
            "convective_coefficient_w_per_m2_k",
            self.convective_coefficient_w_per_m2_k,
            "W/(m² K)",
        )?;
        Ok(HeatBalanceParams {
            heat_capacity_j_per_m_k: self.mass_kg_per_m() * self.specific_heat_j_per_kg_k,
            conductance_w_per_m_k: self.convective_coefficient_w_per_m2_k * self.surface_m2_per_m(),
            resistance_ohm_per_m: self.resistance_ohm_per_m,
        })
    }
}
