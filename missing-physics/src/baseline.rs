//! The plain model with what belongs to each recording left open.

use std::ops::ControlFlow;

use identify::{Fit, FitConfig, ForwardModel, IdentifyError, ParameterVector, WienerModel};
use recording::Recording;

use crate::agreed::agreed;
use crate::config::DiagnoseConfig;
use crate::watch::{Caller, Watched};

/// Error of the plain model with what belongs to the recordings left open, over that without, from which they do not ask for it.
const ASKED_FOR: f64 = 0.95;

/// Starts of that fit, beside the place where the plain model ended.
const FEW_STARTS: u64 = 4;

/// The plain model with what belongs to each recording left open, fitted from where it ended without and from elsewhere; as
/// it was, where nothing is open or the recordings do not ask for it.
pub(crate) fn with_unknowns(
    base: &WienerModel,
    plain: Fit,
    training: &[Recording],
    config: &DiagnoseConfig,
    caller: &Caller<'_>,
) -> Result<(WienerModel, Fit), IdentifyError> {
    let open = base.with_unknowns(training);
    if open.parameters() == base.parameters() {
        return Ok((open, plain));
    }
    let vector = ParameterVector::new(open.parameters(), training.len());
    let fit_config = FitConfig {
        seed: config.seed,
        from: vec![plain.coordinates(&vector)],
        starts: FEW_STARTS,
        ..config.baseline.clone()
    };
    let watched = Watched {
        model: &open,
        watch: caller,
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let fitted = agreed(&watched, training, &fit_config, go_on)?;
    if fitted.train_rmse < ASKED_FOR * plain.train_rmse {
        Ok((open, fitted))
    } else {
        Ok((base.clone(), plain))
    }
}
