//! The search for gains: for gains that stay, and, where that is asked for, along gain schedules.

use std::ops::ControlFlow;

use indicatif::ProgressBar;
use pid_tune::{
    Across, ClosedLoop, CostWeights, Goal, Plants, Screen, SecondOpinion, TaskError, TuneError,
    Tuned, TunerConfig, second_opinion, tune,
};
use sma_effects::Member;
use workbench::{Bench, Scheduled, TriedSchedule};

use super::{Counts, Job, Preset};
use crate::terminal::bar;

/// Share of the cost that a schedule saves at least, to be worth its factors.
const LEAST_SAVED: f64 = 0.01;

/// A controller of one structure, and what its gains have to meet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Structured<'a> {
    /// The rig with the controller.
    pub(super) bench: Bench<'a>,
    /// Its requirements.
    pub(super) screen: &'a Screen,
}

/// A search, whatever the structure of the controller.
pub(super) struct Problem<'a> {
    /// The response that is judged.
    pub(super) fed_back: ClosedLoop<'a>,
    /// Loops that have to come to rest.
    pub(super) resting: [ClosedLoop<'a>; 2],
    /// Set point, as the controller sees it.
    pub(super) set_point: f64,
    pub(super) weights: CostWeights,
    pub(super) rods: &'a [Member],
    /// Rods on which the loop has to rest as well.
    pub(super) likely: &'a [Member],
}

/// Gains that were found, with the structure that they are for.
pub(super) struct Found<'a> {
    pub(super) structured: Structured<'a>,
    pub(super) tuned: Tuned,
}

/// The result of all searches.
pub(super) struct Searched<'a> {
    /// The gains to be used.
    pub(super) best: Found<'a>,
    /// The best gains that stay, if those to be used follow a schedule.
    pub(super) staying: Option<Found<'a>>,
    /// Schedules that were tried.
    pub(super) tried: Vec<TriedSchedule>,
}

impl Searched<'_> {
    /// Cost of the best gains that stay; `None` if none meet what is required.
    pub(super) fn unscheduled(&self) -> Option<f64> {
        let is_scheduled = self.best.structured.bench.pid.gain_schedule.is_some();
        match &self.staying {
            Some(staying) => Some(staying.tuned.cost),
            None => (!is_scheduled).then_some(self.best.tuned.cost),
        }
    }
}

impl<'a> Problem<'a> {
    /// Cost and requirements for one structure.
    pub(super) fn goal<'g>(
        &'g self,
        job: &Job<'_>,
        structured: Structured<'g>,
    ) -> anyhow::Result<Goal<'g>> {
        let goal = if job.args.preset == Preset::Sadeghi {
            Goal::of(self.weights)
        } else {
            structured.bench.goal(
                self.weights,
                structured.screen,
                &self.resting,
                self.set_point,
            )?
        };
        Ok(Goal {
            across: match job.args.across {
                Counts::Worst => Across::Worst,
                Counts::Mean => Across::Mean,
            },
            ..goal
        })
    }

    /// Gains of least cost: those that stay, or the cheapest of some schedules if that saves [`LEAST_SAVED`].
    pub(super) fn search(
        &self,
        job: &Job<'_>,
        staying: Structured<'a>,
        scheduled: &'a [Scheduled<'a>],
    ) -> anyhow::Result<Searched<'a>> {
        let bar = bar(
            job.args.quiet,
            self.config(job, staying)?.moves * (1 + scheduled.len() as u64),
            "tune {bar:20} move {pos}/{len}  {eta} left",
        );
        let mut searches = vec![(staying, self.found(job, staying, &bar)?)];
        for one in scheduled {
            let structured = Structured {
                bench: one.bench,
                screen: &one.screen,
            };
            searches.push((structured, self.found(job, structured, &bar)?));
        }
        bar.finish_and_clear();
        let tried = scheduled.iter().zip(&searches[1..]);
        let tried = tried
            .map(|(one, (_, found))| TriedSchedule {
                exponent: one.shape.exponent,
                by_branch: one.shape.by_branch,
                cost: found.as_ref().ok().map(|tuned| tuned.cost),
            })
            .collect();
        let mut searches = searches.into_iter();
        let of_staying = searches.next().map(|(_, found)| found);
        let cheapest = searches
            .filter_map(|(structured, found)| found.ok().map(|tuned| Found { structured, tuned }))
            .min_by(|a, b| a.tuned.cost.total_cmp(&b.tuned.cost));
        let of_staying = of_staying.unwrap_or(Err(TuneError::NoFiniteCost));
        let stay = |tuned| Found {
            structured: staying,
            tuned,
        };
        let (best, staying) = match (of_staying, cheapest) {
            (Ok(staying), Some(best)) if best.tuned.cost <= (1.0 - LEAST_SAVED) * staying.cost => {
                (best, Some(stay(staying)))
            }
            (Ok(staying), _) => (stay(staying), None),
            (Err(_), Some(best)) => (best, None),
            (Err(fault), None) => return Err(fault.into()),
        };
        Ok(Searched {
            best,
            staying,
            tried,
        })
    }

    /// The best gains of one structure, or the fault of all gains.
    fn found(
        &self,
        job: &Job<'_>,
        structured: Structured<'_>,
        bar: &ProgressBar,
    ) -> anyhow::Result<Result<Tuned, TuneError>> {
        let config = self.config(job, structured)?;
        let task = structured.bench.task(self.fed_back)?;
        let goal = self.goal(job, structured)?;
        let plants = Plants {
            judged: self.rods,
            resting: self.likely,
        };
        let before = bar.position();
        let found = tune(&task, &plants, &goal, &config, |progress| {
            bar.set_position(before + progress.moves);
            ControlFlow::Continue(())
        });
        bar.set_position(before + config.moves);
        match found {
            Ok(tuned) => Ok(Ok(tuned)),
            Err(TaskError::Tune(
                fault @ (TuneError::Unmet | TuneError::NoRest | TuneError::NoFiniteCost),
            )) => Ok(Err(fault)),
            Err(error) => Err(error.into()),
        }
    }

    /// Another optimizer on what a search has found.
    pub(super) fn second_opinion(
        &self,
        job: &Job<'_>,
        found: &Found<'_>,
    ) -> anyhow::Result<SecondOpinion> {
        let structured = found.structured;
        let task = structured.bench.task(self.fed_back)?;
        let goal = self.goal(job, structured)?;
        let config = self.config(job, structured)?;
        Ok(second_opinion(
            &task,
            self.rods,
            &goal,
            &config,
            &found.tuned,
        )?)
    }

    pub(super) fn config(
        &self,
        job: &Job<'_>,
        structured: Structured<'_>,
    ) -> anyhow::Result<TunerConfig> {
        let task = structured.bench.task(self.fed_back)?;
        Ok(job.search(&task, structured.screen)?)
    }
}
