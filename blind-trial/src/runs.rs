use rand::Rng;
use truth_plant::{Draw, DriveProfile, LabDrive, Logging, Manner, Shape, Traces, TruthPlant};

use crate::chance::Chance;

/// Samples of the training recording and of the unseen one, where they are recorded as the guide asks.
const GUIDED_SAMPLES: [usize; 2] = [9_000, 6_000];

/// Samples of all training recordings together, even in the logarithm.
const TRAINING_SAMPLES: [f64; 2] = [2_000.0, 20_000.0];
/// Training recordings at most.
const MOST_RECORDINGS: usize = 5;
/// Samples of a training recording at least, on the average.
const FEWEST_SAMPLES: f64 = 600.0;
/// Samples of the unseen recording.
const UNSEEN_SAMPLES: [usize; 2] = [1_500, 6_000];

/// Samples of the plain rod's time constant: shares of it that a sample lasts, and at most where a run is short.
const SAMPLE: [f64; 2] = [0.01, 0.04];
const LONGEST_SAMPLE: f64 = 0.08;

/// How far apart the surroundings are from run to run at most, K.
const AMBIENT_APART_K: f64 = 4.0;
/// How far the rest position moves from run to run at most, share of the stroke.
const REST_APART: f64 = 0.01;

/// Share of the rigs whose driver has a dead zone, and its width, shares of the largest drive.
const HAS_DEAD_ZONE: f64 = 0.4;
const DEAD_ZONE: [f64; 2] = [0.02, 0.05];

/// How a case is recorded: as the guide asks where no manner is given.
pub(crate) type Habit = Option<Manner>;

/// A run of a rig of which a recording is made.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Run {
    /// Name, the source of its randomness.
    pub(crate) name: String,
    /// The whole drive.
    pub(crate) profile: DriveProfile,
    /// Samples at its start that are not recorded.
    pub(crate) n_before: usize,
    /// How much warmer the surroundings are than in the first run, K.
    pub(crate) ambient_rise_k: f64,
    /// How far the rest position is from that of the first run, m.
    pub(crate) rest_shift_m: f64,
}

/// The runs of a case.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Runs {
    /// For training; at least one.
    pub(crate) training: Vec<Run>,
    /// Not seen in training.
    pub(crate) unseen: Run,
}

impl Run {
    /// One that is recorded from its start, under the conditions of the first.
    pub(crate) fn whole(name: &str, profile: DriveProfile) -> Self {
        Self {
            name: name.to_owned(),
            profile,
            n_before: 0,
            ambient_rise_k: 0.0,
            rest_shift_m: 0.0,
        }
    }

    /// A plant as it is in this run.
    pub(crate) fn conditioned(&self, plant: &TruthPlant) -> TruthPlant {
        let mut plant = plant.clone();
        plant.ambient_degc += self.ambient_rise_k;
        plant.offset_m += self.rest_shift_m;
        plant
    }

    /// Recorded part of the traces of the whole run.
    pub(crate) fn recorded(&self, mut traces: Traces) -> Traces {
        let channels = [
            &mut traces.time_s,
            &mut traces.drive,
            &mut traces.displacement_mm,
            &mut traces.quiet_displacement_mm,
            &mut traces.temperature_degc,
            &mut traces.thermocouple_degc,
            &mut traces.quiet_thermocouple_degc,
            &mut traces.ambient_degc,
            &mut traces.fraction,
        ];
        for channel in channels {
            channel.drain(..self.n_before);
        }
        traces
    }
}

impl Runs {
    /// Both of a user's own drive.
    pub(crate) fn of_drive(profile: &DriveProfile) -> Self {
        Self::logged(
            vec![Run::whole("train", profile.clone())],
            Run::whole("held", profile.clone()),
        )
    }

