//! Which constant current brings a wire to 80 °C in time, if the supply gives no more than 2.5 A?
//!
//! Eq. 3 answers for the wire, the supply sets the limit, and cooling can be asked for but not
//! commanded: current only heats.
//!
//! `cargo run -p sma-thermal --example clamp_the_current`

#![allow(
    clippy::print_stdout,
    reason = "an example shows its results by printing them"
)]

use sma_thermal::{HeatBalance, Heating, Reach, RodParams, ThermalError};

const AMBIENT_DEGC: f64 = 22.0;
const WANTED_DEGC: f64 = 80.0;
const SUPPLY_LIMIT_A: f64 = 2.5;

/// A NiTi wire of half a millimeter in still air.
const WIRE: RodParams = RodParams {
    diameter_m: 0.5e-3,
    density_kg_per_m3: 6450.0,
    specific_heat_j_per_kg_k: 480.0,
    resistance_ohm_per_m: 4.8,
    convective_coefficient_w_per_m2_k: 60.0,
};

fn main() -> Result<(), ThermalError> {
    let heat = HeatBalance::new([WIRE.heat_balance()?])?;
    let ([tau_s], [lambda_k_per_a2]) = (heat.tau_s(), heat.lambda_k_per_a2());
    println!(
        "A wire with a time constant of {tau_s:.2} s that rises {lambda_k_per_a2:.1} K per A².\n"
    );
    heat_it(&heat)?;
    cool_it(&heat)
}

fn heat_it(heat: &HeatBalance) -> Result<(), ThermalError> {
    println!("From {AMBIENT_DEGC} to {WANTED_DEGC} °C with at most {SUPPLY_LIMIT_A} A:\n");
    println!("within    needs     gets      arrives at");
    for within_s in [10.0, 5.0, 2.0, 1.0] {
        let needed_a = heat.current_to_reach_a(&Reach {
            from_degc: AMBIENT_DEGC,
            to_degc: WANTED_DEGC,
            ambient_degc: AMBIENT_DEGC,
            within_s,
        })?;
        let given_a = needed_a.min(SUPPLY_LIMIT_A);
        let heating = Heating {
            power_w_per_m: [given_a * given_a * WIRE.resistance_ohm_per_m],
            ambient_degc: AMBIENT_DEGC,
        };
        let [reached_degc] = heat.step([AMBIENT_DEGC], &heating, &heat.over(within_s));
        let remark = if needed_a > SUPPLY_LIMIT_A {
            "   infeasible"
        } else {
            ""
        };
        println!(
            "{within_s:4.0} s  {needed_a:6.2} A  {given_a:6.2} A  {reached_degc:8.1} °C{remark}"
        );
    }
    // Eq. 2 solved for the time.
    let ([tau_s], [lambda_k_per_a2]) = (heat.tau_s(), heat.lambda_k_per_a2());
    let highest_rise_k = lambda_k_per_a2 * SUPPLY_LIMIT_A * SUPPLY_LIMIT_A;
    let shortest_s = -tau_s * (-(WANTED_DEGC - AMBIENT_DEGC) / highest_rise_k).ln_1p();
    println!("\nAt the limit it takes {shortest_s:.2} s.\n");
    Ok(())
}

fn cool_it(heat: &HeatBalance) -> Result<(), ThermalError> {
    println!("And back from {WANTED_DEGC} °C:\n");
    for (to_degc, within_s) in [(40.0, 10.0), (40.0, 5.0), (15.0, 600.0)] {
        let answer = heat.current_to_reach_a(&Reach {
            from_degc: WANTED_DEGC,
            to_degc,
            ambient_degc: AMBIENT_DEGC,
            within_s,
        });
        match answer {
            Ok(current_a) => {
                println!(
                    "{to_degc} °C within {within_s} s: {current_a:.2} A slow the cooling down"
                );
            }
            Err(reason @ (ThermalError::CannotCool { .. } | ThermalError::BelowAmbient { .. })) => {
                println!("refused: {reason}");
            }
            Err(fault) => return Err(fault),
        }
    }
    Ok(())
}
