//! Eqs 4-12 of [Sadeghi], each by a second route, with the misprint that was corrected.

use crate::common;

use std::f64::consts::{FRAC_PI_2, PI};

use approx::assert_abs_diff_eq;
use common::{material, walk};
use sma_hysteresis::{Branch, Hysteresis, LimitingLoop, LoopParams, Rule};

const HALF_WIDTH_K: f64 = 8.0;
const SPREAD_K: f64 = 5.0;
const ZETA: f64 = 0.8;

fn limits(center: f64, swing: f64) -> LimitingLoop<1> {
    LimitingLoop::new([LoopParams {
        loop_center_degc: 0.0,
        loop_half_width_k: HALF_WIDTH_K,
        loop_spread_k: SPREAD_K,
        fraction_center: center,
        fraction_swing: swing,
    }])
    .unwrap()
}

/// T_p = T_L - T̂ by eqs 5 and 6, from nothing but a point (T̂, ξ).
fn proximity_k(material: &Hysteresis<1>, branch: Branch, temperature: f64, fraction: f64) -> f64 {
    let [limit] = material
        .limits()
        .temperature_degc(branch, [fraction])
        .unwrap();
    limit - temperature
}

/// A minor loop that stays inside: heating from rest to `high`, cooling to `low`, then heating.
const HIGH: f64 = 10.0;
const LOW: f64 = 0.0;

#[test]
fn eq_4_limiting_curves() {
    // Printed with ξ_s as "hysteresis height" and ξ_0 as "saturation": they are half the height and
    // the middle.
    for (center, swing) in [(0.5, 0.5), (0.4, 0.3), (0.5, -0.5)] {
        let limits = limits(center, swing);
        for branch in [Branch::Heating, Branch::Cooling] {
            let shift = branch.sign() * HALF_WIDTH_K;
            let [middle] = limits.fraction(branch, [shift]);
            assert_abs_diff_eq!(middle, center, epsilon = 1e-15);
            // atan 1 = π/4: a quarter of the height away from the middle.
            let [quarter] = limits.fraction(branch, [shift + SPREAD_K]);
            assert_abs_diff_eq!(quarter, center + swing / 2.0, epsilon = 1e-15);
            let [end] = limits.fraction(branch, [1e12]);
            assert_abs_diff_eq!(end, center + swing, epsilon = 1e-10);
        }
    }
}

#[test]
fn eq_5_proximity_is_measured_along_the_temperature_axis() {
    let material = material(HALF_WIDTH_K, SPREAD_K, ZETA, Rule::LastReversal);
    // On its own curve a point is at distance 0, on the other one at 2 T_c.
    for temperature in [-20.0, 0.0, 13.0] {
        let [upper] = material.limits().fraction(Branch::Cooling, [temperature]);
        let to_own = proximity_k(&material, Branch::Cooling, temperature, upper);
        let to_other = proximity_k(&material, Branch::Heating, temperature, upper);
        assert_abs_diff_eq!(to_own, 0.0, epsilon = 1e-9);
        assert_abs_diff_eq!(to_other, 2.0 * HALF_WIDTH_K, epsilon = 1e-9);
    }
}

#[test]
fn eq_6_inverts_eq_4_with_the_fraction_center_that_is_not_printed() {
    let limits = limits(0.4, 0.3);
    for branch in [Branch::Heating, Branch::Cooling] {
        for temperature in [-30.0, -3.0, 0.0, 8.0, 25.0] {
            let fraction = limits.fraction(branch, [temperature]);
            let [back] = limits.temperature_degc(branch, fraction).unwrap();
            assert_abs_diff_eq!(back, temperature, epsilon = 1e-9);
        }
    }
}

#[test]
fn eq_7_proximity_of_any_point_uses_that_points_fraction() {
    // Printed "ξ_0" for the point's own ξ: with ξ_0 the tangent would vanish and the distance would be
    // that of the loop's middle, wherever the point lies.
    let material = material(HALF_WIDTH_K, SPREAD_K, ZETA, Rule::LastReversal);
    let [fraction] = material.limits().fraction(Branch::Cooling, [3.0]);
    let by_eq_7 = SPREAD_K * (PI * (fraction - 0.5)).tan() + HALF_WIDTH_K - 3.0;
    let by_eq_6 = proximity_k(&material, Branch::Heating, 3.0, fraction);
    assert_abs_diff_eq!(by_eq_7, by_eq_6, epsilon = 1e-9);
    let as_printed = HALF_WIDTH_K - 3.0;
    assert!((as_printed - by_eq_6).abs() > 1.0);
}