    /// As the guide asks, of two shapes.
    pub(crate) fn guided(chance: &Chance<'_>, plant: &TruthPlant, shapes: [Shape; 2]) -> Self {
        let drive = |purpose: &str, k: usize| {
            Draw::new(chance.seed(purpose)).drive(shapes[k], plant, GUIDED_SAMPLES[k])
        };
        Self::logged(
            vec![Run::whole("train", drive("rig", 0))],
            Run::whole("held", drive("unseen", 1)),
        )
    }

    /// As a lab of this habit records them.
    pub(crate) fn of_lab(
        chance: &Chance<'_>,
        plant: &TruthPlant,
        shapes: [Shape; 2],
        habit: Habit,
    ) -> Self {
        let mut runs = match habit {
            None => Self::guided(chance, plant, shapes),
            Some(manner) => Self::in_manner(chance, plant, manner),
        };
        runs.vary(chance, plant.stroke_m);
        runs
    }

    fn in_manner(chance: &Chance<'_>, plant: &TruthPlant, manner: Manner) -> Self {
        let mut random = chance.of("logging");
        let lengths = training_lengths(&mut random);
        let n_unseen = random.random_range(UNSEEN_SAMPLES[0]..=UNSEEN_SAMPLES[1]);
        // Half of the labs have another manner in the run that they keep back.
        let other = Manner::ALL[random.random_range(0..Manner::ALL.len())];
        let unseen = if random.random::<bool>() {
            manner
        } else {
            other
        };
        let zone = random.random_range(DEAD_ZONE[0]..DEAD_ZONE[1]);
        let has_zone = random.random::<f64>() < HAS_DEAD_ZONE;
        let share = random.random_range(SAMPLE[0]..SAMPLE[1]);
        let needed = |manner: Manner, n: usize| manner.shortest_time_constants() / n as f64;
        let all = lengths.iter().map(|&n| needed(manner, n));
        let share = all.fold(share, f64::max).max(needed(unseen, n_unseen));
        let dt_s = plant.time_constant_s() * share.min(LONGEST_SAMPLE);
        let drawn = |name: String, purpose: &str, manner: Manner, n_samples: usize| {
            let logging = Logging {
                n_samples,
                dt_s: to_milliseconds(dt_s),
                dead_zone: if has_zone { zone } else { 0.0 },
            };
            let draw = Draw::new(chance.seed(purpose));
            let LabDrive { profile, n_before } = draw.lab_drive(manner, plant, logging);
            Run {
                n_before,
                ..Run::whole(&name, profile)
            }
        };
        let training = lengths.iter().enumerate().map(|(k, &n)| {
            let number = k + 1;
            drawn(
                format!("train {number}"),
                &format!("drive {number}"),
                manner,
                n,
            )
        });
        Self::logged(
            training.collect(),
            drawn("held".to_owned(), "unseen drive", unseen, n_unseen),
        )
    }

    /// Every run but the first has surroundings and a rest position of its own.
    fn vary(&mut self, chance: &Chance<'_>, stroke_m: f64) {
        let mut random = chance.of("conditions");
        let first_k = random.random_range(0.0..AMBIENT_APART_K);
        for run in self.training.iter_mut().skip(1).chain([&mut self.unseen]) {
            run.ambient_rise_k = random.random_range(0.0..AMBIENT_APART_K) - first_k;
            run.rest_shift_m = random.random_range(-REST_APART..REST_APART) * stroke_m;
        }
    }

    fn logged(mut training: Vec<Run>, mut unseen: Run) -> Self {
        for run in training.iter_mut().chain([&mut unseen]) {
            as_logged(&mut run.profile);
        }
        Self { training, unseen }
    }

    /// Length of the longest training run, s.
    pub(crate) fn longest_s(&self) -> f64 {
        let lengths = self
            .training
            .iter()
            .map(|run| run.profile.dt_s * run.profile.drive.len() as f64);
        lengths.fold(0.0, f64::max)
    }

    /// The largest drive in training.
    pub(crate) fn largest_drive(&self) -> f64 {
        let drives = self.training.iter().flat_map(|run| &run.profile.drive);
        drives.copied().fold(0.0, f64::max)
    }
}

