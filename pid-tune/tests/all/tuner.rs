//! Many responses side by side, and the search for gains.

use crate::common;

use std::error::Error;
use std::ops::ControlFlow;

use common::lags::Lags;
use common::{AMBIENT_DEGC, assert_near, assert_same, at, rod, rods, undisturbed};
use fixtures::sadeghi;
use pid_tune::{
    AntiWindup, BoundEnd, ClosedLoop, ClosedLoopParams, CostWeights, DerivativeOf, Disturbances,
    DriveLimits, GainBounds, GainScale, Goal, Pace, Pid, PidGains, PidParams, Plants, Reference,
    ResponseTerms, Task, TaskError, Terms, TuneError, Tuned, TunerConfig, Verdict, second_opinion,
    tune,
};
use pso::{Inertia, Start as SwarmStart, SwarmConfig, Termination};
use wiener::hysteresis::Rule;
use wiener::{Drive, Ensemble, Lanes, Member, Plant, Start, WienerParams};

const RODS: Ensemble = Ensemble {
    drive: Drive::Current,
    rule: Rule::Nested,
};
const STROKE_MM: f64 = 5.0;
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
const PAPER: PidGains = gains(200.0, 0.01, 0.0);
const NO_WEIGHTS: CostWeights = CostWeights {
    mse: 0.0,
    energy: 0.0,
    rise_time: 0.0,
    settling_time: 0.0,
    overshoot: 0.0,
};

const fn gains(kp: f64, ki: f64, kd: f64) -> PidGains {
    PidGains { kp, ki, kd }
}

fn at_rest(params: WienerParams) -> Member {
    Member {
        params,
        start: Start::rest(AMBIENT_DEGC),
    }
}

fn task_over(params: ClosedLoopParams<'_>) -> Task<'_, Ensemble> {
    Task::new(RODS, ClosedLoop::new(params).unwrap(), PID).unwrap()
}

fn step_task() -> Task<'static, Ensemble> {
    task_over(undisturbed(STEP, 300))
}

/// Weights for which each term of the paper's response counts one.
fn balanced(task: &Task<'_, Ensemble>, member: Member) -> CostWeights {
    CostWeights::balancing(&task.evaluate(&[(member, PAPER)]).unwrap()[0])
}

/// A short search.
fn quick(task: &Task<'_, Ensemble>) -> TunerConfig {
    TunerConfig {
        starts: 2,
        moves: 30,
        ..TunerConfig::for_task(task, STROKE_MM).unwrap()
    }
}

fn tuned(
    task: &Task<'_, Ensemble>,
    member: Member,
    weights: &CostWeights,
    config: &TunerConfig,
) -> Tuned {
    tune(
        task,
        &Plants::judged(&[member]),
        &Goal::of(*weights),
        config,
        |_| ControlFlow::Continue(()),
    )
    .unwrap()
}

fn numbers(terms: &Terms) -> Vec<f64> {
    let step = terms.step.unwrap();
    vec![
        terms.mse,
        terms.energy,
        step.rise_time_s,
        step.settling_time_s,
        step.overshoot,
    ]
}

/// Result of a computation on a number of threads.
fn on_threads<R: Send>(n_threads: usize, work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads);
    pool.build().unwrap().install(work)
}

fn lag_task(breaks_above: f64) -> Task<'static, Lags> {
    let closed_loop = ClosedLoop::new(undisturbed(STEP, 200)).unwrap();
    Task::new(Lags { breaks_above }, closed_loop, PID).unwrap()
}

