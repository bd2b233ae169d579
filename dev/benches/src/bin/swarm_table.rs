//! Median final cost of the `pso` presets and of argmin's `ParticleSwarm` on the published functions.
//!
//! `cargo run --release -p benches --bin swarm_table` prints the table of `pso/README.md`. All swarms
//! have the same bounds, particles and evaluations; argmin's keeps its default weights.

use argmin::core::{CostFunction, Error, Executor};
use argmin::solver::particleswarm::ParticleSwarm;
use pso::test_functions::{PUBLISHED, TestFunction};
use pso::{Stop, SwarmConfig, minimize};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::io::Write;
use std::ops::ControlFlow;

const N_SEEDS: u64 = 50;
const N_PARTICLES: usize = 50;
const N_MOVES: u64 = 1000;

/// A test function in the form that argmin takes.
struct Problem(TestFunction);

impl CostFunction for Problem {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, point: &Vec<f64>) -> Result<f64, Error> {
        Ok((self.0.cost)(point))
    }
}

/// Final cost of argmin's swarm; it evaluates the starts and then moves, as ours does.
fn argmin_cost(function: TestFunction, n_dimensions: usize, seed: u64) -> Result<f64, Error> {
    let bounds = (
        vec![function.domain.lower; n_dimensions],
        vec![function.domain.upper; n_dimensions],
    );
    let solver =
        ParticleSwarm::new(bounds, N_PARTICLES).with_rng_generator(ChaCha8Rng::seed_from_u64(seed));
    let result = Executor::new(Problem(function), solver)
        .configure(|state| state.max_iters(N_MOVES))
        .timer(false)
        .run()?;
    Ok(result.state().get_best_cost())
}

/// Final cost of one of our presets; +∞ if there was none.
fn preset_cost(
    config: &SwarmConfig,
    function: TestFunction,
    n_dimensions: usize,
    seed: u64,
) -> Result<f64, Error> {
    let config = SwarmConfig {
        particles: N_PARTICLES,
        ..config.clone()
    };
    let stop = Stop {
        iterations: Some(N_MOVES),
        ..Stop::default()
    };
    let report = minimize(
        config,
        &function.bounds(n_dimensions),
        &stop,
        ChaCha8Rng::seed_from_u64(seed),
        function.cost,
        |_| ControlFlow::Continue(()),
    )?;
    Ok(report.best.map_or(f64::INFINITY, |best| best.cost))
}

/// Median of the costs, and the share below the threshold of success.
fn cell(
    function: TestFunction,
    cost: impl Fn(u64) -> Result<f64, Error> + Sync + Send,
) -> Result<String, Error> {
    let mut costs = (0..N_SEEDS)
        .into_par_iter()
        .map(cost)
        .collect::<Result<Vec<f64>, Error>>()?;
    costs.sort_by(f64::total_cmp);
    let middle = costs.len() / 2;
    let median = 0.5 * (costs[middle - 1] + costs[middle]);
    let n_successes = costs
        .iter()
        .filter(|&&cost| cost < function.threshold)
        .count();
    Ok(format!(
        "{median:.1e} ({:.0} %)",
        100.0 * n_successes as f64 / costs.len() as f64
    ))
}

fn main() -> Result<(), Error> {
    let presets = [
        ("`reliable`", SwarmConfig::reliable()),
        ("`patient`", SwarmConfig::patient()),
        ("`sadeghi_tuning`", SwarmConfig::sadeghi_tuning()),
        (
            "`sadeghi_identification`",
            SwarmConfig::sadeghi_identification(),
        ),
    ];
    let mut out = std::io::stdout().lock();
    write!(out, "| function | dimensions | success below |")?;
    for (name, _) in &presets {
        write!(out, " {name} |")?;
    }
    writeln!(out, " argmin 0.11 |")?;
    writeln!(out, "|---|---|---|{}---|", "---|".repeat(presets.len()))?;
    for function in PUBLISHED {
        for n_dimensions in [10, 30] {
            write!(
                out,
                "| {} | {n_dimensions} | {} |",
                function.name, function.threshold
            )?;
            for (_, config) in &presets {
                let text = cell(function, |seed| {
                    preset_cost(config, function, n_dimensions, seed)
                })?;
                write!(out, " {text} |")?;
            }
            let text = cell(function, |seed| argmin_cost(function, n_dimensions, seed))?;
            writeln!(out, " {text} |")?;
            out.flush()?;
        }
    }
    Ok(())
}
