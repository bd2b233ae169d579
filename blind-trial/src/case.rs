use rand::Rng;
use rand_chacha::ChaCha8Rng;
use truth_plant::{
    Addition, BiasSpring, Draw, DriveName, FamilyKind, NoiseKind, Shape, Traces, TruthPlant,
};

use crate::Like;
use crate::answer::{Answer, Concealed};
use crate::chance::Chance;
use crate::family::Era;
use crate::family::{OUTSIDE, named};
use crate::known::Known;
use crate::runs::{Run, Runs, habit, name_of_habit};
use crate::sizes::size;
use crate::{CaseId, Family, TrialError};

/// Bits of the converter where its steps do not matter: a step is 2e-5 of the stroke.
const FINE_BITS: u32 = 16;

/// Noise of coarse steps, share of a step.
const NOISE_OF_COARSE_STEPS: f64 = 0.15;

/// Noise of a thermocouple on the rod, K.
const TEMPERATURE_NOISE_K: f64 = 0.2;

/// Preload, and what the spring adds over the stroke where its size is 1, Pa.
const STRESS_PA: f64 = 100e6;

/// Share of the second plant's rigs whose loop is of relays; the others follow kinetics.
const RELAYS: f64 = 0.65;

/// A case: a rig that conceals something, or nothing, and what its user knows of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    pub(crate) id: CaseId,
    pub(crate) known: Known,
    /// The rig.
    pub(crate) truth: TruthPlant,
    /// The rig without one of the concealed additions, each in turn.
    pub(crate) without: Vec<TruthPlant>,
    /// Runs that are recorded of it.
    pub(crate) runs: Runs,
    answer: Answer,
    /// Sizes of what is concealed, in the catalogue's units.
    pub(crate) sizes: Vec<Option<f64>>,
    seed: String,
}

/// Recorded traces of a rig.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Recorded {
    pub(crate) training: Vec<Traces>,
    pub(crate) unseen: Traces,
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
        let concealed = concealed(id, &mut chance.of("concealed"), draw.size());
        let family = loop_of(id, &concealed, &mut chance.of("loop"));
        let mut plain = draw.plant(family, drive);
        if let Some(like) = like {
            plain = like.made_of(plain);
        }
        plain.bias_spring = Some(spring(&plain, draw.size()));
        let habit = match (id.era, like) {
            (Era::Lab, None) => Some(habit(&mut chance.of("habit"))),
            _ => None,
        };
        let runs = match (like, habit) {
            (Some(like), _) => Runs::of_drive(&like.profile),
            (None, None) => Runs::guided(&chance, &plain, shapes),
            (None, Some(habit)) => Runs::of_lab(&chance, &plain, shapes, habit),
        };
        let noise = noise_of(id, &mut chance.of("noise"));
        make_noise(noise, id, &draw, &mut plain);
        let own_m = like.and_then(|like| like.noise_m(&plain));
        if let (Some(deviation), Some(noise)) = (own_m, plain.displacement_noise.as_mut()) {
            noise.deviation = deviation;
        }
        let run_s = runs.longest_s();
        let truth = installed(&plain, &concealed, run_s);
        let without = (0..concealed.len()).map(|left_out| {
            let mut others = concealed.clone();
            others.remove(left_out);
            installed(&plain, &others, run_s)
        });
        let known = like.map_or_else(|| Known::drawn(&chance), |like| like.known);
        let sizes = concealed.iter().map(|&(addition, _)| {
            let size = size(addition, &truth)?;
            (known.has_scale() || !size.needs_scale).then_some(size.value)
        });
        Self {
            id,
            known,
            sizes: sizes.collect(),
            without: without.collect(),
            answer: Answer {
                concealed: concealed
                    .iter()
                    .map(|&(addition, size)| Concealed::of(addition, size, &truth))
                    .collect(),
                hysteresis: name_of(family).to_owned(),
                noise: name_of_noise(noise, id).to_owned(),
                plant: (id.era == Era::Lab).then(|| plant_of(id).to_owned()),
                recording: habit.map(|habit| name_of_habit(habit).to_owned()),
            },
            truth,
            runs,
            seed: seed.to_owned(),
        }
    }

    /// Answer of the case. It is concealed from the person who diagnoses.
    #[must_use]
    pub fn answer(&self) -> &Answer {
        &self.answer
    }

    pub(crate) fn into_answer(self) -> Answer {
        self.answer
    }

    pub(crate) fn chance(&self) -> Chance<'_> {
        Chance {
            seed: &self.seed,
            case: self.id,
        }
    }

    pub(crate) fn record(&self) -> Result<Recorded, TrialError> {
        let training = self.runs.training.iter();
        Ok(Recorded {
            training: training
                .map(|run| self.run(&self.truth, run))
                .collect::<Result<_, _>>()?,
            unseen: self.run(&self.truth, &self.runs.unseen)?,
        })
    }

    /// Recorded traces of a plant of this case in a run.
    pub(crate) fn run(&self, plant: &TruthPlant, run: &Run) -> Result<Traces, TrialError> {
        let traces = run.conditioned(plant).simulate(
            &run.profile.drive,
            run.profile.dt_s,
            self.chance().seed(&run.name),
        );
        let traces = traces.map_err(|source| TrialError::Truth {
            case: self.id,
            source,
        })?;
        Ok(run.recorded(traces))
    }
}

/// A plant with some additions, in a run of this length.
fn installed(plain: &TruthPlant, additions: &[(Addition, f64)], run_s: f64) -> TruthPlant {
    let mut plant = plain.clone();
    for &(addition, size) in additions {
        addition.install(&mut plant, size, run_s);
    }
    // What the user may know of the spring says nothing of what is concealed.
    plant.bias_spring = plain.bias_spring;
    plant
}