#[test]
fn responses_side_by_side_have_the_bits_that_each_has_alone() {
    let params = ClosedLoopParams {
        disturbances: Disturbances {
            quantization_step: 5.0 / 4096.0,
            ..Disturbances::default()
        },
        ..undisturbed(STEP, 200)
    };
    let closed_loop = ClosedLoop::new(params).unwrap();
    let case = |n: usize| {
        let share = n as f64 / 40.0;
        let member = at_rest(rod(3.0 + 20.0 * share));
        (member, gains(300.0 * share, 5.0 * share, share))
    };
    let alone = |(member, gains): (Member, PidGains)| {
        let plant = rods(&[member.params]);
        let pid = Pid::new(PID, &[gains]).unwrap();
        let mut plants = at(&plant, plant.rest(AMBIENT_DEGC));
        let mut pid_state = pid.rest(plants.output().displacement).unwrap();
        let mut response = ResponseTerms::new(&STEP, PID.dt_s).unwrap();
        closed_loop.run(&mut plants, &pid, &mut pid_state, |snapshot| {
            response.add(snapshot);
        });
        response.terms()[0]
    };
    let task = task_over(params);
    for n_cases in [0, 1, 2, 8, 9, 25, 33, 40] {
        let cases: Vec<_> = (0..n_cases).map(case).collect();
        let found = task.evaluate(&cases).unwrap();
        assert_eq!(found.len(), n_cases);
        for (found, &case) in found.iter().zip(&cases) {
            assert_same(&numbers(found), &numbers(&alone(case)));
        }
    }
}

#[test]
fn same_seed_same_bits_on_any_number_of_threads() {
    let task = step_task();
    let member = at_rest(rod(6.0));
    let weights = balanced(&task, member);
    let config = quick(&task);
    let one = on_threads(1, || tuned(&task, member, &weights, &config));
    for n_threads in [2, 7] {
        let other = on_threads(n_threads, || tuned(&task, member, &weights, &config));
        // Debug prints every bit.
        assert_eq!(format!("{one:?}"), format!("{other:?}"));
    }
    let another = tuned(&task, member, &weights, &TunerConfig { seed: 1, ..config });
    assert_ne!(format!("{:?}", one.gains), format!("{:?}", another.gains));
}

#[test]
fn the_default_search_does_not_care_about_units() {
    // By a power of two, so that no bit is lost.
    let scale = 1024.0;
    let found = |scale: f64| {
        let mut params = rod(6.0);
        params.gain *= scale;
        params.offset *= scale;
        let reference = Reference::Step {
            from: 0.0,
            to: 0.5 * scale,
            at_s: 0.0,
        };
        let task = task_over(undisturbed(reference, 300));
        let member = at_rest(params);
        let paper = gains(PAPER.kp / scale, PAPER.ki / scale, 0.0);
        let weights = CostWeights::balancing(&task.evaluate(&[(member, paper)]).unwrap()[0]);
        let config = TunerConfig {
            moves: 20,
            ..TunerConfig::for_task(&task, STROKE_MM * scale).unwrap()
        };
        tuned(&task, member, &weights, &config)
    };
    let (millimeters, others) = (found(1.0), found(scale));
    let PidGains { kp, ki, kd } = others.gains;
    assert_eq!(millimeters.gains, gains(kp * scale, ki * scale, kd * scale));
    assert_same(&[millimeters.cost], &[others.cost]);
}

#[test]
fn the_papers_search_has_the_printed_numbers() {
    let config = TunerConfig::sadeghi();
    let GainBounds { lower, upper } = config.bounds;
    let Inertia::Constant(inertia) = config.swarm.weights.inertia else {
        unreachable!("constriction is constant");
    };
    let mut compared = 0;
    for (key, value) in [
        ("pid.swarm.particles", config.swarm.particles as f64),
        ("pid.swarm.iterations", config.moves as f64),
        ("pid.swarm.inertia", inertia),
        ("pid.swarm.cognitive", config.swarm.weights.cognitive),
        ("pid.swarm.social", config.swarm.weights.social),
        ("pid.lower.kp", lower.kp),
        ("pid.lower.ki", lower.ki),
        ("pid.lower.kd", lower.kd),
        ("pid.upper.kp", upper.kp),
        ("pid.upper.ki", upper.ki),
        ("pid.upper.kd", upper.kd),
    ] {
        assert!(
            sadeghi::setting(key).unwrap().agrees(value),
            "{key} {value}"
        );
        compared += 1;
    }
    assert_eq!(compared, 11);
    assert_eq!((config.starts, config.scale), (1, GainScale::Linear));
    let task = step_task();
    let member = at_rest(rod(6.0));
    let found = tuned(&task, member, &balanced(&task, member), &config);
    assert_eq!(found.evaluations, 50 + 50 * 150);
    assert_eq!(found.termination, Termination::Iterations);
}

