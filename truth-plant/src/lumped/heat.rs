//! Heating and heat losses of the lumped mass.

use super::film::coefficient_w_per_m2_k;
use crate::{DriveKind, Supply, TruthPlant};

/// Stefan's and Boltzmann's constant, W/(m² K⁴).
const RADIATION_W_PER_M2_K4: f64 = 5.670_374e-8;
/// Freezing point of water, K.
const FREEZING_K: f64 = 273.15;

/// Surroundings of the rod at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Air {
    pub(super) ambient_degc: f64,
    /// Factor of convection.
    pub(super) draught: f64,
}

/// A wire as one mass.
#[derive(Debug, Clone)]
pub(super) struct Wire<'a> {
    plant: &'a TruthPlant,
    supply: Supply,
    surface_m2: f64,
    pub(super) capacity_j_per_k: f64,
    cold_ohm: [f64; 2],
    n_wires: usize,
    /// Into both fittings, from the mean of the wire, W/K.
    end_w_per_k: f64,
    /// Coefficient of the film at the reference, W/(m² K).
    film_w_per_m2_k: f64,
}

impl<'a> Wire<'a> {
    pub(super) fn new(plant: &'a TruthPlant) -> Self {
        let rod = &plant.rod;
        let ohm = rod.resistance_ohm_per_m * rod.length_m;
        let second = plant.second_rod.map(|second| second.resistance_ratio * ohm);
        let film = plant.free_convection.map(|free| {
            let hot_degc = plant.ambient_degc + free.reference_rise_k;
            coefficient_w_per_m2_k(rod.diameter_m, hot_degc, plant.ambient_degc)
        });
        Self {
            plant,
            supply: plant.supply.unwrap_or_default(),
            surface_m2: rod.perimeter_m() * rod.length_m,
            capacity_j_per_k: rod.heat_capacity_j_per_m_k() * rod.length_m,
            cold_ohm: [ohm, second.unwrap_or(f64::INFINITY)],
            n_wires: 1 + usize::from(second.is_some()),
            end_w_per_k: end_w_per_k(plant),
            film_w_per_m2_k: film.unwrap_or(1.0),
        }
    }

    pub(super) fn n_wires(&self) -> usize {
        self.n_wires
    }

    /// Resistance of a wire, Ω: resistivities mix with the phases and rise with the temperature; martensite is longer, and
    /// of the same volume thinner.
    fn ohm(&self, wire: usize, fraction: f64, warming_k: f64) -> f64 {
        let cold_ohm = self.cold_ohm[wire];
        let Some(phase) = self.plant.phase_resistivity else {
            return cold_ohm;
        };
        let resistivity = (1.0 - fraction) + fraction * (1.0 + phase.austenite_excess);
        let length = 1.0 + phase.martensite_strain * (1.0 - fraction);
        let cold_length = 1.0 + phase.martensite_strain;
        let warm = 1.0 + phase.rise_per_k * warming_k;
        cold_ohm * resistivity * warm * (length / cold_length).powi(2)
    }

    /// Heat that the drive brings about in each wire, W, at `(fraction, warming)` of each.
    pub(super) fn heating_w(&self, drive: f64, wires: &[(f64, f64)]) -> [f64; 2] {
        let n = wires.len() as f64;
        let mut ohms = [f64::INFINITY; 2];
        for (wire, &(fraction, warming_k)) in wires.iter().enumerate() {
            ohms[wire] = self.ohm(wire, fraction, warming_k);
        }
        let siemens: f64 = ohms.iter().map(|ohm| 1.0 / ohm).sum();
        let cold_siemens: f64 = self.cold_ohm.iter().map(|ohm| 1.0 / ohm).sum();
        let Supply {
            series_resistance_ohm: series_ohm,
            shunt_conductance_s: shunt_s,
            compliance_v,
            ..
        } = self.supply;
        // What the supply is set to is right for the cold wires.
        let sagging = (1.0 + series_ohm * cold_siemens) / (1.0 + series_ohm * siemens);
        let mean_square_v2 = match self.plant.drive {
            DriveKind::Current => {
                let source_a = n * drive * (1.0 + shunt_s / cold_siemens);
                (source_a / (siemens + shunt_s))
                    .abs()
                    .min(compliance_v)
                    .powi(2)
            }
            DriveKind::Voltage => (drive * sagging).powi(2),
            DriveKind::Duty { supply_v } => drive * (supply_v * sagging).powi(2),
            DriveKind::Power => n * drive / siemens,
        };
        ohms.map(|ohm| mean_square_v2 / ohm)
    }

    /// Heat that a wire loses to the air and by radiation, W.
    pub(super) fn loss_w(&self, degc: f64, air: Air) -> f64 {
        let plant = self.plant;
        let rise_k = degc - air.ambient_degc;
        let mut coefficient = plant.convective_coefficient_w_per_m2_k;
        if let Some(free) = plant.free_convection {
            let film = coefficient_w_per_m2_k(plant.rod.diameter_m, degc, air.ambient_degc);
            let forced = 1.0 - free.share;
            coefficient *= forced + free.share * film / self.film_w_per_m2_k;
        }
        if let Some(dip) = plant.convection_dip {
            let away = (rise_k - dip.center_k) / dip.width_k;
            coefficient -= coefficient * dip.depth * (-away.powi(2)).exp();
        }
        let mut watts = self.surface_m2 * coefficient * air.draught * rise_k;
        if let Some(radiation) = plant.radiation {
            let [own, other] = [degc, air.ambient_degc].map(|degc| (degc + FREEZING_K).powi(4));
            watts += radiation.emissivity * RADIATION_W_PER_M2_K4 * self.surface_m2 * (own - other);
        }
        watts
    }

    /// Heat into both fittings, W.
    pub(super) fn end_flow_w(&self, degc: f64, fitting_degc: f64) -> f64 {
        self.end_w_per_k * (degc - fitting_degc)
    }

    /// Rate of the fittings' common temperature, K/s.
    pub(super) fn fitting_rate_k_per_s(
        &self,
        received_w: f64,
        degc: f64,
        ambient_degc: f64,
    ) -> f64 {
        let Some(fittings) = self.plant.end_fittings else {
            return 0.0;
        };
        let n = 2.0 * self.n_wires as f64;
        let lost_w = n * fittings.loss_w_per_k * (degc - ambient_degc);
        (received_w - lost_w) / (n * fittings.heat_capacity_j_per_k)
    }
}

/// Conductance into both fittings: each a contact in series with what a fin of half the wire takes up at its root,
/// √(h P k A) tanh(L/2ℓ).
fn end_w_per_k(plant: &TruthPlant) -> f64 {
    let Some(fittings) = plant.end_fittings else {
        return 0.0;
    };
    let rod = &plant.rod;
    let phases = &rod.conductivity;
    let conductivity_w_per_m_k = 0.5 * (phases.martensite_w_per_m_k + phases.austenite_w_per_m_k);
    let side_w_per_m_k = plant.convective_coefficient_w_per_m2_k * rod.perimeter_m();
    let along_w_m_per_k = conductivity_w_per_m_k * rod.section_m2();
    let reach_m = (along_w_m_per_k / side_w_per_m_k).sqrt();
    let fin_w_per_k =
        (side_w_per_m_k * along_w_m_per_k).sqrt() * (0.5 * rod.length_m / reach_m).tanh();
    2.0 / (1.0 / fittings.contact_w_per_k + 1.0 / fin_w_per_k)
}
