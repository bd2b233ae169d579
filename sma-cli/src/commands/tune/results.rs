//! The controller that was found, beside others: all that is said of it.

use missing_physics::RestoredModel;
use pid_tune::{ClosedLoop, OpenLoop, PidGains, front, robustness, sensitivities};
use workbench::report::tuned::{Candidate, LoopPicture, Schedules, TunedReport};
use workbench::{Promise, Rig};

use super::search::{Problem, Searched, Structured};
use super::step::Step;
use super::{Job, Preset, Rods};

/// A controller with its name.
#[derive(Debug, Clone, Copy)]
pub(super) struct Named<'a> {
    pub(super) name: &'static str,
    pub(super) gains: PidGains,
    pub(super) structured: Structured<'a>,
}

/// The problem of the searches, and the controllers that they found.
pub(super) struct Results<'a> {
    pub(super) job: &'a Job<'a>,
    pub(super) step: &'a Step,
    /// The loop to the set point from each side.
    pub(super) approaching: [ClosedLoop<'a>; 3],
    pub(super) rods: &'a Rods,
    pub(super) problem: &'a Problem<'a>,
    pub(super) searched: &'a Searched<'a>,
    /// The controller that is compared with, the tuned one, then others.
    pub(super) named: &'a [Named<'a>],
}

impl<'a> Searched<'a> {
    /// The gains that were found, between controllers by rule and gains of the user.
    pub(super) fn beside(&self, by_rule: Vec<Named<'a>>, own: Option<Named<'a>>) -> Vec<Named<'a>> {
        let mut named = by_rule;
        named.insert(
            1,
            Named {
                name: "tuned",
                gains: self.best.tuned.gains,
                structured: self.best.structured,
            },
        );
        if let Some(staying) = &self.staying {
            named.insert(
                2,
                Named {
                    name: "unscheduled",
                    gains: staying.tuned.gains,
                    structured: staying.structured,
                },
            );
        }
        named.extend(own);
        named
    }
}