#[test]
fn a_search_ends_below_the_papers_gains_and_says_how_its_swarms_agree() {
    let task = step_task();
    let member = at_rest(rod(6.0));
    let weights = balanced(&task, member);
    // To the end, so that all evaluations are counted.
    let config = TunerConfig {
        stall: None,
        ..TunerConfig::for_task(&task, STROKE_MM).unwrap()
    };
    let found = tuned(&task, member, &weights, &config);
    let paper = weights.cost(&task.evaluate(&[(member, PAPER)]).unwrap()[0]);
    assert!(found.cost < 0.9 * paper, "{found:?}");
    assert_same(&[found.cost], &[weights.cost(&found.terms)]);
    let of_gains = task.evaluate(&[(member, found.gains)]).unwrap();
    assert_same(&numbers(&found.terms), &numbers(&of_gains[0]));
    assert!((1..=config.starts).contains(&found.agreeing));
    assert_eq!(found.evaluations, 8 * 50 * 151);
    assert_eq!((found.rejected, found.seed), (0, 0));
}

#[test]
fn more_starts_never_end_higher() {
    let task = step_task();
    let member = at_rest(rod(10.0));
    let weights = balanced(&task, member);
    let found = [1, 2, 4].map(|starts| {
        let config = TunerConfig {
            starts,
            ..quick(&task)
        };
        tuned(&task, member, &weights, &config)
    });
    // The first swarm is the same in all of them.
    assert!(found.is_sorted_by(|a, b| a.cost >= b.cost), "{found:?}");
    assert_eq!(found[0].agreeing, 1);
}

#[test]
fn the_default_search_ends_at_the_same_cost_with_any_seed() {
    let task = step_task();
    let member = at_rest(rod(10.0));
    let weights = balanced(&task, member);
    let costs = [1, 2, 3].map(|seed| {
        let config = TunerConfig {
            seed,
            ..TunerConfig::for_task(&task, STROKE_MM).unwrap()
        };
        tuned(&task, member, &weights, &config).cost
    });
    let lowest = costs.into_iter().fold(f64::INFINITY, f64::min);
    assert!(costs.iter().all(|cost| *cost < 1.01 * lowest), "{costs:?}");
}

#[test]
fn energy_alone_asks_for_no_controller() {
    let weights = CostWeights {
        energy: 1.0,
        ..NO_WEIGHTS
    };
    let task = step_task();
    let config = TunerConfig::for_task(&task, STROKE_MM).unwrap();
    let found = tuned(&task, at_rest(rod(6.0)), &weights, &config);
    assert_same(&[found.cost], &[0.0]);
    // Nothing moves, whatever kd is.
    assert_eq!(found.at_bound[..2], [Some(BoundEnd::Lower); 2]);
    let member = at_rest(rod(6.0));
    let second = second_opinion(&task, &[member], &Goal::of(weights), &config, &found).unwrap();
    assert_eq!(second.from_optimum.verdict, Verdict::Agrees);
}

