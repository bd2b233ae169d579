//! The text of every error.

use sma_hysteresis::{
    Branch, ExponentialProximity, Hysteresis, LimitingLoop, LoopParams, Rule, SineProximity,
};

fn refused(change: impl Fn(&mut LoopParams)) -> String {
    let mut params = LoopParams::default();
    change(&mut params);
    LimitingLoop::new([params]).unwrap_err().to_string()
}

#[test]
fn widths_must_be_positive() {
    for (value, shown) in [
        (0.0, "0"),
        (-1.0, "-1"),
        (f64::NAN, "NaN"),
        (f64::INFINITY, "inf"),
    ] {
        assert_eq!(
            refused(|params| params.loop_half_width_k = value),
            format!("loop_half_width_k = {shown} K: must be finite and > 0")
        );
        assert_eq!(
            refused(|params| params.loop_spread_k = value),
            format!("loop_spread_k = {shown} K: must be finite and > 0")
        );
    }
}

#[test]
fn widths_are_those_of_a_loop() {
    for (value, shown) in [(1e-31, "1e-31"), (1e31, "1e31")] {
        assert_eq!(
            refused(|params| params.loop_half_width_k = value),
            format!("loop_half_width_k = {shown} K: must be from 1e-30 to 1e30 K")
        );
        assert_eq!(
            refused(|params| params.loop_spread_k = value),
            format!("loop_spread_k = {shown} K: must be from 1e-30 to 1e30 K")
        );
    }
}

#[test]
fn centers_must_be_finite() {
    assert_eq!(
        refused(|params| params.loop_center_degc = f64::NAN),
        "loop_center_degc = NaN °C: must be finite"
    );
    assert_eq!(
        refused(|params| params.fraction_center = f64::INFINITY),
        "fraction_center = inf (fraction): must be finite"
    );
}

#[test]
fn a_loop_needs_height() {
    for (value, shown) in [(0.0, "0"), (f64::NAN, "NaN")] {
        assert_eq!(
            refused(|params| params.fraction_swing = value),
            format!(
                "fraction_swing = {shown}: must be finite and not 0 (1/2 for a fraction from 0 to 1)"
            )
        );
    }
}

#[test]
fn zeta_beyond_one_would_run_backward() {
    for (value, shown) in [
        (0.0, "0"),
        (-0.5, "-0.5"),
        (1.0001, "1.0001"),
        (f64::NAN, "NaN"),
    ] {
        assert_eq!(
            SineProximity::new([value]).unwrap_err().to_string(),
            format!("zeta = {shown}: must be > 0 and <= 1, or a branch would run backward")
        );
        assert_eq!(
            ExponentialProximity::new([value]).unwrap_err().to_string(),
            format!("rate = {shown}: must be > 0 and <= 1, or a branch would run backward")
        );
    }
}

#[test]
fn a_start_must_lie_inside_the_loop() {
    let limits = LimitingLoop::new([LoopParams {
        loop_center_degc: 0.0,
        loop_half_width_k: 10.0,
        loop_spread_k: 10.0,
        ..LoopParams::default()
    }])
    .unwrap();
    let proximity = SineProximity::new([0.9]).unwrap();
    let material = Hysteresis::new(limits, proximity, Rule::LastReversal);
    // At 0 °C the curves are at atan(∓1)/π + 1/2.
    for (value, shown) in [(0.2, "0.2"), (0.8, "0.8"), (1.5, "1.5"), (f64::NAN, "NaN")] {
        assert_eq!(
            material.at([0.0], [value]).unwrap_err().to_string(),
            format!(
                "start fraction = {shown} at 0 °C: outside the limiting loop, which spans 0.25 to 0.75 there"
            )
        );
    }
    assert_eq!(
        material.at([f64::NAN], [0.5]).unwrap_err().to_string(),
        "start temperature = NaN °C: must be finite"
    );
    assert!(material.at([0.0], [0.25]).is_ok());
    assert!(material.at([0.0], [0.75]).is_ok());
}

#[test]
fn no_temperature_reaches_an_asymptote() {
    let limits = LimitingLoop::new([LoopParams::default()]).unwrap();
    for (value, shown) in [(1.0, "1"), (-0.1, "-0.1"), (f64::NAN, "NaN")] {
        assert_eq!(
            limits
                .temperature_degc(Branch::Heating, [value])
                .unwrap_err()
                .to_string(),
            format!("fraction = {shown}: the heating curve takes values strictly between 0 and 1")
        );
    }
}
