//! Facts that the judge needs beside the population.

use identify::IdentifyError;
use recording::Recording;

use crate::CandidateSet;
use crate::config::DiagnoseConfig;
use crate::decide::{Known, OF_THERMOMETER, Oddness};
use crate::evidence::{Block, Population, disturbed};
use crate::model::case::{Case, Node};
use crate::model::series::Channel;
use crate::noise::floor::Measured;
use crate::noise::of_drive::of_drive;
use crate::noise::slip::slip;
use crate::noise::slowness::slowness;
use crate::noise::tone::tone;
use crate::search::roads::Search;

/// Facts that the judge needs beside the population. The leading model is that of the search with these effects; `training` has all
/// samples of its recordings, and `noise` is that of those on which it was searched.
pub(crate) fn known(
    (search, effects): (&Search<'_>, CandidateSet),
    population: &Population,
    (training, noise): (&[Recording], &Measured),
    blocks: &[Block],
    config: &DiagnoseConfig,
) -> Result<Known, IdentifyError> {
    let case = search.case;
    let Some(node) = search.get(effects) else {
        unreachable!("the leading model was visited");
    };
    let rounding = noise.rounding.map_or(0.0, |rounding| rounding.powi(2));
    let plain = search.baseline();
    let points = plain.points.iter().map(Vec::as_slice);
    let of_drive = of_drive(&plain.model, training.iter().zip(points), config.seed)?;
    let disturbed = if plain.mean_square() > 2.0 * rounding.max(of_drive) {
        let sensitivities = search.sensitivities(plain)?;
        let evidence = &population.plain().evidence;
        disturbed(case, plain, evidence, &sensitivities, blocks, config.seed)?
    } else {
        // All of it may be rounding, which is a function of the output, or an error of the drive.
        0.0
    };
    // A tone may be faster than the samples on which models are judged.
    let whole = case.whole(training);
    let heard = |node: &Node| match &whole {
        None => Ok(loudest(case, node)),
        Some(whole) => Ok::<f64, IdentifyError>(loudest(whole, &whole.stands(node)?)),
    };
    let oddness = |node: &Node| {
        let is_of_drive = of_drive > 0.0 && node.mean_square() < of_drive + noise.gate;
        if is_of_drive || noise.is_coarse(node.mean_square()) {
            return Ok::<Oddness, IdentifyError>(Oddness::default());
        }
        let own = |channel| {
            let segments = case.layout.of_channel(channel);
            segments.map(|one| &node.residual[one.range.clone()])
        };
        let of_thermometer = match is_off(case, node) {
            true => slowness(own(Channel::Temperature), 0.0),
            false => 0.0,
        };
        Ok(Oddness {
            tone: heard(node)?,
            slowness: slowness(own(Channel::Output), rounding.sqrt()).max(of_thermometer),
        })
    };
    let all = CandidateSet::all(config.catalogue, config.setting.hypotheses);
    Ok(Known {
        segments: case
            .layout
            .segments
            .iter()
            .map(|one| one.range.clone())
            .collect(),
        output_squares: case.output_squares(),
        temperature_squares: case.recorded_squares(Channel::Temperature),
        rounding,
        of_drive,
        catalogue: all,
        untried: all
            .iter()
            .filter(|&one| case.missing(one).is_some())
            .collect(),
        disturbed,
        left: oddness(node)?,
        left_by_plain: oddness(plain)?,
        slip: slip(case, node)?,
        elsewhere: Vec::new(),
        seed: config.seed,
    })
}

/// The loudest tone in what a model leaves of the outputs.
fn loudest(case: &Case<'_>, node: &Node) -> f64 {
    let segments = case.layout.of_channel(Channel::Output);
    let residuals = segments.map(|one| &node.residual[one.range.clone()]);
    residuals.map(tone).fold(0.0, f64::max)
}

/// True if a model misses the recorded temperatures by more than the error of a thermometer.
fn is_off(case: &Case<'_>, node: &Node) -> bool {
    let noise = node.noise.of(Channel::Temperature);
    let left = noise.variance * noise.n_samples as f64;
    left > OF_THERMOMETER.powi(2) * case.recorded_squares(Channel::Temperature)
}
