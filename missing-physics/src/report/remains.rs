//! Where models and recordings part, and what is left.

use identify::IdentifyError;
use recording::order::falling;

use crate::decide::Named;
use crate::locate::everywhere::{locate, remainder_shape};
use crate::locate::located::Located;
use crate::locate::mismatch::Mismatch;
use crate::noise::whiten::Whitener;
use crate::report::diagnosis::Remainder;
use crate::search::roads::Search;
use crate::{CandidateSet, EffectBlock, LoopFamily};

/// A look at what a model that was visited leaves; `at` holds the noise's standard deviation and the seed.
pub(crate) fn located<T>(
    search: &mut Search<'_>,
    effects: CandidateSet,
    at: (f64, u64),
    look: impl FnOnce(&Located<'_>) -> Result<T, IdentifyError>,
) -> Result<T, IdentifyError> {
    let sifted = search.sifted(effects)?;
    let Some(node) = search.get(effects) else {
        unreachable!("its scores were just taken");
    };
    let (floor, seed) = at;
    look(&Located {
        case: search.case,
        node,
        sensitivities: &sifted.sensitivities,
        whitener: &Whitener::new(&search.case.layout, &node.noise),
        floor,
        seed,
    })
}

/// Blocks of what was found, with the probabilities of the names: what an effect can do is known better than
/// where a residual sits.
pub(crate) fn blocks_of(named: &[Named]) -> Vec<(EffectBlock, f64)> {
    let all: f64 = named.iter().map(|named| named.contribution.max(0.0)).sum();
    let mut blocks: Vec<(EffectBlock, f64)> = Vec::new();
    for named in named {
        let weight = if all > 0.0 {
            named.contribution.max(0.0) / all
        } else {
            0.0
        };
        let others = named.others.iter().copied();
        for (effect, probability) in others.chain([(named.effect, named.probability)]) {
            let block = effect.info().block;
            match blocks.iter_mut().find(|(known, _)| *known == block) {
                Some((_, sum)) => *sum += weight * probability,
                None => blocks.push((block, weight * probability)),
            }
        }
    }
    falling(&mut blocks, |block| block.1);
    blocks
}

/// Residual error after the chosen model: `left` is the remaining part of `explainable`, both mean squares on blocks
/// that were left out.
pub(crate) fn remainder(
    search: &mut Search<'_>,
    effects: CandidateSet,
    plain: &Mismatch,
    [explainable, left]: [f64; 2],
    at: (f64, u64),
) -> Result<Option<Remainder>, IdentifyError> {
    let family = search.case.setting.loop_family;
    let mismatch = if effects.is_empty() && family == LoopFamily::Proximity {
        plain.clone()
    } else {
        located(search, effects, at, locate)?
    };
    let shape = match mismatch.block {
        Some((block, _)) => located(search, effects, at, |located| {
            remainder_shape(located, block)
        })?,
        None => None,
    };
    Ok((left > 0.0 && explainable > 0.0).then(|| Remainder {
        rms: left.sqrt(),
        share: left / explainable,
        mismatch,
        shape,
    }))
}
