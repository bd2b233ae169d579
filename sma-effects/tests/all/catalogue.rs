//! The catalogue is complete, and says of each effect what a report needs.

use std::collections::BTreeSet;

use sma_effects::{EffectBlock, EffectId, EffectSet, EffectValues, Role, Sign};

#[test]
fn the_ids_are_those_of_the_design() {
    let designed: BTreeSet<&str> =
        "dead-time supply-limit supply-lag latent-heat radiation natural-convection \
        phase-dependent-resistance ambient-drift end-conduction stress-coupling loop-asymmetry \
        loop-shape r-phase functional-fatigue return-point-memory output-lag backlash end-stop \
        sensor-nonlinearity sensor-drift thermal-expansion thermocouple-lag"
            .split_whitespace()
            .collect();
    let ids: BTreeSet<&str> = EffectId::ALL.into_iter().map(EffectId::id).collect();
    assert_eq!(designed.len(), 22);
    assert_eq!(ids, designed);
    assert_eq!(EffectId::ALL.len(), 22);
}

#[test]
fn flexible_are_the_shape_and_the_drifts() {
    let flexible: Vec<&str> = EffectId::ALL
        .into_iter()
        .filter(|effect| effect.info().flexible)
        .map(EffectId::id)
        .collect();
    assert_eq!(flexible, ["ambient-drift", "loop-shape", "sensor-drift"]);
}

#[test]
fn parameters_are_consistent() {
    let mut names = BTreeSet::new();
    for effect in EffectId::ALL {
        let info = effect.info();
        let mut sizes = 0;
        let mut seen_partner = false;
        for (index, parameter) in info.parameters.iter().enumerate() {
            let name = parameter.name;
            assert!(names.insert(name), "{name} twice");
            assert!(parameter.accepts(parameter.typical), "{name}");
            assert!(parameter.accepts(parameter.neutral()), "{name}");
            assert!(!parameter.accepts(f64::NAN), "{name}");
            assert!(!parameter.unit.is_empty(), "{name}");
            let [lower, upper] = parameter.bounds;
            assert!(lower < upper);
            match parameter.role {
                Role::Size => {
                    assert!(!seen_partner, "{name}: sizes come first");
                    sizes += 1;
                    assert!(parameter.neutral().abs() <= 0.0);
                    match parameter.sign() {
                        Sign::NonNegative => assert!(lower.abs() <= 0.0, "{name}"),
                        Sign::Either => assert!((lower + upper).abs() <= 0.0, "{name}"),
                    }
                }
                Role::Partner { grid } => {
                    let tried = if seen_partner { 0..=0 } else { 5..=9 };
                    assert!(tried.contains(&grid.len()), "{name}");
                    seen_partner = !parameter.needs_thermometer;
                    assert!(grid.iter().all(|&value| parameter.accepts(value)), "{name}");
                    assert!(grid.is_sorted(), "{name}");
                }
            }
            if let Some(literature) = parameter.literature {
                assert!(literature.range[0] <= literature.range[1], "{name}");
                assert!(!literature.source.is_empty(), "{name}");
            }
            let neutral = EffectValues::default().get(effect, index);
            assert_eq!(neutral, Some(parameter.neutral()), "{name}");
        }
        assert!(sizes > 0, "{effect}");
        assert!(info.sentence.contains("{value}"), "{effect}");
        // The bead of a thermocouple: what cools it is in the table, and seldom told.
        assert_eq!(
            info.sentence.contains("{partner}"),
            seen_partner && effect != EffectId::ThermocoupleLag,
            "{effect}"
        );
        assert_eq!(
            EffectValues::default().get(effect, info.parameters.len()),
            None
        );
        assert_eq!(
            info.block == EffectBlock::Sensor,
            effect == EffectId::ThermocoupleLag
        );
    }
}

#[test]
fn blocks_have_names() {
    let names: Vec<&str> = [
        EffectBlock::Drive,
        EffectBlock::HeatBalance,
        EffectBlock::Transformation,
        EffectBlock::Displacement,
        EffectBlock::Sensor,
    ]
    .map(EffectBlock::id)
    .to_vec();
    assert_eq!(
        names,
        [
            "drive",
            "heat-balance",
            "transformation",
            "displacement",
            "sensor"
        ]
    );
}

#[test]
fn sets_hold_what_was_put_in() {
    let pair: EffectSet = [EffectId::Backlash, EffectId::LatentHeat]
        .into_iter()
        .collect();
    assert!(pair.contains(EffectId::Backlash) && !pair.contains(EffectId::Radiation));
    assert_eq!(
        pair.iter().map(EffectId::id).collect::<Vec<_>>(),
        ["latent-heat", "backlash"]
    );
    assert!(pair.meets(EffectSet::of(EffectId::Backlash)));
    assert!(!pair.meets(EffectSet::of(EffectId::Radiation)));
    assert!(EffectSet::EMPTY.is_empty() && !pair.is_empty());
    assert_eq!(EffectSet::all().iter().count(), 22);
    assert_eq!(
        EffectSet::EMPTY.with(EffectId::EndStop),
        EffectSet::of(EffectId::EndStop)
    );
}
