//! Each reference at its corners.

use crate::common;

use common::{assert_near, assert_same};
use pid_tune::Reference;

fn values(reference: Reference<'_>, n_samples: usize, dt_s: f64) -> Vec<f64> {
    let reference = reference.checked().unwrap();
    (0..n_samples).map(|k| reference.at(k, dt_s)).collect()
}

#[test]
fn a_step_shows_at_the_first_sample_at_or_after_it() {
    let step = |at_s| Reference::Step {
        from: 1.0,
        to: 3.0,
        at_s,
    };
    assert_same(&values(step(0.0), 3, 0.5), &[3.0, 3.0, 3.0]);
    assert_same(&values(step(0.5), 3, 0.5), &[1.0, 3.0, 3.0]);
    assert_same(&values(step(0.6), 3, 0.5), &[1.0, 1.0, 3.0]);
}

#[test]
fn an_edge_on_a_sample_is_not_lost_to_rounding() {
    const DT_S: f64 = 0.287;
    for k in 1..5000_usize {
        // As a person would write it: 2.87 is not 10 · 0.287 to the last bit.
        let at_s: f64 = format!("{:.3}", k as f64 * DT_S).parse().unwrap();
        let step = Reference::Step {
            from: 0.0,
            to: 1.0,
            at_s,
        };
        assert_same(&[step.at(k - 1, DT_S), step.at(k, DT_S)], &[0.0, 1.0]);
        let square = Reference::Square {
            low: 0.0,
            high: 1.0,
            hold_s: at_s,
        };
        assert_same(&[square.at(k - 1, DT_S), square.at(k, DT_S)], &[1.0, 0.0]);
    }
}

#[test]
fn a_staircase_holds_its_last_level() {
    let staircase = Reference::Staircase {
        levels: &[1.0, 4.0, 2.0],
        hold_s: 0.2,
    };
    assert_same(
        &values(staircase, 8, 0.1),
        &[1.0, 1.0, 4.0, 4.0, 2.0, 2.0, 2.0, 2.0],
    );
}

#[test]
fn a_sine_starts_at_its_bias_and_rises() {
    let sine = Reference::Sine {
        bias: 0.5,
        amplitude: 0.2,
        frequency_hz: 0.25,
    };
    let expected = [0.5, 0.7, 0.5, 0.3, 0.5];
    for (value, expected) in values(sine, 5, 1.0).into_iter().zip(expected) {
        assert_near(value, expected, 1e-15);
    }
}

#[test]
fn a_trapezoid_ramps_and_holds() {
    let trapezoid = |hold_s| Reference::Trapezoid {
        low: 1.0,
        high: 3.0,
        ramp_s: 2.0,
        hold_s,
    };
    assert_same(
        &values(trapezoid(2.0), 10, 1.0),
        &[1.0, 2.0, 3.0, 3.0, 3.0, 2.0, 1.0, 1.0, 1.0, 2.0],
    );
    assert_same(
        &values(trapezoid(0.0), 6, 1.0),
        &[1.0, 2.0, 3.0, 2.0, 1.0, 2.0],
    );
}

#[test]
fn a_square_starts_high() {
    let square = Reference::Square {
        low: 1.0,
        high: 3.0,
        hold_s: 2.0,
    };
    assert_same(&values(square, 6, 1.0), &[3.0, 3.0, 1.0, 1.0, 3.0, 3.0]);
}

#[test]
fn samples_are_taken_by_number_and_the_last_is_held() {
    let samples = Reference::Samples(&[5.0, 7.0]);
    assert_same(&values(samples, 4, 0.1), &[5.0, 7.0, 7.0, 7.0]);
}
