use rand::Rng;
use rand_chacha::ChaCha8Rng;
use truth_plant::{
    Addition, BiasSpring, Draw, DriveName, DriveProfile, FamilyKind, NoiseKind, Shape, Traces,
    TruthPlant,
};

use crate::Like;
use crate::answer::{Answer, Concealed, hex, seal};
use crate::chance::Chance;
use crate::family::{OUTSIDE, named};
use crate::known::Known;
use crate::{CaseId, Family, TrialError};

/// Samples of the training recording, and of the unseen one.
const SAMPLES: [usize; 2] = [9_000, 6_000];

/// Bits of the converter where its steps do not matter: a step is 2e-5 of the stroke.
const FINE_BITS: u32 = 16;

/// Noise of coarse steps, share of a step.
const NOISE_OF_COARSE_STEPS: f64 = 0.15;

/// Noise of a thermocouple on the rod, K.
const TEMPERATURE_NOISE_K: f64 = 0.2;

/// Preload, and what the spring adds over the stroke where its size is 1, Pa.
const STRESS_PA: f64 = 100e6;

/// A case: a rig that conceals something, or nothing, and what its user knows of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    pub(crate) id: CaseId,
    pub(crate) known: Known,
    /// The rig.
    pub(crate) truth: TruthPlant,
    /// The same without one of the things that are concealed, each in turn.
    pub(crate) without: Vec<TruthPlant>,
    /// Drives of the training and of the unseen recording.
    pub(crate) drives: [DriveProfile; 2],
    answer: Answer,
    salt: String,
    seed: String,
}

/// Two recordings of a rig.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Recorded {
    pub(crate) train: Traces,
    pub(crate) held: Traces,
}

impl Case {
    /// The case of a trial's seed, any text.
    ///
    /// Rig, drive, noise, what is known, what is concealed and its size are drawn each from a stream of their own.
    #[must_use]
    pub fn drawn(seed: &str, id: CaseId) -> Self {
        Self::around(None, seed, id)
    }

    /// The case of a trial around a user's own rig and drive, if there is one: both recordings are of that drive.
    #[must_use]
    pub fn around(like: Option<&Like>, seed: &str, id: CaseId) -> Self {
        let chance = Chance { seed, case: id };
        let draw = Draw::new(chance.seed("rig"));
        let mut random = chance.of("kinds");
        let drive = [
            DriveName::Current,
            DriveName::Duty,
            DriveName::Voltage,
            DriveName::Power,
        ][random.random_range(0..4)];
        let shapes = [0, 1].map(|_| Shape::ALL[random.random_range(0..Shape::ALL.len())]);
        let mut plain = draw.plant(loop_of(id), drive);
        if let Some(like) = like {
            plain = like.made_of(plain);
        }
        plain.bias_spring = Some(spring(&plain, draw.size()));
        // A drive each, of one rig.
        let mut drives = match like {
            Some(like) => [like.profile.clone(), like.profile.clone()],
            None => [
                draw.drive(shapes[0], &plain, SAMPLES[0]),
                Draw::new(chance.seed("unseen")).drive(shapes[1], &plain, SAMPLES[1]),
            ],
        };
        drives.iter_mut().for_each(as_logged);
        let noise = noise_of(id, &mut chance.of("noise"));
        make_noise(noise, id, &draw, &mut plain);
        let own_m = like.and_then(|like| like.noise_m(&plain));
        if let (Some(deviation), Some(noise)) = (own_m, plain.displacement_noise.as_mut()) {
            noise.deviation = deviation;
        }
        let run_s = drives[0].dt_s * drives[0].drive.len() as f64;
        let mut concealed = concealed(id, &mut chance.of("concealed"));
        for (addition, size) in &mut concealed {
            // Its stress is that of the spring, which every rig has.
            if *addition == Addition::StressCoupling {
                *size = draw.size();
            }
        }
        let with = |among: &[(Addition, f64)]| {
            let mut plant = plain.clone();
            for &(addition, size) in among {
                addition.install(&mut plant, size, run_s);
            }
            // What the user may know of the spring says nothing of what is concealed.
            plant.bias_spring = plain.bias_spring;
            plant
        };
        let truth = with(&concealed);
        let without = (0..concealed.len()).map(|left_out| {
            let mut others = concealed.clone();
            others.remove(left_out);
            with(&others)
        });
        Self {
            id,
            known: like.map_or_else(|| Known::drawn(&chance), |like| like.known),
            without: without.collect(),
            answer: Answer {
                concealed: concealed
                    .iter()
                    .map(|&(addition, size)| Concealed::of(addition, size, &truth))
                    .collect(),
                hysteresis: name_of(loop_of(id)).to_owned(),
                noise: name_of_noise(noise, id).to_owned(),
            },
            truth,
            drives,
            salt: hex(&chance.digest("salt")[..16]),
            seed: seed.to_owned(),
        }
    }

