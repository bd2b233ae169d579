//! The baseline model with what differs from run to run left open.

use identify::{
    Enters, Fit, ForwardModel, IdentifyError, OfRig, ParameterState, ParameterVector, RefineConfig,
    Scope, WienerModel, predict, refine,
};
use recording::{Recording, RepeatFloor, RepeatedDrive};

use crate::baseline::unknowns::fitted_from;
use crate::config::DiagnoseConfig;
use crate::model::case::prior;
use crate::watch::{Caller, Watched};

/// Least share of the mean square difference between runs of the same drive that run states must explain before they are opened.
const OF_STATES: f64 = 0.5;

/// The baseline model with what differs from run to run left open, within what is ordinary, where recordings of the same drive differ by
/// more than noise makes, and by what states of theirs account for; as it was where they repeat, or no drive is repeated. `repeats` are of
/// all recordings, those of the training first.
pub(crate) fn with_state_of_runs(
    base: &WienerModel,
    plain: Fit,
    training: &[Recording],
    repeats: Option<&RepeatFloor>,
    (config, caller): (&DiagnoseConfig, &Caller<'_>),
) -> Result<(WienerModel, Fit), IdentifyError> {
    let floor = repeats.and_then(|floor| floor.between_first(training.len()));
    let Some(floor) = floor.filter(|floor| !floor.is_noise()) else {
        return Ok((base.clone(), plain));
    };
    let apart = squares(&floor.pairs, |pair| pair.apart.rms);
    let open = base.with_unknowns(training).with_state_of_runs();
    let watched = Watched {
        model: &open,
        watch: caller,
    };
    let left = of_states(&watched, &plain, training, &floor.pairs)?;
    if left > (1.0 - OF_STATES) * apart {
        return Ok((base.clone(), plain));
    }
    with_open_runs(base, &plain, training, (config, caller))
}

/// The baseline model with what differs from run to run left open, within what is ordinary, fitted from where it ended without.
pub(crate) fn with_open_runs(
    base: &WienerModel,
    plain: &Fit,
    training: &[Recording],
    (config, caller): (&DiagnoseConfig, &Caller<'_>),
) -> Result<(WienerModel, Fit), IdentifyError> {
    let open = base.with_unknowns(training).with_state_of_runs();
    let fitted = fitted_from(
        plain,
        &open,
        training,
        prior(&open, plain.noise.n_effective),
        (config, caller),
    )?;
    Ok((open, fitted))
}

/// Squares of what runs of the same drive differ by that are left where the second has the state which accounts for most of it.
///
/// The model error that both have in common is cancelled: the second run is replaced by its prediction plus the difference of the two
/// residuals, and only level, heat loss and gain are fitted.
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
        let outputs = pair.of_outputs(&left).map(|pair| pair.apart.outputs);
        for [t, first, second] in outputs.unwrap_or_default() {
            let after = training[r].time_s().partition_point(|at| *at < t + lag_s);
            let k = after.min(output.len() - 1);
            output[k] = shown[r][k] + second - first;
            weights[k] = 1.0;
        }
        let point = plain.point(r);
        let mut own = OfRig::at(model, &point);
        for (info, &value) in own.parameters.iter_mut().zip(&point) {
            if info.scope == Scope::PerRecording && info.enters == Enters::Nonlinear {
                // How it began stays, and what is stated.
                if info.ordinary.is_none() {
                    info.state = ParameterState::Fixed(value);
                }
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