#[test]
fn a_range_that_ends_too_early_is_reported_and_a_fixed_gain_is_not() {
    let weights = CostWeights {
        mse: 1.0,
        ..NO_WEIGHTS
    };
    let task = step_task();
    for scale in [GainScale::Linear, GainScale::Logarithmic] {
        let config = TunerConfig {
            bounds: GainBounds {
                lower: gains(0.1, 0.0, 0.25),
                upper: gains(1.0, 0.1, 0.25),
            },
            scale,
            ..quick(&task)
        };
        let found = tuned(&task, at_rest(rod(6.0)), &weights, &config);
        assert_eq!(found.gains, gains(1.0, 0.1, 0.25));
        let upper = Some(BoundEnd::Upper);
        assert_eq!(found.at_bound, [upper, upper, None]);
    }
}

#[test]
fn the_logarithmic_scale_spreads_decades_and_reaches_zero() {
    let task = step_task();
    let config = |scale, share: f64| TunerConfig {
        swarm: SwarmConfig {
            particles: 1,
            start: SwarmStart::Given(vec![vec![share; 3]]),
            ..SwarmConfig::default()
        },
        starts: 1,
        moves: 0,
        bounds: GainBounds {
            lower: gains(0.0, 0.0, 0.0),
            upper: gains(100.0, 100.0, 100.0),
        },
        scale,
        stall: None,
        seed: 0,
    };
    let weights = CostWeights {
        mse: 1.0,
        ..NO_WEIGHTS
    };
    let at = |scale, share| {
        let found = tuned(&task, at_rest(rod(6.0)), &weights, &config(scale, share));
        assert_eq!(found.evaluations, 1);
        found.gains.kp
    };
    for (share, linear, logarithmic) in [
        (0.0, 0.0, 0.0),
        (0.25, 25.0, 0.09),
        (0.5, 50.0, 0.99),
        (0.75, 75.0, 9.99),
        (1.0, 100.0, 100.0),
    ] {
        assert_near(at(GainScale::Linear, share), linear, 1e-12);
        assert_near(at(GainScale::Logarithmic, share), logarithmic, 0.01);
    }
}

#[test]
fn another_reference_is_judged_by_error_and_energy() {
    let levels = [0.3, 0.6, 0.2];
    let member = at_rest(rod(6.0));
    for reference in [
        Reference::Staircase {
            levels: &levels,
            hold_s: 30.0,
        },
        Reference::Sine {
            bias: 0.5,
            amplitude: 0.2,
            frequency_hz: 0.02,
        },
    ] {
        let task = task_over(undisturbed(reference, 300));
        let weights = balanced(&task, member);
        let found = tuned(&task, member, &weights, &quick(&task));
        assert!(found.terms.step.is_none());
        assert!(found.cost < 2.0, "{found:?}");
        let of_a_step = CostWeights {
            mse: 0.0,
            energy: 0.0,
            rise_time: 1.0,
            ..weights
        };
        assert_eq!(
            text(tune(
                &task,
                &Plants::judged(&[member]),
                &Goal::of(of_a_step),
                &quick(&task),
                |_| { ControlFlow::Continue(()) }
            )),
            NO_WEIGHT
        );
    }
}

#[test]
fn an_output_that_is_no_number_costs_no_number() {
    let task = lag_task(2.0);
    let weights = CostWeights {
        mse: 1.0,
        energy: 0.0,
        rise_time: 1.0,
        settling_time: 1.0,
        overshoot: 1.0,
    };
    // The first drives above 2 at once, the third starts at no number.
    let cases = [
        (1.0, gains(5.0, 0.0, 0.0)),
        (1.0, gains(1.0, 0.1, 0.0)),
        (f64::NAN, gains(1.0, 0.1, 0.0)),
    ];
    let terms = task.evaluate(&cases).unwrap();
    assert!(weights.cost(&terms[0]).is_nan());
    assert!(weights.cost(&terms[1]).is_finite());
    assert!(weights.cost(&terms[2]).is_nan());

    // A search avoids such gains and counts them.
    let config = TunerConfig::for_task(&task, 1.0).unwrap();
    let to_the_end = |_: &_| ControlFlow::Continue(());
    let found = tune(
        &task,
        &Plants::judged(&[1.0]),
        &Goal::of(weights),
        &config,
        to_the_end,
    )
    .unwrap();
    assert!(found.cost.is_finite() && found.rejected > 0, "{found:?}");
    let broken = tune(
        &task,
        &Plants::judged(&[f64::NAN]),
        &Goal::of(weights),
        &config,
        to_the_end,
    );
    assert_eq!(
        text(broken),
        "no gains within the bounds have a finite cost: the plant's output must be a finite number"
    );
}

