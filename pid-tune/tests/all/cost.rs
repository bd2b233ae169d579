//! The terms of eqs 13 and 14, against closed forms and by hand.

use crate::common;

use std::f64::consts::PI;

use common::{assert_near, assert_same};
use pid_tune::{CostWeights, Reference, ResponseTerms, Snapshot, StepTerms, Terms};

/// Terms of a response given sample by sample, without any drive.
fn terms(reference: Reference<'_>, dt_s: f64, outputs: &[f64]) -> Terms {
    let mut response = ResponseTerms::new(&reference, dt_s).unwrap();
    for (k, &output) in outputs.iter().enumerate() {
        response.add(&shown(k, reference.at(k, dt_s), output, 0.0));
    }
    let [terms] = response.terms();
    terms
}

fn shown(k: usize, setpoint: f64, output: f64, drive: f64) -> Snapshot {
    Snapshot {
        k,
        time_s: f64::NAN, // the number of the sample decides
        setpoint,
        output: [output],
        measured: [f64::NAN], // true outputs count
        drive: [drive],
        temperature_degc: [f64::NAN],
    }
}

fn step(from: f64, to: f64, at_s: f64) -> Reference<'static> {
    Reference::Step { from, to, at_s }
}

/// Samples of a response to the unit step.
fn sampled(n_samples: usize, dt_s: f64, response: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..n_samples).map(|k| response(k as f64 * dt_s)).collect()
}

fn assert_step(found: StepTerms, expected: StepTerms, tolerance: f64) {
    assert_near(found.rise_time_s, expected.rise_time_s, tolerance);
    assert_near(found.settling_time_s, expected.settling_time_s, tolerance);
    assert_near(found.overshoot, expected.overshoot, tolerance);
}

const TAU_S: f64 = 2.0;

fn first_order(time_s: f64) -> f64 {
    1.0 - (-time_s / TAU_S).exp()
}

/// Of a lag: ln 9 and ln 50 time constants.
fn of_first_order() -> StepTerms {
    StepTerms {
        rise_time_s: TAU_S * 9_f64.ln(),
        settling_time_s: TAU_S * 50_f64.ln(),
        overshoot: 0.0,
    }
}

#[test]
fn mean_square_and_energy_by_hand() {
    let reference = Reference::Samples(&[1.0, 1.0, 2.0]);
    let mut response = ResponseTerms::new(&reference, 0.5).unwrap();
    for (k, (output, drive)) in [(0.0, 1.0), (0.5, -2.0), (4.0, 3.0)]
        .into_iter()
        .enumerate()
    {
        response.add(&shown(k, reference.at(k, 0.5), output, drive));
    }
    let [terms] = response.terms();
    assert_near(terms.mse, (1.0 + 0.25 + 4.0) / 3.0, 1e-15);
    assert_same(&[terms.energy], &[0.5 * (1.0 + 4.0 + 9.0) * 0.5]);
}

#[test]
fn a_lag_rises_in_ln_9_and_settles_in_ln_50_time_constants() {
    for dt_s in [0.002, 0.02, 0.2, 0.5] {
        let outputs = sampled((20.0 / dt_s) as usize, dt_s, first_order);
        let found = terms(step(0.0, 1.0, 0.0), dt_s, &outputs).step.unwrap();
        // A straight line is off by at most dt² y''/8, and y' is the share left over τ: dt²/(8 τ), twice.
        assert_step(found, of_first_order(), dt_s * dt_s / (4.0 * TAU_S));
    }
}

#[test]
fn a_falling_step_is_a_rising_one_upside_down() {
    let outputs = sampled(2000, 0.01, |time_s| 1.3 * first_order(time_s));
    let rising = terms(step(0.0, 1.3, 0.0), 0.01, &outputs);
    let upside_down: Vec<f64> = outputs.iter().map(|output| -output).collect();
    assert_eq!(terms(step(0.0, -1.3, 0.0), 0.01, &upside_down), rising);
}

