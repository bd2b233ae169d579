//! The baseline model with what belongs to each recording left open.

use std::borrow::Cow;
use std::ops::ControlFlow;

use identify::{
    Fit, FitConfig, ForwardModel, IdentifyError, ParameterVector, Prior, WienerModel, fit, thinned,
};
use recording::Recording;

use crate::agreed::agreed;
use crate::config::DiagnoseConfig;
use crate::model::case::prior;
use crate::model::coarse::{NEARLY_ALL, judged};
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
///
/// Many samples are searched on those on which models are judged, and the end is fitted once more to all.
pub(crate) fn with_unknowns(
    base: &WienerModel,
    plain: Fit,
    training: &[Recording],
    config: &DiagnoseConfig,
    caller: &Caller<'_>,
) -> Result<(WienerModel, Fit), IdentifyError> {
    let [few, _] = judged(base, &plain, [training, &[]])?;
    let Cow::Owned(few) = few else {
        return opened(base, plain, [training; 2], 0.0, (config, caller));
    };
    let prior_of_plain = config.baseline.prior;
    let of_few = fitted_from(&plain, base, &few, prior_of_plain, (config, caller))?;
    // That of the samples about their means, which no model changes.
    let between = (plain.train_rmse.powi(2) - of_few.train_rmse.powi(2)).max(0.0);
    let n_effective = plain.noise.n_effective;
    let (open, of_few) = opened(base, of_few, [training, &few], between, (config, caller))?;
    if open.parameters() == base.parameters() {
        return Ok((open, plain));
    }
    let prior = prior(&open, n_effective);
    let fitted = fitted_to_all(of_few, &open, [training, &few], prior, (config, caller))?;
    Ok((open, fitted))
}

/// The model with what its training asks for, fitted to the second recordings, which are the same or fewer samples of them; `between` is the
/// mean square of the samples that these leave out about them.
fn opened(
    base: &WienerModel,
    plain: Fit,
    [training, fitted]: [&[Recording]; 2],
    between: f64,
    (config, caller): (&DiagnoseConfig, &Caller<'_>),
) -> Result<(WienerModel, Fit), IdentifyError> {
    let of_all = |fit: &Fit| (fit.train_rmse.powi(2) + between).sqrt();
    let cold = plain.clone();
    let taken = |(base, plain): (WienerModel, Fit), open: WienerModel, is_asked: bool| {
        let with = refitted(&base, &open, [&plain, &cold], fitted, (config, caller))?;
        let is_taken = !is_asked || of_all(&with) < ASKED_FOR * of_all(&plain);
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
    // What levels leave it may explain, and not before: it shows on the first branch alone.
    let turned = base.with_open_reversals();
    let (base, plain) = taken((base, plain), turned, true)?;
    let scaled = base.with_scale_told_by(training);
    taken((base, plain), scaled, true)
}

/// The fit of a model to all samples, from where its search on fewer of them ended; of very many it goes by way of some. It has the starts and the
/// other minima of the search; simulations of fewer samples count as their share.
pub(crate) fn fitted_to_all(
    of_few: Fit,
    model: &WienerModel,
    [training, few]: [&[Recording]; 2],
    prior: Prior,
    (config, caller): (&DiagnoseConfig, &Caller<'_>),
) -> Result<Fit, IdentifyError> {
    let n = |recordings: &[Recording]| recordings.iter().map(Recording::len).sum::<usize>() as f64;
    let share = |simulations: u64, of: &[Recording]| {
        (simulations as f64 * n(of) / n(training)).ceil() as u64
    };
    let mut simulations = share(of_few.simulations, few);
    let mut from = Cow::Borrowed(&of_few);
    if let Some(some) =
        thinned(training, NEARLY_ALL.samples)?.filter(|some| NEARLY_ALL.are_few(some, training))
    {
        let of_some = fitted_from(&of_few, model, &some, prior, (config, caller))?;
        simulations += share(of_some.simulations - of_few.simulations, &some);
        from = Cow::Owned(of_some);
    }
    let fitted = fitted_from(&from, model, training, prior, (config, caller))?;
    Ok(Fit {
        simulations: simulations + fitted.simulations - from.simulations,
        rejected_costs: of_few.rejected_costs + fitted.rejected_costs,
        other_minima: of_few.other_minima,
        ..fitted
    })
}

/// The fit of a model from where another one ended alone, whose starts and simulations it carries on.
pub(crate) fn fitted_from(
    other: &Fit,
    model: &WienerModel,
    training: &[Recording],
    prior: Prior,
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
        prior,
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

/// The fit of a model with more open than another, from where that ended, where the first of all did and elsewhere; that of the other,
/// where nothing is. What was opened before may have bent the first end to where nothing else leads lower.
fn refitted(
    base: &WienerModel,
    open: &WienerModel,
    [plain, first]: [&Fit; 2],
    training: &[Recording],
    (config, caller): (&DiagnoseConfig, &Caller<'_>),
) -> Result<Fit, IdentifyError> {
    if open.parameters() == base.parameters() {
        return Ok(plain.clone());
    }
    let vector = ParameterVector::new(open.parameters(), training.len());
    let mut from = vec![plain.coordinates(&vector)];
    let of_first = first.coordinates(&vector);
    if !from.contains(&of_first) {
        from.push(of_first);
    }
    let fit_config = FitConfig {
        seed: config.seed,
        from,
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