/// How a lab records: a quarter of them as the guide asks.
pub(crate) fn habit(random: &mut impl Rng) -> Habit {
    let is_guided = random.random::<f64>() < 0.25;
    let manner = Manner::ALL[random.random_range(0..Manner::ALL.len())];
    (!is_guided).then_some(manner)
}

/// Its name in answers and scores.
pub(crate) fn name_of_habit(habit: Habit) -> &'static str {
    habit.map_or("guide", Manner::id)
}

/// Samples of each training recording.
fn training_lengths(random: &mut impl Rng) -> Vec<usize> {
    let [fewest, most] = TRAINING_SAMPLES;
    let total = fewest * (random.random::<f64>() * (most / fewest).ln()).exp();
    let room = ((total / FEWEST_SAMPLES) as usize).min(MOST_RECORDINGS);
    let n = random.random_range(1..=room);
    let weights: Vec<f64> = (0..n).map(|_| random.random_range(0.6..1.4)).collect();
    let sum: f64 = weights.iter().sum();
    weights
        .iter()
        .map(|weight| (total * weight / sum) as usize)
        .collect()
}

fn to_milliseconds(seconds: f64) -> f64 {
    (1e3 * seconds).round().max(1.0) / 1e3
}

/// A logger writes times to the millisecond and drives to six places: what is simulated is what is written.
fn as_logged(profile: &mut DriveProfile) {
    profile.dt_s = to_milliseconds(profile.dt_s);
    for value in &mut profile.drive {
        *value = (1e6 * *value).round() / 1e6;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CaseId, Family};
    use truth_plant::{DriveName, FamilyKind};

    #[test]
    fn training_has_two_to_twenty_thousand_samples_in_one_to_five_recordings() {
        let mut seen = [0; MOST_RECORDINGS + 1];
        for number in 0..300 {
            let case = CaseId::lab(Family::Single, number);
            let lengths = training_lengths(&mut Chance { seed: "s", case }.of("logging"));
            let total: usize = lengths.iter().sum();
            assert!((1_990..=20_000).contains(&total), "{total}");
            assert!(lengths.iter().all(|&n| n > 200), "{lengths:?}");
            seen[lengths.len()] += 1;
        }
        assert!(seen[1..].iter().all(|&n| n > 10), "{seen:?}");
    }

    #[test]
    fn a_quarter_is_recorded_as_the_guide_asks_and_every_manner_is_there() {
        let mut counts = std::collections::BTreeMap::new();
        for number in 0..1_000 {
            let case = CaseId::lab(Family::Single, number);
            let habit = habit(&mut Chance { seed: "s", case }.of("habit"));
            *counts.entry(name_of_habit(habit)).or_insert(0) += 1;
        }
        assert_eq!(counts.len(), 8);
        assert!((200..300).contains(&counts["guide"]), "{counts:?}");
        assert!(counts.values().all(|&n| n > 60), "{counts:?}");
    }

    #[test]
    fn surroundings_and_rests_differ_a_little_from_run_to_run() {
        for number in 0..40 {
            let case = CaseId::lab(Family::Single, number);
            let chance = Chance { seed: "s", case };
            let plant = Draw::new(number).plant(FamilyKind::L2p, DriveName::Duty);
            let runs = Runs::of_lab(&chance, &plant, [Shape::Ramps; 2], Some(Manner::WarmStart));
            let all = || runs.training.iter().chain([&runs.unseen]);
            let rises: Vec<f64> = all().map(|run| run.ambient_rise_k).collect();
            let highest = rises.iter().copied().fold(f64::MIN, f64::max);
            let lowest = rises.iter().copied().fold(f64::MAX, f64::min);
            assert!(highest - lowest <= AMBIENT_APART_K && highest > lowest);
            for run in all() {
                let is_cut = run.n_before > 0;
                assert!(is_cut || run.name == "held");
                assert!(run.rest_shift_m.abs() <= REST_APART * plant.stroke_m);
            }
        }
    }
}
