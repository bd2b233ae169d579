use crate::draw::{Draw, holding_power_w, hot_power_w, rod_ohm};
use crate::random::Random;
use crate::{DriveKind, TruthPlant};
use std::f64::consts::PI;

/// Shares of a run: at rest, three periods, a hot hold, at rest.
const COLD: f64 = 0.08;
const PERIODS: usize = 3;
const PERIOD: f64 = 0.24;
const HOT: f64 = 0.10;

/// Shape of a period of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Triangles of different heights.
    Ramps,
    /// Stairs up and down.
    Stairs,
    /// A full rise, shrinking loops inside, and a full fall.
    InnerLoops,
    /// Even holds at random levels.
    Steps,
    /// On and off at three rates.
    Squares,
    /// Sum of two sines.
    Sines,
    /// Uneven holds at random levels.
    Holds,
}

impl Shape {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Ramps,
        Self::Stairs,
        Self::InnerLoops,
        Self::Steps,
        Self::Squares,
        Self::Sines,
        Self::Holds,
    ];
}

/// A drive in time.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveProfile {
    /// One value a sample, in the unit of the plant's drive.
    pub drive: Vec<f64>,
    /// Length of a sample, s.
    pub dt_s: f64,
}

/// A straight piece: share of the period, level at its start and end. Levels are shares of the largest drive.
type Piece = (f64, f64, f64);

impl Draw {
    /// A drive for a plant: rest, three equal periods of the shape, a hot hold, rest.
    ///
    /// A sample takes 1 to 4 % of the plain rod's time constant, so that 9,000 of them are 90 to 360 of it. The
    /// largest level completes the plain rod's transformation. Depends on what the plant is made of, not on what has
    /// been added.
    #[must_use]
    pub fn drive(&self, shape: Shape, plant: &TruthPlant, n_samples: usize) -> DriveProfile {
        let mut random = self.drive_random();
        let dt_s = plant.time_constant_s() * random.between(0.01, 0.04);
        let pieces = pieces(shape, plant, &mut random);
        let phases = [0.0, 2.0 * PI * random.uniform()];
        let largest = largest_drive(plant);
        let cold_end = PERIODS as f64 * PERIOD + COLD;
        let level = |time: f64| {
            if time < COLD {
                0.0
            } else if time < cold_end {
                let s = ((time - COLD) / PERIOD).fract();
                if shape == Shape::Sines {
                    sines(s, phases)
                } else {
                    at(&pieces, s)
                }
            } else if time < cold_end + HOT {
                1.0
            } else {
                0.0
            }
        };
        let drive = (0..n_samples)
            .map(|k| largest * level(k as f64 / n_samples as f64))
            .collect();
        DriveProfile { drive, dt_s }
    }
}

/// The drive that completes the transformation of the plain rod.
pub(crate) fn largest_drive(plant: &TruthPlant) -> f64 {
    let (power_w, ohm) = (hot_power_w(plant), rod_ohm(plant));
    match plant.drive {
        DriveKind::Current => (power_w / ohm).sqrt(),
        DriveKind::Voltage => (power_w * ohm).sqrt(),
        DriveKind::Duty { supply_v } => (power_w * ohm / (supply_v * supply_v)).min(1.0),
        DriveKind::Power => power_w,
    }
}

impl TruthPlant {
    /// The plant with a convective coefficient at which this drive, in the unit of its kind, just completes the plain
    /// rod's transformation, with a margin of a fifth in power.
    #[must_use]
    pub fn completed_by(mut self, drive: f64) -> Self {
        let ohm = rod_ohm(&self);
        let power_w = match self.drive {
            DriveKind::Current => drive * drive * ohm,
            DriveKind::Voltage => drive * drive / ohm,
            DriveKind::Duty { supply_v } => drive * supply_v * supply_v / ohm,
            DriveKind::Power => drive,
        };
        self.convective_coefficient_w_per_m2_k *= power_w / hot_power_w(&self);
        self
    }
}

/// Level that holds the plain rod at a temperature.
fn level_of(plant: &TruthPlant, temperature_degc: f64) -> f64 {
    let share = holding_power_w(plant, temperature_degc) / hot_power_w(plant);
    match plant.drive {
        DriveKind::Current | DriveKind::Voltage => share.sqrt(),
        DriveKind::Duty { .. } | DriveKind::Power => share,
    }
}

