use crate::error::{TruthError, within};
use std::f64::consts::PI;

/// Cells of a rod whose ends matter.
pub const DISTRIBUTED_CELLS: usize = 20;

/// How much finer the cells at the ends are than on the average: there the temperature falls off.
const GRADING: f64 = 0.8;

/// One rod: a wire between two fittings, in cells that are short at its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rod {
    /// Diameter, m; 1e-5 to 0.02.
    pub diameter_m: f64,
    /// Length between the fittings, m; 1e-3 to 10.
    pub length_m: f64,
    /// Density, kg/m³; 1,000 to 20,000.
    pub density_kg_per_m3: f64,
    /// Specific heat, J/(kg K); 50 to 5,000.
    pub specific_heat_j_per_kg_k: f64,
    /// Resistance over length of the cold rod, Ω/m; 1e-4 to 1e5.
    pub resistance_ohm_per_m: f64,
    /// Young's modulus, Pa; 1e9 to 1e12. With a spring or a stop, the rod gives way.
    pub elastic_modulus_pa: f64,
    /// How heat runs along the rod.
    pub conductivity: Conductivity,
    /// Cells along the length, 1 (lumped) to 200.
    pub cells: usize,
}

/// Thermal conductivity: a mixture of phases, linear in temperature.
///
/// ```text
/// k = ((1 - ξ) k_M + ξ k_A) (1 + b T)        T in °C
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conductivity {
    /// Of martensite k_M, W/(m K); 0 to 500.
    pub martensite_w_per_m_k: f64,
    /// Of austenite k_A, W/(m K); 0 to 500.
    pub austenite_w_per_m_k: f64,
    /// Relative change with temperature b, 1/K; 0 to 0.01.
    pub rise_per_k: f64,
}

impl Default for Rod {
    fn default() -> Self {
        Self {
            diameter_m: 0.75e-3,
            length_m: 0.11,
            density_kg_per_m3: 6450.0,
            specific_heat_j_per_kg_k: 480.0,
            resistance_ohm_per_m: 2.13,
            elastic_modulus_pa: 50e9,
            conductivity: Conductivity::default(),
            cells: 1,
        }
    }
}

impl Default for Conductivity {
    /// 8.6 and 18 W/(m K), of nickel-titanium.
    fn default() -> Self {
        Self {
            martensite_w_per_m_k: 8.6,
            austenite_w_per_m_k: 18.0,
            rise_per_k: 5e-4,
        }
    }
}

impl Conductivity {
    pub(crate) fn at(&self, fraction: f64, temperature_degc: f64) -> f64 {
        let mixed = self.martensite_w_per_m_k
            + fraction * (self.austenite_w_per_m_k - self.martensite_w_per_m_k);
        mixed * (1.0 + self.rise_per_k * temperature_degc)
    }
}

impl Rod {
    /// Cross-section, m².
    #[must_use]
    pub fn section_m2(&self) -> f64 {
        0.25 * PI * self.diameter_m * self.diameter_m
    }

    /// Surface over length, m.
    #[must_use]
    pub fn perimeter_m(&self) -> f64 {
        PI * self.diameter_m
    }

    /// Heat capacity over length, J/(m K).
    #[must_use]
    pub fn heat_capacity_j_per_m_k(&self) -> f64 {
        self.density_kg_per_m3 * self.section_m2() * self.specific_heat_j_per_kg_k
    }

    /// Elastic stiffness, N/m.
    #[must_use]
    pub fn stiffness_n_per_m(&self) -> f64 {
        self.elastic_modulus_pa * self.section_m2() / self.length_m
    }

    /// Lengths of the cells, m: x = L (s - g sin(2πs)/(2π)) for even s.
    pub(crate) fn cell_lengths_m(&self) -> Vec<f64> {
        let place = |k: usize| {
            let s = k as f64 / self.cells as f64;
            self.length_m * (s - GRADING * (2.0 * PI * s).sin() / (2.0 * PI))
        };
        (0..self.cells).map(|k| place(k + 1) - place(k)).collect()
    }

    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("diameter_m", self.diameter_m, 1e-5..=0.02)?;
        within("length_m", self.length_m, 1e-3..=10.0)?;
        within("density_kg_per_m3", self.density_kg_per_m3, 1e3..=2e4)?;
        within(
            "specific_heat_j_per_kg_k",
            self.specific_heat_j_per_kg_k,
            50.0..=5e3,
        )?;
        within(
            "resistance_ohm_per_m",
            self.resistance_ohm_per_m,
            1e-4..=1e5,
        )?;
        within("elastic_modulus_pa", self.elastic_modulus_pa, 1e9..=1e12)?;
        within("cells", self.cells as f64, 1.0..=200.0)?;
        let conductivity = &self.conductivity;
        within(
            "martensite_w_per_m_k",
            conductivity.martensite_w_per_m_k,
            0.0..=500.0,
        )?;
        within(
            "austenite_w_per_m_k",
            conductivity.austenite_w_per_m_k,
            0.0..=500.0,
        )?;
        within("rise_per_k", conductivity.rise_per_k, 0.0..=0.01)
    }
}
