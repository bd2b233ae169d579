//! How fast one job is simulated: scalar, in lockstep, and as a fit.
//!
//! `cargo run --release -p benches --bin speed_ratios` prints a Markdown table. All on one thread, the least time of
//! several repetitions that take turns, and compared with a plain loop on the `sin` and `atan` of
//! the standard library. The recording stands beside the workspace.

#![allow(clippy::print_stdout, reason = "the table is the result")]

use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;
use std::time::Instant;

use benches::{Job, ROD_TOML};
use identify::{FitConfig, WienerModel, fit};
use pso::{Stop, Swarm, SwarmConfig};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::ThreadPoolBuilder;
use rig_files::rod_file;
use wiener::hysteresis::Rule;
use wiener::{Drive, Plant, Wiener, WienerParams, run};

type Failure = Box<dyn Error + Send + Sync>;

const COMMAND: &str = "cargo run --release -p benches --bin speed_ratios";
const N_REPETITIONS: usize = 7;
const N_MOVES: u64 = 150;
const SEED: u64 = 1;
/// Time of a fit over that of the simulations of one swarm run one by one: what a fit may take.
const LARGEST_RATIO: f64 = 0.03;

/// All points that a swarm evaluates, iteration after iteration: what a fit really simulates.
fn visited(job: &Job) -> Result<Vec<Vec<Vec<f64>>>, Failure> {
    let generator = ChaCha8Rng::seed_from_u64(SEED);
    let mut swarm = Swarm::new(SwarmConfig::reliable(), job.bounds(), generator)?;
    let stop = Stop {
        iterations: Some(N_MOVES),
        ..Stop::default()
    };
    let mut visited = Vec::new();
    while swarm.finished(&stop)?.is_none() {
        visited.push(swarm.ask().to_vec());
        let costs = job.costs(swarm.ask())?;
        swarm.tell(&costs)?;
    }
    Ok(visited)
}

/// Mean squared error by a plain loop, with the elementary functions of the standard library.
fn plain_cost(job: &Job, params: &WienerParams, dt_s: f64) -> f64 {
    let (heat, limits) = (&params.heat, &params.limiting_loop);
    let tau_s = heat.heat_capacity_j_per_m_k / heat.conductance_w_per_m_k;
    let lambda_k_per_a2 = heat.resistance_ohm_per_m / heat.conductance_w_per_m_k;
    let retained = (-dt_s / tau_s).exp();
    let swing = 2.0 * limits.fraction_swing / PI;
    let mut temperature_k = job.ambient_degc() - limits.loop_center_degc;
    let ambient_k = temperature_k;
    let mut sign = -1.0;
    let mut reversal_k = temperature_k;
    let mut proximity_k = 0.0;
    let mut rate_per_k = 0.0;
    let mut level_k = temperature_k + limits.loop_half_width_k;
    let mut sum = 0.0;
    for (current_a, y) in job.recording().drive().iter().zip(job.recording().output()) {
        let fraction = swing * (level_k / limits.loop_spread_k).atan() + limits.fraction_center;
        sum += (params.gain * fraction + params.offset - y).powi(2);

        let balance_k = ambient_k + current_a * current_a * lambda_k_per_a2;
        let next_k = balance_k + (temperature_k - balance_k) * retained;
        if sign * (next_k - temperature_k) < 0.0 {
            sign = -sign;
            reversal_k = temperature_k;
            proximity_k = level_k + sign * limits.loop_half_width_k - temperature_k;
            rate_per_k = if proximity_k.abs() > 1e-9 {
                params.zeta / proximity_k
            } else {
                0.0
            };
        }
        temperature_k = next_k;
        let angle = (rate_per_k * (temperature_k - reversal_k)).clamp(0.0, FRAC_PI_2);
        level_k =
            temperature_k - sign * limits.loop_half_width_k + proximity_k * (1.0 - angle.sin());
    }
    sum / job.recording().len() as f64
}

/// Mean squared error by the library's loop over one model.
fn scalar_cost(job: &Job, params: &WienerParams) -> Result<f64, Failure> {
    let model = Wiener::new(
        Drive::Current,
        Rule::LastReversal,
        std::array::from_ref(params),
    )?;
    let output = job.recording().output();
    let mut sum = 0.0;
    run(
        &model,
        &mut model.rest(job.ambient_degc()),
        &job.profile()?,
        |k, shown| {
            let error = shown.displacement[0] - output[k];
            sum += error * error;
        },
    );
    Ok(sum / output.len() as f64)
}

/// A way to do the job: its name, how many simulations it takes, and the least time so far, s.
struct Entry {
    name: &'static str,
    simulations: u64,
    time_s: f64,
}