    /// What is published before the diagnosis.
    #[must_use]
    pub fn seal(&self) -> String {
        seal(&self.salt, &self.answer)
    }

    /// Opens the seal: salt and answer.
    #[must_use]
    pub fn open(&self) -> (&str, &Answer) {
        (&self.salt, &self.answer)
    }

    pub(crate) fn chance(&self) -> Chance<'_> {
        Chance {
            seed: &self.seed,
            case: self.id,
        }
    }

    pub(crate) fn record(&self) -> Result<Recorded, TrialError> {
        Ok(Recorded {
            train: self.run(&self.truth, &self.drives[0], "train")?,
            held: self.run(&self.truth, &self.drives[1], "held")?,
        })
    }

    /// A run of a plant of this case; the name of the run is what its randomness comes from.
    pub(crate) fn run(
        &self,
        plant: &TruthPlant,
        profile: &DriveProfile,
        name: &str,
    ) -> Result<Traces, TrialError> {
        plant
            .simulate(&profile.drive, profile.dt_s, self.chance().seed(name))
            .map_err(|source| TrialError::Truth {
                case: self.id,
                source,
            })
    }
}

/// A logger writes times to the millisecond and drives to six places: what is simulated is what is written.
fn as_logged(profile: &mut DriveProfile) {
    profile.dt_s = (1e3 * profile.dt_s).round().max(1.0) / 1e3;
    for value in &mut profile.drive {
        *value = (1e6 * *value).round() / 1e6;
    }
}

/// A spring whose force grows over the stroke by `size` times 100 MPa.
fn spring(plant: &TruthPlant, size: f64) -> BiasSpring {
    let section_m2 = plant.rod.section_m2();
    BiasSpring {
        stiffness_n_per_m: size * STRESS_PA * section_m2 / plant.stroke_m,
        preload_n: STRESS_PA * section_m2,
    }
}

fn loop_of(id: CaseId) -> FamilyKind {
    match (id.family, id.number % 2) {
        (Family::OtherLoop | Family::OtherLoopClean, 0) => FamilyKind::Preisach,
        (Family::OtherLoop | Family::OtherLoopClean, _) => FamilyKind::Cosine,
        _ => FamilyKind::L2p,
    }
}

fn name_of(family: FamilyKind) -> &'static str {
    match family {
        FamilyKind::L2p | FamilyKind::L2pNested => "l2p",
        FamilyKind::Preisach => "preisach",
        FamilyKind::Cosine => "cosine",
    }
}

fn noise_of(id: CaseId, random: &mut ChaCha8Rng) -> NoiseKind {
    let colored = NoiseKind::Ar1 {
        correlation: random.random_range(0.5..0.95),
    };
    let outliers = NoiseKind::Outliers {
        share: 0.01,
        factor: 20.0,
    };
    match id.family {
        Family::CleanWhite | Family::CleanQuantized => NoiseKind::White,
        Family::CleanAr => colored,
        Family::CleanOneOverF => NoiseKind::OneOverF,
        Family::CleanOutliers => outliers,
        Family::HardNoise => match id.number / 21 % 3 {
            0 => NoiseKind::OneOverF,
            1 => NoiseKind::White,
            _ => outliers,
        },
        _ if random.random::<bool>() => colored,
        _ => NoiseKind::White,
    }
}

