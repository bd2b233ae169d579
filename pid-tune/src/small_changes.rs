use rayon::prelude::*;
use wiener::{Fleet, Input, Lanes, NARROW};

use crate::{DriveLimits, PlantResponse, TaskError, TuneError};

/// Samples a time constant on the way to where small changes are looked at.
const SAMPLES_PER_TAU: usize = 20;
/// Time constants until a rod stands: while it transforms, latent heat makes it a dozen times as slow.
const STANDS_AFTER: usize = 150;
/// Rounds in which drives are looked for that hold outputs at even distances.
const ROUNDS: usize = 4;
/// The largest change of the drive, as a share of its range, and that of the output, as a share of what is looked
/// at.
const SMALL: f64 = 1e-3;
/// Fewest time constants of an answer.
const SHORTEST_TAUS: f64 = 8.0;
/// Share of an answer by which it may still grow over its last quarter, where it counts as done.
const DONE: f64 = 1e-3;
/// Longest answer, samples: beyond, it is cut, and sampled less often it would not be.
const LONGEST: usize = 20_000;
/// Time constant over the time of an early answer: how steep a plant is at the frequencies at which a loop around
/// it is on the edge.
const EARLY: f64 = 5.0;

/// Where small changes of the drive are looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmallChanges {
    /// Limits of the drive.
    pub limits: DriveLimits,
    /// Temperature of the surroundings, °C.
    pub ambient_degc: f64,
    /// Sample time of the loop, s.
    pub dt_s: f64,
    /// Slowest time constant that the plant is thought to have, s.
    pub tau_s: f64,
    /// Outputs from which to which; the second larger.
    pub outputs: [f64; 2],
    /// Samples from a command to its effect.
    pub dead_time_samples: usize,
}

/// How a plant answers a small change of its drive at one output, on one branch of its hysteresis.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// Output that is held, in its unit.
    pub output: f64,
    /// Its change a fifth of a time constant after the change, per change of the drive, in the output's unit per the drive's.
    pub slope: f64,
    /// The whole answer.
    pub plant: PlantResponse,
}

/// How a plant answers small changes of its drive, from output to output.
#[derive(Debug, Clone, PartialEq)]
pub struct Answers {
    /// Lowest and highest output, in its unit.
    pub outputs: [f64; 2],
    /// On the way up.
    pub heating: Vec<Answer>,
    /// On the way down.
    pub cooling: Vec<Answer>,
}

/// Changes of an output per change of the drive, sample by sample.
#[derive(Debug)]
struct Moved {
    /// The output that was held.
    output: f64,
    changes: Vec<f64>,
}

/// Which way the drive goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// Up from the lower limit.
    Heating,
    /// Down from the upper limit.
    Cooling,
}

impl SmallChanges {
    /// How a plant answers where it answers most: on its way up and on its way down again, among outputs at even
    /// distances between both ends, where the answer is largest in the end, and where it is largest early.
    ///
    /// The drive goes on the way that it came: there a loop is steepest, right after a reversal it is flatter. A loop
    /// that rests with these is safe for all smaller ones.
    ///
    /// Any plant, with all effects that it has: two that are alike, of which one has its drive changed, are run side by
    /// side. At most four answers; none where the output does not move.
    ///
    /// # Errors
    ///
    /// [`TaskError::Plant`] for the plant; [`TuneError`] for numbers out of range.
    pub fn steepest<F: Fleet>(
        &self,
        fleet: &F,
        member: F::Member,
    ) -> Result<Vec<PlantResponse>, TaskError<F::Error>> {
        let mut chosen: Vec<Vec<f64>> = Vec::new();
        for way in [Way::Heating, Way::Cooling] {
            let held = self.held(fleet, member, way)?;
            let answers = self.answers(fleet, member, way, &held)?;
            let answers: Vec<Vec<f64>> = answers.into_iter().map(|one| one.changes).collect();
            for place in [self.early(), usize::MAX] {
                let at = |answer: &[f64]| answer[place.min(answer.len() - 1)];
                let most = answers.iter().max_by(|a, b| at(a).total_cmp(&at(b)));
                let rising = most.filter(|answer| answer[answer.len() - 1] > 0.0);
                if let Some(answer) = rising
                    && !chosen.contains(answer)
                {
                    chosen.push(answer.clone());
                }
            }
        }
        let of = |answer: &Vec<f64>| PlantResponse::new(self.dt_s, self.dead_time_samples, answer);
        let steepest: Result<Vec<_>, TuneError> = chosen.iter().map(of).collect();
        Ok(steepest?)
    }

    /// How a plant answers at all of those outputs, on its way up and on its way down again.
    ///
    /// # Errors
    ///
    /// As [`SmallChanges::steepest`].
    pub fn everywhere<F: Fleet>(
        &self,
        fleet: &F,
        member: F::Member,
    ) -> Result<Answers, TaskError<F::Error>> {
        let on = |way| {
            let held = self.held(fleet, member, way)?;
            let answers = self.answers(fleet, member, way, &held)?;
            let of = |one: &Moved| {
                let changes = &one.changes;
                Ok(Answer {
                    output: one.output,
                    slope: changes[self.early().min(changes.len() - 1)],
                    plant: PlantResponse::new(self.dt_s, self.dead_time_samples, changes)?,
                })
            };
            let answers: Result<Vec<Answer>, TuneError> = answers.par_iter().map(of).collect();
            Ok::<_, TaskError<F::Error>>(answers?)
        };
        Ok(Answers {
            outputs: self.outputs,
            heating: on(Way::Heating)?,
            cooling: on(Way::Cooling)?,
        })
    }

