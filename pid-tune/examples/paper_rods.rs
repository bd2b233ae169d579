//! How good are the gains of the paper? Three rods like its own are given its step of 0.5 mm; what its gains
//! cost there is compared with the lowest cost that swarms and a simplex find, and both follow a sine.
//!
//! Prints Markdown. Output in mm, drive in A.

#![allow(clippy::print_stdout, reason = "an example talks")]

use std::error::Error;
use std::ops::ControlFlow;

use fixtures::sadeghi;
use pid_tune::{
    AntiWindup, ClosedLoop, ClosedLoopParams, CostWeights, DerivativeOf, Disturbances, DriveLimits,
    Goal, PidGains, PidParams, Plants, Reference, RelayTest, Requirements, Response, RestTest,
    Screen, SmallChanges, Task, TunerConfig, second_opinion, tune,
};
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::{HeatBalanceParams, ThermalConstants};
use wiener::{Drive, Ensemble, Member, Plant, Start, Wiener, WienerParams};

const AMBIENT_DEGC: f64 = 22.0;
const UPPER_A: f64 = 3.0;
/// 172 s.
const STEP_SAMPLES: usize = 600;
/// Three periods, 430 s.
const SINE_SAMPLES: usize = 1497;

struct PaperRod {
    name: &'static str,
    tau_s: f64,
    loop_center_degc: f64,
    loop_spread_k: f64,
}

/// λ = 15 K/A²: 3 A heat by 135 K, well through all three loops.
const PAPER_RODS: [PaperRod; 3] = [
    PaperRod {
        name: "slow",
        tau_s: 30.0,
        loop_center_degc: 75.0,
        loop_spread_k: 6.0,
    },
    PaperRod {
        name: "middle",
        tau_s: 10.0,
        loop_center_degc: 65.0,
        loop_spread_k: 4.5,
    },
    PaperRod {
        name: "fast",
        tau_s: 3.0,
        loop_center_degc: 55.0,
        loop_spread_k: 3.0,
    },
];

fn printed(key: &str) -> Result<f64, Box<dyn Error>> {
    Ok(sadeghi::setting(key)?.value())
}

fn printed_gains(set: &str) -> Result<PidGains, Box<dyn Error>> {
    Ok(PidGains {
        kp: printed(&format!("pid.{set}.kp"))?,
        ki: printed(&format!("pid.{set}.ki"))?,
        kd: printed(&format!("pid.{set}.kd"))?,
    })
}

/// A rod at rest, at 0 mm.
fn member(rod: &PaperRod) -> Result<Member, Box<dyn Error>> {
    let heat = HeatBalanceParams::from_constants(ThermalConstants {
        tau_s: rod.tau_s,
        lambda_k_per_a2: 15.0,
    });
    let mut params = WienerParams {
        heat,
        limiting_loop: LoopParams {
            loop_center_degc: rod.loop_center_degc,
            loop_half_width_k: 8.0,
            loop_spread_k: rod.loop_spread_k,
            ..LoopParams::default()
        },
        zeta: 0.85,
        gain: printed("rig.stroke")?,
        offset: 0.0,
    };
    // A rod at rest remembers nothing: any rule will do.
    let at_rest = Wiener::new(Drive::Current, Rule::Nested, &[params])?;
    let [displacement] = at_rest.output(&at_rest.rest(AMBIENT_DEGC)).displacement;
    params.offset = -displacement;
    Ok(Member {
        params,
        start: Start::rest(AMBIENT_DEGC),
    })
}

fn task(
    rule: Rule,
    reference: Reference<'_>,
    n_samples: usize,
) -> Result<Task<'_, Ensemble>, Box<dyn Error>> {
    let rods = Ensemble {
        drive: Drive::Current,
        rule,
    };
    let closed_loop = ClosedLoop::new(ClosedLoopParams {
        reference,
        n_samples,
        ambient_degc: AMBIENT_DEGC,
        feed_forward: None,
        aim: None,
        disturbances: Disturbances {
            quantization_step: printed("rig.lvdt_range")? / printed("rig.converter_bits")?.exp2(),
            ..Disturbances::default()
        },
    })?;
    let params = PidParams {
        dt_s: printed("rig.sample_time")?,
        limits: DriveLimits {
            lower: 0.0,
            upper: UPPER_A,
        },
        anti_windup: AntiWindup::Clamping,
        derivative_of: DerivativeOf::Measurement,
        derivative_filter_s: 0.0,
        setpoint_weight: 1.0,
        gain_schedule: None,
    };
    Ok(Task::new(rods, closed_loop, params)?)
}

struct Controller {
    name: &'static str,
    gains: PidGains,
}