#[test]
fn an_observer_sees_every_move_and_may_end_the_search() {
    let task = step_task();
    let member = at_rest(rod(6.0));
    let weights = balanced(&task, member);
    let config = quick(&task);
    let mut costs = Vec::new();
    let found = tune(
        &task,
        &Plants::judged(&[member]),
        &Goal::of(weights),
        &config,
        |progress| {
            assert_eq!(progress.moves, costs.len() as u64);
            assert_eq!(progress.evaluations, 2 * 50 * (progress.moves + 1));
            costs.push(progress.best.unwrap().1);
            if progress.moves == 5 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        },
    )
    .unwrap();
    assert_eq!(found.termination, Termination::Observer);
    assert_eq!(found.evaluations, 600);
    assert!(costs.is_sorted_by(|a, b| a >= b), "{costs:?}");
    assert_same(&[found.cost], &[costs[5]]);
}

#[test]
fn pace_leads_from_gentle_to_fast() {
    let task = step_task();
    let config = TunerConfig::for_task(&task, STROKE_MM).unwrap();
    let calm = gains(6.0, 1.2, 0.0);
    for (tau_s, reference) in [(3.0, calm), (6.0, calm), (10.0, PAPER)] {
        let member = at_rest(rod(tau_s));
        let terms = task.evaluate(&[(member, reference)]).unwrap()[0];
        let balanced = CostWeights::balancing(&terms);
        let speed = CostWeights {
            energy: 0.0,
            overshoot: 0.0,
            ..balanced
        };
        let found: Vec<_> = [0.0, 0.25, 0.5, 0.75, 1.0]
            .into_iter()
            .map(|pace| {
                let weights = Pace::new(pace).unwrap().weigh(&balanced);
                let terms = tuned(&task, member, &weights, &config).terms;
                let slowness = speed.cost(&terms);
                let effort = balanced.cost(&terms) - slowness;
                (slowness, effort, terms.step.unwrap().rise_time_s)
            })
            .collect();
        // A search ends within a per cent or so of the lowest cost, with terms a little further off.
        for pair in found.windows(2) {
            let ((slowness, effort, rise_s), faster) = (pair[0], pair[1]);
            assert!(faster.0 <= 1.02 * slowness, "{tau_s} s: {found:?}");
            assert!(faster.1 >= 0.98 * effort, "{tau_s} s: {found:?}");
            assert!(faster.2 <= 1.05 * rise_s, "{tau_s} s: {found:?}");
        }
        assert!(found[4].0 < found[0].0, "{tau_s} s: {found:?}");
        assert!(found[4].1 > found[0].1, "{tau_s} s: {found:?}");
    }
}

#[test]
fn pace_moves_two_kinds_of_terms_against_each_other() {
    let balanced = CostWeights {
        mse: 2.0,
        energy: 3.0,
        rise_time: 5.0,
        settling_time: 7.0,
        overshoot: 11.0,
    };
    assert_eq!(Pace::BALANCED, Pace::new(0.5).unwrap());
    assert_eq!(Pace::BALANCED.weigh(&balanced), balanced);
    for (pace, faster) in [(0.0, 0.1_f64.sqrt()), (0.75, 10_f64.sqrt()), (1.0, 10.0)] {
        let found = Pace::new(pace).unwrap().weigh(&balanced);
        assert_near(found.mse, 2.0 * faster, 1e-12);
        assert_near(found.rise_time, 5.0 * faster, 1e-12);
        assert_near(found.settling_time, 7.0 * faster, 1e-12);
        assert_near(found.energy, 3.0 / faster, 1e-12);
        assert_near(found.overshoot, 11.0 / faster, 1e-12);
    }
}

