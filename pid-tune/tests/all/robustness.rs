//! One controller on many plants, and how runs end.

use crate::common;

use common::{AMBIENT_DEGC, assert_near, assert_same, pid, rod, rods, snapshots, undisturbed};
use pid_tune::{
    AntiWindup, ClosedLoop, ClosedLoopParams, DerivativeOf, DriveLimits, Ending, PidGains,
    PidParams, Reference, Task, Variation, robustness, sensitivities,
};
use wiener::hysteresis::Rule;
use wiener::{Drive, Ensemble, Member, Start, WienerParams};

const STEP: Reference<'_> = Reference::Step {
    from: 0.0,
    to: 0.5,
    at_s: 0.0,
};
const PID: PidParams = PidParams {
    dt_s: 0.287,
    limits: DriveLimits {
        lower: 0.0,
        upper: 3.0,
    },
    anti_windup: AntiWindup::Clamping,
    derivative_of: DerivativeOf::Measurement,
    derivative_filter_s: 0.0,
    setpoint_weight: 1.0,
    gain_schedule: None,
};
const PAPER: PidGains = PidGains {
    kp: 200.0,
    ki: 0.01,
    kd: 0.0,
};
const CALM: PidGains = PidGains {
    kp: 6.0,
    ki: 1.2,
    kd: 0.0,
};

fn at_rest(params: WienerParams) -> Member {
    Member {
        params,
        start: Start::rest(AMBIENT_DEGC),
    }
}