    /// Samples to where an answer counts as an early one.
    fn early(&self) -> usize {
        (self.tau_s / EARLY / self.dt_s) as usize
    }

    /// Drives that hold outputs at even distances, with the outputs.
    fn held<F: Fleet>(
        &self,
        fleet: &F,
        member: F::Member,
        way: Way,
    ) -> Result<[(f64, f64); NARROW], TaskError<F::Error>> {
        let DriveLimits { lower, upper } = self.limits;
        let [from, to] = self.outputs;
        let place = |l: usize| (l as f64 + 0.5) / NARROW as f64;
        let mut drives: [f64; NARROW] =
            core::array::from_fn(|l| lower + place(l) * (upper - lower));
        // Rising in both.
        let mut known: Vec<(f64, f64)> = Vec::new();
        let mut held = [(0.0, 0.0); NARROW];
        for _ in 0..ROUNDS {
            let mut plants = fleet.narrow(&[member; NARROW]).map_err(TaskError::Plant)?;
            self.go(&mut *plants, way, drives);
            let outputs = plants.output().displacement;
            held = core::array::from_fn(|l| (drives[l], outputs[l]));
            known.extend(held.iter().filter(|(_, output)| output.is_finite()));
            known.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            drives = core::array::from_fn(|l| {
                let wanted = from + place(l) * (to - from);
                let above = known.partition_point(|&(_, output)| output < wanted);
                match (known.get(above.wrapping_sub(1)), known.get(above)) {
                    (Some(&(u0, y0)), Some(&(u1, y1))) if y1 > y0 => {
                        u0 + (wanted - y0) / (y1 - y0) * (u1 - u0)
                    }
                    (Some(&(drive, _)), None) | (None, Some(&(drive, _))) => drive,
                    _ => lower,
                }
            });
        }
        Ok(held)
    }

    /// Brings plants from rest to drives, one a lane.
    fn go(&self, plants: &mut (dyn Lanes<NARROW> + Send), way: Way, drives: [f64; NARROW]) {
        let mut hold = |drive: [f64; NARROW]| {
            let input = Input {
                drive,
                ambient_degc: self.ambient_degc,
            };
            for _ in 0..STANDS_AFTER * SAMPLES_PER_TAU {
                plants.step(&input, self.tau_s / SAMPLES_PER_TAU as f64);
            }
        };
        if way == Way::Cooling {
            hold([self.limits.upper; NARROW]);
        }
        hold(drives);
    }

    /// Outputs where plants are held, and their changes per change of the drive, sample by sample.
    fn answers<F: Fleet>(
        &self,
        fleet: &F,
        member: F::Member,
        way: Way,
        held: &[(f64, f64); NARROW],
    ) -> Result<Vec<Moved>, TaskError<F::Error>> {
        let DriveLimits { lower, upper } = self.limits;
        let sign = match way {
            Way::Heating => 1.0,
            Way::Cooling => -1.0,
        };
        let [drives, outputs] = [held.map(|(drive, _)| drive), held.map(|(_, output)| output)];
        // Less where the output is steep.
        let changes: [f64; NARROW] = core::array::from_fn(|l| {
            let neighbor = if l + 1 < NARROW { l + 1 } else { l - 1 };
            let drive = (held[neighbor].0 - held[l].0).abs();
            let output = (held[neighbor].1 - held[l].1).abs();
            let small = SMALL * (self.outputs[1] - self.outputs[0]).abs() * drive / output;
            let most = SMALL * (upper - lower);
            sign * if small > 0.0 { small.min(most) } else { most }
        });
        let mut still = fleet.narrow(&[member; NARROW]).map_err(TaskError::Plant)?;
        let mut moved = fleet.narrow(&[member; NARROW]).map_err(TaskError::Plant)?;
        self.go(&mut *still, way, drives);
        self.go(&mut *moved, way, drives);
        let input = |drive| Input {
            drive,
            ambient_degc: self.ambient_degc,
        };
        let held = input(drives);
        let changed = input(core::array::from_fn(|l| drives[l] + changes[l]));
        let lasts = STANDS_AFTER as f64 * self.tau_s / self.dt_s;
        let shortest = ((SHORTEST_TAUS * self.tau_s / self.dt_s) as usize).max(1);
        let mut series = vec![Vec::new(); NARROW];
        for k in 0..(lasts.ceil() as usize).clamp(2, LONGEST) {
            if k >= shortest && k.is_multiple_of(shortest) && stands(&series) {
                break;
            }
            still.step(&held, self.dt_s);
            moved.step(&changed, self.dt_s);
            let [before, after] = [&still, &moved].map(|plants| plants.output().displacement);
            for l in 0..NARROW {
                series[l].push((after[l] - before[l]) / changes[l]);
            }
        }
        let moved = outputs.into_iter().zip(series);
        Ok(moved
            .filter(|(_, changes)| changes.iter().all(|value| value.is_finite()))
            .map(|(output, changes)| Moved { output, changes })
            .collect())
    }
}

/// True if all answers are done, by their last quarter.
fn stands(series: &[Vec<f64>]) -> bool {
    series.iter().all(|answers| {
        let n = answers.len();
        let (Some(&quarter), Some(&last)) =
            (answers.get(n.saturating_sub(n / 4 + 1)), answers.last())
        else {
            return false;
        };
        // One that is no number is done as well.
        (last - quarter).abs() <= DONE * last.abs() || !last.is_finite()
    })
}