#[test]
fn a_simplex_agrees_with_a_search_and_exposes_a_poor_one() {
    let task = step_task();
    let member = at_rest(rod(6.0));
    let weights = balanced(&task, member);
    let config = TunerConfig::for_task(&task, STROKE_MM).unwrap();
    let found = tuned(&task, member, &weights, &config);
    let second = second_opinion(&task, &[member], &Goal::of(weights), &config, &found).unwrap();
    let there = second.from_optimum;
    assert_eq!(there.verdict, Verdict::Agrees, "{second:?}");
    assert_near(there.start.kp / found.gains.kp, 1.0, 1e-9);
    assert_near(there.ratio, there.cost / found.cost, 1e-15);
    assert!((1..2000).contains(&there.evaluations));
    let boasting = Tuned {
        lowest: 0.5 * found.lowest,
        ..found
    };
    let second = second_opinion(&task, &[member], &Goal::of(weights), &config, &boasting).unwrap();
    assert_eq!(second.from_optimum.verdict, Verdict::EndedHigher);
    assert_near(second.from_optimum.ratio, 2.0 * there.ratio, 1e-6);

    let poor = TunerConfig {
        swarm: SwarmConfig {
            particles: 2,
            ..SwarmConfig::default()
        },
        starts: 1,
        moves: 0,
        ..config
    };
    let found = tuned(&task, member, &weights, &poor);
    let second = second_opinion(&task, &[member], &Goal::of(weights), &poor, &found).unwrap();
    assert_eq!(second.from_optimum.verdict, Verdict::EndedLower);
    assert!(second.from_optimum.ratio < 0.99);
    let again = second_opinion(&task, &[member], &Goal::of(weights), &poor, &found).unwrap();
    assert_eq!(format!("{second:?}"), format!("{again:?}"));
}

const NO_WEIGHT: &str =
    "no weight is > 0 on a term that responses to this reference have: at least 1 must be";

fn text<T: std::fmt::Debug, E: Error>(result: Result<T, E>) -> String {
    result.unwrap_err().to_string()
}

#[test]
fn every_error_says_what_is_wrong() {
    let task = step_task();
    let member = at_rest(rod(6.0));
    let config = quick(&task);
    let weights = balanced(&task, member);
    let refused = |weights: &CostWeights, config: &TunerConfig| {
        text(tune(
            &task,
            &Plants::judged(&[member]),
            &Goal::of(*weights),
            config,
            |_| ControlFlow::Continue(()),
        ))
    };

    assert_eq!(
        text(task.evaluate(&[(member, PAPER), (member, gains(1.0, -1.0, 0.0))])),
        "ki = -1: must be finite and >= 0"
    );
    assert_eq!(
        text(task.evaluate(&[(member, gains(f64::NAN, 0.0, 0.0))])),
        "kp = NaN: must be finite and >= 0"
    );
    let no_levels = undisturbed(
        Reference::Staircase {
            levels: &[],
            hold_s: 1.0,
        },
        10,
    );
    assert_eq!(
        text(ClosedLoop::new(no_levels)),
        "levels has no values; at least 1 is needed"
    );
    let with = |pid| text(Task::new(RODS, *task.closed_loop(), pid));
    let limits = DriveLimits {
        lower: 0.0,
        upper: 0.0,
    };
    assert_eq!(
        with(PidParams { limits, ..PID }),
        "the drive is limited to 0 .. 0: both must be finite, the lower below the upper"
    );
    assert_eq!(
        with(PidParams { dt_s: 0.0, ..PID }),
        "dt_s = 0: must be finite and > 0"
    );
    for (stroke, shown) in [(0.0, "0"), (f64::NAN, "NaN")] {
        assert_eq!(
            text(TunerConfig::for_task(&task, stroke)),
            format!("stroke = {shown}: must be finite and > 0")
        );
    }
    assert_eq!(refused(&NO_WEIGHTS, &config), NO_WEIGHT);
    let no_number = CostWeights {
        overshoot: f64::NAN,
        ..weights
    };
    assert_eq!(
        refused(&no_number, &config),
        "overshoot = NaN: must be finite and >= 0"
    );
    let none = TunerConfig {
        starts: 0,
        ..config.clone()
    };
    assert_eq!(refused(&weights, &none), "starts = 0: must be at least 1");
    for (pace, shown) in [(-0.1, "-0.1"), (1.5, "1.5"), (f64::NAN, "NaN")] {
        assert_eq!(
            text(Pace::new(pace)),
            format!("pace = {shown}: must lie in 0 .. 1")
        );
    }
}