/// The paper's controllers and what the searches find, for one rod.
fn controllers(
    task: &Task<'_, Ensemble>,
    rod: Member,
    weights: &CostWeights,
) -> Result<Vec<Controller>, Box<dyn Error>> {
    let paper = TunerConfig::sadeghi();
    let of_paper = tune(
        task,
        &Plants::judged(&[rod]),
        &Goal::of(*weights),
        &paper,
        |_| ControlFlow::Continue(()),
    )?;
    let default = TunerConfig::for_task(task, printed("rig.stroke")?)?;
    let of_default = tune(
        task,
        &Plants::judged(&[rod]),
        &Goal::of(*weights),
        &default,
        |_| ControlFlow::Continue(()),
    )?;
    let simplex = second_opinion(task, &[rod], &Goal::of(*weights), &default, &of_default)?;
    println!(
        "Default search: {} responses, {} of {} swarms within 1 % of its cost, at a bound {:?}. Simplex from \
         there: {:?}; from elsewhere: {:?}.\n",
        of_default.evaluations,
        of_default.agreeing,
        default.starts,
        of_default.at_bound,
        simplex.from_optimum.verdict,
        simplex.from_elsewhere.verdict,
    );
    Ok([
        ("paper, found", printed_gains("found")?),
        ("paper, used", printed_gains("used")?),
        ("paper's search", of_paper.gains),
        ("default search", of_default.gains),
        ("simplex from there", simplex.from_optimum.gains),
        ("simplex from elsewhere", simplex.from_elsewhere.gains),
    ]
    .into_iter()
    .map(|(name, gains)| Controller { name, gains })
    .collect())
}

fn responses(
    task: &Task<'_, Ensemble>,
    rod: Member,
    controllers: &[Controller],
) -> Result<Vec<Response>, Box<dyn Error>> {
    let cases: Vec<_> = controllers.iter().map(|one| (rod, one.gains)).collect();
    Ok(task.responses(&cases)?)
}

