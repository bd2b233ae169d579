//! The plain model with what belongs to each recording left open.

use std::ops::ControlFlow;

use identify::{
    Fit, FitConfig, ForwardModel, IdentifyError, ParameterVector, WienerModel, fit, predict,
};
use recording::{Recording, RepeatedDrive, repeat_floor};

use crate::agreed::agreed;
use crate::config::DiagnoseConfig;
use crate::model::case::expecting;
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

/// Difference of runs over what noise makes of it, up to which they repeat.
const REPEATS: f64 = 1.5;

/// Share of the square of what runs of the same drive differ by that states of theirs account for, from which these are what differs.
const OF_STATES: f64 = 0.5;

/// The plain model with what differs from run to run left open, within what is ordinary, where recordings of the same drive differ by
/// more than noise makes, and by what states of theirs account for; as it was where they repeat, or no drive is repeated.
///
/// What the model leaves out does the same in both, and is none of their difference.
pub(crate) fn with_state_of_runs(
    base: &WienerModel,
    plain: Fit,
    training: &[Recording],
    caller: &Caller<'_>,
) -> Result<(WienerModel, Fit), IdentifyError> {
    let floor = repeat_floor(training);
    let mut pairs = floor.map_or_else(Vec::new, |floor| floor.pairs);
    pairs.retain(|pair| pair.recordings()[0] != pair.recordings()[1]);
    let apart = squares(&pairs, |pair| pair.apart.rms);
    if apart <= REPEATS.powi(2) * squares(&pairs, |pair| pair.by_noise) {
        return Ok((base.clone(), plain));
    }
    let open = base.with_unknowns(training).with_state_of_runs();
    let vector = ParameterVector::new(open.parameters(), training.len());
    let config = FitConfig {
        seed: plain.seed,
        from: vec![plain.coordinates(&vector)],
        starts: 0,
        expecting: expecting(&open, &plain.noise),
        ..FitConfig::default()
    };
    let watched = Watched {
        model: &open,
        watch: caller,
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let fitted = fit(&watched, training, &config, go_on)?;
    let left = training.iter().enumerate().map(|(r, recording)| {
        let shown = predict(&watched, &fitted.point(r), recording)?.output;
        let pairs = recording.output().iter().zip(&shown);
        Ok(recording.with_output(pairs.map(|(recorded, shown)| recorded - shown).collect())?)
    });
    let left = left.collect::<Result<Vec<Recording>, IdentifyError>>()?;
    let pairs: Vec<RepeatedDrive> = pairs.iter().map(|pair| pair.of_outputs(&left)).collect();
    if squares(&pairs, |pair| pair.apart.rms) > (1.0 - OF_STATES) * apart {
        return Ok((base.clone(), plain));
    }
    let fitted = Fit {
        agreeing_starts: plain.agreeing_starts,
        starts: plain.starts,
        simulations: plain.simulations + fitted.simulations,
        ..fitted
    };
    Ok((open, fitted))
}

/// Sum of squares over all samples of pairs.
fn squares(pairs: &[RepeatedDrive], of: fn(&RepeatedDrive) -> f64) -> f64 {
    let squares = pairs
        .iter()
        .map(|pair| pair.samples as f64 * of(pair).powi(2));
    squares.sum()
}
