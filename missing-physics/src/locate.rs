//! Where a model and its recordings part: in which regimes, when, how fast, and in which block.

use identify::IdentifyError;

use crate::bands::bands;
use crate::blocks::{Pulled, blocks};
use crate::case::{Case, Node};
use crate::cells::cells;
use crate::regimes::regimes;
use crate::remainder::shape;
use crate::scene::Scene;
use crate::spans::spans;
use crate::tangent::Sensitivity;
use crate::whiten::Whitener;
use crate::{EffectBlock, Mismatch, Shape};

/// Standard errors of the noise's mean square by which that of the residual must exceed it.
const CLEAR: f64 = 2.0;

/// A model whose residual is to be located.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Located<'a> {
    pub(crate) case: &'a Case<'a>,
    pub(crate) node: &'a Node,
    pub(crate) sensitivities: &'a [Sensitivity],
    pub(crate) whitener: &'a Whitener,
    /// Standard deviation of the noise of the output.
    pub(crate) floor: f64,
    /// Seed of the surrogates.
    pub(crate) seed: u64,
}

impl<'a> Located<'a> {
    /// Columns that the model's free parameters can follow.
    pub(crate) fn fitted(&self) -> Vec<&'a Vec<f64>> {
        let free = self.sensitivities.iter().filter(|one| !one.held);
        free.map(|one| &one.column).collect()
    }

    /// Sum of the squares of the output's residual beyond the noise that a fit leaves.
    pub(crate) fn explainable(&self) -> f64 {
        let n_outputs = self.case.layout.n_outputs() as f64;
        let left = n_outputs - self.node.n_free() as f64;
        n_outputs * self.node.mean_square() - left.max(0.0) * self.floor.powi(2)
    }

    /// Whether there is anything to explain.
    fn is_clear(&self) -> bool {
        let n_outputs = self.case.layout.n_outputs() as f64;
        let n_effective = self.node.noise.output.n_effective.max(1.0);
        let error = n_outputs * self.floor.powi(2) * (2.0 / n_effective).sqrt();
        self.explainable() > CLEAR * error
    }
}

/// Locates what a model leaves; nothing where that is noise.
pub(crate) fn locate(located: &Located<'_>) -> Result<Mismatch, IdentifyError> {
    if !located.is_clear() {
        return Ok(Mismatch::default());
    }
    let scene = Scene::of(located.case, located.node, located.sensitivities)?;
    let pulled = Pulled::of(located, &scene);
    let blocks = blocks(&pulled);
    Ok(Mismatch {
        block: blocks.first().copied(),
        blocks,
        cells: cells(located, &regimes(located.case, &scene)),
        spans: spans(located, &scene),
        bands: bands(located, &scene),
    })
}

/// The residual as a curve in a block; `None` where it is noise, or no curve describes it.
pub(crate) fn remainder_shape(
    located: &Located<'_>,
    block: EffectBlock,
) -> Result<Option<Shape>, IdentifyError> {
    if !located.is_clear() {
        return Ok(None);
    }
    let scene = Scene::of(located.case, located.node, located.sensitivities)?;
    Ok(shape(located, &Pulled::of(located, &scene), block))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::screening::sift;
    use crate::synthetic::{NOISE_MM, Synthetic};
    use crate::tangent::sensitivities;
    use crate::{EffectId, EffectSet, EffectValues};

    fn located<T>(rig: &Synthetic, use_it: impl FnOnce(&Located<'_>) -> T) -> T {
        let case = rig.case();
        let node = case.baseline().unwrap();
        let sensitivities = sensitivities(&case, &node).unwrap();
        let whitener = Whitener::new(&case.layout, &node.noise);
        use_it(&Located {
            case: &case,
            node: &node,
            sensitivities: &sensitivities,
            whitener: &whitener,
            floor: NOISE_MM,
            seed: 1,
        })
    }

    #[test]
    fn survey() {
        let _ = sift;
        for effect in EffectId::ALL {
            for multiple in [1.0, 0.3] {
                let t = std::time::Instant::now();
                let rig = Synthetic::of(EffectSet::of(effect), EffectValues::typical(effect, multiple), 3);
                let fit_s = t.elapsed().as_secs_f64();
                located(&rig, |l| {
                    let t = std::time::Instant::now();
                    let m = locate(l).unwrap();
                    let s = t.elapsed().as_secs_f64();
                    println!("## {effect:?} x{multiple} [{:?}] rmse {:.4} fit {fit_s:.2} loc {s:.2} phi {:?}", effect.info().block, rig.fit.train_rmse, l.node.noise.output.coefficients.len());
                    println!("   {:?}", m.blocks.iter().map(|(b, p)| format!("{} {p:.3}", b.id())).collect::<Vec<_>>());
                    for c in m.cells.iter().take(3) { println!("   {} {:.2} of {:.2} p {:.3}", c.at, c.share, c.occupancy, c.p_value); }
                    println!("   spans {:?}", m.spans.iter().map(|s| format!("{} {:.0}-{:.0} {:.2}", s.recording, s.start_s, s.end_s, s.share)).collect::<Vec<_>>());
                    println!("   bands {:?}", m.bands.iter().map(|b| format!("{:.3}: {:.2}", b.hz[0], b.share)).collect::<Vec<_>>());
                });
            }
        }
    }
}
