//! Models that the tests share.

#![allow(dead_code, reason = "no test file needs all of it")]

use proptest::prelude::*;
use sma_hysteresis::{LoopParams, Rule};
use sma_thermal::{HeatBalanceParams, ThermalConstants};
use wiener::{Drive, Output, Profile, State, Wiener, WienerParams, run};

pub(crate) const AMBIENT_DEGC: f64 = 25.0;

/// A rod that is warm after some seconds and goes through its loop between 1 and 2 A.
pub(crate) fn params() -> WienerParams {
    WienerParams {
        heat: HeatBalanceParams::from_constants(ThermalConstants {
            tau_s: 4.0,
            lambda_k_per_a2: 25.0,
        }),
        limiting_loop: LoopParams {
            loop_center_degc: 75.0,
            loop_half_width_k: 11.0,
            loop_spread_k: 6.0,
            ..LoopParams::default()
        },
        zeta: 0.85,
        gain: 6.0,
        offset: 0.4,
    }
}

/// The model of [`params`] with a current drive.
pub(crate) fn model(rule: Rule) -> Wiener {
    Wiener::new(Drive::Current, rule, &[params()]).unwrap()
}

/// Runs a model and collects what it shows.
pub(crate) fn outputs(model: &Wiener, mut state: State, profile: &Profile<'_>) -> Vec<Output> {
    let mut outputs = Vec::with_capacity(profile.len());
    run(model, &mut state, profile, |_, output| outputs.push(output));
    outputs
}

/// Any rod whose loop some of [`any_currents`] reach.
pub(crate) fn any_params() -> impl Strategy<Value = WienerParams> {
    let heat = (0.5..20.0, 5.0..60.0);
    let limiting_loop = (40.0..110.0, 1.0..30.0, 0.5..20.0);
    let readout = (prop_oneof![-15.0..-1.0, 1.0..15.0], -2.0..2.0);
    let zeta = prop_oneof![0.2..1.0, Just(1.0)];
    (heat, limiting_loop, readout, zeta).prop_map(
        |((tau_s, lambda_k_per_a2), (center, half_width, spread), (gain, offset), zeta)| {
            WienerParams {
                heat: HeatBalanceParams::from_constants(ThermalConstants {
                    tau_s,
                    lambda_k_per_a2,
                }),
                limiting_loop: LoopParams {
                    loop_center_degc: center,
                    loop_half_width_k: half_width,
                    loop_spread_k: spread,
                    ..LoopParams::default()
                },
                zeta,
                gain,
                offset,
            }
        },
    )
}

/// Currents of many samples, A: each value held for a while, some of them 0.
pub(crate) fn any_currents() -> impl Strategy<Value = Vec<f64>> {
    let held = (prop_oneof![1 => Just(0.0), 3 => 0.3..3.0], 1_usize..12);
    prop::collection::vec(held, 1..15).prop_map(|pieces| {
        pieces
            .into_iter()
            .flat_map(|(current_a, n_samples)| std::iter::repeat_n(current_a, n_samples))
            .collect()
    })
}

pub(crate) fn any_rule() -> impl Strategy<Value = Rule> {
    prop_oneof![Just(Rule::LastReversal), Just(Rule::Nested)]
}
