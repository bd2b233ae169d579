//! A supply that gives no more than a certain current, whatever it is asked.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it makes its data"
)]

use crate::common;

use std::ops::ControlFlow;

use common::{current_a, found, noisy, params, played, recording, setting};
use fixtures::wire::ROD;
use identify::WienerModel;
use missing_physics::{DiagnoseConfig, Verdict, diagnose};
use rig_files::rod_file;
use sma_effects::{EffectId, EffectSet, EffectValues, Extended};
use wiener::hysteresis::Rule;

/// Where the supply is at its end, A; the drive goes to 2.3 A.
const LIMIT_A: f64 = 1.9;

/// Slower than the logger of the other tests: what is asked here does not need its samples.
const DT_S: f64 = 0.6;

/// Effects that a limit might be taken for, of each block. The whole catalogue names the same effect, in ten times the time.
const RIVALS: [EffectId; 4] = [
    EffectId::SupplyLimit,
    EffectId::LatentHeat,
    EffectId::NaturalConvection,
    EffectId::EndStop,
];

#[test]
fn a_limit_of_the_supply_is_found_with_its_place() {
    let asked: Vec<f64> = current_a().into_iter().step_by(3).collect();
    let given: Vec<f64> = asked.iter().map(|asked| asked.min(LIMIT_A)).collect();
    // The plain plant, under what the supply gives: the effect has no part in making the data.
    let plain = Extended { setting: setting() };
    let output = noisy(played(
        &plain,
        params(),
        EffectValues::default(),
        &given,
        DT_S,
    ));
    let training = [recording("made-up.csv", asked, output, DT_S)];
    let rod = rod_file::parse("rod.toml", ROD).unwrap();
    let base = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap();
    let config = DiagnoseConfig {
        setting: setting(),
        catalogue: RIVALS.into_iter().collect::<EffectSet>(),
        ..DiagnoseConfig::default()
    };
    let go_on = &mut |_| ControlFlow::Continue(());
    let diagnosis = diagnose(&base, &training, &[], &config, go_on).unwrap();
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
