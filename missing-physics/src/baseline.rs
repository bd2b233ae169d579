//! The plain model with what belongs to each recording left open.

use std::ops::ControlFlow;

use identify::{
    Enters, Fit, FitConfig, ForwardModel, IdentifyError, OfRig, ParameterState, ParameterVector,
    RefineConfig, Scope, WienerModel, fit, predict, refine,
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
    let watched = Watched {
        model: &open,
        watch: caller,
    };
    let left = of_states(&watched, &plain, training, &pairs)?;
    if left > (1.0 - OF_STATES) * apart {
        return Ok((base.clone(), plain));
    }
    let vector = ParameterVector::new(open.parameters(), training.len());
    let config = FitConfig {
        seed: plain.seed,
        from: vec![plain.coordinates(&vector)],
        starts: 0,
        expecting: expecting(&open, &plain.noise),
        ..FitConfig::default()
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let fitted = fit(&watched, training, &config, go_on)?;
    let fitted = Fit {
        agreeing_starts: plain.agreeing_starts,
        starts: plain.starts,
        simulations: plain.simulations + fitted.simulations,
        ..fitted
    };
    Ok((open, fitted))
}

/// Squares of what runs of the same drive differ by that are left where the second has the state which accounts for most of it.
///
/// What a model leaves out does the same in both, and is none of their difference: the second is what the model shows of it and what
/// it leaves of the second more than of the first.
fn of_states(
    model: &dyn ForwardModel,
    plain: &Fit,
    training: &[Recording],
    pairs: &[RepeatedDrive],
) -> Result<f64, IdentifyError> {
    let shown = training
        .iter()
        .enumerate()
        .map(|(r, recording)| Ok(predict(model, &plain.point(r), recording)?.output))
        .collect::<Result<Vec<Vec<f64>>, IdentifyError>>()?;
    let left = training.iter().zip(&shown).map(|(recording, shown)| {
        let pairs = recording.output().iter().zip(shown);
        Ok(recording.with_output(pairs.map(|(recorded, shown)| recorded - shown).collect())?)
    });
    let left = left.collect::<Result<Vec<Recording>, IdentifyError>>()?;
    let mut squares = 0.0;
    for pair in pairs {
        let r = pair.recordings()[1];
        let lag_s = pair.second.start_s - pair.first.start_s;
        let mut output = shown[r].clone();
        let mut weights = vec![0.0; output.len()];
        for [t, first, second] in pair.of_outputs(&left).apart.outputs {
            let after = training[r].time_s().partition_point(|at| *at < t + lag_s);
            let k = after.min(output.len() - 1);
            output[k] = shown[r][k] + second - first;
            weights[k] = 1.0;
        }
        let point = plain.point(r);
        let mut own = OfRig::at(model, &point);
        for (info, &value) in own.parameters.iter_mut().zip(&point) {
            if info.scope == Scope::PerRecording && info.enters == Enters::Nonlinear {
                info.state = match info.ordinary {
                    Some(_) => ParameterState::Free,
                    // How it began stays.
                    None => ParameterState::Fixed(value),
                };
            }
        }
        let vector = ParameterVector::new(own.parameters(), 1);
        let start = vector.coordinates(|_, _| Some(0.0));
        let config = RefineConfig {
            weights: Some(vec![weights]),
            ..RefineConfig::default()
        };
        let refined = refine(&own, &[training[r].with_output(output)?], &[start], &config)?;
        squares += pair.samples as f64 * refined.mean_square;
    }
    Ok(squares)
}

/// Sum of squares over all samples of pairs.
fn squares(pairs: &[RepeatedDrive], of: fn(&RepeatedDrive) -> f64) -> f64 {
    let squares = pairs
        .iter()
        .map(|pair| pair.samples as f64 * of(pair).powi(2));
    squares.sum()
}