fn print_step(controllers: &[Controller], responses: &[Response], weights: &CostWeights) {
    let costs = responses.iter().map(|shown| weights.cost(&shown.terms));
    let lowest = costs.fold(f64::INFINITY, f64::min);
    println!(
        "| controller | kp, A/mm | ki, A/(mm s) | kd, A s/mm | MSE, µm² | energy, A² s | rise, s | settling, s \
         | overshoot, % | cost | cost/lowest | steady-state error, µm | swing at the end, µm | saturated, % |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    for (Controller { name, gains }, Response { terms, ending }) in
        controllers.iter().zip(responses)
    {
        let Some(step) = terms.step else { continue };
        let cost = weights.cost(terms);
        print!(
            "| {name} | {:.4} | {:.4} | {:.4} ",
            gains.kp, gains.ki, gains.kd
        );
        print!("| {:.0} | {:.1} ", 1e6 * terms.mse, terms.energy);
        let overshoot_percent = 100.0 * step.overshoot;
        print!(
            "| {:.2} | {:.1} | {overshoot_percent:.1} ",
            step.rise_time_s, step.settling_time_s
        );
        println!(
            "| {cost:.3} | {:.3} | {:.2} | {:.1} | {:.1} |",
            cost / lowest,
            1e3 * ending.mean_error,
            1e3 * ending.swing,
            100.0 * ending.saturated_share,
        );
    }
}

fn print_sine(controllers: &[Controller], responses: &[Response]) {
    println!("| controller | RMSE, µm | energy, A² s | mean error at the end, µm | saturated, % |");
    println!("|---|--:|--:|--:|--:|");
    for (Controller { name, .. }, Response { terms, ending }) in controllers.iter().zip(responses) {
        println!(
            "| {name} | {:.1} | {:.1} | {:.2} | {:.1} |",
            1e3 * terms.mse.sqrt(),
            terms.energy,
            1e3 * ending.mean_error,
            100.0 * ending.saturated_share,
        );
    }
}

/// Controllers that keep equal margins and move the drive equally little for a step of the sensor: tuned, and by rule.
fn print_equals(rod: &PaperRod, level: f64) -> Result<(), Box<dyn Error>> {
    let member = member(rod)?;
    let step = Reference::Step {
        from: 0.0,
        to: level,
        at_s: 0.0,
    };
    let ideal = task(Rule::LastReversal, step, STEP_SAMPLES)?;
    let mut params = *ideal.closed_loop().params();
    params.disturbances.dead_time_samples = 1;
    let sensor_step = params.disturbances.quantization_step;
    let pid = *ideal.pid();
    let rods = Ensemble {
        drive: Drive::Current,
        rule: Rule::LastReversal,
    };
    let task = Task::new(rods, ClosedLoop::new(params)?, pid)?;
    let changes = SmallChanges {
        limits: pid.limits,
        ambient_degc: AMBIENT_DEGC,
        dt_s: pid.dt_s,
        tau_s: rod.tau_s,
        outputs: [0.0, 1.05 * level],
        dead_time_samples: 1,
    };
    let required = Requirements {
        gain_margin: 2.0,
        phase_margin_rad: 45.0_f64.to_radians(),
        sensor_step,
        largest_kick: 0.05,
    };
    let screen = Screen::new(required, pid, changes.steepest(&rods, member)?)?;
    let simc = screen
        .simc()
        .ok_or("no gains of SIMC meet what is required")?;
    let relay = RelayTest {
        limits: pid.limits,
        ambient_degc: AMBIENT_DEGC,
        dt_s: pid.dt_s,
        tau_s: rod.tau_s,
        setpoint: level,
        dead_time_samples: 1,
        hysteresis: 2.0 * sensor_step,
    };
    let cycle = relay
        .run(&rods, member)?
        .ok_or("no cycle in a relay test")?;
    let relay = screen
        .relay(&cycle)
        .ok_or("no gains of a relay test meet what is required")?;
    let [before] = task.evaluate(&[(member, simc)])?[..] else {
        return Err("one case has one response".into());
    };
    let loops = [*task.closed_loop()];
    let goal = Goal {
        screen: Some(&screen),
        rest: Some(RestTest {
            loops: &loops,
            height: level,
            drive_swing: 0.2 * UPPER_A,
        }),
        ..Goal::of(CostWeights {
            mse: 1.0 / before.mse,
            ..CostWeights::balancing(&before)
        })
    };
    let config = TunerConfig::for_task(&task, printed("rig.stroke")?)?;
    let to_the_end = |_: &_| ControlFlow::Continue(());
    let found = tune(
        &task,
        &Plants::judged(&[member]),
        &goal,
        &config,
        to_the_end,
    )?;
    println!(
        "| {} rod | kp, A/mm | ki, A/(mm s) | MSE, µm² | MSE over tuned | settling, s | gain margin | phase margin, ° | drive moved, % |",
        rod.name
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|");
    let named = [
        ("tuned", found.gains),
        ("SIMC", simc),
        ("relay test", relay),
    ];
    for (name, gains) in named {
        let [terms] = task.evaluate(&[(member, gains)])?[..] else {
            continue;
        };
        let (Some(margins), Some(step)) = (screen.margins(&gains), terms.step) else {
            continue;
        };
        println!(
            "| {name} | {:.4} | {:.4} | {:.0} | {:.3} | {:.1} | {:.2} | {:.1} | {:.2} |",
            gains.kp,
            gains.ki,
            1e6 * terms.mse,
            terms.mse / found.terms.mse,
            step.settling_time_s,
            margins.gain_margin,
            margins.phase_margin_rad.to_degrees(),
            100.0 * screen.kick(&gains),
        );
    }
    println!();
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let level = printed("reference.step")?;
    let step = Reference::Step {
        from: 0.0,
        to: level,
        at_s: 0.0,
    };
    let sine = Reference::Sine {
        bias: level,
        amplitude: 0.2,
        frequency_hz: printed("reference.sine_frequency")?,
    };
    println!("# The paper's gains on rods like the paper's\n");
    println!(
        "Step to {level} mm: each term of the response of \"paper, used\" costs 1. Below it, the"
    );
    println!("same gains at a sine of 0.007 Hz, {level} ± 0.2 mm, from rest at 0 mm.\n");
    for rule in [Rule::LastReversal, Rule::Nested] {
        for rod in &PAPER_RODS {
            println!(
                "## {} rod: τ {} s, loop around {} °C, spread {} K; memory {rule:?}\n",
                rod.name, rod.tau_s, rod.loop_center_degc, rod.loop_spread_k
            );
            let member = member(rod)?;
            let at_step = task(rule, step, STEP_SAMPLES)?;
            let paper = at_step.evaluate(&[(member, printed_gains("used")?)])?;
            let weights = CostWeights::balancing(&paper[0]);
            let controllers = controllers(&at_step, member, &weights)?;
            let shown = responses(&at_step, member, &controllers)?;
            print_step(&controllers, &shown, &weights);
            println!();
            let at_sine = task(rule, sine, SINE_SAMPLES)?;
            print_sine(&controllers, &responses(&at_sine, member, &controllers)?);
            println!();
        }
    }
    println!("## Equal margins and noise: tuned, and by rule\n");
    for rod in &PAPER_RODS {
        print_equals(rod, level)?;
    }
    Ok(())
}
