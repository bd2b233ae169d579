//! `sma identify` on rigs of the plants that know nothing of it, recorded as labs often do: at one rate only, or started warm.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write;
use std::fs;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::TempDir;
use truth_plant::{
    Draw, DriveName, FamilyKind, Logging, LoopFamily, Manner, NoiseKind, TruthPlant,
};

/// How many rigs are drawn.
const RIGS: u64 = 30;

/// Samples of a recording.
const SAMPLES: usize = 600;

/// Families of loops, in turn, as often as the trial has them in rigs that conceal nothing of the loop: the first plant with the
/// fitted one, the second with relays or kinetics.
const FAMILIES: [FamilyKind; 6] = [
    FamilyKind::L2p,
    FamilyKind::Relays,
    FamilyKind::L2p,
    FamilyKind::Relays,
    FamilyKind::L2p,
    FamilyKind::Tanaka,
];

/// A drawn rig in a folder: `rod.toml` and `run.csv`.
struct DrawnRig {
    folder: TempDir,
    plant: TruthPlant,
}

impl DrawnRig {
    fn new(
        number: u64,
        drive: impl FnOnce(&TruthPlant, &Draw, Logging) -> (Vec<f64>, usize),
    ) -> Self {
        let draw = Draw::new(1_000 + number);
        let family = FAMILIES[number as usize % FAMILIES.len()];
        let mut plant = draw.plant(family, DriveName::Current);
        draw.noise(NoiseKind::White, &mut plant);
        if let Some(converter) = plant.converter.as_mut() {
            converter.bits = 16;
        }
        let dt_s = (1e3 * plant.time_constant_s() / 20.0).round() / 1e3;
        let logging = Logging {
            n_samples: SAMPLES,
            dt_s,
            dead_zone: 0.0,
        };
        let (drive, n_before) = drive(&plant, &draw, logging);
        let traces = plant.simulate(&drive, dt_s, number).unwrap();
        let mut rows = "time_s,current_a,displacement_mm\n".to_owned();
        for k in n_before..drive.len() {
            writeln!(
                rows,
                "{:.3},{},{:.6}",
                dt_s * (k - n_before) as f64,
                drive[k],
                traces.displacement_mm[k]
            )
            .unwrap();
        }
        let rod = &plant.rod;
        let known = format!(
            "[rod]\ndiameter_mm = {}\nlength_mm = {}\ndensity_kg_per_m3 = {}\nspecific_heat_j_per_kg_k = {}\n\
             resistance_ohm_per_m = {}\n[surroundings]\nambient_degc = {}\n",
            1e3 * rod.diameter_m,
            1e3 * rod.length_m,
            rod.density_kg_per_m3,
            rod.specific_heat_j_per_kg_k,
            rod.resistance_ohm_per_m,
            plant.ambient_degc
        );
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("run.csv"), rows).unwrap();
        fs::write(folder.path().join("rod.toml"), known).unwrap();
        Self { folder, plant }
    }

    /// JSON of `sma identify` on its recording.
    fn identified(&self) -> Value {
        let call = "identify rod.toml --train run.csv --no-plot --quiet --json -";
        let mut sma = Command::cargo_bin("sma").unwrap();
        let run = sma
            .args(call.split_whitespace())
            .current_dir(self.folder.path());
        let output = run.output().unwrap();
        let code = output.status.code().unwrap();
        assert!(
            code == 0 || code == 4,
            "{code}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        serde_json::from_slice(&output.stdout).unwrap()
    }

    /// Time constant, s, middle of the loop, °C, and half width, K.
    fn truth(&self) -> [f64; 3] {
        let [center_degc, half_width_k] = match self.plant.hysteresis {
            LoopFamily::L2p(l2p) => [l2p.loop_center_degc, l2p.loop_half_width_k],
            LoopFamily::Preisach(loops) => {
                between(loops.heating_center_degc, loops.cooling_center_degc)
            }
            LoopFamily::Relays(loops) => {
                between(loops.heating_center_degc, loops.cooling_center_degc)
            }
            LoopFamily::Cosine(loops) => between(
                0.5 * (loops.austenite_start_degc + loops.austenite_finish_degc),
                0.5 * (loops.martensite_start_degc + loops.martensite_finish_degc),
            ),
            LoopFamily::Tanaka(loops) => {
                let half_done = std::f64::consts::LN_2;
                between(
                    loops.austenite_start_degc + half_done / loops.austenite_rate_per_k,
                    loops.martensite_start_degc - half_done / loops.martensite_rate_per_k,
                )
            }
        };
        [self.plant.time_constant_s(), center_degc, half_width_k]
    }
}

