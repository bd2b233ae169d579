use crate::drives::{inside, largest_drive, power_share};
use crate::random::Random;
use crate::{Draw, DriveProfile, TruthPlant};
use std::f64::consts::PI;

/// Lowest level of a rig that never rests.
const LOWEST_DRIVEN: f64 = 0.3;

/// How a lab drives a rig that nobody has given a guide to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Manner {
    /// Random steps, ramps and sines, one after the other, from rest; nothing comes twice.
    NoRepeats,
    /// Random steps, ramps and sines, driven from the first sample to the last; nothing comes twice.
    NoRests,
    /// Random steps, ramps and sines, the beginning cut away: the rod starts warm and partly transformed.
    WarmStart,
    /// A single rise and fall between two rests.
    OneExcursion,
    /// One to three triangles, slow against the rod.
    SlowRamps,
    /// Holds at random levels.
    StepsOnly,
    /// A controller's on and off around levels.
    Chatter,
}

/// Sampling and dead zone of a recording, known before its drive is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Logging {
    /// Samples that are recorded; at least 100.
    pub n_samples: usize,
    /// Length of a sample, s.
    pub dt_s: f64,
    /// Share of the largest drive below which the driver gives nothing; 0 to 0.2. Nobody commands less, but for 0.
    pub dead_zone: f64,
}

/// A drive of which the recording has only the end.
#[derive(Debug, Clone, PartialEq)]
pub struct LabDrive {
    /// The whole drive, from rest.
    pub profile: DriveProfile,
    /// Samples that went before the recording.
    pub n_before: usize,
}

impl Manner {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::NoRepeats,
        Self::NoRests,
        Self::WarmStart,
        Self::OneExcursion,
        Self::SlowRamps,
        Self::StepsOnly,
        Self::Chatter,
    ];

    /// Its name in files.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::NoRepeats => "no-repeats",
            Self::NoRests => "no-rests",
            Self::WarmStart => "warm-start",
            Self::OneExcursion => "one-excursion",
            Self::SlowRamps => "slow-ramps",
            Self::StepsOnly => "steps-only",
            Self::Chatter => "chatter",
        }
    }

    /// Time constants of the plain rod that a recording of this manner lasts at least.
    #[must_use]
    pub fn shortest_time_constants(self) -> f64 {
        match self {
            Self::SlowRamps => 40.0,
            _ => 14.0,
        }
    }
}

impl Draw {
    /// A drive in the manner of a lab, for a plant. Depends on what the plant is made of, not on what has been added.
    #[must_use]
    pub fn lab_drive(&self, manner: Manner, plant: &TruthPlant, logging: Logging) -> LabDrive {
        let mut hand = Hand {
            random: self.drive_random(),
            plant,
            logging,
            unit: ((plant.time_constant_s() / logging.dt_s) as usize)
                .min(logging.n_samples / 24)
                .max(2),
            levels: Vec::new(),
            n_before: 0,
        };
        hand.drive(manner);
        let n = hand.n_before + logging.n_samples;
        let last = hand.levels.last().copied().unwrap_or(0.0);
        hand.levels.resize(n, last);
        let largest = largest_drive(plant);
        let commanded = |level: f64| {
            let is_given = level >= logging.dead_zone;
            largest * if is_given { level } else { 0.0 }
        };
        LabDrive {
            profile: DriveProfile {
                drive: hand.levels.iter().copied().map(commanded).collect(),
                dt_s: logging.dt_s,
            },
            n_before: hand.n_before,
        }
    }
}

/// Who turns the knob: levels are shares of the largest drive.
struct Hand<'a> {
    random: Random,
    plant: &'a TruthPlant,
    logging: Logging,
    /// Samples of a time constant, or fewer where the recording is short: what pieces are measured in.
    unit: usize,
    levels: Vec<f64>,
    n_before: usize,
}