/// Runs a way once more.
fn again<T>(entry: &mut Entry, work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    let begin = Instant::now();
    let result = work()?;
    entry.time_s = entry.time_s.min(begin.elapsed().as_secs_f64());
    Ok(result)
}

fn main() -> Result<(), Failure> {
    let job = Job::load()?;
    let training = [job.recording().clone()];
    let rod = rod_file::parse("rod.toml", ROD_TOML)?;
    let model = WienerModel::new(&rod, Rule::LastReversal, &training)?;
    let visited = visited(&job)?;
    let points = visited.concat();
    let dt_s = job.dt_s();
    let one_thread = ThreadPoolBuilder::new().num_threads(1).build()?;

    let n_simulations = points.len() as u64;
    let entry = |name| Entry {
        name,
        simulations: n_simulations,
        time_s: f64::INFINITY,
    };
    let mut plain = entry("plain loop, `f64::sin` and `f64::atan`");
    let mut scalar = entry("`wiener::run`");
    let mut lockstep = entry("`Ensemble`, 50 members a batch");
    let mut full = entry("`Ensemble`, 32 members a batch");
    let mut fitted = entry("`identify::fit`, default");
    for _ in 0..N_REPETITIONS {
        let plain_costs = again(&mut plain, || {
            let cost = |point: &Vec<f64>| plain_cost(&job, &job.params(point), dt_s);
            Ok(points.iter().map(cost).collect::<Vec<f64>>())
        })?;
        let scalar_costs = again(&mut scalar, || {
            let cost = |point: &Vec<f64>| scalar_cost(&job, &job.params(point));
            points.iter().map(cost).collect::<Result<Vec<f64>, _>>()
        })?;
        let lockstep_costs = again(&mut lockstep, || {
            let costs = |batch: &Vec<Vec<f64>>| Ok(job.costs(batch)?);
            Ok(visited
                .iter()
                .map(costs)
                .collect::<Result<Vec<_>, Failure>>()?
                .concat())
        })?;
        let full_costs = again(&mut full, || {
            let costs = |batch: &[Vec<f64>]| Ok(job.costs(batch)?);
            Ok(points
                .chunks(32)
                .map(costs)
                .collect::<Result<Vec<_>, Failure>>()?
                .concat())
        })?;
        let fit = again(&mut fitted, || {
            let fitting = || {
                fit(&model, &training, &FitConfig::default(), &mut |_| {
                    ControlFlow::Continue(())
                })
            };
            Ok(one_thread.install(fitting)?)
        })?;
        fitted.simulations = fit.simulations;

        let equal = |other: &[f64]| {
            let bits = |costs: &[f64]| costs.iter().map(|cost| cost.to_bits()).collect::<Vec<_>>();
            bits(&scalar_costs) == bits(other)
        };
        if !equal(&lockstep_costs) || !equal(&full_costs) {
            return Err("lanes and scalar differ in their bits".into());
        }
        let farthest = (plain_costs.iter().zip(&scalar_costs))
            .map(|(plain, scalar)| (plain / scalar - 1.0).abs())
            .fold(0.0, f64::max);
        if farthest > 1e-9 {
            return Err(format!("plain loop and library differ by {farthest:e}").into());
        }
    }

    let n_samples = job.recording().len();
    println!(
        "| {n_samples} samples, one thread | simulations | s | ns a sample | time / plain loop | the same, a simulation |\n\
         |---|---|---|---|---|---|"
    );
    let each_s = |entry: &Entry| entry.time_s / entry.simulations as f64;
    for entry in [&plain, &scalar, &lockstep, &full, &fitted] {
        println!(
            "| {} | {} | {:.3} | {:.2} | {:.3} | {:.3} |",
            entry.name,
            entry.simulations,
            entry.time_s,
            1e9 * each_s(entry) / n_samples as f64,
            entry.time_s / plain.time_s,
            each_s(entry) / each_s(&plain),
        );
    }
    let ratio = fitted.time_s / scalar.time_s;
    println!(
        "\n`identify::fit` against {n_simulations} runs of `wiener::run`: {ratio:.3} of their time; the bound of \
         {LARGEST_RATIO} is {}.\n",
        if ratio <= LARGEST_RATIO {
            "kept"
        } else {
            "missed"
        },
    );
    println!(
        "`Ensemble` of 50 against `wiener::run`: {:.1} x as fast; of 32: {:.1} x.\n\
         Command: `{COMMAND}`; least of {N_REPETITIONS} repetitions that take turns.",
        each_s(&scalar) / each_s(&lockstep),
        each_s(&scalar) / each_s(&full),
    );
    Ok(())
}
