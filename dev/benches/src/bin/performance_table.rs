//! How often swarms and fits end at the floor of one job: a recording simulated from a known truth.
//!
//! `cargo run --release -p benches --bin performance_table` prints two Markdown tables. All swarms have the
//! same bounds, particles and evaluations; argmin's keeps its default weights. The recording stands
//! beside the workspace.

#![allow(clippy::print_stdout, reason = "the tables are the result")]

use std::error::Error;
use std::ops::ControlFlow;
use std::time::Instant;

use argmin::core::{CostFunction, Executor, SyncAlias};
use argmin::solver::particleswarm::ParticleSwarm;
use benches::{Job, ROD_TOML};
use identify::{Fit, FitConfig, ForwardModel, SadeghiModel, WienerModel, fit};
use pso::{Boundary, Stop, Swarm, SwarmConfig, Topology};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use recording::Recording;
use rig_files::rod_file;
use wiener::hysteresis::Rule;

type Failure = Box<dyn Error + Send + Sync>;

const COMMAND: &str = "cargo run --release -p benches --bin performance_table";
const N_SEEDS: u64 = 100;
const N_PARTICLES: usize = 50;
const N_MOVES: u64 = 150;
/// Moves of the swarm that looks for the floor.
const N_LONG_MOVES: u64 = 2000;
/// Published floor of the job, mm²: the lowest mean squared error over the seven parameters.
const PUBLISHED_FLOOR_MM2: f64 = 1.1282e-4;

/// The rig with a heat capacity, for the paper's unknowns; which one only moves the scale that is free.
const SADEGHI_ROD_TOML: &str = r#"[rod]
diameter_mm = 1.2
density_kg_per_m3 = 6450.0
specific_heat_j_per_kg_k = 480.0

[surroundings]
ambient_degc = 25.0
"#;

/// Final cost of one of our swarms, mm².
fn swarm_cost(job: &Job, config: &SwarmConfig, moves: u64, seed: u64) -> Result<f64, Failure> {
    let config = SwarmConfig {
        particles: N_PARTICLES,
        ..config.clone()
    };
    let stop = Stop {
        iterations: Some(moves),
        ..Stop::default()
    };
    let mut swarm = Swarm::new(config, job.bounds(), ChaCha8Rng::seed_from_u64(seed))?;
    while swarm.finished(&stop)?.is_none() {
        let costs = job.costs(swarm.ask())?;
        swarm.tell(&costs)?;
    }
    Ok(swarm.best_cost().unwrap_or(f64::INFINITY))
}

/// The job in the form that argmin takes.
struct Problem<'a>(&'a Job);

impl CostFunction for Problem<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, point: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        Ok(self.0.costs(&[point])?[0])
    }

    fn bulk_cost<P: std::borrow::Borrow<Vec<f64>> + SyncAlias>(
        &self,
        points: &[P],
    ) -> Result<Vec<f64>, argmin::core::Error> {
        let points: Vec<&Vec<f64>> = points.iter().map(std::borrow::Borrow::borrow).collect();
        Ok(self.0.costs(&points)?)
    }
}

/// Final cost of argmin's swarm, mm²; it evaluates the starts and then moves, as ours does.
fn argmin_cost(job: &Job, seed: u64) -> Result<f64, Failure> {
    let bounds = job.bounds();
    let ends = (
        bounds.iter().map(|bound| bound.lower).collect(),
        bounds.iter().map(|bound| bound.upper).collect(),
    );
    let solver =
        ParticleSwarm::new(ends, N_PARTICLES).with_rng_generator(ChaCha8Rng::seed_from_u64(seed));
    let result = Executor::new(Problem(job), solver)
        .configure(|state| state.max_iters(N_MOVES))
        .timer(false)
        .run()?;
    Ok(result.state().get_best_cost())
}

/// Final costs of all seeds, in their order, and how long they took together, s.
fn all_seeds<T: Send>(
    run: impl Fn(u64) -> Result<T, Failure> + Sync + Send,
) -> Result<(Vec<T>, f64), Failure> {
    let begin = Instant::now();
    let ends = (1..=N_SEEDS)
        .into_par_iter()
        .map(run)
        .collect::<Result<Vec<T>, Failure>>()?;
    Ok((ends, begin.elapsed().as_secs_f64()))
}

/// Cells of a row: shares of the costs near the floor and far from it, and their median.
fn cells(costs: &[f64], floor_mm2: f64) -> String {
    let share = |holds: &dyn Fn(f64) -> bool| {
        let count = costs
            .iter()
            .filter(|&&cost| holds(cost / floor_mm2))
            .count();
        100.0 * count as f64 / costs.len() as f64
    };
    let mut sorted = costs.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let median = 0.5 * (sorted[(sorted.len() - 1) / 2] + sorted[middle]) / floor_mm2;
    format!(
        "{:.0} % | {:.0} % | {:.0} % | {median:.4}",
        share(&|ratio| ratio <= 1.01),
        share(&|ratio| ratio <= 1.1),
        share(&|ratio| ratio > 100.0),
    )
}