/// Center and half width of a loop between the middles of its branches.
fn between(heating_degc: f64, cooling_degc: f64) -> [f64; 2] {
    [
        0.5 * (heating_degc + cooling_degc),
        0.5 * (heating_degc - cooling_degc),
    ]
}

const NAMES: [&str; 3] = ["tau_s", "loop_center_degc", "loop_half_width_k"];

/// Value and interval of a parameter.
fn parameter<'v>(identified: &'v Value, name: &str) -> (f64, &'v Value) {
    let parameters = identified["parameters"].as_array().unwrap();
    let found = parameters.iter().find(|one| one["name"] == name).unwrap();
    (found["values"][0].as_f64().unwrap(), &found["ci95"][0])
}

/// Equal steps, equal triangles, or a single excursion of a lab, in turn.
fn one_rate(number: u64) -> DrawnRig {
    DrawnRig::new(number, |plant, draw, logging| {
        let lab = draw
            .lab_drive(Manner::OneExcursion, plant, logging)
            .profile
            .drive;
        let largest = lab.iter().copied().fold(0.0, f64::max);
        let period = SAMPLES / 3;
        let share = |k: usize| (k % period) as f64 / period as f64;
        let steps = |k: usize| f64::from(u8::from((0.1..0.5).contains(&share(k))));
        let triangles = |k: usize| (1.0 - (share(k) - 0.5).abs() / 0.4).max(0.0);
        let drive = match number / 6 % 3 {
            0 => (0..SAMPLES).map(|k| largest * steps(k)).collect(),
            1 => (0..SAMPLES).map(|k| largest * triangles(k)).collect(),
            _ => lab,
        };
        (drive, 0)
    })
}

#[test]
fn intervals_of_one_rate_hold_the_truth_or_the_parameter_is_called_not_fixed() {
    let (mut held, mut said, mut table) = ([0; 3], 0, String::new());
    for number in 0..RIGS {
        let rig = one_rate(number);
        let identified = rig.identified();
        said += u32::from(!identified["other_loops_carried"].is_null());
        let truth = rig.truth();
        write!(
            table,
            "{number} {:?}: ",
            FAMILIES[number as usize % FAMILIES.len()]
        )
        .unwrap();
        for (k, name) in NAMES.into_iter().enumerate() {
            let (value, interval) = parameter(&identified, name);
            let ends = [0, 1].map(|end| interval[end].as_f64());
            let holds = match ends {
                [Some(lower), Some(upper)] => (lower..=upper).contains(&truth[k]),
                _ => true,
            };
            held[k] += u32::from(holds);
            let mark = if holds { "" } else { " MISSED" };
            write!(
                table,
                "{name} {:.3} {value:.3} {interval}{mark}; ",
                truth[k]
            )
            .unwrap();
        }
        writeln!(
            table,
            "rmse {} {}",
            identified["fit"]["train_rmse"], identified["other_loops_carried"]
        )
        .unwrap();
    }
    assert!(u64::from(said) >= RIGS * 9 / 10, "{said}\n{table}");
    let enough = |held: &u32| 10 * u64::from(*held) >= 9 * RIGS;
    assert!(held.iter().all(enough), "{held:?} of {RIGS}\n{table}");
}

#[test]
fn the_loop_of_a_rig_that_starts_warm_is_found() {
    let (mut errors, mut table) = (Vec::new(), String::new());
    for number in 0..RIGS {
        let rig = DrawnRig::new(100 + number, |plant, draw, logging| {
            let drive = draw.lab_drive(Manner::WarmStart, plant, logging);
            (drive.profile.drive, drive.n_before)
        });
        let identified = rig.identified();
        let [.., truth_k] = rig.truth();
        let (half_width_k, interval) = parameter(&identified, "loop_half_width_k");
        errors.push((half_width_k / truth_k - 1.0).abs());
        writeln!(
            table,
            "{number} {:?}: {truth_k:.3} {half_width_k:.3} {interval} rmse {}",
            FAMILIES[number as usize % FAMILIES.len()],
            identified["fit"]["train_rmse"]
        )
        .unwrap();
    }
    errors.sort_by(f64::total_cmp);
    let median = errors[errors.len() / 2];
    assert!(median <= 0.02, "{median}\n{table}");
}