#[test]
fn eq_8_a_branch_starts_with_the_proximity_of_its_reversal() {
    // Printed "ξ_0" for ξ_r. From a limiting curve the branch starts with -2 δ_old T_c.
    let material = material(HALF_WIDTH_K, SPREAD_K, ZETA, Rule::LastReversal);
    let mut memory = material.on_limiting_curve(Branch::Heating, [HIGH]);
    let at_reversal = walk(&material, &mut memory, &[HIGH]);
    let start = proximity_k(&material, Branch::Cooling, HIGH, at_reversal);
    assert_abs_diff_eq!(start, -2.0 * HALF_WIDTH_K, epsilon = 1e-9);
    // The operator's own branch starts there: a step so small that P has not fallen yet.
    let after = walk(&material, &mut memory, &[HIGH - 1e-6]);
    let going = proximity_k(&material, Branch::Cooling, HIGH - 1e-6, after);
    assert_abs_diff_eq!(going, start, epsilon = 1e-5);
}

#[test]
fn eqs_9_10_12_proximity_fades_as_p_of_x() {
    // Eq. 12 leaves ζx = π/2 undefined; P is 0 there from both sides.
    let material = material(HALF_WIDTH_K, SPREAD_K, ZETA, Rule::LastReversal);
    let mut memory = material.on_limiting_curve(Branch::Cooling, [-40.0]);
    walk(&material, &mut memory, &[HIGH, LOW]);
    let at_reversal = walk(&material, &mut memory, &[LOW]);
    let start = proximity_k(&material, Branch::Heating, LOW, at_reversal);
    assert!(start > 1.0 && start < 2.0 * HALF_WIDTH_K);
    let end = LOW + FRAC_PI_2 * start / ZETA;
    for share in [0.01, 0.25, 0.5, 0.9, 1.0, 1.1, 2.0] {
        let temperature = LOW + share * (end - LOW);
        let fraction = walk(&material, &mut memory, &[temperature]);
        let x = (temperature - LOW) / start;
        let p = if ZETA * x < FRAC_PI_2 {
            1.0 - (ZETA * x).sin()
        } else {
            0.0
        };
        let found = proximity_k(&material, Branch::Heating, temperature, fraction);
        assert_abs_diff_eq!(found, start * p, epsilon = 1e-8);
    }
}

#[test]
fn eq_11_a_branch_is_shifted_from_the_limiting_curve() {
    // Printed without "+ ξ_0".
    let material = material(HALF_WIDTH_K, SPREAD_K, ZETA, Rule::LastReversal);
    let mut memory = material.on_limiting_curve(Branch::Heating, [HIGH]);
    walk(&material, &mut memory, &[HIGH]);
    let start = -2.0 * HALF_WIDTH_K;
    for temperature in [8.0, 5.0, 0.0, -10.0] {
        let x: f64 = (temperature - HIGH) / start;
        let p = 1.0 - (ZETA * x).min(FRAC_PI_2).sin();
        let by_eq_11 = ((start * p + temperature + HALF_WIDTH_K) / SPREAD_K).atan() / PI + 0.5;
        let fraction = walk(&material, &mut memory, &[temperature]);
        assert_abs_diff_eq!(fraction, by_eq_11, epsilon = 1e-14);
    }
}

#[test]
fn the_papers_operator_overshoots_its_return_point() {
    // Not printed: a minor loop from the limiting curve whose swing is below π T_c/ζ does not close.
    let swing = 0.6 * PI * HALF_WIDTH_K / ZETA;
    let gap = |rule| {
        let material = material(HALF_WIDTH_K, SPREAD_K, ZETA, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [-60.0]);
        // Far enough to be on the heating curve at the reversal.
        let left = walk(&material, &mut memory, &[HIGH]);
        walk(&material, &mut memory, &[HIGH - swing, HIGH]) - left
    };
    assert!(gap(Rule::LastReversal) > 1e-3);
    assert_abs_diff_eq!(gap(Rule::Nested), 0.0, epsilon = 1e-14);
}
