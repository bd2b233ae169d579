use crate::{
    AmbientDrift, AmbientSensor, BiasSpring, ConvectionDip, Correlation, DISTRIBUTED_CELLS,
    Draughts, EndFittings, EndStop, Fatigue, FreeConvection, Friction, LatentHeat, LoopAsymmetry,
    LoopFamily, MainsHum, MountSlip, OutputFilter, PhaseResistivity, RPhase, Radiation, SecondRod,
    SensorCubic, SensorDrift, SpringChange, StressCoupling, ThermalExpansion, Thermocouple,
    TruthPlant,
};

/// A piece of physics that a case conceals, by its usual size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs)] // Each is the field of `TruthPlant` that `install` sets.
pub enum Addition {
    SupplyLag,
    SupplyDeadTime,
    SupplyImpedance,
    PhaseResistivity,
    SecondRod,
    FreeConvection,
    Radiation,
    ConvectionDip,
    Draughts,
    AmbientDrift,
    EndFittings,
    LatentHeat,
    LoopAsymmetry,
    RPhase,
    Fatigue,
    StressCoupling,
    NestedMemory,
    SpringChange,
    EndStop,
    MountSlip,
    ThermalExpansion,
    Friction,
    SensorCubic,
    OutputFilter,
    OutputDelay,
    SensorDrift,
    MainsHum,
    Thermocouple,
}

impl Addition {
    /// All of them.
    pub const ALL: [Self; 28] = [
        Self::SupplyLag,
        Self::SupplyDeadTime,
        Self::SupplyImpedance,
        Self::PhaseResistivity,
        Self::SecondRod,
        Self::FreeConvection,
        Self::Radiation,
        Self::ConvectionDip,
        Self::Draughts,
        Self::AmbientDrift,
        Self::EndFittings,
        Self::LatentHeat,
        Self::LoopAsymmetry,
        Self::RPhase,
        Self::Fatigue,
        Self::StressCoupling,
        Self::NestedMemory,
        Self::SpringChange,
        Self::EndStop,
        Self::MountSlip,
        Self::ThermalExpansion,
        Self::Friction,
        Self::SensorCubic,
        Self::OutputFilter,
        Self::OutputDelay,
        Self::SensorDrift,
        Self::MainsHum,
        Self::Thermocouple,
    ];

