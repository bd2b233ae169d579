//! Fits that end where more than one start of them does.

use std::ops::ControlFlow;

use identify::{Fit, FitConfig, FitProgress, ForwardModel, IdentifyError, ParameterVector, fit};
use recording::Recording;

/// Starts of a second fit over those of the first, where no two of these agreed.
const HARDER: u64 = 4;

/// A fit, and where no two of its starts agree another one from where it ended and from so many more.
///
/// # Errors
///
/// As [`fit`].
pub(crate) fn agreed(
    model: &dyn ForwardModel,
    training: &[Recording],
    config: &FitConfig,
    progress: &mut dyn FnMut(&FitProgress) -> ControlFlow<()>,
) -> Result<Fit, IdentifyError> {
    let first = fit(model, training, config, progress)?;
    if first.agreeing_starts >= first.starts.min(2) {
        return Ok(first);
    }
    let vector = ParameterVector::new(model.parameters(), training.len());
    let harder = FitConfig {
        starts: HARDER * config.starts,
        seed: config.seed.wrapping_add(1),
        from: vec![first.coordinates(&vector)],
        ..config.clone()
    };
    let second = fit(model, training, &harder, progress)?;
    Ok(Fit {
        simulations: first.simulations + second.simulations,
        ..second
    })
}
