//! Effects of stress and resistance in static recordings, on measured and on generated data.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it reads its data"
)]

use std::f64::consts::PI;
use std::ops::ControlFlow;

use identify::{
    Bounds, Estimate, FitConfig, IdentifyError, LoopModel, NotTestable, Rod, StaticEffects,
    static_effects,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use recording::{Quantity, Recording, RecordingParts, Resistance, read_csv};
use rig_files::rod_file;
use wiener::hysteresis::{Branch, Hysteresis, LimitingLoop, LoopParams, Rule, SineProximity};

const STATIC: &str = "[drive]\nkind = \"temperature\"\n";

fn rod(columns: &str) -> Rod {
    rod_file::parse("rod.toml", &format!("{STATIC}{columns}")).unwrap()
}

fn effects(rod: &Rod, training: &[Recording], config: &FitConfig) -> StaticEffects {
    static_effects(rod, Rule::LastReversal, training, config, &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

fn holds(interval: Option<Bounds>, value: f64) -> bool {
    interval.is_some_and(|interval| (interval.lower..=interval.upper).contains(&value))
}

#[test]
fn resistance_of_a_wire_under_constant_load_falls_by_a_fifth() {
    let Some(path) = fixtures::shared::path("recordings/mk-zuk/static.csv") else {
        return;
    };
    // The way up and the way down stand side by side in the file.
    let rod = rod(r#"
        [columns]
        drive = { name = "tempg [stC]", unit = "degc" }
        output = "dLzmg0 [mm]"
        resistance = { voltage = "Uzmg [V]", current = "Izmg [A]" }
        [columns.then]
        drive = { name = "tempd [stC]", unit = "degc" }
        output = "dLzmd0 [mm]"
        resistance = { voltage = "Uzmd [V]", current = "Izmd [A]" }
    "#);
    let training = [read_csv(&path, &rod.read_options()).unwrap()];
    assert_eq!(training[0].len(), 82);
    let effects = effects(&rod, &training, &FitConfig::default());
    assert_eq!(effects.stress_coupling, Err(NotTestable::NoStress));
    let found = effects.phase_dependent_resistance.unwrap();
    let change = found.estimate("resistance_change").unwrap();
    // -0.202, from -0.239 to -0.166: on cooling the resistance rises before the wire moves, which no line can do.
    assert!((change.value + 0.202).abs() < 1e-3, "{change:?}");
    let interval = change.interval.unwrap();
    assert!(holds(change.interval, -0.2) && interval.upper < -0.15 && interval.lower > -0.25);
    // 3.55 Ω cold; 0.25 Ω are left without, 0.072 Ω with it.
    let cold = found.estimate("resistance_ohm").unwrap();
    assert!((cold.value - 3.55).abs() < 0.01, "{cold:?}");
    assert!(found.with.rmse < 0.3 * found.without.rmse && found.with.bic < found.without.bic);
}

#[test]
fn loop_of_a_wire_rises_with_its_load() {
    let file = |mpa| {
        let name = format!("recordings/flexinol/filtered_data_{mpa}MPa.txt");
        fixtures::shared::path(&name)
    };
    let files = [50, 100, 150].map(file);
    if files.iter().any(Option::is_none) {
        return;
    }
    let rod = rod(r#"
        [columns]
        drive = { name = "Temperature", unit = "degc" }
        output = "Strain"
        stress = { name = "Stress", unit = "mpa" }
    "#);
    let training = files.map(|path| read_csv(path.unwrap(), &rod.read_options()).unwrap());
    let both = effects(&rod, &training, &FitConfig::default());
    assert_eq!(
        both.phase_dependent_resistance,
        Err(NotTestable::NoResistance)
    );
    let found = both.stress_coupling.unwrap();
    let slope = found.estimate("stress_coupling_mpa_per_k").unwrap();
    // 7.47 MPa/K, from 7.12 to 7.85. Heating alone rises by 8.5, cooling by 7.2 MPa/K: the loop narrows, too,
    // which one shift cannot do.
    assert!((slope.value - 7.47).abs() < 0.02, "{slope:?}");
    let interval = slope.interval.unwrap();
    assert!(interval.lower > 7.0 && interval.upper < 8.0, "{interval:?}");
    assert!(found.with.rmse < 0.3 * found.without.rmse && found.with.bic < found.without.bic);

    let one = effects(&rod, &training[..1], &FitConfig::default());
    let why = one.stress_coupling.unwrap_err();
    assert!(matches!(why, NotTestable::OneStress { .. }), "{why:?}");
}

// The truth of the generated recordings.
const SHIFT_K_PER_MPA: f64 = 0.125;
const GAIN_PER_MPA: f64 = 6e-4;
const COLD_OHM: f64 = 3.5;
const CHANGE: f64 = -0.2;
const REFERENCE_MPA: f64 = 100.0;

/// Three loads, each through the whole loop and a smaller one within, with noise of lag-1 correlation `phi`: 1 % of
/// the stroke and of the voltage.
fn generated(phi: f64, seed: u64) -> Vec<Recording> {
    let mut noise = Noise {
        rng: ChaCha8Rng::seed_from_u64(seed),
        phi,
    };
    [50.0, 100.0, 150.0]
        .map(|mpa| under_load(mpa, &mut noise))
        .into()
}

fn under_load(mpa: f64, noise: &mut Noise) -> Recording {
    let turns: [f64; 5] = [20.0, 130.0, 66.0, 86.0, 20.0];
    let mut drive = vec![turns[0]];
    for pair in turns.windows(2) {
        let n = (pair[1] - pair[0]).abs().round();
        drive.extend((1..=n as usize).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / n));
    }
    let n = drive.len();
    let load_mpa = |k: usize| mpa - REFERENCE_MPA + 2.0 * (6.0 * PI * k as f64 / n as f64).sin();
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
    let shifted = |k: usize| [drive[k] - SHIFT_K_PER_MPA * load_mpa(k)];
    let mut memory = material.on_limiting_curve(Branch::Cooling, shifted(0));
    let fraction: Vec<f64> = (0..n)
        .map(|k| material.commit(&mut memory, shifted(k))[0])
        .collect();
    let errors = [noise.series(n), noise.series(n)];
    let output = |k: usize| {
        let stroke = -4.0 * (1.0 + GAIN_PER_MPA * load_mpa(k));
        stroke * fraction[k] + 4.0 + 0.04 * errors[0][k]
    };
    let current_a = |k: usize| 0.006 * (drive[k] - 20.0);
    let voltage_v =
        |k: usize| current_a(k) * COLD_OHM * (1.0 + CHANGE * fraction[k]) + 0.015 * errors[1][k];
    Recording::new(RecordingParts {
        name: format!("{mpa} MPa"),
        drive_quantity: Quantity::Temperature,
        output_unit: "%".to_owned(),
        output: (0..n).map(output).collect(),
        stress_pa: Some(
            (0..n)
                .map(|k| 1e6 * (load_mpa(k) + REFERENCE_MPA))
                .collect(),
        ),
        resistance: Some(Resistance::VoltageOverCurrent {
            voltage_v: (0..n).map(voltage_v).collect(),
            current_a: (0..n).map(current_a).collect(),
        }),
        drive,
        ..RecordingParts::default()
    })
    .unwrap()
}

struct Noise {
    rng: ChaCha8Rng,
    phi: f64,
}

impl Noise {
    fn series(&mut self, n: usize) -> Vec<f64> {
        let mut normal = || -> f64 { StandardNormal.sample(&mut self.rng) };
        let mut state = normal();
        (0..n)
            .map(|_| {
                let now = state;
                state = self.phi * state + (1.0 - self.phi * self.phi).sqrt() * normal();
                now
            })
            .collect()
    }
}

const REPEATS: u64 = 200;

/// Checks that the intervals hold the truth in 95 % of repeats, as far as 200 of them can tell.
fn check_coverage(phi: f64) {
    let truths = [
        ("stress_coupling_k_per_mpa", SHIFT_K_PER_MPA),
        ("stress_coupling_mpa_per_k", 1.0 / SHIFT_K_PER_MPA),
        ("stress_gain_per_mpa", GAIN_PER_MPA),
        ("resistance_change", CHANGE),
        ("resistance_ohm", COLD_OHM),
    ];
    let config = FitConfig {
        starts: 1,
        ..FitConfig::default()
    };
    let rod = rod("");
    let held: Vec<Vec<bool>> = (0..REPEATS)
        .into_par_iter()
        .map(|seed| {
            let effects = effects(&rod, &generated(phi, seed), &config);
            let found = [
                effects.stress_coupling.unwrap(),
                effects.phase_dependent_resistance.unwrap(),
            ];
            assert!(
                found
                    .iter()
                    .all(|effect| effect.with.bic < effect.without.bic)
            );
            let estimate = |name: &str| -> Estimate {
                let named = found.iter().find_map(|effect| effect.estimate(name));
                named.unwrap().clone()
            };
            truths
                .iter()
                .map(|(name, truth)| holds(estimate(name).interval, *truth))
                .collect()
        })
        .collect();
    let shares: Vec<f64> = (0..truths.len())
        .map(|k| held.iter().filter(|held| held[k]).count() as f64 / REPEATS as f64)
        .collect();
    for ((name, _), share) in truths.iter().zip(&shares) {
        assert!(
            (0.9..=0.985).contains(share),
            "{name}: {share} of {shares:?}"
        );
    }
}

#[test]
fn intervals_cover_under_white_noise() {
    check_coverage(0.0);
}

#[test]
fn intervals_cover_under_correlated_noise() {
    check_coverage(0.8);
}

#[test]
fn a_recorded_resistance_counts_as_a_voltage_and_a_current() {
    let plain: Vec<Recording> = generated(0.0, 1)
        .iter()
        .map(|recording| {
            // Under 1 A the voltage is the resistance.
            let current_a = vec![1.0; recording.len()];
            with_resistance(recording, |voltage_v| Resistance::VoltageOverCurrent {
                voltage_v,
                current_a,
            })
        })
        .collect();
    let ohm: Vec<Recording> = plain
        .iter()
        .map(|recording| with_resistance(recording, Resistance::Ohm))
        .collect();
    let config = FitConfig::default();
    let found = [plain, ohm].map(|training| effects(&rod(""), &training, &config));
    assert_eq!(found[0], found[1]);
}

fn with_resistance(recording: &Recording, of: impl FnOnce(Vec<f64>) -> Resistance) -> Recording {
    let voltage_v = recording.resistance().unwrap().voltage_and_current();
    Recording::new(RecordingParts {
        name: recording.name().to_owned(),
        drive_quantity: Quantity::Temperature,
        drive: recording.drive().to_vec(),
        output: recording.output().to_vec(),
        resistance: Some(of(voltage_v.map(|(voltage_v, _)| voltage_v).collect())),
        ..RecordingParts::default()
    })
    .unwrap()
}

#[test]
fn what_cannot_be_told_says_why() {
    let loaded = generated(0.0, 2);
    let config = FitConfig::default();
    let of_one = effects(&rod(""), &loaded[..1], &config);
    assert_eq!(
        of_one.stress_coupling.unwrap_err().to_string(),
        "the mean stresses, 50.000 to 50.000 MPa, differ by no more than the stress moves within a recording, \
         1.414 MPa"
    );
    assert!(of_one.phase_dependent_resistance.is_ok());
    let without_current = with_resistance(&loaded[0], |voltage_v| Resistance::VoltageOverCurrent {
        current_a: vec![0.0; voltage_v.len()],
        voltage_v,
    });
    let still = effects(&rod(""), &[without_current], &config);
    let texts = [
        still.stress_coupling.unwrap_err(),
        still.phase_dependent_resistance.unwrap_err(),
        NotTestable::NoResistance,
    ];
    assert_eq!(
        texts.map(|why| why.to_string()),
        [
            "not every recording has a stress",
            "no current flows, or nothing transforms while it does",
            "no recording has a resistance",
        ]
    );
}

#[test]
fn a_shift_needs_a_stress() {
    let plain = [with_resistance(&generated(0.0, 3)[0], Resistance::Ohm)];
    let model = LoopModel::new(&rod(""), Rule::LastReversal, &plain).unwrap();
    let fault = model.with_stress_coupling(&plain).unwrap_err();
    assert!(matches!(fault, IdentifyError::NoStress { .. }));
    assert_eq!(
        fault.to_string(),
        "50 MPa: no stress; expected a column stress_mpa, or one named under [columns]"
    );
}
