//! Loops that drift with their cycles, and such that do not.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

use std::ops::ControlFlow;

use identify::{Estimate, FitConfig, NotTestable, Rod, StaticEffect, static_effects};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use recording::{Quantity, Recording, RecordingParts, read_csv};
use rig_files::rod_file;
use wiener::hysteresis::{Branch, Hysteresis, LimitingLoop, LoopParams, Rule, SineProximity};

const STATIC: &str = "[drive]\nkind = \"temperature\"\n";
const LOWEST_DEGC: f64 = 20.0;
const HIGHEST_DEGC: f64 = 130.0;

/// Fatigue of a generated loop, over all of its cycles.
#[derive(Debug, Clone, Copy)]
struct Made {
    cycles: usize,
    /// Samples from one end of the input to the other.
    half: usize,
    shift_k: f64,
    loss: f64,
    lasting: f64,
    fading: f64,
    /// Half as much again as the heating branch is steep.
    steeper: f64,
    noise: f64,
    seed: u64,
}

const STABLE: Made = Made {
    cycles: 12,
    half: 40,
    shift_k: 0.0,
    loss: 0.0,
    lasting: 0.0,
    fading: 0.0,
    steeper: 1.0,
    noise: 0.01,
    seed: 0,
};

const DRIFTING: Made = Made {
    shift_k: -2.4,
    loss: 0.05,
    lasting: 0.11,
    fading: 0.1,
    ..STABLE
};

impl Made {
    /// The law by its closed form, cycles counted by the triangles of the input.
    fn recording(&self, load_mpa: Option<f64>) -> Recording {
        let n = 2 * self.half * self.cycles + 1;
        let cycle = |k: usize| k as f64 / (2 * self.half) as f64;
        let drive: Vec<f64> = (0..n)
            .map(|k| {
                let phase = cycle(k).fract();
                let share = 1.0 - (2.0 * phase - 1.0).abs();
                LOWEST_DEGC + (HIGHEST_DEGC - LOWEST_DEGC) * share
            })
            .collect();
        let come = |k: usize| match self.fading > 0.0 {
            true => {
                (-self.fading * cycle(k)).exp_m1() / (-self.fading * self.cycles as f64).exp_m1()
            }
            false => cycle(k) / self.cycles as f64,
        };
        let material = Hysteresis::new(
            LimitingLoop::new([LoopParams {
                loop_center_degc: 75.0,
                loop_half_width_k: 9.0,
                loop_spread_k: 6.0,
                ..LoopParams::default()
            }])
            .unwrap(),
            SineProximity::new([0.7]).unwrap(),
            Rule::LastReversal,
        );
        let shifted = |k: usize| [drive[k] - self.shift_k * come(k)];
        let mut memory = material.on_limiting_curve(Branch::Cooling, shifted(0));
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let mut noise = || -> f64 { StandardNormal.sample(&mut rng) };
        let output = (0..n)
            .map(|k| {
                let fraction = material.commit(&mut memory, shifted(k))[0];
                let is_heating = cycle(k).fract() < 0.5;
                // A loop that the model cannot meet: one branch bends otherwise.
                let fraction = if is_heating {
                    fraction.max(0.0).powf(self.steeper)
                } else {
                    fraction
                };
                let transformed = (1.0 - self.loss * come(k)) * fraction;
                -4.0 * (transformed + self.lasting * come(k)) + 4.0 + 4.0 * self.noise * noise()
            })
            .collect();
        Recording::new(RecordingParts {
            name: "cycles.csv".to_owned(),
            drive_quantity: Quantity::Temperature,
            drive,
            output_unit: "%".to_owned(),
            output,
            stress_pa: load_mpa.map(|mpa| vec![1e6 * mpa; n]),
            ..RecordingParts::default()
        })
        .unwrap()
    }
}

fn tested(rod: &Rod, training: &[Recording]) -> Result<StaticEffect, NotTestable> {
    let config = FitConfig {
        starts: 1,
        ..FitConfig::default()
    };
    let effects = static_effects(rod, Rule::LastReversal, training, &config, &mut |_| {
        ControlFlow::Continue(())
    });
    effects.unwrap().functional_fatigue
}

fn rod() -> Rod {
    rod_file::parse("rod.toml", STATIC).unwrap()
}

fn holds(effect: &StaticEffect, name: &str, truth: f64) -> bool {
    let interval = effect
        .estimate(name)
        .and_then(|one: &Estimate| one.interval);
    interval.is_some_and(|one| (one.lower..=one.upper).contains(&truth))
}

