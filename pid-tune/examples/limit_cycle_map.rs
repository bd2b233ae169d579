//! Where does the paper's loop cycle? A map over set point, time constant, largest current and unit of the error, and
//! how well what is predicted agrees with simulation; prints Markdown. The memory is the paper's, or nested with the
//! argument `nested`.
//!
//! "No limit cycle", says the paper of its gains, 200 and 0.01. In mm that is a switch, in meters a soft controller;
//! the rods are like the paper's: 5 mm of stroke, sampled every 0.287 s by a converter of 12 bits.

#![allow(clippy::print_stdout, reason = "what an example is for")]

use core::ops::Range;

use pid_tune::{
    Agreement, AntiWindup, DerivativeOf, DriveLimits, LoopAnalysis, PidGains, PidParams,
    PredictedCycle, RodLoop, RodLoopParams, Source, TuneError,
};
use rayon::prelude::*;
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::{HeatBalanceParams, ThermalConstants};
use wiener::{Drive, WienerParams};

const SETPOINTS_MM: [f64; 5] = [0.5, 1.0, 2.0, 3.0, 4.0];
const TAUS_S: [f64; 3] = [3.0, 12.0, 48.0];
const CURRENTS_A: [f64; 3] = [2.2, 2.7, 3.4];

/// One cell of a map.
#[derive(Clone, Copy)]
struct Cell {
    rule: Rule,
    /// Gain per mm.
    kp: f64,
    tau_s: f64,
    largest_a: f64,
    setpoint_mm: f64,
    dead_time_samples: usize,
    loop_center_degc: f64,
    loop_spread_k: f64,
}

impl Cell {
    fn analyzed(&self) -> Result<LoopAnalysis, TuneError> {
        RodLoop::new(RodLoopParams {
            rod: WienerParams {
                heat: HeatBalanceParams::from_constants(ThermalConstants {
                    tau_s: self.tau_s,
                    lambda_k_per_a2: 15.0,
                }),
                limiting_loop: LoopParams {
                    loop_center_degc: self.loop_center_degc,
                    loop_half_width_k: 8.0,
                    loop_spread_k: self.loop_spread_k,
                    ..LoopParams::default()
                },
                zeta: 0.85,
                gain: 5.0,
                offset: -0.2,
            },
            drive: Drive::Current,
            rule: self.rule,
            controller: PidParams {
                dt_s: 0.287,
                limits: DriveLimits {
                    lower: 0.0,
                    upper: self.largest_a,
                },
                anti_windup: AntiWindup::Clamping,
                derivative_of: DerivativeOf::Measurement,
                derivative_filter_s: 0.0,
                setpoint_weight: 1.0,
                gain_schedule: None,
            },
            // 200 and 0.01, whatever the unit: ki/kp stays.
            gains: PidGains {
                kp: self.kp,
                ki: self.kp * 0.01 / 200.0,
                kd: 0.0,
            },
            setpoint: self.setpoint_mm,
            ambient_degc: 22.0,
            dead_time_samples: self.dead_time_samples,
            quantization_step: 5.0 / 4096.0,
        })?
        .analyzed()
    }
}

type Analyzed = (Cell, LoopAnalysis);

fn analyzed(cells: &[Cell]) -> Result<Vec<Analyzed>, TuneError> {
    cells
        .par_iter()
        .map(|cell| Ok((*cell, cell.analyzed()?)))
        .collect()
}

fn main() -> Result<(), TuneError> {
    let rule = match std::env::args().nth(1).as_deref() {
        Some("nested") => Rule::Nested,
        _ => Rule::LastReversal,
    };
    println!("# Limit cycles of the paper's loop\n");
    existence(rule)?;
    println!("## Fast rods with dead time, memory: {}\n", name(rule));
    accuracy(&with_dead_time(rule)?);
    Ok(())
}