/// A spring whose force grows over the stroke by `size` times 100 MPa.
fn spring(plant: &TruthPlant, size: f64) -> BiasSpring {
    let section_m2 = plant.rod.section_m2();
    BiasSpring {
        stiffness_n_per_m: size * STRESS_PA * section_m2 / plant.stroke_m,
        preload_n: STRESS_PA * section_m2,
    }
}

/// The loop of the rig. That return points are remembered is news only where the others forget them.
fn loop_of(id: CaseId, concealed: &[(Addition, f64)], random: &mut ChaCha8Rng) -> FamilyKind {
    let other = matches!(id.family, Family::OtherLoop | Family::OtherLoopClean);
    let is_even = id.number.is_multiple_of(2);
    if id.has_second_plant() {
        let forgets = concealed
            .iter()
            .any(|&(addition, _)| addition == Addition::NestedMemory);
        let has_relays = if other {
            is_even
        } else {
            random.random::<f64>() < RELAYS
        };
        return if has_relays && !forgets {
            FamilyKind::Relays
        } else {
            FamilyKind::Tanaka
        };
    }
    match (other, is_even) {
        (true, true) => FamilyKind::Preisach,
        (true, false) => FamilyKind::Cosine,
        (false, _) => FamilyKind::L2p,
    }
}

/// The plant of the rig.
fn plant_of(id: CaseId) -> &'static str {
    if id.has_second_plant() {
        "lumped"
    } else {
        "volumes"
    }
}

fn name_of(family: FamilyKind) -> &'static str {
    match family {
        FamilyKind::L2p | FamilyKind::L2pNested => "l2p",
        FamilyKind::Preisach => "preisach",
        FamilyKind::Cosine => "cosine",
        FamilyKind::Relays => "relays",
        FamilyKind::Tanaka => "tanaka",
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

/// True if the converter's steps are coarser than the noise.
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

/// Additions that a case conceals, with their sizes. Effects go round with the number of the case, then sizes; stress is as
/// large as that of the spring, which every rig has.
fn concealed(id: CaseId, random: &mut ChaCha8Rng, spring_size: f64) -> Vec<(Addition, f64)> {
    let named = named();
    let round = |all: &[Addition]| {
        let n = all.len() as u64;
        let size = [1.0, 0.5, 2.0][(id.number / n % 3) as usize];
        (all[(id.number % n) as usize], size)
    };
    let mut concealed = match id.family {
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
    };
    for (addition, size) in &mut concealed {
        if *addition == Addition::StressCoupling {
            *size = spring_size;
        }
    }
    concealed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CaseLine;
    use crate::folder::Folder;

    /// Of the first published table.
    const PUBLISHED_SEED: &str = "78df37d2691ed14051715e501e38ee6bccfd9fc6";

    fn case(family: Family, number: u64) -> Case {
        Case::drawn("a seed", CaseId::lab(family, number))
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

    /// Some of every family.
    #[test]
    fn guided_cases_are_those_that_were_published() {
        let published = include_str!("../results/cases.jsonl");
        for line in published.lines().step_by(70) {
            let line: CaseLine = serde_json::from_str(line).unwrap();
            let case = Case::drawn(PUBLISHED_SEED, line.case);
            let folder = tempfile::tempdir().unwrap();
            let recorded = case.record().unwrap();
            let written = Folder::write(folder.path(), &case, &recorded).unwrap();
            assert_eq!(written.digest().unwrap(), line.files, "{}", line.case);
        }
    }

    /// Both plants conceal every effect, and every size of it.
    #[test]
    fn plants_alternate_for_every_effect() {
        for family in [Family::Single, Family::Outside] {
            let mut plants = std::collections::BTreeMap::<_, [bool; 2]>::new();
            for number in 0..family.published() {
                let case = case(family, number);
                let one = &case.answer.concealed[0];
                let both = plants.entry(one.addition.clone()).or_default();
                both[usize::from(case.answer.plant.as_deref() == Some("lumped"))] = true;
            }
            assert!(plants.values().all(|both| *both == [true; 2]), "{plants:?}");
        }
    }

    /// Of every family and both plants, with every effect.
    #[test]
    fn lab_rigs_can_be_recorded() {
        for family in Family::ALL {
            // Those with every effect, and every cause outside the catalogue; of the others some.
            let n = match family {
                Family::Single | Family::Outside => 42,
                _ => 8,
            };
            for number in 0..n.min(family.published()) {
                let recorded = case(family, number).record().unwrap();
                for traces in recorded.training.iter().chain([&recorded.unseen]) {
                    let finite = traces.displacement_mm.iter().all(|mm| mm.is_finite());
                    assert!(finite, "{family} {number}");
                }
            }
        }
    }

    /// Every kind of recording is simulated and written.
    #[test]
    fn lab_cases_are_recorded_in_one_to_five_files() {
        let mut kinds = std::collections::BTreeSet::new();
        for number in 0..24 {
            let case = case(Family::Single, number);
            let folder = tempfile::tempdir().unwrap();
            let recorded = case.record().unwrap();
            let written = Folder::write(folder.path(), &case, &recorded).unwrap();
            let files = written.training();
            assert_eq!(files.len(), case.runs.training.len());
            assert!(
                files
                    .iter()
                    .chain([&written.unseen()])
                    .all(|file| file.exists())
            );
            for (traces, run) in recorded.training.iter().zip(&case.runs.training) {
                let n = run.profile.drive.len() - run.n_before;
                assert_eq!(traces.displacement_mm.len(), n);
            }
            kinds.extend(case.answer.recording.clone());
        }
        assert!(kinds.len() >= 6, "{kinds:?}");
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