impl<'a> Results<'a> {
    /// The call with the tuned controller.
    fn of_tuned(&self) -> Job<'a> {
        Job {
            bench: self.searched.best.structured.bench,
            ..*self.job
        }
    }

    /// The rods on which the loop has to rest as well.
    fn likely(&self) -> anyhow::Result<Vec<Rig>> {
        let rig = self.job.bench.rig;
        let rods = self.rods.likely.iter().map(|&rod| rig.of_rod(rod));
        Ok(rods.collect::<Result<_, _>>()?)
    }

    /// Controllers that follow references: the one that is compared with, the tuned one, and beside a schedule the best gains
    /// that stay.
    fn followed(&self) -> &'a [Named<'a>] {
        &self.named[..2 + usize::from(self.searched.staying.is_some())]
    }

    /// Response to a test of the rig.
    pub(super) fn promise(&self) -> anyhow::Result<Promise> {
        let job = self.of_tuned();
        let gains = self.searched.best.tuned.gains;
        job.promise(job.bench.rig, &job.steps()?, gains, &self.likely()?)
    }

    /// All that is said.
    pub(super) fn report(&self, model: &RestoredModel<'_>) -> anyhow::Result<TunedReport<'a>> {
        let Self {
            job,
            step,
            approaching,
            problem,
            ..
        } = *self;
        let args = job.args;
        let rig = job.bench.rig;
        let best = &self.searched.best;
        let bench = best.structured.bench;
        let gains = best.tuned.gains;
        let set_point = problem.set_point;
        let goal = problem.goal(job, best.structured)?;
        let closed_loop = step.closed_loop(&bench)?;
        let task = bench.task(closed_loop)?;
        let both = [self.named[0], self.named[1]];
        let ended = |one: Named<'_>| {
            one.structured
                .bench
                .rests(one.gains, set_point, approaching)
        };
        let [of_compared, of_tuned] =
            both.map(|one| one.structured.bench.rod_loop(one.gains, set_point));
        let (of_compared, of_tuned) = (of_compared?, of_tuned?);
        let draws = &self.rods.draws;
        Ok(TunedReport {
            rig,
            set_point: args.step_output,
            pid: bench.pid,
            sensor: bench.sensor,
            resolution: bench.resolution,
            dead_time_samples: bench.dead_time_samples,
            requirements: (args.preset != Preset::Sadeghi)
                .then(|| *best.structured.screen.requirements()),
            feed_forward: args.structure.feed_forward,
            schedules: args.structure.gain_schedule.map(|_| Schedules {
                tried: self.searched.tried.clone(),
                unscheduled: self.searched.unscheduled(),
            }),
            n_rods: self.rods.judged.len(),
            duration_s: step.n_samples as f64 * bench.pid.dt_s,
            weights: goal.weights,
            wear: goal.wear,
            found: best.tuned,
            opinion: problem.second_opinion(job, best)?,
            rests: [ended(both[0])?, ended(both[1])?],
            analyses: [of_compared.analyzed()?, of_tuned.analyzed()?],
            loops: pictures(&both),
            describing_curve: of_tuned.describing_curve(),
            robust: if draws.is_empty() {
                None
            } else {
                Some(robustness(&task, gains, draws)?)
            },
            restless_share: if draws.is_empty() {
                0.0
            } else {
                bench.restless_share(gains, set_point, approaching, draws)?
            },
            varied: sensitivities(&task, gains, &rig.variations(job.saved, model))?,
            front: if args.front {
                let fed_back = bench.task(problem.fed_back)?;
                let config = problem.config(job, best.structured)?;
                front(&fed_back, &self.rods.judged, &goal, &config)?
            } else {
                Vec::new()
            },
            tracks: job.tracks(&closed_loop, self.followed())?,
            checked: match &args.check {
                Some(path) => Some(self.of_tuned().checked(path, gains, &self.likely()?)?),
                None => None,
            },
            candidates: self.candidates()?,
        })
    }

    /// Controllers with their response, their margins and their cost.
    fn candidates(&self) -> anyhow::Result<Vec<Candidate>> {
        let candidate = |one: &Named<'_>| {
            let Structured { bench, screen } = one.structured;
            let task = bench.task(self.step.closed_loop(&bench)?)?;
            let response = task.response(bench.rig.member, one.gains)?;
            let goal = self.problem.goal(self.job, one.structured)?;
            Ok(Candidate {
                name: one.name,
                gains: one.gains,
                terms: response.terms,
                ending: response.ending,
                cost: goal.cost(&response),
                margins: screen.margins(&one.gains),
                passage: screen.passage(&one.gains),
                kick: screen.kick(&one.gains),
            })
        };
        self.named.iter().map(candidate).collect()
    }
}

/// Loops over frequencies where the phase margin of the last controller is least.
fn pictures(named: &[Named<'_>]) -> Vec<LoopPicture> {
    let Some(tuned) = named.last() else {
        return Vec::new();
    };
    let lag_rad = |open: &OpenLoop<'_>| open.margins().phase_margin_rad;
    let loops = tuned.structured.screen.loops(&tuned.gains);
    let Some(of_tuned) = loops.min_by(|a, b| lag_rad(a).total_cmp(&lag_rad(b))) else {
        return Vec::new();
    };
    let picture = |one: &Named<'_>| {
        let open = if one.name == tuned.name {
            of_tuned
        } else {
            OpenLoop {
                controller: one.structured.bench.pid,
                gains: one.gains,
                plant: of_tuned.plant,
            }
        };
        let at = of_tuned.plant.swept();
        LoopPicture {
            name: one.name,
            response: at
                .map(|(omega, _)| (omega / std::f64::consts::TAU, open.response(omega)))
                .collect(),
        }
    };
    named.iter().map(picture).collect()
}
