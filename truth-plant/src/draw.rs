use crate::random::{Random, Stream};
use crate::{
    Addition, Converter, CosineLoop, DriveKind, L2pLoop, LoopFamily, Noise, NoiseKind,
    PreisachLoop, RelayLoop, Rod, TanakaLoop, TruthPlant,
};

/// Which family of loops to draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FamilyKind {
    /// Limiting-loop proximity with the paper's memory.
    L2p,
    /// Limiting-loop proximity with all reversals.
    L2pNested,
    /// Preisach.
    Preisach,
    /// Cosine kinetics.
    Cosine,
    /// Explicit relays, in the lumped plant.
    Relays,
    /// Exponential kinetics, in the lumped plant.
    Tanaka,
}

/// Which drive to draw a plant for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DriveName {
    /// Current.
    Current,
    /// Duty of a switched supply.
    Duty,
    /// Voltage.
    Voltage,
    /// Power.
    Power,
}

/// Cases from a seed: every kind of draw has a stream of its own, so that none tells of another.
///
/// | drawn | range |
/// | --- | --- |
/// | diameter | 0.2 to 1.5 mm, even in the logarithm |
/// | length | 60 to 300 mm |
/// | resistivity | 0.7 to 1.0 µΩ m |
/// | specific heat | 450 to 840 J/(kg K) |
/// | density | 6,400 to 6,500 kg/m³ |
/// | convective coefficient | 25 to 120 W/(m² K), even in the logarithm |
/// | ambient | 17 to 28 °C |
/// | middle of the loop | 55 to 75 °C |
/// | half width | 4 to 12 K |
/// | spread (h_0 of the arc tangent) | 1.5 to 4 K; deviation of Preisach's and of the relays and mean way of the kinetics 1.5 times, range of the cosine 4.5 times that |
/// | ζ | 0.6 to 1; ϱ of Preisach 0.2 to 0.8, of the relays 0.3 to 0.9; their tails 0 to 0.8 |
/// | stroke | 3 to 5 % of the length |
/// | noise | 0.05 to 0.5 % of the stroke, even in the logarithm |
/// | converter | 10 to 14 bits over 1.3 strokes |
/// | size of an addition | ½, 1, 2 |
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Draw {
    seed: u64,
}

