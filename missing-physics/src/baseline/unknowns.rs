//! The baseline model with what belongs to each recording left open.

use std::borrow::Cow;
use std::ops::ControlFlow;

use identify::{Fit, FitConfig, ForwardModel, IdentifyError, ParameterVector, WienerModel, fit};
use recording::Recording;

use crate::agreed::agreed;
use crate::config::DiagnoseConfig;
use crate::model::case::prior;
use crate::model::coarse::judged;
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

/// [`with_unknowns`], but where there are many samples what is open is decided and searched on those on which models are judged, and the
/// end is fitted once more to all.
pub(crate) fn with_unknowns_of_many(
    base: &WienerModel,
    plain: Fit,
    training: &[Recording],
    config: &DiagnoseConfig,
    caller: &Caller<'_>,
) -> Result<(WienerModel, Fit), IdentifyError> {
    let [few, _] = judged(base, &plain, [training, &[]])?;
    let Cow::Owned(few) = few else {
        return with_unknowns(base, plain, training, config, caller);
    };
    let n_effective = plain.noise.n_effective;
    let of_few = fitted_from((&plain, n_effective), base, &few, (config, caller))?;
    let (open, of_few) = with_unknowns(base, of_few, &few, config, caller)?;
    if open.parameters() == base.parameters() {
        return Ok((open, plain));
    }
    let fitted = fitted_from((&of_few, n_effective), &open, training, (config, caller))?;
    Ok((open, fitted))
}

/// The fit of a model from where another one ended alone, whose starts it carries on; `n_effective` samples count against priors.
pub(crate) fn fitted_from(
    (other, n_effective): (&Fit, f64),
    model: &WienerModel,
    training: &[Recording],
    (config, caller): (&DiagnoseConfig, &Caller<'_>),
) -> Result<Fit, IdentifyError> {
    let watched = Watched {
        model,
        watch: caller,
    };
    let vector = ParameterVector::new(model.parameters(), training.len());
    let fit_config = FitConfig {
        seed: config.seed,
        from: vec![other.coordinates(&vector)],
        starts: 0,
        prior: prior(model, n_effective),
        ended: Vec::new(),
        ..config.baseline.clone()
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let fitted = fit(&watched, training, &fit_config, go_on)?;
    Ok(Fit {
        agreeing_starts: other.agreeing_starts,
        starts: other.starts,
        simulations: other.simulations + fitted.simulations,
        ..fitted
    })
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
