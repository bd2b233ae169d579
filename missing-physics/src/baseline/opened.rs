//! From the rig as it is written down to the baseline model that is searched from.

use std::ops::ControlFlow;

use identify::{Fit, FitConfig, IdentifyError, WienerModel, both, tell_time_constant, thinned};
use recording::{Recording, RepeatFloor, repeat_floor};

use crate::agreed::agreed;
use crate::baseline::run_states::{with_open_runs, with_state_of_runs};
use crate::baseline::unknowns::{fitted_to_all, with_unknowns};
use crate::config::DiagnoseConfig;
use crate::watch::{Caller, DiagnoseProgress, Watched};

/// Samples on which the baseline model is searched before anything is known of it, about.
const ENOUGH: usize = 1_500;

/// A baseline model with what belongs to recordings and runs open as far as it is asked for.
#[derive(Debug)]
pub(crate) struct Opened {
    pub(crate) base: WienerModel,
    pub(crate) plain: Fit,
    /// True if one minimum was found, before anything was opened or after.
    pub(crate) is_found: bool,
    /// Difference between recordings of the same drive, training and unseen.
    pub(crate) repeats: Option<RepeatFloor>,
}

impl Opened {
    /// The baseline model with what its recordings ask for: the training, and those that are not used.
    pub(crate) fn of(
        base: &WienerModel,
        recordings: [&[Recording]; 2],
        config: &DiagnoseConfig,
        caller: &Caller<'_>,
    ) -> Result<Self, IdentifyError> {
        let (plain, repeats) = both(
            || plain_fit(base, recordings[0], config, caller),
            || repeat_floor(&recordings.concat()),
        );
        Self::beyond(base, (plain?, repeats), recordings[0], config, caller)
    }

    /// [`Opened::of`] where the baseline model is fitted as it is already.
    pub(crate) fn from(
        base: &WienerModel,
        plain: Fit,
        recordings: [&[Recording]; 2],
        config: &DiagnoseConfig,
        caller: &Caller<'_>,
    ) -> Result<Self, IdentifyError> {
        let repeats = repeat_floor(&recordings.concat());
        Self::beyond(base, (plain, repeats), recordings[0], config, caller)
    }

    /// The baseline model with what its training asks for; `plain` is its fit as it is.
    fn beyond(
        base: &WienerModel,
        (plain, repeats): (Fit, Option<RepeatFloor>),
        training: &[Recording],
        config: &DiagnoseConfig,
        caller: &Caller<'_>,
    ) -> Result<Self, IdentifyError> {
        let has_converged = plain.converged();
        let (base, plain) = with_unknowns(base, plain, training, config, caller)?;
        let (base, plain) =
            with_state_of_runs(&base, plain, training, repeats.as_ref(), (config, caller))?;
        Ok(Self {
            is_found: has_converged || plain.converged(),
            base,
            plain,
            repeats,
        })
    }

    /// The baseline model of runs that may differ from one another as runs of a rig ordinarily do.
    pub(crate) fn of_runs(
        base: &WienerModel,
        plain: &Fit,
        runs: &[Recording],
        config: &DiagnoseConfig,
        caller: &Caller<'_>,
    ) -> Result<Self, IdentifyError> {
        let has_converged = plain.converged();
        let base = base.without_reference_run();
        let (base, plain) = with_open_runs(&base, plain, runs, (config, caller))?;
        Ok(Self {
            is_found: has_converged || plain.converged(),
            base,
            plain,
            repeats: repeat_floor(runs),
        })
    }
}

/// The baseline model fitted as it is. Of many samples it is searched on means of some, and fitted to all from where that ended.
pub(crate) fn plain_fit(
    base: &WienerModel,
    training: &[Recording],
    config: &DiagnoseConfig,
    caller: &Caller<'_>,
) -> Result<Fit, IdentifyError> {
    let Some(few) = thinned(training, ENOUGH)? else {
        return searched(base, training, config, caller);
    };
    let of_few = searched(base, &few, config, caller)?;
    if !tell_time_constant(&few, of_few.tau_s()) {
        return searched(base, training, config, caller);
    }
    let prior = config.baseline.prior;
    fitted_to_all(of_few, base, [training, &few], prior, (config, caller))
}

/// The baseline model fitted from many places.
fn searched(
    base: &WienerModel,
    training: &[Recording],
    config: &DiagnoseConfig,
    caller: &Caller<'_>,
) -> Result<Fit, IdentifyError> {
    let fit_config = FitConfig {
        seed: config.seed,
        ..config.baseline.clone()
    };
    let watched = Watched {
        model: base,
        watch: caller,
    };
    agreed(&watched, training, &fit_config, &mut |so_far| {
        // If this ends it, so does the next simulation.
        match caller.tell(DiagnoseProgress::Baseline(so_far.clone())) {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    })
}
