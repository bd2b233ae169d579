//! Lanes do not see each other, and a state can be kept.

use crate::support;

use proptest::prelude::*;
use sma_effects::{EffectId, EffectSet, EffectValues, ExtendedPlant, Member};
use support::{AMBIENT_DEGC, all_typical, current_a, fleet, params, setting, various};
use wiener::{Input, Plant, Profile};

/// Sizes that differ from lane to lane, within their bounds.
fn scattered(members: &mut [Member]) {
    for (k, member) in members.iter_mut().enumerate() {
        for effect in EffectId::ALL {
            for (index, parameter) in effect.info().parameters.iter().enumerate() {
                let slot = member.effects.slot(effect, index).unwrap();
                let scaled = *slot * (0.2 + 0.05 * (k % 17) as f64);
                *slot = scaled.clamp(parameter.bounds[0], parameter.bounds[1]);
            }
        }
    }
}

#[test]
fn lanes_have_the_bits_of_one_plant_alone() {
    let current_a = current_a(0.2);
    let profile = Profile::uniform(&current_a, 0.2, AMBIENT_DEGC).unwrap();
    let setting = setting(EffectSet::all());
    let mut members = various(33, all_typical());
    scattered(&mut members);
    let alone: Vec<Vec<u64>> = members
        .iter()
        .map(|member| fleet(&setting, &[*member], &profile).remove(0))
        .collect();
    for count in [5, 9, 33] {
        let together = fleet(&setting, &members[..count], &profile);
        assert_eq!(together, alone[..count], "{count}");
    }
}

#[test]
fn each_effect_gives_lanes_the_bits_of_one_plant_alone() {
    let current_a = current_a(0.3);
    let profile = Profile::uniform(&current_a, 0.3, AMBIENT_DEGC).unwrap();
    for effect in EffectId::ALL {
        let members = various(8, EffectValues::typical(effect, 1.0));
        let setting = setting(EffectSet::of(effect));
        let together = fleet(&setting, &members, &profile);
        for (member, expected) in members.iter().zip(&together) {
            let alone = fleet(&setting, &[*member], &profile);
            assert_eq!(&alone[0], expected, "{effect}");
        }
    }
}

/// The power of one changes within a sample where that of another does not.
#[test]
fn lanes_that_turn_within_a_sample_leave_the_bits_of_those_that_do_not() {
    let current_a = current_a(0.2);
    let profile = Profile::uniform(&current_a[..300], 0.2, AMBIENT_DEGC).unwrap();
    for late in [EffectId::DeadTime, EffectId::SupplyLag] {
        for effect in EffectId::ALL {
            let setting = setting(EffectSet::of(effect).with(late));
            let mut members = various(6, EffectValues::typical(effect, 1.0));
            for (k, member) in members.iter_mut().enumerate() {
                let size = 0.13 * (k % 3) as f64;
                *member.effects.slot(late, 0).unwrap() = size;
            }
            let together = fleet(&setting, &members, &profile);
            for (member, expected) in members.iter().zip(&together) {
                let alone = fleet(&setting, &[*member], &profile);
                assert!(&alone[0] == expected, "{late} {effect}");
            }
        }
    }
}

#[test]
fn a_state_can_be_kept_and_resumed() {
    let setting = setting(EffectSet::all());
    let plant = ExtendedPlant::new(&setting, &params(), &all_typical()).unwrap();
    let mut state = plant.rest(AMBIENT_DEGC);
    let step = |state: &mut _, current: f64| {
        let input = Input {
            drive: [current],
            ambient_degc: AMBIENT_DEGC,
        };
        plant.step(state, &input, 0.2);
    };
    let current_a = current_a(0.2);
    let (first, second) = current_a.split_at(200);
    first.iter().for_each(|&i| step(&mut state, i));
    let mut kept = state.clone();
    second.iter().for_each(|&i| step(&mut state, i));
    second.iter().for_each(|&i| step(&mut kept, i));
    assert_eq!(kept, state);
}

/// Runs the effects of `bits`, each parameter at its place between its bounds.
fn stays_finite(bits: u32, places: &[f64], dt_s: f64) {
    let active: EffectSet = EffectId::ALL
        .into_iter()
        .enumerate()
        .filter(|(k, _)| bits >> k & 1 == 1)
        .map(|(_, effect)| effect)
        .collect();
    let mut values = EffectValues::default();
    let mut place = places.iter();
    for effect in active.iter() {
        for (index, parameter) in effect.info().parameters.iter().enumerate() {
            let [lower, upper] = parameter.bounds;
            *values.slot(effect, index).unwrap() = lower + place.next().unwrap() * (upper - lower);
        }
    }
    let plant = ExtendedPlant::new(&setting(active), &params(), &values).unwrap();
    let mut state = plant.rest(AMBIENT_DEGC);
    for current in current_a(0.5) {
        let input = Input {
            drive: [current],
            ambient_degc: AMBIENT_DEGC,
        };
        plant.step(&mut state, &input, dt_s);
        let shown = plant.output(&state);
        assert!(shown.displacement[0].is_finite());
        let degc = shown.temperature_degc[0];
        assert!((-50.0..400.0).contains(&degc), "{degc}");
        assert!((0.0..=1.0).contains(&state.fraction()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    /// Any combination within bounds stays finite, and the fraction within the loop.
    #[test]
    fn whatever_is_accepted_stays_finite(
        bits in 0u32..1 << 21,
        places in proptest::collection::vec(prop_oneof![Just(0.0), Just(1.0), 0.0..=1.0f64], 64),
        dt_s in 0.02..1.0f64,
    ) {
        stays_finite(bits, &places, dt_s);
    }
}
