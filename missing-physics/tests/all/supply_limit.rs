//! A supply that gives no more than a certain current, whatever it is asked.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it makes its data"
)]

use crate::common;

use common::{DT_S, current_a, diagnosed_under, found, noisy, params, played, setting};
use missing_physics::{EffectId, EffectValues, Extended, Status, Verdict};

/// Where the supply is at its end, A; the drives go to 2.3 A.
const LIMIT_A: f64 = 1.9;

#[test]
fn a_limit_of_the_supply_is_found_with_its_place() {
    let given: Vec<f64> = current_a().iter().map(|asked| asked.min(LIMIT_A)).collect();
    let plain = Extended { setting: setting() };
    let output = played(&plain, params(), EffectValues::default(), &given, DT_S);
    let diagnosis = diagnosed_under(current_a(), noisy(output), &[]);
    assert_eq!(
        found(&diagnosis),
        ["supply-limit"],
        "{:?}",
        diagnosis.suspects
    );
    assert_eq!(diagnosis.verdict, Verdict::Explained);
    let finding = &diagnosis.findings[0];
    let [share, position] = &finding.parameters[..] else {
        panic!("{finding:?}");
    };
    assert!((share.value - 1.0).abs() < 0.05, "{share:?}");
    assert!(
        (position.value / (LIMIT_A / 2.3) - 1.0).abs() < 0.01,
        "{position:?}"
    );
    assert!(
        finding
            .sentence
            .starts_with("Limit of the supply is missing: from 8"),
        "{}",
        finding.sentence
    );
}

#[test]
fn at_one_level_a_limit_is_another_resistance() {
    let level_a = |k: usize| {
        if (100..500).contains(&(k % 900)) {
            2.1
        } else {
            0.0
        }
    };
    let asked: Vec<f64> = (0..1800).map(level_a).collect();
    let given: Vec<f64> = asked.iter().map(|asked| asked.min(LIMIT_A)).collect();
    let plain = Extended { setting: setting() };
    let output = played(&plain, params(), EffectValues::default(), &given, DT_S);
    let diagnosis = diagnosed_under(asked, noisy(output), &[]);
    assert_eq!(found(&diagnosis), [""; 0], "{:?}", diagnosis.findings);
    let mut entries = diagnosis.catalogue.iter();
    let limit = entries.find(|entry| entry.effect == EffectId::SupplyLimit);
    assert_eq!(limit.unwrap().status, Status::NotTestable);
}