fn name(rule: Rule) -> &'static str {
    match rule {
        Rule::LastReversal => "last reversal (the paper's operator)",
        Rule::Nested => "nested",
    }
}

/// The map of existence.
fn existence(rule: Rule) -> Result<(), TuneError> {
    println!("## Memory: {}\n", name(rule));
    println!(
        "Largest half peak-to-peak of three starts, µm; · for rest, ! where rest or cycle was not foreseen.\n"
    );
    let mut map = Vec::new();
    for (unit, kp) in [("mm", 200.0), ("m", 0.2)] {
        for largest_a in CURRENTS_A {
            println!("Error in {unit}, at most {largest_a} A:\n");
            println!(
                "| τ, s | {} |",
                SETPOINTS_MM.map(|r| format!("{r} mm")).join(" | ")
            );
            println!("|{}", " --- |".repeat(1 + SETPOINTS_MM.len()));
            for tau_s in TAUS_S {
                let cells = SETPOINTS_MM.map(|setpoint_mm| Cell {
                    rule,
                    kp,
                    tau_s,
                    largest_a,
                    setpoint_mm,
                    dead_time_samples: 0,
                    loop_center_degc: 65.0,
                    loop_spread_k: 4.5,
                });
                let row = analyzed(&cells)?;
                let shown: Vec<String> = row.iter().map(|(_, found)| shown(found)).collect();
                println!("| {tau_s} | {} |", shown.join(" | "));
                map.extend(row);
            }
            println!();
        }
    }
    for (unit, kp) in [("mm", 200.0), ("m", 0.2)] {
        let of_unit: Vec<_> = map
            .iter()
            .filter(|(cell, _)| cell.kp.total_cmp(&kp).is_eq())
            .collect();
        let count = |holds: fn(&LoopAnalysis) -> bool| {
            of_unit.iter().filter(|(_, found)| holds(found)).count()
        };
        println!(
            "Error in {unit}: {} of {} cells cycle in simulation, {} are foreseen to; both agree in {}.\n",
            count(LoopAnalysis::cycles_in_simulation),
            of_unit.len(),
            count(LoopAnalysis::foresees_cycle),
            count(agrees),
        );
    }
    let n_agree = map.iter().filter(|(_, found)| agrees(found)).count();
    let share = 100.0 * n_agree as f64 / map.len() as f64;
    println!(
        "Rest or cycle as foreseen in {n_agree} of {} cells, {share:.1} %.\n",
        map.len()
    );
    accuracy(&map);
    Ok(())
}

fn agrees(found: &LoopAnalysis) -> bool {
    found.foresees_cycle() == found.cycles_in_simulation()
}

fn shown(found: &LoopAnalysis) -> String {
    let amplitudes = found
        .outcomes
        .iter()
        .filter_map(|outcome| outcome.oscillation);
    let largest_mm = amplitudes.map(|cycle| cycle.amplitude).fold(0.0, f64::max);
    let mark = if agrees(found) { "" } else { " !" };
    if largest_mm > 0.0 {
        format!("{:.1}{mark}", 1000.0 * largest_mm)
    } else {
        format!("·{mark}")
    }
}

/// Fast rods, with dead time: all of them cycle.
fn with_dead_time(rule: Rule) -> Result<Vec<Analyzed>, TuneError> {
    let mut cells = Vec::new();
    for dead_time_samples in [1, 2, 4, 8] {
        for tau_s in [2.0, 4.0, 8.0] {
            for largest_a in [2.4, 3.2] {
                for setpoint_mm in [0.8, 1.8, 3.2] {
                    cells.push(Cell {
                        rule,
                        kp: 200.0,
                        tau_s,
                        largest_a,
                        setpoint_mm,
                        dead_time_samples,
                        loop_center_degc: 60.0,
                        loop_spread_k: 3.5,
                    });
                }
            }
        }
    }
    analyzed(&cells)
}