impl Hand<'_> {
    fn drive(&mut self, manner: Manner) {
        let n = self.logging.n_samples;
        match manner {
            Manner::NoRepeats => {
                self.rest(0.04);
                self.pieces(n, 0.0);
            }
            Manner::NoRests => {
                let level = self.level(LOWEST_DRIVEN);
                self.hold(level, 0.5, 2.0);
                self.pieces(n, LOWEST_DRIVEN);
            }
            Manner::WarmStart => {
                let before = self.random.between(6.0, 14.0) * self.unit as f64;
                self.pieces(before as usize, 0.0);
                // From above or from below, into the branch that leads there.
                let is_above = self.random.uniform() < 0.6;
                self.hold(if is_above { 1.0 } else { 0.0 }, 3.0, 4.0);
                let from_end = self.random.between(0.22, 0.45);
                let share = if is_above { from_end } else { 1.0 - from_end };
                let level = inside(self.plant, share);
                self.hold(level, 3.0, 5.0);
                self.n_before = self.levels.len();
                self.hold(level, 0.5, 2.0);
                self.pieces(self.n_before + n, 0.0);
            }
            Manner::OneExcursion => self.excursion(),
            Manner::SlowRamps => self.triangles(),
            Manner::StepsOnly => {
                self.rest(0.04);
                self.hold(1.0, 3.0, 5.0);
                while self.levels.len() < n {
                    let level = self.level(0.0);
                    self.hold(level, 1.0, 5.0);
                }
            }
            Manner::Chatter => self.chatter(),
        }
    }

    fn rest(&mut self, share: f64) {
        let n = (share * self.logging.n_samples as f64) as usize;
        self.levels.resize(self.levels.len() + n.max(5), 0.0);
    }

    /// A level that holds the rod in its loop or near it; in one of six where rests are allowed, none.
    fn level(&mut self, lowest: f64) -> f64 {
        let rests = lowest < LOWEST_DRIVEN && self.random.uniform() < 1.0 / 6.0;
        let level = inside(self.plant, self.random.between(0.1, 1.0));
        if rests { 0.0 } else { level.max(lowest) }
    }

    fn duration(&mut self, shortest: f64, longest: f64) -> usize {
        ((self.random.between(shortest, longest) * self.unit as f64) as usize).max(2)
    }

    /// Holds a level over so many units.
    fn hold(&mut self, level: f64, shortest: f64, longest: f64) {
        let n = self.duration(shortest, longest);
        self.levels.resize(self.levels.len() + n, level);
    }

    fn ramp(&mut self, to: f64, n: usize) {
        let from = self.levels.last().copied().unwrap_or(0.0);
        let part = |k: usize| from + (to - from) * (k + 1) as f64 / n as f64;
        self.levels.extend((0..n).map(part));
    }

    /// One to four periods around a level, as far as it goes.
    fn sine(&mut self, lowest: f64) {
        let middle = inside(self.plant, self.random.between(0.35, 0.65));
        let widest = (1.0 - middle).min(middle - lowest);
        let amplitude = self.random.between(0.4, 1.0) * widest;
        let n = self.duration(2.0, 7.0);
        let periods = self.random.between(1.0, 4.0);
        let phase = 2.0 * PI * self.random.uniform();
        let wave = |k: usize| {
            middle + amplitude * (2.0 * PI * periods * k as f64 / n as f64 + phase).sin()
        };
        self.levels.extend((0..n).map(wave));
    }

    /// Steps, ramps and sines up to so many samples, the third piece at the largest drive, the fourth at the lowest, none
    /// below that.
    fn pieces(&mut self, until: usize, lowest: f64) {
        let mut piece = 0;
        while self.levels.len() < until {
            match (piece, self.random.below(3)) {
                (2, _) => self.hold(1.0, 3.0, 4.0),
                (3, _) => self.hold(lowest, 3.0, 4.0),
                (_, 0) => {
                    let level = self.level(lowest);
                    self.hold(level, 1.0, 5.0);
                }
                (_, 1) => {
                    let (level, n) = (self.level(lowest), self.duration(1.0, 6.0));
                    self.ramp(level, n);
                }
                _ => self.sine(lowest),
            }
            piece += 1;
        }
    }

    fn excursion(&mut self) {
        let n = self.logging.n_samples as f64;
        let rest = self.random.between(0.06, 0.15);
        self.rest(rest);
        let height = self.random.between(0.85, 1.0);
        let rise = (self.random.between(0.05, 0.35) * n) as usize;
        if self.random.uniform() < 0.3 {
            self.levels.resize(self.levels.len() + rise, height);
        } else {
            self.ramp(height, rise.max(2));
        }
        let top = (self.random.between(0.05, 0.2) * n) as usize;
        self.levels.resize(self.levels.len() + top, height);
        if self.random.uniform() < 0.7 {
            let fall = (self.random.between(0.05, 0.3) * n) as usize;
            self.ramp(0.0, fall.max(2));
        }
        self.rest(1.0);
        self.levels.truncate(self.logging.n_samples);
    }

    fn triangles(&mut self) {
        let n = self.logging.n_samples as f64;
        self.rest(0.04);
        let n_triangles = 1 + self.random.below(3);
        let each = 0.92 * n / n_triangles as f64;
        for k in 0..n_triangles {
            let height = if k == 0 {
                1.0
            } else {
                self.random.between(0.7, 1.0)
            };
            let low = if k + 1 == n_triangles {
                0.0
            } else {
                self.random.between(0.0, 0.5)
            };
            let rise = (self.random.between(0.3, 0.7) * each) as usize;
            self.ramp(height, rise);
            self.ramp(low, each as usize - rise);
        }
        self.rest(0.1);
        self.levels.truncate(self.logging.n_samples);
    }

    /// A switch with a band, over an observer of the plain rod's temperature.
    fn chatter(&mut self) {
        self.rest(0.04);
        let kept = (-self.logging.dt_s / self.plant.time_constant_s()).exp();
        let (mut warmth, mut is_on) = (0.0, true);
        let (mut set, mut is_high) = (0.92, true);
        while self.levels.len() < self.logging.n_samples {
            let band = self.random.between(0.01, 0.05);
            let on = self.random.between(set + 0.5 * (1.0 - set), 1.0);
            for _ in 0..self.duration(4.0, 10.0) {
                if warmth > set + band {
                    is_on = false;
                } else if warmth < set - band {
                    is_on = true;
                }
                let level = if is_on { on } else { 0.0 };
                warmth = kept * warmth + (1.0 - kept) * power_share(self.plant, level);
                self.levels.push(level);
            }
            // Above and below in turn, as a stroke is asked for and given back.
            is_high = !is_high;
            let share = self.random.between(0.12, 0.45);
            let wanted = inside(self.plant, if is_high { 1.0 - share } else { share });
            set = power_share(self.plant, wanted);
        }
    }
}
