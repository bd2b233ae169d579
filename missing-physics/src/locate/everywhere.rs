//! Where a model and its recordings part: in which regimes, when, how fast, and in which block.

use identify::IdentifyError;

use crate::EffectBlock;
use crate::locate::bands::bands;
use crate::locate::blocks::{Pulled, blocks};
use crate::locate::cells::cells;
use crate::locate::located::Located;
use crate::locate::mismatch::{Mismatch, Shape};
use crate::locate::regimes::regimes;
use crate::locate::remainder::shape;
use crate::locate::spans::spans;
use crate::pullback::scene::Scene;

/// Locates what a model leaves; nothing where that is noise.
pub(crate) fn locate(located: &Located<'_>) -> Result<Mismatch, IdentifyError> {
    let scene = Scene::of(located.case, located.node, located.sensitivities)?;
    let blocks = blocks(&Pulled::of(located, &scene));
    let found = Mismatch {
        block: blocks.first().copied(),
        blocks,
        ..Mismatch::default()
    };
    if !located.is_clear() {
        return Ok(found);
    }
    Ok(Mismatch {
        cells: cells(located, &regimes(located.case, &scene)),
        spans: spans(located, &scene),
        bands: bands(located, &scene),
        ..found
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
    use crate::model::synthetic::{NOISE_MM, Synthetic};
    use crate::model::tangent::sensitivities;
    use crate::noise::whiten::Whitener;
    use crate::{EffectId, EffectSet, EffectValues};

    fn rig(effect: EffectId, multiple: f64) -> Synthetic {
        let values = EffectValues::typical(effect, multiple);
        Synthetic::of(EffectSet::of(effect), values, 3)
    }

    /// Result of `find` at the baseline of a rig.
    fn at_baseline<T>(rig: &Synthetic, find: impl FnOnce(&Located<'_>) -> T) -> T {
        let case = rig.case();
        let node = case.baseline().unwrap();
        let sensitivities = sensitivities(&case, &node).unwrap();
        let whitener = Whitener::new(&case.layout, &node.noise);
        find(&Located {
            case: &case,
            node: &node,
            sensitivities: &sensitivities,
            whitener: &whitener,
            floor: NOISE_MM,
            seed: 1,
        })
    }

    fn mismatch(rig: &Synthetic) -> Mismatch {
        at_baseline(rig, |located| locate(located).unwrap())
    }

    #[test]
    fn effects_are_found_in_their_blocks() {
        for (effect, multiple, least) in [
            (EffectId::LatentHeat, 1.0, 0.95),
            (EffectId::LatentHeat, 0.3, 0.95),
            (EffectId::NaturalConvection, 0.3, 0.95),
            (EffectId::Radiation, 1.0, 0.95),
            (EffectId::Backlash, 1.0, 0.95),
            (EffectId::Backlash, 0.3, 0.95),
            (EffectId::EndStop, 1.0, 0.95),
            (EffectId::EndStop, 0.3, 0.7),
            (EffectId::ThermalExpansion, 1.0, 0.95),
            (EffectId::FunctionalFatigue, 1.0, 0.5),
            (EffectId::SupplyLag, 1.0, 0.7),
        ] {
            let (block, probability) = mismatch(&rig(effect, multiple)).block.unwrap();
            assert_eq!(block, effect.info().block, "{effect:?} {multiple}");
            assert!(probability > least, "{effect:?} {multiple} {probability}");
        }
    }

    #[test]
    fn late_drives_and_late_sensors_are_not_told_apart() {
        let blocks = mismatch(&rig(EffectId::OutputLag, 1.0)).blocks;
        for (block, probability) in &blocks[..2] {
            assert!(matches!(
                block,
                EffectBlock::Drive | EffectBlock::Displacement
            ));
            assert!((0.3..0.7).contains(probability), "{blocks:?}");
        }
    }

    #[test]
    fn clean_recordings_have_no_cells_and_no_block() {
        let found: Vec<Mismatch> = (0..20)
            .map(|seed| {
                mismatch(&Synthetic::of(
                    EffectSet::EMPTY,
                    EffectValues::default(),
                    seed,
                ))
            })
            .collect();
        let clean = found.iter().filter(|found| found.cells.is_empty());
        assert!(clean.count() >= 18);
        let nowhere = found.iter().filter(|found| found.block.is_none());
        assert!(nowhere.count() >= 18);
    }

    #[test]
    fn cells_hold_more_than_their_share() {
        let found = mismatch(&rig(EffectId::LatentHeat, 1.0));
        assert!((1..=6).contains(&found.cells.len()));
        for cell in &found.cells {
            assert!(
                cell.share > cell.occupancy && cell.p_value <= 0.05,
                "{cell:?}"
            );
        }
        // A thermal effect does not show where nothing transforms.
        assert!(
            found
                .cells
                .iter()
                .all(|cell| !cell.at.starts_with("at rest"))
        );
        assert!((1..=5).contains(&found.spans.len()));
        assert!(found.spans.iter().all(|span| span.start_s < span.end_s));
        let covered: f64 = found.spans.iter().map(|span| span.share).sum();
        assert!((0.5..1.2).contains(&covered), "{covered}");
        let shares: f64 = found.bands.iter().map(|band| band.share).sum();
        assert!((shares - 1.0).abs() < 1e-9);
        // Slower than the rod.
        let slow: f64 = found.bands[..3].iter().map(|band| band.share).sum();
        assert!(slow > 0.9, "{slow}");
    }

    #[test]
    fn a_recording_in_which_something_slips_is_found_at_the_right_time() {
        let mut rig = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 5);
        rig.shift(1, 100.0..112.0, 0.1);
        let spans = mismatch(&rig).spans;
        assert_eq!(spans[0].recording, "steps");
        let off_s = [spans[0].start_s - 100.0, spans[0].end_s - 112.0];
        assert!(off_s.iter().all(|off_s| off_s.abs() < 1.0), "{spans:?}");
        assert!(spans[0].share > 0.6, "{spans:?}");
    }

    #[test]
    fn backlash_is_a_step_between_the_branches() {
        let shape = at_baseline(&rig(EffectId::Backlash, 0.3), |located| {
            remainder_shape(located, EffectBlock::Displacement).unwrap()
        });
        let shape = shape.unwrap();
        assert_eq!(shape.value, "displacement, mm");
        assert!((0.3..1.0).contains(&shape.share), "{}", shape.share);
        let [heating, cooling] = &shape.curves[..] else {
            panic!("two branches");
        };
        assert!(heating.heating && !cooling.heating);
        for (up, down) in heating.points.iter().zip(&cooling.points) {
            assert!(up[1] < 0.0 && down[1] > 0.0, "{shape:?}");
        }
        // In the middle the step is beyond doubt.
        let (up, down) = (heating.points[2], cooling.points[2]);
        assert!(up[1] + up[2] < 0.0 && down[1] - down[2] > 0.0, "{shape:?}");
    }

    #[test]
    fn noise_has_no_shape() {
        let rig = Synthetic::of(EffectSet::EMPTY, EffectValues::default(), 7);
        at_baseline(&rig, |located| {
            for block in crate::locate::blocks::BLOCKS {
                assert_eq!(remainder_shape(located, block).unwrap(), None);
            }
        });
    }

    #[test]
    fn same_seed_same_result() {
        let rig = rig(EffectId::EndStop, 0.3);
        assert_eq!(mismatch(&rig), mismatch(&rig));
    }
}