/// How far amplitude and frequency are off where loops cycle.
fn accuracy(found: &[Analyzed]) {
    let outcomes: Vec<_> = found.iter().flat_map(|(_, found)| found.outcomes).collect();
    let count = |agreement| {
        outcomes
            .iter()
            .filter(|outcome| outcome.agreement == agreement)
            .count()
    };
    println!(
        "{} loops, of which {} cycle; of {} runs {} are confirmed (amplitude and frequency within 15 %), {} cycle \
         otherwise, {} refute the forecast.\n",
        found.len(),
        found
            .iter()
            .filter(|(_, found)| found.cycles_in_simulation())
            .count(),
        outcomes.len(),
        count(Agreement::Confirmed),
        count(Agreement::Inaccurate),
        count(Agreement::Refuted),
    );
    println!(
        "| forecast by | runs | amplitude off, median | 90 % | frequency off, median | 90 % |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    let errors = |wanted: &dyn Fn(Source, bool) -> bool| -> Vec<[f64; 2]> {
        outcomes
            .iter()
            .filter_map(|outcome| {
                let (forecast, cycle) = (outcome.forecast?, outcome.oscillation?);
                wanted(forecast.source, forecast.reliable).then_some([
                    forecast.amplitude / cycle.sine_amplitude - 1.0,
                    forecast.frequency_hz / cycle.frequency_hz - 1.0,
                ])
            })
            .collect()
    };
    row("all", errors(&|_, _| true));
    row(
        "stable orbit",
        errors(&|source, reliable| source == Source::Chatter && reliable),
    );
    row(
        "unstable orbit",
        errors(&|source, reliable| source == Source::Chatter && !reliable),
    );
    row(
        "harmonic balance, reliable",
        errors(&|source, reliable| source == Source::DescribingFunction && reliable),
    );
    row(
        "harmonic balance, unreliable",
        errors(&|source, reliable| source == Source::DescribingFunction && !reliable),
    );
    println!("\nHarmonic balance alone (the largest stable cycle), whatever the forecast was:\n");
    println!(
        "| ratio of harmonics | runs | amplitude off, median | 90 % | frequency off, median | 90 % |"
    );
    println!("| --- | --- | --- | --- | --- | --- |");
    for (label, ratios) in [
        ("up to 0.15", 0.0..0.15),
        ("0.15 to 0.3", 0.15..0.3),
        ("above 0.3", 0.3..f64::INFINITY),
    ] {
        row(label, balance_errors(found, &ratios));
    }
    println!();
}

fn balance_errors(found: &[Analyzed], ratios: &Range<f64>) -> Vec<[f64; 2]> {
    let mut errors = Vec::new();
    for (cell, found) in found {
        for outcome in &found.outcomes {
            let belongs = |cycle: &&PredictedCycle| {
                cycle.stable
                    && (cell.rule == Rule::LastReversal
                        || cycle.approach == outcome.start.approach())
            };
            let largest = found
                .cycles
                .iter()
                .filter(belongs)
                .max_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
            if let (Some(cycle), Some(run)) = (largest, outcome.oscillation)
                && ratios.contains(&cycle.harmonic_ratio)
            {
                errors.push([
                    cycle.amplitude / run.sine_amplitude - 1.0,
                    cycle.frequency_hz / run.frequency_hz - 1.0,
                ]);
            }
        }
    }
    errors
}

fn row(label: &str, errors: Vec<[f64; 2]>) {
    let shares = [0, 1].map(|column| {
        let mut column: Vec<f64> = errors.iter().map(|error| error[column].abs()).collect();
        column.sort_by(f64::total_cmp);
        [0.5, 0.9].map(
            |share| match column.get((share * column.len() as f64) as usize) {
                Some(error) => format!("{:.1} %", 100.0 * error),
                None => "–".to_owned(),
            },
        )
    });
    let [amplitude, frequency] = shares.map(|shares| shares.join(" | "));
    println!("| {label} | {} | {amplitude} | {frequency} |", errors.len());
}
