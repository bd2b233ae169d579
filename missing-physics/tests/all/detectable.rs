//! Effects that recordings cannot show are reported with the size from which they would show.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it makes its data"
)]

use crate::common;

use common::{diagnosed, noisy, output_mm, setting};
use missing_physics::{Diagnosis, Entry, Status, Verdict};
use sma_effects::{EffectId, EffectSet, EffectValues, Setting};

/// Diagnosis of the wire with an effect at so many times its typical size.
fn with(effect: EffectId, multiple: f64) -> Diagnosis {
    let setting = Setting {
        active: EffectSet::of(effect),
        ..setting()
    };
    let truth = EffectValues::typical(effect, multiple);
    diagnosed(noisy(output_mm(setting, truth)), &[])
}

fn entry(diagnosis: &Diagnosis, effect: EffectId) -> &Entry {
    let mut entries = diagnosis.catalogue.iter();
    entries.find(|entry| entry.effect == effect).unwrap()
}

#[test]
fn every_effect_that_is_not_there_has_its_size() {
    let clean = diagnosed(noisy(output_mm(setting(), EffectValues::default())), &[]);
    assert_eq!(clean.verdict, Verdict::Adequate);
    for effect in EffectId::ALL {
        let found = entry(&clean, effect);
        let largest = effect.info().parameters[0].bounds.map(f64::abs);
        match found.status {
            // No thermometer, no second load.
            Status::Unknown { .. } => assert_eq!(effect, EffectId::ThermocoupleLag),
            Status::Excluded { upper } => {
                assert!(upper < largest[0].max(largest[1]), "{effect:?} {upper}");
            }
            Status::NotTestable => {
                // None where there is no trace at all: no inner reversal, say.
                let size = found.minimum_detectable.unwrap_or(f64::INFINITY);
                assert!(size > 0.0, "{effect:?} {size}");
            }
            other => panic!("{effect:?} {other:?}"),
        }
    }
}

#[test]
fn nothing_shows_below_an_effects_size_and_something_does_above() {
    let effect = EffectId::LatentHeat;
    let typical = effect.info().parameters[0].typical;
    let clean = with(effect, 0.0);
    let least = entry(&clean, effect).minimum_detectable.unwrap() / typical;
    assert_eq!(with(effect, 0.3 * least).verdict, Verdict::Adequate);
    assert_ne!(with(effect, 2.0 * least).verdict, Verdict::Adequate);
}
