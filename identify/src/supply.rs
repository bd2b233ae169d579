//! Supply and leads between the drive and the rod: a supply that saturates, and leads that take part of the voltage.

/// Supply and leads of a rig.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Supply {
    /// Magnitude beyond which the drive acts no further, in its unit; > 0.
    ///
    /// ```text
    /// drive' = sign(drive) min(|drive|, limit)
    /// voltage, of a current I at most:   limit = I (R l + R_lead)
    /// current, of a voltage V at most:   limit = V/(R l)
    /// ```
    pub limit: Option<f64>,
    /// Resistance of leads and contacts in series with the rod, Ω; > 0.
    pub lead_resistance_ohm: Option<f64>,
}

impl Supply {
    /// Drive after the limit of the supply, in its unit.
    #[must_use]
    pub fn limited(&self, drive: f64) -> f64 {
        match self.limit {
            Some(limit) => drive.abs().min(limit).copysign(drive),
            None => drive,
        }
    }
}
