//! The plain model with what belongs to each recording left open.

use std::ops::ControlFlow;

use identify::{Fit, FitConfig, ForwardModel, IdentifyError, ParameterVector, WienerModel, fit};
use recording::{Recording, RepeatFloor};

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

/// Share of what runs of the same drive differ by that is no state of a run, up to which it is one that differs.
const OF_STATE: f64 = 0.5;

/// Whether the rig is seen to be another from run to run: recordings of the same drive differ by more than noise makes, and mostly by
/// what a heat loss, a gain or surroundings of their own do, each as much as the drive.
fn differs(repeats: &RepeatFloor) -> bool {
    let of_runs = repeats.pairs.iter();
    let of_runs = of_runs.filter(|pair| pair.first.recording != pair.second.recording);
    let [apart, left, by_noise] = of_runs.fold([0.0; 3], |[apart, left, by_noise], pair| {
        let n = pair.samples as f64;
        [
            apart + n * pair.apart.rms.powi(2),
            left + n * pair.apart.left.powi(2),
            by_noise + n * pair.by_noise.powi(2),
        ]
    });
    apart > REPEATS.powi(2) * by_noise && left < OF_STATE * apart
}

/// The plain model with what is seen to differ from run to run left open, within what is ordinary; as it was where runs repeat, or no
/// drive is repeated.
pub(crate) fn with_state_of_runs(
    base: &WienerModel,
    plain: Fit,
    training: &[Recording],
    repeats: Option<&RepeatFloor>,
    caller: &Caller<'_>,
) -> Result<(WienerModel, Fit), IdentifyError> {
    if training.len() < 2 || !repeats.is_some_and(differs) {
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
    let fitted = Fit {
        agreeing_starts: plain.agreeing_starts,
        starts: plain.starts,
        simulations: plain.simulations + fitted.simulations,
        ..fitted
    };
    Ok((open, fitted))
}
