use rayon::prelude::*;
use wiener::{Fleet, Lanes, NARROW, WIDE, padded, widest_vectors};

use crate::reference::edges_passed;
use crate::robustness::EndingLanes;
use crate::{
    ClosedLoop, Ending, Pid, PidGains, PidParams, PidState, Reference, ResponseTerms, Snapshot,
    Terms, TuneError,
};

/// No drive, whatever the error.
const IDLE: PidGains = PidGains {
    kp: 0.0,
    ki: 0.0,
    kd: 0.0,
};

/// Errors that can stop a [`Task`]: `E` is the error of its plants, [`Fleet::Error`].
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

    /// True if the reference is a step, so that the response has a rise time, a settling time and an overshoot.
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
        self.responses_around(self.closed_loop, cases)
    }

    /// Responses around another loop.
    pub(crate) fn responses_around(
        &self,
        closed_loop: ClosedLoop<'_>,
        cases: &[(F::Member, PidGains)],
    ) -> Result<Vec<Response>, TaskError<F::Error>> {
        // Equal bits at every width: how the cases are shared out is a matter of speed only.
        let share = cases.len().div_ceil(rayon::current_num_threads());
        let share = share.next_multiple_of(NARROW).clamp(NARROW, WIDE);
        let chunks: Vec<_> = cases
            .par_chunks(share)
            .map(|chunk| self.chunk(&closed_loop, chunk))
            .collect();
        let mut responses = Vec::with_capacity(cases.len());
        for chunk in chunks {
            responses.extend(chunk?);
        }
        Ok(responses)
    }

    /// One response.
    ///
    /// # Errors
    ///
    /// As [`Task::responses`].
    pub fn response(
        &self,
        member: F::Member,
        gains: PidGains,
    ) -> Result<Response, TaskError<F::Error>> {
        let Some(response) = self.responses(&[(member, gains)])?.pop() else {
            unreachable!("one case has one response");
        };
        Ok(response)
    }

    /// One response, sample by sample: the plant under a controller from where [`Task::responses`] starts.
    ///
    /// # Errors
    ///
    /// As [`Task::responses`].
    pub fn show(
        &self,
        member: F::Member,
        gains: PidGains,
        visit: &mut dyn FnMut(&Snapshot),
    ) -> Result<(), TaskError<F::Error>> {
        let plants = self.fleet.narrow(&[member; NARROW]);
        let plants = plants.map_err(TaskError::Plant)?;
        Ok(show_first(
            &self.closed_loop,
            self.pid,
            plants,
            gains,
            visit,
        )?)
    }

    /// The responses of 1 to [`WIDE`] cases.
    fn chunk(
        &self,
        closed_loop: &ClosedLoop<'_>,
        cases: &[(F::Member, PidGains)],
    ) -> Result<Vec<Response>, TaskError<F::Error>> {
        let members: Vec<F::Member> = cases.iter().map(|&(member, _)| member).collect();
        let gains: Vec<PidGains> = cases.iter().map(|&(_, gains)| gains).collect();
        // Two functions that are not generic: a loop around plants is compiled here, for all of them.
        let responses = if cases.len() <= NARROW {
            let plants = self.fleet.narrow(&padded(&members));
            respond_narrow(
                closed_loop,
                self.pid,
                plants.map_err(TaskError::Plant)?,
                &gains,
            )
        } else {
            let plants = self.fleet.wide(&padded(&members));
            respond_wide(
                closed_loop,
                self.pid,
                plants.map_err(TaskError::Plant)?,
                &gains,
            )
        };
        Ok(responses?)
    }
}

fn respond_narrow(
    closed_loop: &ClosedLoop<'_>,
    pid: PidParams,
    plants: Box<dyn Lanes<NARROW> + Send>,
    gains: &[PidGains],
) -> Result<Vec<Response>, TuneError> {
    respond(closed_loop, pid, plants, gains)
}

fn respond_wide(
    closed_loop: &ClosedLoop<'_>,
    pid: PidParams,
    plants: Box<dyn Lanes<WIDE> + Send>,
    gains: &[PidGains],
) -> Result<Vec<Response>, TuneError> {
    respond(closed_loop, pid, plants, gains)
}

/// Shows the first of plants that are alike, under controllers that are.
fn show_first(
    closed_loop: &ClosedLoop<'_>,
    pid: PidParams,
    mut plants: Box<dyn Lanes<NARROW> + Send>,
    gains: PidGains,
    visit: &mut dyn FnMut(&Snapshot),
) -> Result<(), TuneError> {
    let pid = Pid::new(pid, &[gains; NARROW])?;
    let mut pid_state = idle(&pid, &*plants)?;
    closed_loop.run(&mut *plants, &pid, &mut pid_state, |snapshot| {
        visit(&Snapshot {
            k: snapshot.k,
            time_s: snapshot.time_s,
            setpoint: snapshot.setpoint,
            output: [snapshot.output[0]],
            measured: [snapshot.measured[0]],
            drive: [snapshot.drive[0]],
            temperature_degc: [snapshot.temperature_degc[0]],
        });
    });
    Ok(())
}

/// Controllers at rest at what plants show; at 0 where that is no number, so that they miss their first sample.
fn idle<const L: usize>(
    pid: &Pid<L>,
    plants: &(dyn Lanes<L> + Send),
) -> Result<PidState<L>, TuneError> {
    let shown = plants.output().displacement;
    pid.rest(shown.map(|value| if value.is_finite() { value } else { 0.0 }))
}

/// Responses of the plants of as many lanes as there are gains.
fn respond<const L: usize>(
    closed_loop: &ClosedLoop<'_>,
    pid: PidParams,
    mut plants: Box<dyn Lanes<L> + Send>,
    gains: &[PidGains],
) -> Result<Vec<Response>, TuneError> {
    let params = closed_loop.params();
    let mut terms = ResponseTerms::<L>::new(&params.reference, pid.dt_s)?;
    let mut ending = EndingLanes::<L>::new(params.n_samples, &pid);
    let pid = Pid::new(pid, &padded(gains))?;
    let mut pid_state = idle(&pid, &*plants)?;
    widest_vectors(
        #[inline(always)]
        || {
            closed_loop.run(
                &mut *plants,
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
    Ok((0..gains.len())
        .map(|l| Response {
            terms: terms[l],
            ending: endings[l],
        })
        .collect())
}
