use truth_plant::{Addition, TruthPlant};

/// Size of an addition in the catalogue: the value of its effect's first size, and whether that is in true units only if
/// heat capacity and resistance are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Size {
    pub(crate) value: f64,
    pub(crate) needs_scale: bool,
}

/// The size of what a plant conceals, in the unit of the catalogue; `None` where truth and catalogue cannot be compared.
///
/// Where the truth has more of a shape than the catalogue's one number, it is the least that the number can be: what is
/// "excluded above" less than this is there.
pub(crate) fn size(addition: Addition, plant: &TruthPlant) -> Option<Size> {
    let of_any_scale = |value: f64| Size {
        value,
        needs_scale: false,
    };
    let of_scale = |value: f64| Size {
        value,
        needs_scale: true,
    };
    Some(match addition {
        // s.
        Addition::SupplyLag => of_any_scale(plant.supply?.time_constant_s),
        Addition::SupplyDeadTime => of_any_scale(plant.supply?.dead_time_s),
        Addition::OutputDelay => of_any_scale(plant.output_filter?.dead_time_s),
        Addition::OutputFilter => of_any_scale(plant.output_filter?.time_constant_s),
        Addition::Thermocouple => {
            // Behind its contact; its own loss is another parameter.
            let bead = plant.thermocouple?;
            of_any_scale(bead.contact_k_per_w * bead.heat_capacity_j_per_k)
        }
        // Shares of the stroke.
        Addition::Friction => {
            let friction = plant.friction?;
            let play_m = 2.0 * friction.coulomb_force_n / friction.coupling_stiffness_n_per_m;
            of_any_scale(play_m / plant.stroke_m)
        }
        Addition::SensorDrift => {
            let drift = plant.sensor_drift?;
            // Over three time constants.
            of_any_scale(0.95 * drift.offset_m_per_k * drift.warming_k / plant.stroke_m)
        }
        Addition::RPhase => of_any_scale(plant.r_phase?.strain_share),
        // Shares of their own.
        Addition::PhaseResistivity => {
            let phase = plant.phase_resistivity?;
            let stretch = (1.0 + phase.martensite_strain).powi(2);
            of_any_scale(((1.0 + phase.austenite_excess) / stretch - 1.0).abs())
        }
        Addition::EndStop => {
            let contact_n_per_m = plant.end_stop?.contact_stiffness_n_per_m;
            of_any_scale(contact_n_per_m / (contact_n_per_m + plant.rod.stiffness_n_per_m()))
        }
        // K, J/kg and emissivity.
        Addition::Fatigue => {
            let fatigue = plant.fatigue?;
            of_scale((fatigue.shift_k * (-1.0 / fatigue.cycles).exp_m1()).abs())
        }
        Addition::AmbientDrift => of_scale(plant.ambient_drift?.wave_amplitude_k),
        Addition::LatentHeat => of_scale(plant.latent_heat?.enthalpy_j_per_kg),
        Addition::Radiation => of_scale(plant.radiation?.emissivity),
        Addition::StressCoupling => {
            let spring = plant.bias_spring?;
            let yields = spring.stiffness_n_per_m / plant.rod.stiffness_n_per_m();
            let swing_n = spring.stiffness_n_per_m * plant.stroke_m / (1.0 + yields);
            let rise_n_per_k =
                plant.rod.section_m2() * plant.stress_coupling?.clausius_clapeyron_pa_per_k;
            of_scale(swing_n / rise_n_per_k)
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_grow_with_what_is_installed() {
        for addition in Addition::ALL {
            let of = |scale: f64| {
                let mut plant = TruthPlant::default();
                addition.install(&mut plant, scale, 300.0);
                size(addition, &plant).map(|size| size.value)
            };
            let (Some(half), Some(whole)) = (of(0.5), of(1.0)) else {
                continue;
            };
            assert!(half > 0.0 && whole >= half, "{addition:?}: {half} {whole}");
        }
    }
}
