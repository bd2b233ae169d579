use crate::error::{TruthError, within};

/// A bead on the middle of the rod: heated through its contact, cooled by the air.
///
/// ```text
/// C_b dT_b/dt = (T - T_b)/R_c - G_b (T_b - T_amb)
/// ```
///
/// It is late by about R_c C_b and reads low by the share R_c G_b. What it takes from the rod is left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thermocouple {
    /// Heat capacity of the bead C_b, J/K; 1e-7 to 10. Typical: 4e-4.
    pub heat_capacity_j_per_k: f64,
    /// Resistance of the contact R_c, K/W; above 0, to 1e6. R_c C_b must be at least 0.001 s. Typical: 4,000.
    pub contact_k_per_w: f64,
    /// Conductance to the air G_b, W/K; 0 to 1. Typical: 1e-5.
    pub loss_w_per_k: f64,
}

impl Thermocouple {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within(
            "heat_capacity_j_per_k",
            self.heat_capacity_j_per_k,
            1e-7..=10.0,
        )?;
        within("contact_k_per_w", self.contact_k_per_w, 1e-6..=1e6)?;
        within("loss_w_per_k", self.loss_w_per_k, 0.0..=1.0)?;
        within(
            "contact_k_per_w * heat_capacity_j_per_k",
            self.contact_k_per_w * self.heat_capacity_j_per_k,
            1e-3..=1e4,
        )
    }

    pub(crate) fn rate_k_per_s(&self, rod_degc: f64, bead_degc: f64, ambient_degc: f64) -> f64 {
        ((rod_degc - bead_degc) / self.contact_k_per_w
            - self.loss_w_per_k * (bead_degc - ambient_degc))
            / self.heat_capacity_j_per_k
    }

    /// Bead temperature at rest on a rod of `rod_degc`.
    pub(crate) fn rest_degc(&self, rod_degc: f64, ambient_degc: f64) -> f64 {
        let leak = self.contact_k_per_w * self.loss_w_per_k;
        (rod_degc + leak * ambient_degc) / (1.0 + leak)
    }
}
