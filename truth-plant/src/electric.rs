use crate::error::{TruthError, within};

/// Quantity of the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DriveKind {
    /// Current through each rod, A; -1,000 to 1,000.
    Current,
    /// Duty of a switched supply, 0 to 1.
    Duty {
        /// Its voltage, V; above 0, to 1,000. At least 0.01.
        supply_v: f64,
    },
    /// Voltage, V; -1,000 to 1,000.
    Voltage,
    /// Power in each rod, W; 0 to 1e5.
    Power,
}

/// Path from the drive to the rod. The drive is calibrated on the cold rod: an impedance shows only as far as the rod's
/// resistance changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Supply {
    /// Time constant with which the drive is followed, s; 0 or from 5e-4 to 100. Typical: 0.3.
    pub time_constant_s: f64,
    /// Pure delay, s; 0 to 10. Typical: 0.4.
    pub dead_time_s: f64,
    /// Resistance in series, leads and source, Ω; 0 to 100. Acts on voltages. Typical: 0.3 of the rod's.
    pub series_resistance_ohm: f64,
    /// Conductance beside the rod, S; 0 to 100. Acts on currents. Typical: 0.3 of the rod's.
    pub shunt_conductance_s: f64,
    /// Largest voltage that a current source reaches, V; above 0, infinite if there is no limit.
    pub compliance_v: f64,
}

impl Default for Supply {
    /// Ideal.
    fn default() -> Self {
        Self {
            time_constant_s: 0.0,
            dead_time_s: 0.0,
            series_resistance_ohm: 0.0,
            shunt_conductance_s: 0.0,
            compliance_v: f64::INFINITY,
        }
    }
}

/// The resistance of a volume element: phases in series along the rod, and the wire's geometry.
///
/// ```text
/// R'(ξ, T) = R'_0 (1 + ρ ξ) (1 + a (T - T_0)) (1 + ε_M (1 - ξ))²/(1 + ε_M)²
/// ```
///
/// R'_0 is the resistance of the cold rod. A stretched wire is longer and thinner, both by 1 + ε (constant volume):
/// 1 + 2ε for small ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseResistivity {
    /// Relative difference of the resistivities ρ, austenite over martensite; -0.6 to 0.6. Typical: ±0.15.
    pub austenite_excess: f64,
    /// Temperature coefficient a, 1/K; -0.002 to 0.005.
    pub rise_per_k: f64,
    /// Strain of the martensite against the austenite ε_M; 0 to 0.1. Typical: 0.04.
    pub martensite_strain: f64,
}

/// A second rod beside the first, of the same material and make but for its resistance.
///
/// Both pull a crosshead at whose middle the displacement is measured: it moves by the mean. They are wired in
/// parallel; a drive in amperes or watts counts for each rod on the average, so that two equal rods act as one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondRod {
    /// Its resistance over that of the first; 0.2 to 5. Typical: 1.3.
    pub resistance_ratio: f64,
}

impl DriveKind {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        match *self {
            Self::Duty { supply_v } => within("supply_v", supply_v, 0.01..=1e3),
            _ => Ok(()),
        }
    }

    /// Accepted samples.
    pub(crate) fn range(&self) -> std::ops::RangeInclusive<f64> {
        match self {
            Self::Current | Self::Voltage => -1e3..=1e3,
            Self::Duty { .. } => 0.0..=1.0,
            Self::Power => 0.0..=1e5,
        }
    }

    /// Mean square of the current in each strand, A²; strands in parallel of the given resistances.
    pub(crate) fn square_currents_a2(
        &self,
        (supply, cold_conductance_s): (&Supply, f64),
        amplitude: f64,
        resistances_ohm: &[f64],
        square_currents_a2: &mut [f64],
    ) {
        let strands = resistances_ohm.len() as f64;
        let conductance_s: f64 = resistances_ohm.iter().map(|ohm| 1.0 / ohm).sum();
        let divider = |conductance_s: f64| 1.0 + supply.series_resistance_ohm * conductance_s;
        let divided = divider(cold_conductance_s) / divider(conductance_s);
        // Square of the voltage across the rods, on the average over time.
        let square_v2 = match *self {
            Self::Current => {
                let cold_share = 1.0 + supply.shunt_conductance_s / cold_conductance_s;
                let voltage_v =
                    strands * amplitude * cold_share / (conductance_s + supply.shunt_conductance_s);
                voltage_v.abs().min(supply.compliance_v).powi(2)
            }
            Self::Voltage => (amplitude * divided).powi(2),
            Self::Duty { supply_v } => amplitude * (supply_v * divided).powi(2),
            Self::Power => strands * amplitude / conductance_s,
        };
        for (square_a2, ohm) in square_currents_a2.iter_mut().zip(resistances_ohm) {
            *square_a2 = square_v2 / (ohm * ohm);
        }
    }
}

impl Supply {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        if self.time_constant_s > 0.0 || self.time_constant_s.is_nan() {
            within("time_constant_s", self.time_constant_s, 5e-4..=100.0)?;
        } else {
            within("time_constant_s", self.time_constant_s, 0.0..=100.0)?;
        }
        within("dead_time_s", self.dead_time_s, 0.0..=10.0)?;
        within(
            "series_resistance_ohm",
            self.series_resistance_ohm,
            0.0..=100.0,
        )?;
        within("shunt_conductance_s", self.shunt_conductance_s, 0.0..=100.0)?;
        within("compliance_v", self.compliance_v, 1e-3..=f64::INFINITY)
    }
}

impl PhaseResistivity {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("austenite_excess", self.austenite_excess, -0.6..=0.6)?;
        within("rise_per_k", self.rise_per_k, -0.002..=0.005)?;
        within("martensite_strain", self.martensite_strain, 0.0..=0.1)
    }

    /// Resistance over that of the cold rod.
    pub(crate) fn factor(&self, fraction: f64, warming_k: f64) -> f64 {
        let stretch =
            (1.0 + self.martensite_strain * (1.0 - fraction)) / (1.0 + self.martensite_strain);
        (1.0 + self.austenite_excess * fraction)
            * (1.0 + self.rise_per_k * warming_k)
            * stretch
            * stretch
    }
}

impl SecondRod {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("resistance_ratio", self.resistance_ratio, 0.2..=5.0)
    }
}