#[test]
fn a_start_away_from_the_reference_is_measured_by_the_way_to_go() {
    let dt_s = 0.01;
    let outputs = sampled(2000, dt_s, |time_s| 0.3 + 0.7 * first_order(time_s));
    // From the output at the step, not from the reference before it.
    for from in [-5.0, 0.0, 0.3] {
        let found = terms(step(from, 1.0, 0.0), dt_s, &outputs).step.unwrap();
        assert_step(found, of_first_order(), 1e-4);
    }
}

#[test]
fn times_count_from_the_sample_that_shows_the_step() {
    let dt_s = 0.01;
    let mut outputs = vec![0.0; 300];
    outputs.extend(sampled(2000, dt_s, first_order));
    for at_s in [3.0, 2.995] {
        let found = terms(step(0.0, 1.0, at_s), dt_s, &outputs).step.unwrap();
        assert_step(found, of_first_order(), 1e-4);
    }
}

#[test]
fn overshoot_of_a_second_order_response_follows_the_closed_form() {
    let dt_s = 0.001;
    for damping in [0.1_f64, 0.3, 0.5, 0.7] {
        let damped = (1.0 - damping * damping).sqrt();
        let outputs = sampled(60_000, dt_s, |time_s| {
            let phase = damped * time_s;
            1.0 - (-damping * time_s).exp() * (phase.cos() + damping / damped * phase.sin())
        });
        for sign in [1.0, -1.0] {
            let outputs: Vec<f64> = outputs.iter().map(|output| sign * output).collect();
            let found = terms(step(0.0, sign, 0.0), dt_s, &outputs).step.unwrap();
            assert_near(found.overshoot, (-PI * damping / damped).exp(), 1e-6);
        }
    }
}

#[test]
fn what_never_rises_is_charged_the_time_that_was_left() {
    let left_s = |outputs: &[f64]| terms(step(0.0, 1.0, 2.0), 0.5, outputs).step.unwrap();
    // Ten samples end at 4.5 s: 2.5 s after the step. Flat, away from it, and up to 89 %.
    let mut nearly = vec![0.0; 10];
    nearly[9] = 0.89;
    for outputs in [vec![0.0; 10], sampled(10, 0.5, |time_s| -time_s), nearly] {
        let found = left_s(&outputs);
        assert_same(&[found.rise_time_s, found.settling_time_s], &[2.5, 2.5]);
        assert_same(&[found.overshoot], &[0.0]);
    }
}

#[test]
fn what_stops_short_rises_but_does_not_settle() {
    let outputs = sampled(400, 0.1, |time_s| 0.97 * first_order(time_s));
    let found = terms(step(0.0, 1.0, 0.0), 0.1, &outputs).step.unwrap();
    assert!(found.rise_time_s > TAU_S * 9_f64.ln() && found.rise_time_s < 3.0 * TAU_S);
    assert_near(found.settling_time_s, 39.9, 1e-12);
}

#[test]
fn settling_counts_the_last_time_outside() {
    // Inside the band at 1 s, outside again until 2.5 s: 1.06 to 1 crosses 1.02 after two thirds of a sample.
    let outputs = [0.0, 1.0, 1.06, 1.0, 1.0];
    let found = terms(step(0.0, 1.0, 0.0), 1.0, &outputs).step.unwrap();
    assert_near(found.settling_time_s, 2.0 + 2.0 / 3.0, 1e-12);
    assert_near(found.rise_time_s, 0.8, 1e-12);
    assert_near(found.overshoot, 0.06, 1e-12);
}

#[test]
fn a_jump_over_all_levels_is_read_from_one_line() {
    let found = terms(step(0.0, 1.0, 0.0), 1.0, &[0.0, 2.0, 1.0])
        .step
        .unwrap();
    assert_near(found.rise_time_s, 0.4, 1e-12);
    assert_near(found.settling_time_s, 1.98, 1e-12);
    assert_near(found.overshoot, 1.0, 1e-12);
}

