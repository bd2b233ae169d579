//! The front of accuracy against energy.

use crate::common;

use common::{AMBIENT_DEGC, rod, undisturbed};
use pid_tune::{
    AntiWindup, ClosedLoop, CostWeights, DerivativeOf, DriveLimits, FrontPoint, Goal, PidGains,
    PidParams, Reference, Task, TunerConfig, front,
};
use wiener::hysteresis::Rule;
use wiener::{Drive, Ensemble, Member, Start};

const WEIGHTS: CostWeights = CostWeights {
    mse: 100.0,
    energy: 0.01,
    rise_time: 0.0,
    settling_time: 0.0,
    overshoot: 0.0,
};

fn task() -> Task<'static, Ensemble> {
    let rods = Ensemble {
        drive: Drive::Current,
        rule: Rule::Nested,
    };
    let reference = Reference::Step {
        from: 0.0,
        to: 0.5,
        at_s: 0.0,
    };
    let pid = PidParams {
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
    let closed_loop = ClosedLoop::new(undisturbed(reference, 200)).unwrap();
    Task::new(rods, closed_loop, pid).unwrap()
}

fn member() -> Member {
    Member {
        params: rod(6.0),
        start: Start::rest(AMBIENT_DEGC),
    }
}

fn found() -> Vec<FrontPoint> {
    let task = task();
    let config = TunerConfig {
        moves: 40,
        ..TunerConfig::for_task(&task, 5.0).unwrap()
    };
    front(&task, &[member()], &Goal::of(WEIGHTS), &config).unwrap()
}

#[test]
fn no_controller_of_a_front_is_better_than_another_in_both_terms() {
    let front = found();
    assert!(front.len() > 20, "{}", front.len());
    for pair in front.windows(2) {
        // Sorted in both, strictly: so nobody is beaten by anybody.
        assert!(pair[0].terms.mse < pair[1].terms.mse);
        assert!(pair[0].terms.energy > pair[1].terms.energy);
    }
    let (accurate, sparing) = (front[0], front[front.len() - 1]);
    assert!(accurate.terms.mse < 0.1 * sparing.terms.mse);
    // The bounds allow to do nothing at all.
    assert!(sparing.terms.energy <= 0.0, "{sparing:?}");
}

#[test]
fn a_front_is_at_least_as_good_as_the_papers_gains() {
    let paper = PidGains {
        kp: 200.0,
        ki: 0.01,
        kd: 0.0,
    };
    let terms = task().evaluate(&[(member(), paper)]).unwrap()[0];
    let beats = |point: &FrontPoint| {
        point.terms.mse <= 1.01 * terms.mse && point.terms.energy <= 1.01 * terms.energy
    };
    assert!(found().iter().any(beats));
}

#[test]
fn points_have_the_terms_of_their_gains() {
    let front = found();
    let cases: Vec<_> = front.iter().map(|point| (member(), point.gains)).collect();
    let terms = task().evaluate(&cases).unwrap();
    assert!(front.iter().map(|point| point.terms).eq(terms));
}

#[test]
fn a_front_has_the_same_bits_on_any_number_of_threads() {
    let on = |n_threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads);
        format!("{:?}", pool.build().unwrap().install(found))
    };
    let one = on(1);
    assert_eq!(one, on(2));
    assert_eq!(one, on(7));
}

#[test]
fn both_weights_must_be_positive() {
    let task = task();
    let config = TunerConfig::for_task(&task, 5.0).unwrap();
    let refused = |weights| {
        front(&task, &[member()], &Goal::of(weights), &config)
            .unwrap_err()
            .to_string()
    };
    for (value, shown) in [(0.0, "0"), (f64::NAN, "NaN")] {
        assert_eq!(
            refused(CostWeights {
                mse: value,
                ..WEIGHTS
            }),
            format!("mse = {shown}: must be finite and > 0")
        );
        assert_eq!(
            refused(CostWeights {
                energy: value,
                ..WEIGHTS
            }),
            format!("energy = {shown}: must be finite and > 0")
        );
    }
}