/// Compared settings of the swarm with their names, one row each.
fn configs() -> Vec<(&'static str, SwarmConfig)> {
    let reliable = SwarmConfig::reliable;
    vec![
        ("`reliable`", reliable()),
        ("`patient`", SwarmConfig::patient()),
        ("`sadeghi_tuning`", SwarmConfig::sadeghi_tuning()),
        (
            "`sadeghi_identification`",
            SwarmConfig::sadeghi_identification(),
        ),
        (
            "`reliable`, everybody informed",
            SwarmConfig {
                topology: Topology::Global,
                ..reliable()
            },
        ),
        (
            "`reliable`, no velocity limit",
            SwarmConfig {
                velocity_limit: None,
                ..reliable()
            },
        ),
        (
            "`reliable`, periodic bounds",
            SwarmConfig {
                boundary: Boundary::Periodic,
                ..reliable()
            },
        ),
        (
            "`reliable`, ring of 1",
            SwarmConfig {
                topology: Topology::Ring { neighbors: 1 },
                ..reliable()
            },
        ),
    ]
}

fn fitted(
    model: &dyn ForwardModel,
    training: &[Recording],
    config: FitConfig,
    seed: u64,
) -> Result<Fit, Failure> {
    let config = FitConfig { seed, ..config };
    Ok(fit(model, training, &config, &mut |_| {
        ControlFlow::Continue(())
    })?)
}

fn print_fits(name: &str, fits: &[Fit], floor_mm2: f64, time_s: f64) {
    let costs: Vec<f64> = fits.iter().map(|fit| fit.train_rmse.powi(2)).collect();
    let simulations: u64 = fits.iter().map(|fit| fit.simulations).sum();
    println!(
        "| {name} | {} | {:.0} | {time_s:.1} |",
        cells(&costs, floor_mm2),
        simulations as f64 / fits.len() as f64,
    );
}

fn main() -> Result<(), Failure> {
    let begin = Instant::now();
    let job = Job::load()?;
    let training = [job.recording().clone()];
    let rod = rod_file::parse("rod.toml", ROD_TOML)?;
    let model = WienerModel::new(&rod, Rule::LastReversal, &training)?;

    let (fits, fits_s) = all_seeds(|seed| fitted(&model, &training, FitConfig::default(), seed))?;
    let fit_costs: Vec<f64> = fits.iter().map(|fit| fit.train_rmse.powi(2)).collect();
    let long_mm2 = swarm_cost(&job, &SwarmConfig::reliable(), N_LONG_MOVES, 1)?;
    let found_mm2 = fit_costs.iter().copied().fold(long_mm2, f64::min);
    let floor_mm2 = found_mm2.min(PUBLISHED_FLOOR_MM2);
    println!(
        "Floor: {floor_mm2:.6e} mm² (published {PUBLISHED_FLOOR_MM2:.4e}, a swarm of {N_LONG_MOVES} moves \
         {long_mm2:.6e}, the lowest fit {found_mm2:.6e}).\n"
    );

    println!(
        "| swarm, {N_PARTICLES} particles, {N_MOVES} moves, {N_SEEDS} seeds | within 1 % | within 10 % | \
         above 100 x | median/floor | s |\n|---|---|---|---|---|---|"
    );
    for (name, config) in configs() {
        let (costs, time_s) = all_seeds(|seed| swarm_cost(&job, &config, N_MOVES, seed))?;
        println!("| {name} | {} | {time_s:.1} |", cells(&costs, floor_mm2));
    }
    let (costs, time_s) = all_seeds(|seed| argmin_cost(&job, seed))?;
    println!(
        "| argmin 0.11 | {} | {time_s:.1} |",
        cells(&costs, floor_mm2)
    );

    println!(
        "\n| fit, {N_SEEDS} seeds | within 1 % | within 10 % | above 100 x | median/floor | mean simulations | s |\n\
         |---|---|---|---|---|---|---|"
    );
    print_fits("`FitConfig::default`", &fits, floor_mm2, fits_s);
    let rod = rod_file::parse("rod.toml", SADEGHI_ROD_TOML)?;
    let model = SadeghiModel::new(&rod, Rule::LastReversal, &training)?;
    let (fits, fits_s) = all_seeds(|seed| fitted(&model, &training, FitConfig::sadeghi(), seed))?;
    print_fits(
        "`FitConfig::sadeghi` on `SadeghiModel`",
        &fits,
        floor_mm2,
        fits_s,
    );
    println!(
        "\nCommand: `{COMMAND}`; s: wall time of all seeds of a row on {} threads; {:.0} s in all.",
        rayon::current_num_threads(),
        begin.elapsed().as_secs_f64(),
    );
    Ok(())
}
