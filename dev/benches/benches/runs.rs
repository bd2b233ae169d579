//! Whole runs: one model through 10⁴ samples, one move of a swarm, one fit.

use std::ops::ControlFlow;

use benches::sound;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use identify::{FitConfig, IdentifyError, WienerModel, fit};
use pso::{Bound, Swarm, SwarmConfig, SwarmError};
use rand::{RngCore, SeedableRng};
use rand_chacha::ChaCha8Rng;
use recording::{Quantity, Recording, RecordingParts};
use rig_files::rod_file;
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::{HeatBalanceParams, ThermalConstants};
use wiener::{Drive, Plant, Profile, Wiener, WienerError, WienerParams, run};

const AMBIENT_DEGC: f64 = 25.0;
const DT_S: f64 = 0.287;
const SEED: u64 = 1;
/// Size of the noise of the generated recording, mm.
const NOISE_MM: f64 = 0.01;
const ROD_TOML: &str = "[surroundings]\nambient_degc = 25.0\n\n[drive]\nkind = \"current\"\n";

fn truth() -> Result<Wiener, WienerError> {
    let params = WienerParams {
        heat: HeatBalanceParams::from_constants(ThermalConstants {
            tau_s: 4.2,
            lambda_k_per_a2: 24.0,
        }),
        limiting_loop: LoopParams {
            loop_center_degc: 74.0,
            loop_half_width_k: 12.5,
            loop_spread_k: 6.0,
            ..LoopParams::default()
        },
        zeta: 0.86,
        gain: 6.0,
        offset: 0.35,
    };
    Wiener::new(Drive::Current, Rule::LastReversal, &[params])
}

/// Levels held for 30 to 60 samples, A.
fn currents_a(n_samples: usize) -> Vec<f64> {
    let mut generator = ChaCha8Rng::seed_from_u64(SEED);
    let mut currents_a = Vec::with_capacity(n_samples + 60);
    while currents_a.len() < n_samples {
        let level_a = 2.0 * unit(&mut generator);
        let n_held = 30 + (30.0 * unit(&mut generator)) as usize;
        currents_a.extend(std::iter::repeat_n(level_a, n_held));
    }
    currents_a.truncate(n_samples);
    currents_a
}

/// Uniform in [0, 1).
fn unit(generator: &mut ChaCha8Rng) -> f64 {
    (generator.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// A recording of the truth with noise.
fn generated(n_samples: usize) -> Result<Recording, IdentifyError> {
    let currents_a = currents_a(n_samples);
    let truth = truth()?;
    let mut generator = ChaCha8Rng::seed_from_u64(SEED + 1);
    let mut output = Vec::with_capacity(n_samples);
    run(
        &truth,
        &mut truth.rest(AMBIENT_DEGC),
        &Profile::uniform(&currents_a, DT_S, AMBIENT_DEGC)?,
        |_, shown| {
            output.push(shown.displacement[0] + NOISE_MM * (2.0 * unit(&mut generator) - 1.0));
        },
    );
    Ok(Recording::new(RecordingParts {
        name: "generated".to_owned(),
        time_s: Some((0..n_samples).map(|k| k as f64 * DT_S).collect()),
        drive_quantity: Quantity::Current,
        drive: currents_a,
        output_unit: "mm".to_owned(),
        output,
        ..RecordingParts::default()
    })?)
}

#[divan::bench(args = [10_000])]
fn wiener(bencher: Bencher, n_samples: usize) {
    let model = sound(truth());
    let currents_a = currents_a(n_samples);
    let profile = sound(Profile::uniform(&currents_a, DT_S, AMBIENT_DEGC));
    let rest = model.rest(AMBIENT_DEGC);
    bencher
        .counter(ItemsCount::new(n_samples))
        .with_inputs(|| rest.clone())
        .bench_local_refs(|state| {
            let mut sum = 0.0;
            run(&model, state, black_box(&profile), |_, shown| {
                sum += shown.displacement[0];
            });
            sum
        });
}

/// A swarm of 50 in seven coordinates that has been told its first costs.
fn swarm(particles: usize) -> Result<Swarm<ChaCha8Rng>, SwarmError> {
    let config = SwarmConfig {
        particles,
        ..SwarmConfig::reliable()
    };
    let bounds = [Bound {
        lower: -1.0,
        upper: 1.0,
    }; 7];
    let mut swarm = Swarm::new(config, &bounds, ChaCha8Rng::seed_from_u64(SEED))?;
    let costs = sphere(swarm.ask());
    swarm.tell(&costs)?;
    Ok(swarm)
}

fn sphere(points: &[Vec<f64>]) -> Vec<f64> {
    let cost = |point: &Vec<f64>| point.iter().map(|x| x * x).sum();
    points.iter().map(cost).collect()
}

#[divan::bench(args = [50])]
fn ask_tell(bencher: Bencher, particles: usize) {
    let swarm = sound(swarm(particles));
    let costs = sphere(swarm.ask());
    bencher
        .with_inputs(|| swarm.clone())
        .bench_local_refs(|swarm| {
            black_box(swarm.ask());
            swarm.tell(black_box(&costs))
        });
}

#[divan::bench(name = "fit", args = [400], sample_count = 20)]
fn fit_generated(bencher: Bencher, n_samples: usize) {
    let training = [sound(generated(n_samples))];
    let rod = sound(rod_file::parse("rod.toml", ROD_TOML));
    let model = sound(WienerModel::new(&rod, Rule::LastReversal, &training));
    let config = FitConfig {
        starts: 1,
        seed: SEED,
        ..FitConfig::default()
    };
    bencher.bench_local(|| {
        fit(&model, black_box(&training), &config, &mut |_| {
            ControlFlow::Continue(())
        })
    });
}

fn main() {
    divan::main();
}