impl Draw {
    /// The case of a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { seed }
    }

    /// A plain plant.
    #[must_use]
    pub fn plant(&self, family: FamilyKind, drive: DriveName) -> TruthPlant {
        let mut random = Random::new(self.seed, Stream::DrawRod);
        let diameter_m = random.log_between(0.2e-3, 1.5e-3);
        let mut rod = Rod {
            diameter_m,
            length_m: random.between(0.06, 0.3),
            density_kg_per_m3: random.between(6400.0, 6500.0),
            specific_heat_j_per_kg_k: random.between(450.0, 840.0),
            ..Rod::default()
        };
        rod.resistance_ohm_per_m = random.between(0.7e-6, 1.0e-6) / rod.section_m2();
        let convective_coefficient_w_per_m2_k = random.log_between(25.0, 120.0);
        let ambient_degc = random.between(17.0, 28.0);
        let mut random = Random::new(self.seed, Stream::DrawLoad);
        let stroke_m = rod.length_m * random.between(0.03, 0.05);
        let mut plant = TruthPlant {
            rod,
            convective_coefficient_w_per_m2_k,
            ambient_degc,
            hysteresis: self.family(family),
            stroke_m,
            offset_m: random.between(-0.2, 0.2) * stroke_m,
            ..TruthPlant::default()
        };
        plant.drive = match drive {
            DriveName::Current => DriveKind::Current,
            DriveName::Voltage => DriveKind::Voltage,
            DriveName::Power => DriveKind::Power,
            DriveName::Duty => {
                let needed_v = hot_power_w(&plant).sqrt() * rod_ohm(&plant).sqrt();
                DriveKind::Duty {
                    supply_v: needed_v * random.between(1.1, 1.6),
                }
            }
        };
        plant
    }

    fn family(&self, family: FamilyKind) -> LoopFamily {
        let mut random = Random::new(self.seed, Stream::DrawLoop);
        let center_degc = random.between(55.0, 75.0);
        let half_width_k = random.between(4.0, 12.0);
        let spread_k = random.between(1.5, 4.0);
        let shape = random.uniform();
        match family {
            FamilyKind::L2p | FamilyKind::L2pNested => LoopFamily::L2p(L2pLoop {
                loop_center_degc: center_degc,
                loop_half_width_k: half_width_k,
                loop_spread_k: spread_k,
                zeta: 0.6 + 0.4 * shape,
                cooling_over_heating_spread: 1.0,
                nested: family == FamilyKind::L2pNested,
            }),
            FamilyKind::Preisach => LoopFamily::Preisach(PreisachLoop {
                heating_center_degc: center_degc + half_width_k,
                heating_deviation_k: 1.5 * spread_k,
                cooling_center_degc: center_degc - half_width_k,
                cooling_deviation_k: 1.5 * spread_k,
                correlation: 0.2 + 0.6 * shape,
            }),
            FamilyKind::Relays => LoopFamily::Relays(RelayLoop {
                heating_center_degc: center_degc + half_width_k,
                heating_deviation_k: 1.5 * spread_k,
                cooling_center_degc: center_degc - half_width_k,
                cooling_deviation_k: 1.5 * spread_k,
                correlation: 0.3 + 0.6 * shape,
                tails: 0.8 * random.uniform(),
            }),
            FamilyKind::Tanaka => {
                // Half of the transformation is done a center away from its middle.
                let mean_k = 1.5 * spread_k;
                let half_done_k = mean_k * std::f64::consts::LN_2;
                LoopFamily::Tanaka(TanakaLoop {
                    martensite_start_degc: center_degc - half_width_k + half_done_k,
                    martensite_rate_per_k: 1.0 / mean_k,
                    austenite_start_degc: center_degc + half_width_k - half_done_k,
                    austenite_rate_per_k: 1.0 / mean_k,
                })
            }
            FamilyKind::Cosine => {
                let half_range_k = 2.25 * spread_k;
                LoopFamily::Cosine(CosineLoop {
                    martensite_finish_degc: center_degc - half_width_k - half_range_k,
                    martensite_start_degc: center_degc - half_width_k + half_range_k,
                    austenite_start_degc: center_degc + half_width_k - half_range_k,
                    austenite_finish_degc: center_degc + half_width_k + half_range_k,
                })
            }
        }
    }

    /// Noise of a kind on a plant's displacement, with its converter.
    pub fn noise(&self, kind: NoiseKind, plant: &mut TruthPlant) {
        let mut random = Random::new(self.seed, Stream::DrawNoise);
        plant.displacement_noise = Some(Noise {
            kind,
            deviation: random.log_between(5e-4, 5e-3) * plant.stroke_m,
        });
        plant.converter = Some(Converter {
            full_scale_m: 1.3 * plant.stroke_m,
            lowest_m: plant.offset_m - 0.15 * plant.stroke_m,
            bits: 10 + random.below(5) as u32,
        });
    }

    /// One of some additions; `None` if there are none.
    #[must_use]
    pub fn addition(&self, among: &[Addition]) -> Option<Addition> {
        let mut random = Random::new(self.seed, Stream::DrawAddition);
        among.get(random.below(among.len().max(1))).copied()
    }

    /// Its size: ½, 1 or 2.
    #[must_use]
    pub fn size(&self) -> f64 {
        let mut random = Random::new(self.seed, Stream::DrawSize);
        [0.5, 1.0, 2.0][random.below(3)]
    }

    pub(crate) fn drive_random(&self) -> Random {
        Random::new(self.seed, Stream::DrawDrive)
    }
}

/// Resistance of the cold rod, Ω.
pub(crate) fn rod_ohm(plant: &TruthPlant) -> f64 {
    plant.rod.resistance_ohm_per_m * plant.rod.length_m
}

/// Power that holds the plain rod at `temperature_degc`, W.
pub(crate) fn holding_power_w(plant: &TruthPlant, temperature_degc: f64) -> f64 {
    plant.convective_coefficient_w_per_m2_k
        * plant.rod.perimeter_m()
        * plant.rod.length_m
        * (temperature_degc - plant.ambient_degc).max(0.0)
}

/// Power that completes the transformation of the plain rod, with a margin of a fifth, W.
pub(crate) fn hot_power_w(plant: &TruthPlant) -> f64 {
    1.2 * holding_power_w(plant, plant.hysteresis.hot_degc())
}