/// Level that holds the plain rod inside the loop, so far between its cold and its hot end.
pub(crate) fn inside(plant: &TruthPlant, share: f64) -> f64 {
    let (cold_degc, hot_degc) = (plant.hysteresis.cold_degc(), plant.hysteresis.hot_degc());
    level_of(plant, cold_degc + share * (hot_degc - cold_degc))
}

/// Power at a level, share of the largest.
pub(crate) fn power_share(plant: &TruthPlant, level: f64) -> f64 {
    match plant.drive {
        DriveKind::Current | DriveKind::Voltage => level * level,
        DriveKind::Duty { .. } | DriveKind::Power => level,
    }
}

fn sines(s: f64, phases: [f64; 2]) -> f64 {
    let fade = (20.0 * s).min(20.0 * (1.0 - s)).min(1.0);
    let wave = 0.35 * (2.0 * PI * 2.0 * s - 0.5 * PI + phases[0]).sin()
        + 0.15 * (2.0 * PI * 7.0 * s + phases[1]).sin();
    fade * (0.5 + wave)
}

fn at(pieces: &[Piece], s: f64) -> f64 {
    let mut left = s;
    for &(share, from, to) in pieces {
        if left < share {
            return from + (to - from) * left / share;
        }
        left -= share;
    }
    0.0
}

fn pieces(shape: Shape, plant: &TruthPlant, random: &mut Random) -> Vec<Piece> {
    match shape {
        Shape::Ramps => {
            let n = 2 + random.below(3);
            let each = 0.5 / n as f64;
            let mut pieces = Vec::new();
            for k in 0..n {
                let height = if k == 0 {
                    1.0
                } else {
                    random.between(0.7, 1.0)
                };
                pieces.extend([(each, 0.0, height), (each, height, 0.0)]);
            }
            pieces
        }
        Shape::Stairs => {
            let n = 5 + random.below(5);
            let each = 0.5 / (n + 1) as f64;
            let up = (1..=n).map(|k| k as f64 / n as f64);
            let down = (0..n).rev().map(|k| k as f64 / n as f64);
            up.chain(down).map(|level| (each, level, level)).collect()
        }
        Shape::InnerLoops => inner_loops(plant, random),
        Shape::Steps => {
            let n = 6 + random.below(5);
            let levels = (0..n).map(|k| match k {
                0 => 1.0,
                _ => random.between(0.3, 1.0),
            });
            let each = 1.0 / (n + 1) as f64;
            levels.map(|level| (each, level, level)).collect()
        }
        Shape::Squares => {
            let half_periods = [0.12, 0.06, 0.03].map(|share| share * random.between(0.8, 1.1));
            let mut pieces = Vec::new();
            for half in half_periods {
                for _ in 0..2 {
                    pieces.extend([(half, 1.0, 1.0), (half, 0.0, 0.0)]);
                }
            }
            pieces
        }
        // Made of no straight pieces.
        Shape::Sines => Vec::new(),
        Shape::Holds => {
            let n = 8 + random.below(9);
            let lengths: Vec<f64> = (0..=n).map(|_| random.between(0.3, 1.7)).collect();
            let total: f64 = lengths.iter().sum();
            let holds = lengths.iter().take(n).enumerate();
            holds
                .map(|(k, length)| {
                    let level = if k == 0 {
                        1.0
                    } else {
                        random.between(0.0, 1.0)
                    };
                    (length / total, level, level)
                })
                .collect()
        }
    }
}

/// Between levels that hold the rod well inside the loop.
fn inner_loops(plant: &TruthPlant, random: &mut Random) -> Vec<Piece> {
    let inside = |share: f64| inside(plant, share);
    let n = 3 + random.below(4);
    let each = 0.7 / (2 * n) as f64;
    let mut pieces = vec![(0.15, 0.0, 1.0)];
    let mut from = 1.0;
    for k in 0..n {
        let narrow = 0.3 * k as f64 / n as f64;
        let low = inside(random.between(0.15, 0.25) + narrow);
        let high = inside(random.between(0.75, 0.85) - narrow);
        pieces.extend([(each, from, low), (each, low, high)]);
        from = high;
    }
    pieces.push((0.1, from, 0.0));
    pieces
}