/// Whether the converter's steps are coarser than the noise.
fn is_coarse(noise: NoiseKind, id: CaseId) -> bool {
    let is_white = noise == NoiseKind::White;
    id.family == Family::CleanQuantized || (id.family == Family::HardNoise && is_white)
}

fn name_of_noise(noise: NoiseKind, id: CaseId) -> &'static str {
    match noise {
        _ if is_coarse(noise, id) => "quantized",
        NoiseKind::White => "white",
        NoiseKind::Ar1 { .. } => "ar",
        NoiseKind::OneOverF => "one-over-f",
        NoiseKind::HeavyTails => "heavy-tails",
        NoiseKind::Outliers { .. } => "outliers",
    }
}

fn make_noise(kind: NoiseKind, id: CaseId, draw: &Draw, plant: &mut TruthPlant) {
    draw.noise(kind, plant);
    let converter = plant.converter.as_mut();
    let noise = plant.displacement_noise.as_mut();
    if let (Some(converter), Some(noise)) = (converter, noise) {
        if is_coarse(kind, id) {
            // 10 to 14 bits become 7 to 9: steps of 1 to 0.25 % of the stroke.
            converter.bits = 7 + converter.bits % 3;
            let step_m = converter.full_scale_m / f64::from(1_u32 << converter.bits);
            noise.deviation = NOISE_OF_COARSE_STEPS * step_m;
        } else {
            converter.bits = FINE_BITS;
        }
    }
    plant.temperature_noise = Some(truth_plant::Noise {
        kind: NoiseKind::White,
        deviation: TEMPERATURE_NOISE_K,
    });
}

/// What a case conceals, and how much of it. Effects go round with the number of the case, then sizes.
fn concealed(id: CaseId, random: &mut ChaCha8Rng) -> Vec<(Addition, f64)> {
    let named = named();
    let round = |all: &[Addition]| {
        let n = all.len() as u64;
        let size = [1.0, 0.5, 2.0][(id.number / n % 3) as usize];
        (all[(id.number % n) as usize], size)
    };
    match id.family {
        family if family.is_clean() => Vec::new(),
        Family::OtherLoopClean => Vec::new(),
        Family::Outside => vec![round(&OUTSIDE)],
        Family::Pair => {
            let first = random.random_range(0..named.len());
            let others: Vec<Addition> = named
                .iter()
                .copied()
                .filter(|other| other.catalogue_id() != named[first].catalogue_id())
                .collect();
            let second = random.random_range(0..others.len());
            vec![(named[first], 1.0), (others[second], 1.0)]
        }
        Family::Deleted => vec![(round(&named).0, 1.0)],
        _ => vec![round(&named)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(family: Family, number: u64) -> Case {
        Case::drawn("a seed", CaseId { family, number })
    }

    #[test]
    fn the_same_seed_draws_the_same_case() {
        assert_eq!(case(Family::Pair, 3), case(Family::Pair, 3));
        assert_ne!(case(Family::Pair, 3).truth, case(Family::Pair, 4).truth);
    }

    #[test]
    fn clean_cases_conceal_nothing_and_others_do() {
        for family in Family::ALL {
            let n = case(family, 5).answer.concealed.len();
            let expected = match family {
                Family::Pair => 2,
                Family::OtherLoopClean => 0,
                _ => usize::from(!family.is_clean()),
            };
            assert_eq!(n, expected, "{family}");
        }
    }

    #[test]
    fn every_case_is_a_plant_that_runs() {
        for family in Family::ALL {
            for number in 0..family.published() {
                let case = case(family, number);
                case.truth.check().unwrap();
                for without in &case.without {
                    without.check().unwrap();
                }
            }
        }
    }

    #[test]
    fn what_is_known_does_not_depend_on_what_is_concealed() {
        // The spring is in every rig, whether or not its stress counts.
        for number in 0..63 {
            let case = case(Family::Single, number);
            let draw = Draw::new(case.chance().seed("rig"));
            let stiffness = case.truth.bias_spring.unwrap().stiffness_n_per_m;
            let expected = spring(&case.truth, draw.size()).stiffness_n_per_m;
            assert!((stiffness / expected - 1.0).abs() < 1e-12);
        }
    }
}
