use crate::error::{TruthError, within};

/// The fittings that hold the ends of the rod: two alike, warmed by it and losing to the surroundings.
///
/// ```text
/// C_f dT_f/dt = G (T_end - T_f) - G_f (T_f - T_amb),     1/G = 1/G_c + Δx/(2 k A)
/// ```
///
/// G_c is the contact, the other resistance half of the rod's last cell. Without fittings the ends are adiabatic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndFittings {
    /// Conductance of a contact G_c, W/K; 0 to 100. Typical: 0.02, some kW/(m² K) over the section.
    pub contact_w_per_k: f64,
    /// Heat capacity of a fitting C_f, J/K; 0.01 to 1e6. Typical: 2.
    pub heat_capacity_j_per_k: f64,
    /// Its conductance to the surroundings G_f, W/K; 0 to 100. Typical: 0.02.
    pub loss_w_per_k: f64,
}

impl EndFittings {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("contact_w_per_k", self.contact_w_per_k, 0.0..=100.0)?;
        within(
            "heat_capacity_j_per_k",
            self.heat_capacity_j_per_k,
            0.01..=1e6,
        )?;
        within("loss_w_per_k", self.loss_w_per_k, 0.0..=100.0)
    }
}
