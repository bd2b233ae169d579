//! How much do the rods of one batch differ under one and the same current?
//!
//! Two hundred rods, their diameters within 2 % and the air around each with its own coefficient within
//! 20 %, run in lockstep through one heating and cooling. Should the rig be calibrated rod by rod?
//!
//! `cargo run -p wiener --example batch_spread`

#![allow(
    clippy::print_stdout,
    reason = "an example shows its results by printing them"
)]

use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Drive, Ensemble, Member, Profile, Start, WienerError, WienerParams};

const AMBIENT_DEGC: f64 = 22.0;
const DT_S: f64 = 0.1;
const N_RODS: u32 = 200;
/// Heated for 40 s, cooled for 20 s.
const N_HEATED: usize = 400;
const N_SAMPLES: usize = 600;

/// Rod `k` of the batch: deviations from -1 to 1 that fill the square evenly.
fn rod(k: u32) -> Result<Member, WienerError> {
    // Multiples of 1/g and 1/g², where g³ = g + 1: the R2 sequence of low discrepancy.
    let spread = |step: f64| 2.0 * (step * f64::from(k)).fract() - 1.0;
    let (thickness, draft) = (spread(0.754_877_666), spread(0.569_840_291));
    let rod = RodParams {
        diameter_m: 0.75e-3 * (1.0 + 0.02 * thickness),
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 480.0,
        // Of the same alloy: resistance goes with the inverse of the section.
        resistance_ohm_per_m: 2.13 / (1.0 + 0.02 * thickness).powi(2),
        convective_coefficient_w_per_m2_k: 60.0 * (1.0 + 0.2 * draft),
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
    Ok(Member {
        params,
        start: Start::rest(AMBIENT_DEGC),
    })
}

fn main() -> Result<(), WienerError> {
    let members = (0..N_RODS).map(rod).collect::<Result<Vec<_>, _>>()?;
    let mut current_a = [0.0; N_SAMPLES];
    current_a[..N_HEATED].fill(2.0);
    let profile = Profile::uniform(&current_a, DT_S, AMBIENT_DEGC)?;

    // Displacements of all rods, a row a sample.
    let mut displacement_mm = vec![vec![0.0; members.len()]; N_SAMPLES];
    let ensemble = Ensemble {
        drive: Drive::Current,
        rule: Rule::Nested,
    };
    ensemble.run(&members, &profile, &mut |block| {
        for (row, values) in block.displacement.chunks(block.stride).enumerate() {
            displacement_mm[block.first_sample + row][block.first_member..][..block.members]
                .copy_from_slice(&values[..block.members]);
        }
    })?;

    println!("Displacement of {N_RODS} rods, mm, heated by 2 A until 40 s:\n");
    println!("  time   lowest   median  highest   spread");
    for sample in [50, 100, 150, 200, 399, 450, 500, 599] {
        let mut row = displacement_mm[sample].clone();
        row.sort_by(f64::total_cmp);
        let (lowest, median, highest) = (row[0], row[row.len() / 2], row[row.len() - 1]);
        let time_s = DT_S * sample as f64;
        let spread = highest - lowest;
        println!("{time_s:4.0} s {lowest:8.2} {median:8.2} {highest:8.2} {spread:8.2}");
    }
    println!(
        "\nHeld hot they differ little; on the way up and down by most of the stroke. A current planned for\n\
         the median rod serves a rig that only switches; one that must stop in between needs each rod's own fit."
    );
    Ok(())
}
