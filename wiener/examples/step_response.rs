//! How long must a rod be heated by 2 A to reach 90 % of its stroke, and what is left of it after 20 s
//! of cooling?
//!
//! The stroke is that of a current held for good. Cooling does not undo heating at the same rate: the
//! rod must first cool across the width of its loop.
//!
//! `cargo run -p wiener --example step_response`

#![allow(
    clippy::print_stdout,
    reason = "an example shows its results by printing them"
)]

use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Drive, Input, Plant, Profile, State, Wiener, WienerError, WienerParams, run};

const AMBIENT_DEGC: f64 = 22.0;
const CURRENT_A: f64 = 2.0;
const DT_S: f64 = 0.05;
/// Ten minutes: as good as for good.
const N_SETTLED: usize = 12_000;

/// A rod of 0.75 mm in still air that moves its load by 5 mm.
fn rod() -> Result<Wiener, WienerError> {
    let rod = RodParams {
        diameter_m: 0.75e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 480.0,
        resistance_ohm_per_m: 2.13,
        convective_coefficient_w_per_m2_k: 60.0,
    };
    let params = WienerParams {
        heat: rod.heat_balance()?,
        limiting_loop: LoopParams {
            loop_center_degc: 55.0,
            loop_half_width_k: 8.0,
            loop_spread_k: 3.0,
            ..LoopParams::default()
        },
        zeta: 0.85,
        gain: 5.0,
        offset: 0.0,
    };
    Wiener::new(Drive::Current, Rule::Nested, &[params])
}

/// Displacement at the start of each sample of a held current, mm.
fn held(rod: &Wiener, state: &mut State, n_samples: usize) -> Result<Vec<f64>, WienerError> {
    let current_a = vec![CURRENT_A; n_samples];
    let profile = Profile::uniform(&current_a, DT_S, AMBIENT_DEGC)?;
    let mut displacement_mm = Vec::with_capacity(n_samples);
    run(rod, state, &profile, |_, output| {
        displacement_mm.push(output.displacement[0]);
    });
    Ok(displacement_mm)
}

fn main() -> Result<(), WienerError> {
    let rod = rod()?;
    let heating_mm = held(&rod, &mut rod.rest(AMBIENT_DEGC), N_SETTLED)?;
    let rest_mm = heating_mm[0];
    let stroke_mm = heating_mm[N_SETTLED - 1] - rest_mm;
    println!(
        "Heated by {CURRENT_A} A for good the rod moves by {stroke_mm:.2} mm. On the way there:\n"
    );
    let mut n_heated = 0;
    for share in [0.1, 0.5, 0.9] {
        let wanted_mm = rest_mm + share * stroke_mm;
        n_heated = heating_mm.partition_point(|&displacement_mm| displacement_mm < wanted_mm);
        println!(
            "  {:3.0} % of the stroke after {:5.2} s",
            100.0 * share,
            DT_S * n_heated as f64
        );
    }

    // Stopped there; the state goes on into the cooling.
    let mut state = rod.rest(AMBIENT_DEGC);
    held(&rod, &mut state, n_heated)?;
    println!("\nSwitched off at 90 %:\n\n  cooled for   rod at   share of the stroke left");
    for k in 0..=400 {
        if k % 80 == 0 {
            let output = rod.output(&state);
            println!(
                "{:10.0} s {:6.1} °C {:9.0} %",
                DT_S * f64::from(k),
                output.temperature_degc[0],
                100.0 * (output.displacement[0] - rest_mm) / stroke_mm
            );
        }
        let off = Input {
            drive: [0.0],
            ambient_degc: AMBIENT_DEGC,
        };
        rod.step(&mut state, &off, DT_S);
    }
    Ok(())
}
