//! How much of the error on unseen recordings is explained, and how surely.

use identify::{ForwardModel, IdentifyError, Validated, WienerModel, predict};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use recording::Recording;

use crate::diagnosis::{Explained, ExtendedStage, Stage};
use crate::floor::Measured;
use crate::judge::Judged;

/// Blocks of an unseen recording that are drawn anew.
const BLOCKS: usize = 12;

/// Times that they are.
const DRAWS: usize = 500;

/// Shares of the explainable error that the extended model explains.
pub(crate) fn explained(
    baseline: &Stage,
    extended: &ExtendedStage,
    judged: &Judged,
    unseen: &[Recording],
    noise: &Measured,
    base: &WienerModel,
) -> Result<Explained, IdentifyError> {
    let mut before = Vec::new();
    let mut after = Vec::new();
    for (k, recording) in unseen.iter().enumerate() {
        before.extend(blocks(base, &baseline.validated[k], recording)?);
        after.extend(blocks(
            &extended.model,
            &extended.stage.validated[k],
            recording,
        )?);
    }
    let share = |pick: &mut dyn FnMut(usize) -> usize| {
        let (mut n, mut sums) = (0.0, [0.0; 2]);
        for k in 0..before.len() {
            let k = pick(k);
            n += before[k].0;
            sums[0] += before[k].1;
            sums[1] += after[k].1;
        }
        let [before, after] = sums.map(|sum| sum / n);
        let explainable = before - noise.gate;
        (explainable > 0.0).then(|| (before - after) / explainable)
    };
    if unseen.is_empty() {
        return Ok(Explained {
            train: judged.explained,
            validate: None,
            validate_interval: None,
        });
    }
    let validate = share(&mut |k| k);
    let mut rng = ChaCha8Rng::seed_from_u64(extended.stage.fit.seed);
    let mut drawn: Vec<f64> = (0..DRAWS)
        .filter_map(|_| share(&mut |_| rng.random_range(0..before.len())))
        .collect();
    drawn.sort_by(f64::total_cmp);
    let quantile = |share: f64| {
        let place = (share * drawn.len() as f64) as usize;
        drawn.get(place.min(drawn.len().saturating_sub(1))).copied()
    };
    Ok(Explained {
        train: judged.explained,
        validate,
        validate_interval: quantile(0.025)
            .zip(quantile(0.975))
            .filter(|_| validate.is_some())
            .map(|(low, high)| [low, high]),
    })
}

/// Number of samples and sum of squared errors, block by block.
fn blocks(
    model: &dyn ForwardModel,
    validated: &Validated,
    recording: &Recording,
) -> Result<Vec<(f64, f64)>, IdentifyError> {
    let shown = predict(model, &validated.point, recording)?;
    let squares: Vec<f64> = recording
        .output()
        .iter()
        .zip(&shown.output)
        .map(|(recorded, shown)| (recorded - shown).powi(2))
        .collect();
    let length = squares.len().div_ceil(BLOCKS);
    Ok(squares
        .chunks(length)
        .map(|block| (block.len() as f64, block.iter().sum()))
        .collect())
}
