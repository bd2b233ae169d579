//! Zero is the baseline by arithmetic: every effect active, none with a size.

use crate::support;

use sma_effects::{EffectId, EffectSet, EffectValues, ExtendedPlant, Setting};
use support::{AMBIENT_DEGC, DRIVES, current_a, drive_of, fleet, params, setting, trace, various};
use wiener::hysteresis::Rule;
use wiener::{Drive, Ensemble, Input, Plant, Profile, Wiener, WienerParams};

fn every_set() -> Vec<EffectSet> {
    let mut sets: Vec<EffectSet> = EffectId::ALL.into_iter().map(EffectSet::of).collect();
    sets.extend([EffectSet::EMPTY, EffectSet::all()]);
    sets
}

/// Bits that the baseline shows for the same members.
fn baseline(
    setting: &Setting,
    members: &[sma_effects::Member],
    profile: &Profile<'_>,
) -> Vec<Vec<u64>> {
    let members: Vec<wiener::Member> = members
        .iter()
        .map(|member| wiener::Member {
            params: member.params,
            start: member.start,
        })
        .collect();
    let mut traces = vec![Vec::new(); members.len()];
    let ensemble = Ensemble {
        drive: setting.drive,
        rule: setting.rule,
    };
    ensemble
        .run(&members, profile, &mut |block| {
            for (shown, degc) in block
                .displacement
                .chunks(block.stride)
                .zip(block.temperature_degc.chunks(block.stride))
            {
                for column in 0..block.members {
                    traces[block.first_member + column].push(shown[column].to_bits());
                    traces[block.first_member + column].push(degc[column].to_bits());
                }
            }
        })
        .unwrap();
    traces
}

#[test]
fn zero_is_the_baseline_bit_for_bit() {
    let current_a = current_a(0.2);
    let profile = Profile::uniform(&current_a, 0.2, AMBIENT_DEGC).unwrap();
    for active in every_set() {
        // 1, 8 and 32 lanes.
        for count in [1, 5, 32] {
            let members = various(count, EffectValues::default());
            let setting = setting(active);
            assert_eq!(
                fleet(&setting, &members, &profile),
                baseline(&setting, &members, &profile),
                "{active:?} {count}"
            );
        }
    }
}

#[test]
fn zero_is_the_baseline_for_every_drive_rule_and_scale_of_the_fraction() {
    for drive in DRIVES {
        for (rule, lead_share) in [
            (Rule::LastReversal, 0.0),
            (Rule::Nested, 0.0),
            (Rule::Nested, 0.37),
        ] {
            let samples = drive_of(drive, &current_a(0.3));
            let profile = Profile::uniform(&samples, 0.3, AMBIENT_DEGC).unwrap();
            let setting = Setting {
                drive,
                rule,
                lead_share,
                ..setting(EffectSet::all())
            };
            let mut members = various(9, EffectValues::default());
            for member in &mut members {
                member.params.limiting_loop.fraction_swing = -0.5;
                member.params.gain = -3.0;
            }
            assert_eq!(
                fleet(&setting, &members, &profile),
                baseline(&setting, &members, &profile),
                "{drive:?} {rule:?}"
            );
        }
    }
}

#[test]
fn zero_is_the_baseline_at_samples_of_any_length_and_none() {
    let model = Wiener::new(Drive::Current, Rule::LastReversal, &[params()]).unwrap();
    let setting = setting(EffectSet::all());
    let plant = ExtendedPlant::new(&setting, &params(), &EffectValues::default()).unwrap();
    let mut expected = model.rest(AMBIENT_DEGC);
    let mut state = plant.rest(AMBIENT_DEGC);
    for (k, &drive) in current_a(0.1).iter().enumerate() {
        assert_eq!(plant.output(&state), model.output(&expected), "{k}");
        let input = Input {
            drive: [drive],
            ambient_degc: AMBIENT_DEGC + 1e-3 * k as f64,
        };
        let dt_s = [0.1, 0.0, 0.07, 0.13, 0.1, 2.0][k % 6];
        model.step(&mut expected, &input, dt_s);
        plant.step(&mut state, &input, dt_s);
    }
}

#[test]
fn partners_do_nothing_without_a_size() {
    let current_a = current_a(0.2);
    let mut values = EffectValues::default();
    let expected = trace(
        &setting(EffectSet::EMPTY),
        &params(),
        &values,
        &current_a,
        0.2,
    );
    for effect in EffectId::ALL {
        for (index, parameter) in effect.info().parameters.iter().enumerate() {
            if matches!(parameter.role, sma_effects::Role::Partner { .. }) {
                *values.slot(effect, index).unwrap() = parameter.bounds[1];
            }
        }
    }
    let shown = trace(
        &setting(EffectSet::all()),
        &params(),
        &values,
        &current_a,
        0.2,
    );
    assert_eq!(shown.displacement, expected.displacement);
    assert_eq!(shown.temperature_degc, expected.temperature_degc);
}

#[test]
fn sub_steps_are_those_of_the_baseline() {
    let current_a = current_a(0.2);
    let sets = [EffectSet::EMPTY, EffectSet::all()];
    let [none, all] = sets.map(|active| {
        let setting = Setting {
            sub_steps: 3,
            ..setting(active)
        };
        trace(
            &setting,
            &params(),
            &EffectValues::default(),
            &current_a,
            0.2,
        )
    });
    assert_eq!(none.displacement, all.displacement);
    assert_eq!(none.temperature_degc, all.temperature_degc);
}

#[test]
fn no_gain_is_no_number_out_of_range() {
    let flat = WienerParams {
        gain: 0.0,
        ..params()
    };
    let mut all = EffectValues::default();
    for effect in EffectId::ALL {
        for index in 0..effect.info().parameters.len() {
            *all.slot(effect, index).unwrap() = EffectValues::typical(effect, 1.0)
                .get(effect, index)
                .unwrap();
        }
    }
    let shown = trace(
        &setting(EffectSet::all()),
        &flat,
        &all,
        &current_a(0.2),
        0.2,
    );
    assert!(shown.displacement.iter().all(|shown| shown.is_finite()));
}
