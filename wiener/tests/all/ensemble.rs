//! The ensemble: the bits of each model alone, whatever the number of models.

use crate::common;

use common::{AMBIENT_DEGC, any_currents, any_params, any_rule, outputs};
use proptest::prelude::*;
use sma_hysteresis::Rule;
use wiener::{Block, Drive, Ensemble, Member, Profile, Start, Wiener, WienerError};

/// Below, at and above the widths of a chunk, and several chunks with a rest.
const SIZES: [usize; 10] = [1, 2, 8, 9, 16, 17, 32, 33, 50, 70];

fn any_members() -> impl Strategy<Value = Vec<Member>> {
    let start = (prop_oneof![Just(AMBIENT_DEGC), 10.0..120.0], 0.0..=1.0);
    let start = prop_oneof![
        Just(Start::rest(AMBIENT_DEGC)),
        start.prop_map(|(temperature_degc, share)| Start {
            since_reversal_k: 0.0,
            temperature_degc,
            share
        })
    ];
    let member = (any_params(), start).prop_map(|(params, start)| Member { params, start });
    prop::collection::vec(member, 70)
}

/// Displacement and temperature of each member at each sample, as bits; asserts that every one is
/// shown once.
fn by_ensemble(
    ensemble: Ensemble,
    members: &[Member],
    profile: &Profile<'_>,
) -> Vec<Vec<[u64; 2]>> {
    let mut traces = vec![Vec::new(); members.len()];
    ensemble
        .run(members, profile, &mut |block: Block<'_>| {
            let rows = block.displacement.chunks(block.stride);
            let temperatures = block.temperature_degc.chunks(block.stride);
            assert_eq!(block.displacement.len(), block.temperature_degc.len());
            for (row, (displacement, temperature_degc)) in rows.zip(temperatures).enumerate() {
                for column in 0..block.members {
                    let trace = &mut traces[block.first_member + column];
                    assert_eq!(trace.len(), block.first_sample + row);
                    let values = [displacement[column], temperature_degc[column]];
                    trace.push(values.map(f64::to_bits));
                }
            }
        })
        .unwrap();
    assert!(traces.iter().all(|trace| trace.len() == profile.len()));
    traces
}

fn alone(ensemble: Ensemble, member: Member, profile: &Profile<'_>) -> Vec<[u64; 2]> {
    let model = Wiener::new(ensemble.drive, ensemble.rule, &[member.params]).unwrap();
    let start =
        model.between_limiting_curves([member.start.temperature_degc], [member.start.share]);
    outputs(&model, start, profile)
        .iter()
        .map(|output| [output.displacement[0], output.temperature_degc[0]].map(f64::to_bits))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn every_member_has_the_bits_of_a_run_alone(
        members in any_members(), rule in any_rule(), currents_a in any_currents(),
        steps_s in prop::collection::vec(prop_oneof![Just(0.25), 0.01..1.0], 200),
        ambient_degc in prop::collection::vec(20.0..30.0, 200),
    ) {
        let mut time_s = vec![0.0];
        for k in 1..currents_a.len() {
            time_s.push(time_s[k - 1] + steps_s[k]);
        }
        let profile = Profile::timed(&currents_a, &time_s, AMBIENT_DEGC)
            .and_then(|profile| profile.with_ambient(&ambient_degc[..currents_a.len()]))
            .unwrap();
        let ensemble = Ensemble { drive: Drive::Current, rule };
        let expected: Vec<_> = members
            .iter()
            .map(|&member| alone(ensemble, member, &profile))
            .collect();
        for size in SIZES {
            let traces = by_ensemble(ensemble, &members[..size], &profile);
            prop_assert!(traces[..] == expected[..size], "{} members", size);
        }
    }
}

#[test]
fn every_drive_gives_the_bits_of_a_run_alone() {
    let values: Vec<f64> = (0..100)
        .map(|k| 0.5 + 0.5 * f64::from(k % 17) / 16.0)
        .collect();
    let profile = Profile::uniform(&values, 0.287, AMBIENT_DEGC).unwrap();
    let (length_m, supply_v) = (0.2, 4.0);
    let member = |k: u32| {
        let mut params = common::params();
        params.heat.resistance_ohm_per_m = 30.0 + f64::from(k);
        Member {
            params,
            start: Start::rest(AMBIENT_DEGC),
        }
    };
    let members: Vec<Member> = (0..9).map(member).collect();
    for drive in [
        Drive::Current,
        Drive::Duty { supply_v, length_m },
        Drive::Voltage { length_m },
        Drive::Power { length_m },
    ] {
        let ensemble = Ensemble {
            drive,
            rule: Rule::Nested,
        };
        let traces = by_ensemble(ensemble, &members, &profile);
        for (trace, &member) in traces.iter().zip(&members) {
            assert!(trace == &alone(ensemble, member, &profile), "{drive:?}");
        }
    }
}

#[test]
fn a_start_at_rest_is_the_rest_of_the_model() {
    use wiener::Plant;
    let model = common::model(Rule::Nested);
    let start = Start::rest(AMBIENT_DEGC);
    let state = model.between_limiting_curves([start.temperature_degc], [start.share]);
    assert_eq!(state, model.rest(AMBIENT_DEGC));
}

#[test]
fn no_members_show_nothing() {
    let profile = Profile::uniform(&[1.0], 0.287, AMBIENT_DEGC).unwrap();
    let ensemble = Ensemble {
        drive: Drive::Current,
        rule: Rule::LastReversal,
    };
    let mut n_blocks = 0;
    ensemble.run(&[], &profile, &mut |_| n_blocks += 1).unwrap();
    assert_eq!(n_blocks, 0);
}

#[test]
fn a_member_out_of_range_is_refused() {
    let profile = Profile::uniform(&[1.0], 0.287, AMBIENT_DEGC).unwrap();
    let ensemble = Ensemble {
        drive: Drive::Current,
        rule: Rule::LastReversal,
    };
    let sound = Member {
        params: common::params(),
        start: Start::rest(AMBIENT_DEGC),
    };
    for size in SIZES {
        let mut members = vec![sound; size];
        members[size - 1].params.gain = f64::NAN;
        let refused = ensemble.run(&members, &profile, &mut |_| {});
        assert!(matches!(
            refused,
            Err(WienerError::Readout { name: "gain", .. })
        ));
    }
}
