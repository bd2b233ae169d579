//! The discrepancy under which what a model leaves of reference runs is likeliest.

use std::ops::ControlFlow;

use pso::{Bound, Stop, SwarmConfig, Topology, minimize_parallel};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::changed::discrepancy::Discrepancy;
use crate::changed::joint::{Joint, Runs};

/// Smallest share of the variance.
const SMALLEST: f64 = 1e-4;

/// Memories, time constants of the rod.
const SLOW: [f64; 2] = [0.3, 30.0];
const TIMING: [f64; 2] = [0.1, 3.0];

const PARTICLES: usize = 16;
const ITERATIONS: u64 = 40;

/// The likeliest of a given size: what laws and states would take in is integrated out, so that of a slow part little is seen, and
/// its size would be anything. `rms` is what the model leaves of runs, in the unit of the output; `tau_s` the rod's time constant.
pub(crate) fn likeliest(
    joint: &Joint,
    runs: &Runs,
    which: &[usize],
    (rms, tau_s): (f64, f64),
    seed: u64,
) -> Discrepancy {
    let ln = |[lower, upper]: [f64; 2]| Bound {
        lower: lower.ln(),
        upper: upper.ln(),
    };
    let share = ln([SMALLEST, 1.0]);
    let memory = |of: [f64; 2]| ln(of.map(|taus| taus * tau_s));
    let bounds = [share, share, share, memory(SLOW), memory(TIMING)];
    let at = |point: &[f64]| {
        let shares = [0, 1, 2].map(|k| point[k].exp());
        let all: f64 = shares.iter().sum();
        let [noise, slow, timing] = shares.map(|share| rms * (share / all).sqrt());
        Discrepancy {
            noise,
            slow,
            slow_s: point[3].exp(),
            timing,
            timing_s: point[4].exp(),
        }
    };
    let config = SwarmConfig {
        particles: PARTICLES,
        topology: Topology::Global,
        ..SwarmConfig::default()
    };
    let stop = Stop {
        iterations: Some(ITERATIONS),
        ..Stop::default()
    };
    let report = minimize_parallel(
        config,
        &bounds,
        &stop,
        ChaCha8Rng::seed_from_u64(seed),
        |point| {
            let system = joint.system(runs, which, &at(point));
            -system.nats(system.squares())
        },
        |_| ControlFlow::Continue(()),
    );
    // Where no density is a number, as where nothing is left: equal shares.
    let best = report.ok().and_then(|report| report.best);
    best.map_or_else(
        || at(&[0.0, 0.0, 0.0, tau_s.ln(), tau_s.ln()]),
        |best| at(&best.point),
    )
}