#[test]
fn without_any_way_to_go_there_is_nothing_to_measure() {
    let found = terms(step(0.0, 0.5, 0.0), 1.0, &[0.5, 0.7, 0.4, 0.5]);
    let step = found.step.unwrap();
    assert_same(
        &[step.rise_time_s, step.settling_time_s, step.overshoot],
        &[0.0; 3],
    );
    assert!(found.mse > 0.0);
}

#[test]
fn only_the_response_to_a_step_has_its_terms() {
    let sine = Reference::Sine {
        bias: 0.5,
        amplitude: 0.2,
        frequency_hz: 0.007,
    };
    assert_eq!(terms(sine, 0.287, &[0.0; 50]).step, None);
    // A step that the run does not reach, or only with its last sample.
    for at_s in [9.0, 20.0] {
        assert_eq!(terms(step(0.0, 1.0, at_s), 1.0, &[0.0; 10]).step, None);
    }
    assert!(terms(step(0.0, 1.0, 8.0), 1.0, &[0.0; 10]).step.is_some());
}

#[test]
fn an_output_that_is_no_number_spoils_the_mean_square_only() {
    let found = terms(step(0.0, 1.0, 0.0), 1.0, &[0.0, 0.5, f64::NAN, f64::NAN]);
    assert!(found.mse.is_nan());
    let step = found.step.unwrap();
    assert_same(
        &[step.rise_time_s, step.settling_time_s, step.overshoot],
        &[3.0, 3.0, 0.0],
    );
    let weights = CostWeights {
        mse: 1.0,
        energy: 1.0,
        rise_time: 1.0,
        settling_time: 1.0,
        overshoot: 1.0,
    };
    assert!(weights.cost(&found).is_nan());
}

#[test]
fn no_samples_have_no_mean_square() {
    let response = ResponseTerms::<1>::new(&step(0.0, 1.0, 0.0), 1.0).unwrap();
    let [found] = response.terms();
    assert!(found.mse.is_nan());
    assert_eq!(found.step, None);
}

const SOME: Terms = Terms {
    mse: 0.02,
    energy: 80.0,
    step: Some(StepTerms {
        rise_time_s: 4.0,
        settling_time_s: 9.0,
        overshoot: 0.25,
    }),
};

#[test]
fn the_cost_is_the_weighted_sum() {
    let weights = CostWeights {
        mse: 100.0,
        energy: 0.5,
        rise_time: 2.0,
        settling_time: 3.0,
        overshoot: 4.0,
    };
    assert_near(weights.cost(&SOME), 2.0 + 40.0 + 8.0 + 27.0 + 1.0, 1e-12);
    let without_step = Terms { step: None, ..SOME };
    assert_near(weights.cost(&without_step), 42.0, 1e-12);
}

#[test]
fn balanced_each_term_counts_one() {
    let weights = CostWeights::balancing(&SOME).checked().unwrap();
    assert_near(weights.cost(&SOME), 5.0, 1e-12);
    assert_near(weights.mse * SOME.mse, 1.0, 1e-15);
    assert_near(weights.energy * SOME.energy, 1.0, 1e-15);
    let without_step = Terms { step: None, ..SOME };
    let weights = CostWeights::balancing(&without_step).checked().unwrap();
    assert_near(weights.cost(&without_step), 2.0, 1e-12);
    assert_same(
        &[weights.rise_time, weights.settling_time, weights.overshoot],
        &[0.0; 3],
    );
}

#[test]
fn overshoot_has_a_weight_even_if_there_was_none() {
    let none = Terms {
        step: SOME.step.map(|step| StepTerms {
            overshoot: 0.0,
            ..step
        }),
        ..SOME
    };
    let weights = CostWeights::balancing(&none).checked().unwrap();
    // The settling band.
    assert_near(weights.overshoot, 1.0 / 0.02, 1e-12);
}

#[test]
fn a_term_of_zero_or_no_number_gets_no_weight() {
    for term in [0.0, f64::NAN, f64::INFINITY, 1e-320] {
        let weights = CostWeights::balancing(&Terms {
            mse: term,
            energy: term,
            step: None,
        });
        assert_same(&[weights.mse, weights.energy], &[0.0; 2]);
    }
}