#[test]
fn bounds_must_not_fall() {
    let task = step_task();
    let member = at_rest(rod(6.0));
    let weights = balanced(&task, member);
    for (lower, upper, shown) in [
        (3.0, 2.0, "3 .. 2"),
        (-1.0, 2.0, "-1 .. 2"),
        (f64::NAN, 2.0, "NaN .. 2"),
        (0.0, f64::NAN, "0 .. NaN"),
        (0.0, f64::INFINITY, "0 .. inf"),
    ] {
        let mut config = quick(&task);
        config.bounds.lower.ki = lower;
        config.bounds.upper.ki = upper;
        assert_eq!(
            text(tune(
                &task,
                &Plants::judged(&[member]),
                &Goal::of(weights),
                &config,
                |_| { ControlFlow::Continue(()) }
            )),
            format!(
                "ki is looked for in {shown}: both must be finite and >= 0, the lower at most the upper"
            )
        );
    }
}

#[test]
fn what_lies_below_is_the_source_of_an_error() {
    let task = step_task();
    let mut member = at_rest(rod(6.0));
    let weights = balanced(&task, member);
    let config = TunerConfig {
        swarm: SwarmConfig {
            particles: 0,
            ..SwarmConfig::default()
        },
        ..quick(&task)
    };
    let refused = tune(
        &task,
        &Plants::judged(&[member]),
        &Goal::of(weights),
        &config,
        |_| ControlFlow::Continue(()),
    )
    .unwrap_err();
    assert_eq!(refused.to_string(), "swarm");
    assert_eq!(
        refused.source().unwrap().to_string(),
        "particles = 0: must be at least 1"
    );
    assert!(matches!(refused, TaskError::Tune(TuneError::Swarm(_))));

    member.params.zeta = 2.0;
    let refused = task.evaluate(&[(member, PAPER)]).unwrap_err();
    assert_eq!(refused.to_string(), "plant");
    assert!(refused.source().unwrap().source().is_some());

    let failed = TuneError::SecondOpinion {
        said: "no".to_owned(),
    };
    assert_eq!(failed.to_string(), "second opinion: no");
}

#[test]
fn a_search_ends_where_swarms_agree_and_nothing_gets_better() {
    let task = step_task();
    let member = at_rest(rod(6.0));
    let weights = balanced(&task, member);
    let config = TunerConfig {
        starts: 4,
        ..TunerConfig::for_task(&task, STROKE_MM).unwrap()
    };
    let whole = TunerConfig {
        stall: None,
        ..config.clone()
    };
    let [short, whole] = [&config, &whole].map(|config| tuned(&task, member, &weights, config));
    assert_eq!(short.termination, Termination::Stall);
    assert_eq!(whole.termination, Termination::Iterations);
    assert!(short.evaluations < whole.evaluations && short.agreeing >= 3);
    assert!(
        short.cost <= 1.01 * whole.cost,
        "{} {}",
        short.cost,
        whole.cost
    );
}
