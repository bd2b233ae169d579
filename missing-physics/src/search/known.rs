//! Facts that the judge needs beside the population.

use identify::IdentifyError;

use crate::CandidateSet;
use crate::config::DiagnoseConfig;
use crate::decide::{Known, Oddness};
use crate::evidence::{Block, Population, disturbed};
use crate::model::case::Node;
use crate::model::series::Channel;
use crate::noise::floor::Measured;
use crate::noise::slip::slip;
use crate::noise::slowness::slowness;
use crate::noise::tone::tone;
use crate::search::roads::Search;

/// Facts that the judge needs beside the population. The leading model is that of the search with these effects.
pub(crate) fn known(
    (search, effects): (&Search<'_>, CandidateSet),
    population: &Population,
    noise: &Measured,
    blocks: &[Block],
    config: &DiagnoseConfig,
) -> Result<Known, IdentifyError> {
    let case = search.case;
    let Some(node) = search.get(effects) else {
        unreachable!("the leading model was visited");
    };
    let rounding = noise.rounding.map_or(0.0, |rounding| rounding.powi(2));
    let plain = search.baseline();
    let disturbed = if plain.mean_square() > 2.0 * rounding {
        let sensitivities = search.sensitivities(plain)?;
        let evidence = &population.plain().evidence;
        disturbed(case, plain, evidence, &sensitivities, blocks, config.seed)?
    } else {
        // All of it may be rounding, which is a function of the output.
        0.0
    };
    let oddness = |node: &Node| {
        if noise.is_coarse(node.mean_square()) {
            return Oddness::default();
        }
        let own = || case.layout.of_channel(Channel::Output);
        let residuals = || own().map(|one| &node.residual[one.range.clone()]);
        Oddness {
            tone: residuals().map(tone).fold(0.0, f64::max),
            slowness: slowness(residuals()),
        }
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
        rounding,
        catalogue: all,
        untried: all
            .iter()
            .filter(|&one| case.missing(one).is_some())
            .collect(),
        disturbed,
        left: oddness(node),
        left_by_plain: oddness(plain),
        slip: slip(case, node)?,
        seed: config.seed,
    })
}