#[test]
fn drifts_lie_within_their_intervals() {
    let truths = [
        ("fatigue_total_shift", DRIFTING.shift_k),
        ("fatigue_total_stroke_loss", DRIFTING.loss),
        ("fatigue_total_lasting", DRIFTING.lasting),
    ];
    let held: Vec<[bool; 3]> = (0..10)
        .into_par_iter()
        .map(|seed| {
            let effect = tested(&rod(), &[Made { seed, ..DRIFTING }.recording(None)]).unwrap();
            assert!(effect.is_found(), "{effect:?}");
            let cycles = effect.estimate("cycles").unwrap().value;
            assert!((cycles - 12.0).abs() < 0.1, "{cycles}");
            truths.map(|(name, truth)| holds(&effect, name, truth))
        })
        .collect();
    let count = held.iter().flatten().filter(|held| **held).count();
    // 28 or 29 of 30 are to be expected.
    assert!(count >= 25, "{count}");
}

#[test]
fn stable_loops_have_no_drift() {
    let stable = (0..6).map(|seed| Made { seed, ..STABLE });
    // A loop that the model does not meet, and one that is hardly noisy.
    let bent = (10..14).map(|seed| Made {
        seed,
        steeper: 1.3,
        ..STABLE
    });
    let quiet = (15..17).map(|seed| Made {
        seed,
        steeper: 1.3,
        noise: 1e-3,
        ..STABLE
    });
    let found: Vec<u64> = stable
        .chain(bent)
        .chain(quiet)
        .collect::<Vec<Made>>()
        .into_par_iter()
        .filter(|made| tested(&rod(), &[made.recording(None)]).unwrap().is_found())
        .map(|made| made.seed)
        .collect();
    assert_eq!(found, [0; 0]);
}

#[test]
fn what_cannot_be_told_says_why() {
    let one = Made {
        cycles: 1,
        ..STABLE
    };
    let why = tested(&rod(), &[one.recording(None)]).unwrap_err();
    assert_eq!(why, NotTestable::OneCycle);
    assert_eq!(why.to_string(), "no recording goes through two cycles");
    let loads = [50.0, 100.0].map(|mpa| STABLE.recording(Some(mpa)));
    let why = tested(&rod(), &loads).unwrap_err();
    assert_eq!(
        why.to_string(),
        "the recordings differ in their stress; give those of one stress by themselves"
    );
}

#[test]
fn a_wire_that_was_cycled_100_times() {
    let Some(path) = fixtures::shared::path("recordings/asmada/example-test-data.txt") else {
        return;
    };
    let text =
        format!("{STATIC}[columns]\ndrive = {{ number = 1, unit = \"degc\" }}\noutput = 2\n");
    let rod = rod_file::parse("rod.toml", &text).unwrap();
    let whole = read_csv(&path, &rod.read_options()).unwrap();
    // Every second sample: 130 of a cycle.
    let every_2nd = |values: &[f64]| values.iter().copied().step_by(2).collect::<Vec<f64>>();
    let training = [Recording::new(RecordingParts {
        name: "every 2nd".to_owned(),
        drive_quantity: Quantity::Temperature,
        drive: every_2nd(whole.drive()),
        output: every_2nd(whole.output()),
        ..RecordingParts::default()
    })
    .unwrap()];
    let effect = tested(&rod, &training).unwrap();
    assert!(effect.is_found() && effect.with.converged, "{effect:?}");
    let value = |name: &str| effect.estimate(name).unwrap().value;
    // 100 that do not reach both ends.
    let cycles = value("cycles");
    assert!((90.0..100.0).contains(&cycles), "{cycles}");
    // Fitted by themselves, the first and the last eleven cycles have centers of 114.0 and 111.6 °C, each to a kelvin, and rests 11 %
    // of the stroke apart: some eight tenths of what the law says of all.
    let come = |n: f64| {
        let k = value("fatigue_fading");
        (-k * n).exp_m1() / (-k * cycles).exp_m1()
    };
    let between = come(cycles - 5.0) - come(5.0);
    let shift_k = between * value("fatigue_total_shift");
    assert!((shift_k + 2.4).abs() < 1.2, "{shift_k}");
    let lasting = between * value("fatigue_total_lasting");
    assert!((lasting + 0.11).abs() < 0.03, "{lasting}");
    // Little beside what no loop of this shape meets.
    assert!(effect.with.rmse < 0.95 * effect.without.rmse, "{effect:?}");
}