fn task_over(params: ClosedLoopParams<'_>) -> Task<'_, Ensemble> {
    let rods = Ensemble {
        drive: Drive::Current,
        rule: Rule::Nested,
    };
    Task::new(rods, ClosedLoop::new(params).unwrap(), PID).unwrap()
}

#[test]
fn percentiles_are_those_of_the_draws() {
    let task = task_over(undisturbed(STEP, 400));
    // 21 draws: 5, 50 and 95 % are the 2nd, 11th and 20th. Neither in order.
    let members: Vec<_> = (0..21)
        .map(|n| at_rest(rod(4.0 + 0.5 * f64::from((n * 8) % 21))))
        .collect();
    let found = robustness(&task, CALM, &members).unwrap();
    let cases: Vec<_> = members.iter().map(|&member| (member, CALM)).collect();
    let terms = task.evaluate(&cases).unwrap();
    let sorted = |mut values: Vec<f64>| {
        values.sort_by(f64::total_cmp);
        [values[1], values[10], values[19]]
    };
    let mse = sorted(terms.iter().map(|terms| terms.mse).collect());
    let rise = sorted(
        terms
            .iter()
            .map(|terms| terms.step.unwrap().rise_time_s)
            .collect(),
    );
    assert_eq!(found.draws, 21);
    assert_same(&[found.mse.p5, found.mse.p50, found.mse.p95], &mse);
    let step = found.step.unwrap();
    let of_rise = step.rise_time_s;
    assert_same(&[of_rise.p5, of_rise.p50, of_rise.p95], &rise);
    assert!(step.settling_time_s.p5 < step.settling_time_s.p95);

    let [first, second] = [terms[0].energy, terms[1].energy];
    let of_two = robustness(&task, CALM, &members[..2]).unwrap().energy;
    assert_near(of_two.p50, 0.5 * (first + second), 1e-12);
    let low = first.min(second);
    assert_near(of_two.p5, low + 0.05 * (first - second).abs(), 1e-12);
    let of_one = robustness(&task, CALM, &members[..1]).unwrap().energy;
    assert_same(&[of_one.p5, of_one.p50, of_one.p95], &[first; 3]);
}

#[test]
fn fast_rods_oscillate_under_the_papers_gains_and_slow_ones_settle() {
    let task = task_over(undisturbed(STEP, 1000));
    let members = [3.0, 30.0, 3.0, 40.0].map(|tau_s| at_rest(rod(tau_s)));
    let found = robustness(&task, PAPER, &members).unwrap().step.unwrap();
    assert_near(found.oscillating_share, 0.5, 1e-15);
    assert_near(found.unsettled_share, 0.5, 1e-15);
    let calm = robustness(&task, CALM, &members[..1])
        .unwrap()
        .step
        .unwrap();
    assert_near(calm.oscillating_share, 0.0, 1e-15);
}

#[test]
fn a_response_that_stops_short_has_not_settled_and_does_not_oscillate() {
    let task = task_over(undisturbed(STEP, 400));
    let gentle = PidGains {
        kp: 0.5,
        ki: 0.0,
        kd: 0.0,
    };
    let found = robustness(&task, gentle, &[at_rest(rod(6.0))]).unwrap();
    let step = found.step.unwrap();
    assert_near(step.unsettled_share, 1.0, 1e-15);
    assert_near(step.oscillating_share, 0.0, 1e-15);
}

#[test]
fn another_reference_has_no_terms_of_a_step() {
    let reference = Reference::Sine {
        bias: 0.5,
        amplitude: 0.2,
        frequency_hz: 0.02,
    };
    let task = task_over(undisturbed(reference, 200));
    let found = robustness(&task, CALM, &[at_rest(rod(6.0))]).unwrap();
    assert!(found.step.is_none());
    assert!(found.mse.p50 > 0.0);
}

#[test]
fn an_end_is_that_of_the_samples_shown() {
    let n_samples = 800;
    for (tau_s, gains) in [(3.0, PAPER), (6.0, CALM), (30.0, PAPER)] {
        let params = undisturbed(STEP, n_samples);
        let member = at_rest(rod(tau_s));
        let task = task_over(params);
        let found = task.responses(&[(member, gains)]).unwrap()[0].ending;
        let shown = snapshots(params, &rods(&[member.params]), &pid(PID, gains));
        let errors: Vec<f64> = shown.iter().map(|one| 0.5 - one.output[0]).collect();
        let swing = |errors: &[f64]| {
            errors.iter().copied().fold(f64::MIN, f64::max)
                - errors.iter().copied().fold(f64::MAX, f64::min)
        };
        assert_near(found.swing, swing(&errors[700..]), 1e-15);
        assert_near(found.swing_before, swing(&errors[600..700]), 1e-15);
        assert_near(found.drift, errors[799] - errors[600], 1e-15);
        let mean = errors[700..].iter().sum::<f64>() / 100.0;
        assert_near(found.mean_error, mean, 1e-15);
        let at_limit = |drive: f64| drive <= 0.0 || drive >= 3.0;
        let saturated = shown.iter().filter(|one| at_limit(one.drive[0])).count();
        assert_near(found.saturated_share, saturated as f64 / 800.0, 1e-15);
    }
}

#[test]
fn a_run_of_less_than_eight_samples_has_no_end() {
    let task = task_over(undisturbed(STEP, 7));
    let found = task.responses(&[(at_rest(rod(6.0)), PAPER)]).unwrap()[0].ending;
    assert_same(
        &[
            found.mean_error,
            found.swing,
            found.swing_before,
            found.drift,
        ],
        &[0.0; 4],
    );
    assert_near(found.saturated_share, 1.0, 1e-15);
}

#[test]
fn a_drive_chatters_if_it_goes_to_and_fro_not_if_it_goes_one_way() {
    let ending = |drive_swing, drive_travel| Ending {
        mean_error: 0.0,
        swing: 0.0,
        swing_before: 0.0,
        drift: 0.0,
        saturated_share: 0.0,
        travel_per_s: 0.0,
        drive_travel,
        drive_swing,
    };
    assert!(ending(0.5, 5.0).chatters(0.2));
    assert!(!ending(0.5, 0.5).chatters(0.2));
    assert!(!ending(0.1, 9.0).chatters(0.2));
    assert!(!ending(f64::NAN, f64::NAN).chatters(0.2));
}

#[test]
fn what_dies_out_drifts_or_is_small_does_not_oscillate() {
    let steady = Ending {
        travel_per_s: 0.0,
        drive_travel: 0.0,
        drive_swing: 0.0,
        mean_error: 0.0,
        swing: 0.1,
        swing_before: 0.1,
        drift: 0.1,
        saturated_share: 0.0,
    };
    assert!(steady.oscillates(0.5) && steady.oscillates(-0.5));
    // 2 % of the step.
    assert!(steady.oscillates(4.9) && !steady.oscillates(5.1));
    let swing = |swing| Ending { swing, ..steady };
    assert!(swing(0.081).oscillates(0.5) && !swing(0.079).oscillates(0.5));
    let drift = |drift| Ending { drift, ..steady };
    assert!(!drift(0.2).oscillates(0.5) && !drift(-0.2).oscillates(0.5));
    assert!(!swing(f64::NAN).oscillates(0.5));
    assert!(!steady.oscillates(f64::NAN) && !steady.oscillates(0.0));
}

#[test]
fn sensitivities_name_each_parameter_and_run_both_plants() {
    let task = task_over(undisturbed(STEP, 300));
    let with = |change: fn(&mut WienerParams, f64), factor| {
        let mut params = rod(6.0);
        change(&mut params, factor);
        at_rest(params)
    };
    let varied = |name, change| Variation {
        name,
        minus: with(change, 0.8),
        plus: with(change, 1.2),
    };
    let variations = [
        varied("gain", |params: &mut WienerParams, factor| {
            params.gain *= factor;
        }),
        varied("loop_half_width_k", |params, factor| {
            params.limiting_loop.loop_half_width_k *= factor;
        }),
    ];
    let found = sensitivities(&task, CALM, &variations).unwrap();
    assert_eq!(found.len(), 2);
    for (found, varied) in found.iter().zip(&variations) {
        let cases = [(varied.minus, CALM), (varied.plus, CALM)];
        let expected = task.responses(&cases).unwrap();
        assert_eq!(found.name, varied.name);
        assert_eq!([found.minus, found.plus], expected[..]);
    }
    // More of a gain in the loop is a faster rise.
    let rise_s = |response: pid_tune::Response| response.terms.step.unwrap().rise_time_s;
    assert!(rise_s(found[0].plus) < rise_s(found[0].minus));
}

#[test]
fn without_draws_there_is_nothing_to_say() {
    let task = task_over(undisturbed(STEP, 300));
    assert_eq!(
        robustness(&task, CALM, &[]).unwrap_err().to_string(),
        "members has no values; at least 1 is needed"
    );
}
