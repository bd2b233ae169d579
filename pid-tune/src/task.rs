use rayon::prelude::*;
use wiener::{Fleet, Plant, Started, widest_vectors};

use crate::reference::edges_passed;
use crate::robustness::EndingLanes;
use crate::{
    ClosedLoop, Ending, Pid, PidGains, PidParams, Reference, ResponseTerms, Terms, TuneError,
};

/// Lanes of a full chunk: four vectors of eight, as in [`wiener::lockstep`].
const WIDE: usize = 32;
/// Lanes of a small chunk: one vector of eight.
const NARROW: usize = 8;

/// No drive, whatever the error.
const IDLE: PidGains = PidGains {
    kp: 0.0,
    ki: 0.0,
    kd: 0.0,
};

/// What can stop a [`Task`]: `E` is the error of its plants, [`Fleet::Error`].
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TaskError<E> {
    /// A plant is refused.
    #[error("plant")]
    Plant(#[source] E),
    /// Anything else is.
    #[error(transparent)]
    Tune(#[from] TuneError),
}

/// One job for a controller: a kind of plant, the loop around it, and all of the controller but its gains.
///
/// Plants are any [`Fleet`]: `wiener::Ensemble`, or one of your own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Task<'a, F> {
    fleet: F,
    closed_loop: ClosedLoop<'a>,
    pid: PidParams,
}

/// How one plant under one controller responded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    /// Terms of the cost.
    pub terms: Terms,
    /// How it ended.
    pub ending: Ending,
}

impl<'a, F> Task<'a, F> {
    /// Checks the controller; the loop has been checked, plants are when they are run.
    ///
    /// # Errors
    ///
    /// Those of [`Pid::new`].
    pub fn new(fleet: F, closed_loop: ClosedLoop<'a>, pid: PidParams) -> Result<Self, TuneError> {
        Pid::new(pid, &[IDLE])?;
        Ok(Self {
            fleet,
            closed_loop,
            pid,
        })
    }

    /// The loop.
    #[must_use]
    pub fn closed_loop(&self) -> &ClosedLoop<'a> {
        &self.closed_loop
    }

    /// All of the controller but its gains.
    #[must_use]
    pub fn pid(&self) -> &PidParams {
        &self.pid
    }

    /// Whether the reference is a step, and so has a rise, a settling time and an overshoot.
    pub(crate) fn is_step(&self) -> bool {
        self.n_after_step().is_some_and(|n_samples| n_samples >= 2)
    }

    /// Time that is left after the step, s: the settling time of a response that does not settle.
    pub(crate) fn left_s(&self) -> Option<f64> {
        let n_samples = self.n_after_step()?;
        Some(n_samples.saturating_sub(1) as f64 * self.pid.dt_s)
    }

    /// Samples from the step on.
    fn n_after_step(&self) -> Option<usize> {
        let params = self.closed_loop.params();
        let Reference::Step { at_s, .. } = params.reference else {
            return None;
        };
        let after = |&k: &usize| edges_passed(at_s, k, self.pid.dt_s) > 0;
        Some((0..params.n_samples).filter(after).count())
    }
}

impl<F: Fleet<Member: Sync, Error: Send> + Sync> Task<'_, F> {
    /// Terms of the cost of many responses, each of a plant under a controller, in the order of the cases.
    ///
    /// Terms of an output that is `NaN` are `NaN`, and so is their cost.
    ///
    /// # Errors
    ///
    /// As [`Task::responses`].
    pub fn evaluate(
        &self,
        cases: &[(F::Member, PidGains)],
    ) -> Result<Vec<Terms>, TaskError<F::Error>> {
        let responses = self.responses(cases)?;
        Ok(responses.iter().map(|response| response.terms).collect())
    }

    /// Many responses, each of a plant under a controller, in the order of the cases.
    ///
    /// They run side by side in lockstep, on the widest vectors of the machine and the threads of the current
    /// rayon pool, and are the same bits as each alone, if the plants' lanes keep to plain arithmetic. Plants
    /// start as their fleet says, controllers idle ([`Pid::rest`]).
    ///
    /// # Errors
    ///
    /// [`TaskError::Plant`] for a plant, [`TaskError::Tune`] for gains that are refused; of several, for one
    /// of the first chunk that has any.
    pub fn responses(
        &self,
        cases: &[(F::Member, PidGains)],
    ) -> Result<Vec<Response>, TaskError<F::Error>> {
        // Equal bits at every width: how the cases are shared out is a matter of speed only.
        let share = cases.len().div_ceil(rayon::current_num_threads());
        let share = share.next_multiple_of(NARROW).clamp(NARROW, WIDE);
        let chunks: Vec<_> = cases
            .par_chunks(share)
            .map(|chunk| match chunk.len() {
                // Two widths: a plant with many effects takes the compiler long.
                n if n <= NARROW => self.chunk::<NARROW>(chunk),
                _ => self.chunk::<WIDE>(chunk),
            })
            .collect();
        let mut responses = Vec::with_capacity(cases.len());
        for chunk in chunks {
            responses.extend(chunk?);
        }
        Ok(responses)
    }

    /// The responses of 1 to `L` cases.
    fn chunk<const L: usize>(
        &self,
        cases: &[(F::Member, PidGains)],
    ) -> Result<Vec<Response>, TaskError<F::Error>> {
        // Empty lanes repeat the last case.
        let lanes: [_; L] = core::array::from_fn(|l| cases[l.min(cases.len() - 1)]);
        let members = lanes.map(|(member, _)| member);
        let Started { plant, mut state } = self.fleet.start(&members).map_err(TaskError::Plant)?;
        let pid = Pid::new(self.pid, &lanes.map(|(_, gains)| gains))?;
        // A controller cannot rest at what is no number: it misses its first sample instead.
        let shown = plant.output(&state).displacement;
        let mut pid_state =
            pid.rest(shown.map(|value| if value.is_finite() { value } else { 0.0 }))?;
        let params = self.closed_loop.params();
        let mut terms = ResponseTerms::<L>::new(&params.reference, self.pid.dt_s)?;
        let mut ending = EndingLanes::<L>::new(params.n_samples, self.pid.limits);
        widest_vectors(
            #[inline(always)]
            || {
                self.closed_loop.run(
                    &plant,
                    &mut state,
                    &pid,
                    &mut pid_state,
                    #[inline(always)]
                    |snapshot| {
                        terms.add(snapshot);
                        ending.add(snapshot);
                    },
                );
            },
        );
        let (terms, endings) = (terms.terms(), ending.endings());
        Ok((0..cases.len())
            .map(|l| Response {
                terms: terms[l],
                ending: endings[l],
            })
            .collect())
    }
}