    /// The name under which a catalogue of effects may know it; `None` for what stands in none, and for draughts,
    /// which no model of the mean can follow.
    #[must_use]
    pub fn catalogue_id(self) -> Option<&'static str> {
        Some(match self {
            Self::SupplyLag => "supply-lag",
            Self::SupplyDeadTime | Self::OutputDelay => "dead-time",
            Self::PhaseResistivity => "phase-dependent-resistance",
            Self::FreeConvection => "natural-convection",
            Self::Radiation => "radiation",
            Self::AmbientDrift => "ambient-drift",
            Self::EndFittings => "end-conduction",
            Self::LatentHeat => "latent-heat",
            Self::LoopAsymmetry => "loop-asymmetry",
            Self::RPhase => "r-phase",
            Self::Fatigue => "functional-fatigue",
            Self::StressCoupling => "stress-coupling",
            Self::NestedMemory => "return-point-memory",
            Self::EndStop => "end-stop",
            Self::ThermalExpansion => "thermal-expansion",
            Self::Friction => "backlash",
            Self::SensorCubic => "sensor-nonlinearity",
            Self::OutputFilter => "output-lag",
            Self::SensorDrift => "sensor-drift",
            Self::Thermocouple => "thermocouple-lag",
            Self::SupplyImpedance
            | Self::SecondRod
            | Self::ConvectionDip
            | Self::Draughts
            | Self::SpringChange
            | Self::MountSlip
            | Self::MainsHum => return None,
        })
    }

    /// Sets it in a plant: `size` 1 is the typical one, 0 changes nothing; to 2.
    ///
    /// `run_s` is the length of the run, for what happens once in it. A spring that changes and a mount that slips
    /// bring a spring where there is none, and a source's impedance a resistance that changes.
    /// [`Addition::NestedMemory`] has no size, and does nothing in a loop that nests anyway.
    pub fn install(self, plant: &mut TruthPlant, size: f64, run_s: f64) {
        match self {
            Self::SupplyLag | Self::SupplyDeadTime | Self::SupplyImpedance => {
                self.install_supply(plant, size);
            }
            Self::PhaseResistivity
            | Self::SecondRod
            | Self::FreeConvection
            | Self::Radiation
            | Self::ConvectionDip
            | Self::Draughts
            | Self::AmbientDrift
            | Self::EndFittings => self.install_heat(plant, size, run_s),
            Self::LatentHeat
            | Self::LoopAsymmetry
            | Self::RPhase
            | Self::Fatigue
            | Self::NestedMemory
            | Self::ThermalExpansion => self.install_transformation(plant, size),
            Self::StressCoupling
            | Self::SpringChange
            | Self::EndStop
            | Self::MountSlip
            | Self::Friction => self.install_load(plant, size, run_s),
            _ => self.install_sensor(plant, size, run_s),
        }
    }

    fn install_supply(self, plant: &mut TruthPlant, size: f64) {
        let rod_ohm = plant.rod.resistance_ohm_per_m * plant.rod.length_m;
        let mut supply = plant.supply.unwrap_or_default();
        match self {
            Self::SupplyLag => supply.time_constant_s = 0.3 * size,
            Self::SupplyDeadTime => supply.dead_time_s = 0.4 * size,
            _ => {
                supply.series_resistance_ohm = 0.3 * size * rod_ohm;
                supply.shunt_conductance_s = 0.3 * size / rod_ohm;
                // A source's impedance shows where the rod's resistance moves.
                plant.phase_resistivity.get_or_insert(PhaseResistivity {
                    austenite_excess: -0.15 * size,
                    rise_per_k: 0.0,
                    martensite_strain: 0.0,
                });
            }
        }
        plant.supply = Some(supply);
    }

    fn install_heat(self, plant: &mut TruthPlant, size: f64, run_s: f64) {
        let hot_k = plant.hysteresis.hot_degc() - plant.ambient_degc;
        match self {
            Self::PhaseResistivity => {
                plant.phase_resistivity = Some(PhaseResistivity {
                    austenite_excess: -0.15 * size,
                    rise_per_k: 2.5e-4 * size,
                    martensite_strain: 0.04 * size,
                });
            }
            Self::SecondRod => {
                let resistance_ratio = 1.0 + 0.3 * size;
                plant.second_rod = Some(SecondRod { resistance_ratio });
            }
            Self::FreeConvection => {
                plant.free_convection = Some(FreeConvection {
                    correlation: Correlation::ChurchillChu,
                    share: size.min(1.0),
                    reference_rise_k: 0.6 * hot_k,
                });
            }
            Self::Radiation => {
                let emissivity = (0.6 * size).min(1.0);
                plant.radiation = Some(Radiation { emissivity });
            }
            Self::ConvectionDip => {
                plant.convection_dip = Some(ConvectionDip {
                    depth: 0.25 * size,
                    center_k: 0.6 * hot_k,
                    width_k: 0.15 * hot_k,
                });
            }
            Self::Draughts => {
                plant.draughts = Some(Draughts {
                    deviation: 0.2 * size,
                    correlation_s: 0.5 * plant.time_constant_s(),
                });
            }
            Self::AmbientDrift => {
                plant.ambient_drift = Some(AmbientDrift {
                    rate_k_per_s: 0.0,
                    wave_amplitude_k: 2.0 * size,
                    wave_period_s: (1.3 * run_s).max(10.0),
                    wave_phase_rad: 0.4,
                    random_walk_k_per_root_s: (size / run_s.sqrt()).min(1.0),
                });
                // The thermometer on the wall.
                plant.ambient_sensor.get_or_insert(AmbientSensor {
                    offset_k: 0.0,
                    noise_k: 0.1,
                    sees_drift: false,
                });
            }
            _ => self.install_fittings(plant, size),
        }
    }

    /// Contacts that conduct like 3 mm of rod, fittings of ten times the rod's heat.
    fn install_fittings(self, plant: &mut TruthPlant, size: f64) {
        let rod = &mut plant.rod;
        let contact_w_per_k = rod.conductivity.martensite_w_per_m_k * rod.section_m2() / 3e-3;
        let heat_capacity_j_per_k = 10.0 * rod.heat_capacity_j_per_m_k() * rod.length_m;
        rod.cells = DISTRIBUTED_CELLS;
        plant.end_fittings = Some(EndFittings {
            contact_w_per_k: size * contact_w_per_k,
            heat_capacity_j_per_k,
            loss_w_per_k: 2.0 * contact_w_per_k,
        });
    }

    fn install_transformation(self, plant: &mut TruthPlant, size: f64) {
        let (cold_degc, hot_degc) = (plant.hysteresis.cold_degc(), plant.hysteresis.hot_degc());
        match self {
            Self::LatentHeat => {
                let enthalpy_j_per_kg = 12_000.0 * size;
                plant.latent_heat = Some(LatentHeat { enthalpy_j_per_kg });
            }
            Self::LoopAsymmetry => {
                plant.loop_asymmetry = Some(LoopAsymmetry {
                    cooling_over_heating_spread: 1.0 + 0.8 * size,
                });
            }
            Self::RPhase => {
                plant.r_phase = Some(RPhase {
                    strain_share: 0.15 * size,
                    center_degc: 0.5 * (cold_degc + hot_degc),
                    half_width_k: 1.5,
                    spread_k: 1.0,
                });
            }
            Self::Fatigue => {
                plant.fatigue = Some(Fatigue {
                    shift_k: -6.0 * size,
                    stroke_loss: 0.05 * size,
                    cycles: 5.0,
                });
            }
            Self::NestedMemory => {
                match &mut plant.hysteresis {
                    LoopFamily::L2p(parameters) => parameters.nested = size > 0.0,
                    // Domains remember where kinetics forget.
                    LoopFamily::Tanaka(kinetics) if size > 0.0 => {
                        plant.hysteresis = LoopFamily::Relays(kinetics.remembering());
                    }
                    _ => {}
                }
            }
            _ => {
                plant.thermal_expansion = Some(ThermalExpansion {
                    martensite_per_k: 6.6e-6 * size,
                    austenite_per_k: 11e-6 * size,
                });
            }
        }
    }

    fn install_load(self, plant: &mut TruthPlant, size: f64, run_s: f64) {
        let (section_m2, stroke_m) = (plant.rod.section_m2(), plant.stroke_m);
        // A preload of 100 MPa, 100 MPa more over the stroke.
        let spring = BiasSpring {
            stiffness_n_per_m: 100e6 * section_m2 / stroke_m,
            preload_n: 100e6 * section_m2,
        };
        match self {
            Self::StressCoupling => {
                plant.bias_spring = Some(BiasSpring {
                    stiffness_n_per_m: size * spring.stiffness_n_per_m,
                    ..spring
                });
                plant.stress_coupling = Some(StressCoupling {
                    clausius_clapeyron_pa_per_k: 7e6,
                });
            }
            Self::SpringChange => {
                plant.bias_spring.get_or_insert(spring);
                plant.spring_change = Some(SpringChange {
                    at_s: 0.5 * run_s,
                    over_s: (0.05 * run_s).max(0.1),
                    ratio: 1.0 - 0.2 * size,
                });
            }
            Self::EndStop => {
                plant.end_stop = Some(EndStop {
                    position_m: (1.0 - 0.2 * size) * stroke_m,
                    contact_stiffness_n_per_m: 10.0 * plant.rod.stiffness_n_per_m(),
                });
            }
            Self::MountSlip => {
                let spring = *plant.bias_spring.get_or_insert(spring);
                // Above half of the stroke; a quarter of the run at full force would lose 3 % of it.
                let surplus_n = 0.5 * spring.stiffness_n_per_m * stroke_m;
                plant.mount_slip = Some(MountSlip {
                    holding_force_n: spring.preload_n + surplus_n,
                    mobility_m_per_n_s: 0.03 * size * stroke_m
                        / (0.25 * run_s * surplus_n.max(1e-3)),
                });
            }
            _ => {
                let coupling_stiffness_n_per_m = 0.2 * plant.rod.stiffness_n_per_m();
                plant.friction = Some(Friction {
                    coulomb_force_n: 0.01 * size * stroke_m * coupling_stiffness_n_per_m,
                    coupling_stiffness_n_per_m,
                    bristle_stiffness_n_per_m: 0.4 * coupling_stiffness_n_per_m,
                });
            }
        }
    }

    fn install_sensor(self, plant: &mut TruthPlant, size: f64, run_s: f64) {
        let stroke_m = plant.stroke_m;
        match self {
            Self::SensorCubic => {
                let coefficient = 0.03 * size;
                plant.sensor_cubic = Some(SensorCubic { coefficient });
            }
            Self::OutputFilter => {
                plant.output_filter = Some(OutputFilter {
                    time_constant_s: 0.4 * size,
                    dead_time_s: 0.0,
                });
            }
            Self::OutputDelay => {
                plant.output_filter = Some(OutputFilter {
                    time_constant_s: 0.0,
                    dead_time_s: 0.3 * size,
                });
            }
            Self::SensorDrift => {
                plant.sensor_drift = Some(SensorDrift {
                    offset_m_per_k: 0.005 * size * stroke_m,
                    warming_k: 8.0,
                    warming_time_s: (run_s / 3.0).max(1.0),
                });
            }
            Self::MainsHum => {
                plant.mains_hum = Some(MainsHum {
                    amplitude_m: 0.01 * size * stroke_m,
                    frequency_hz: 50.02,
                    phase_rad: 1.0,
                });
            }
            _ => {
                plant.thermocouple = Some(Thermocouple {
                    heat_capacity_j_per_k: 4e-4 * size.max(1e-3),
                    contact_k_per_w: 4000.0,
                    loss_w_per_k: 1e-5 * size,
                });
            }
        }
    }
}
