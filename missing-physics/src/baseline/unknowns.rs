//! The baseline model with what belongs to each recording left open.

use std::ops::ControlFlow;

use identify::{Fit, FitConfig, ForwardModel, IdentifyError, ParameterVector, WienerModel};
use recording::Recording;

use crate::agreed::agreed;
use crate::config::DiagnoseConfig;
use crate::model::case::prior;
use crate::watch::{Caller, Watched};

/// Error of the baseline model with more open, over that without, from which the recordings do not ask for it.
const ASKED_FOR: f64 = 0.95;

/// Starts of such a fit, beside the place where the baseline model ended.
const FEW_STARTS: u64 = 4;

/// The baseline model with what belongs to each recording left open, within what is ordinary, and with the scale of temperature open
/// where recorded surroundings tell it; fitted from where it ended without and from elsewhere.
///
/// The level of the surroundings is open even where the baseline model does not ask for it: a misfit may hide it, and then what is
/// found of the misfit would be blamed for it, too. A warm start and the scale, of which nothing is known before, are asked for.
pub(crate) fn with_unknowns(
    base: &WienerModel,
    plain: Fit,
    training: &[Recording],
    config: &DiagnoseConfig,
    caller: &Caller<'_>,
) -> Result<(WienerModel, Fit), IdentifyError> {
    let taken = |(base, plain): (WienerModel, Fit), open: WienerModel, is_asked: bool| {
        let with = refitted(&base, &open, plain.clone(), training, (config, caller))?;
        let is_taken = !is_asked || with.train_rmse < ASKED_FOR * plain.train_rmse;
        Ok(if is_taken {
            (open, with)
        } else {
            (base, plain)
        })
    };
    let warm = base.with_open_starts(training);
    let (base, plain) = taken((base.clone(), plain), warm, true)?;
    let leveled = base.with_open_levels(training);
    let (base, plain) = taken((base, plain), leveled, false)?;
    let scaled = base.with_scale_told_by(training);
    taken((base, plain), scaled, true)
}

/// The fit of a model with more open than another, from where that ended and from elsewhere; that of the other, where nothing is.
fn refitted(
    base: &WienerModel,
    open: &WienerModel,
    plain: Fit,
    training: &[Recording],
    (config, caller): (&DiagnoseConfig, &Caller<'_>),
) -> Result<Fit, IdentifyError> {
    if open.parameters() == base.parameters() {
        return Ok(plain);
    }
    let vector = ParameterVector::new(open.parameters(), training.len());
    let fit_config = FitConfig {
        seed: config.seed,
        from: vec![plain.coordinates(&vector)],
        starts: FEW_STARTS,
        prior: prior(open, plain.noise.n_effective),
        ..config.baseline.clone()
    };
    let watched = Watched {
        model: open,
        watch: caller,
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    agreed(&watched, training, &fit_config, go_on)
}
