//! Do minor loops close? Reversal curves under both rules of memory, side by side.
//!
//! First-order curves leave a limiting curve and are the same under both rules. Nested curves leave
//! another reversal curve: there the paper's operator, which remembers the last reversal only,
//! misses the point that Madelung's rules return to.
//!
//! `cargo run -p sma-hysteresis --example minor_loops`

#![allow(
    clippy::print_stdout,
    reason = "an example shows its results by printing them"
)]

use sma_hysteresis::{
    Branch, Hysteresis, HysteresisError, LimitingLoop, LoopParams, Rule, SineProximity,
};

/// Far below the loop.
const COLD_DEGC: f64 = 0.0;
/// Where all curves leave the heating branch: its fraction is about ½ there.
const TOP_DEGC: f64 = 80.0;
const BOTTOMS_DEGC: [f64; 5] = [75.0, 70.0, 65.0, 60.0, 40.0];

fn material(rule: Rule) -> Result<Hysteresis<1>, HysteresisError> {
    let limits = LimitingLoop::new([LoopParams {
        loop_center_degc: 70.0,
        loop_half_width_k: 8.0,
        loop_spread_k: 5.0,
        ..LoopParams::default()
    }])?;
    Ok(Hysteresis::new(limits, SineProximity::new([0.8])?, rule))
}

/// Fraction after each of some temperatures, visited in turn from the cold.
fn fractions<const N: usize>(
    rule: Rule,
    temperatures_degc: [f64; N],
) -> Result<[f64; N], HysteresisError> {
    let material = material(rule)?;
    let mut memory = material.on_limiting_curve(Branch::Cooling, [COLD_DEGC]);
    Ok(temperatures_degc.map(|temperature_degc| {
        let [fraction] = material.commit(&mut memory, [temperature_degc]);
        fraction
    }))
}

/// A row of fractions under the last reversal, then under nested memory.
fn row(label: &str, temperatures: impl Fn(f64) -> [f64; 3]) -> Result<(), HysteresisError> {
    print!("{label:>14}");
    for rule in [Rule::LastReversal, Rule::Nested] {
        print!("  |");
        for bottom_degc in BOTTOMS_DEGC {
            let [.., fraction] = fractions(rule, temperatures(bottom_degc))?;
            print!(" {fraction:7.4}");
        }
    }
    println!();
    Ok(())
}

fn main() -> Result<(), HysteresisError> {
    println!(
        "Fraction on curves that leave the heating branch at {TOP_DEGC} °C, turn, and come back.\n"
    );
    println!(
        "{:>14}  | {:<39}  | {:<39}",
        "", "last reversal (the paper)", "nested (wiping-out)"
    );
    print!("{:>14}", "turned at");
    for _ in 0..2 {
        print!("  |");
        for bottom_degc in BOTTOMS_DEGC {
            print!(" {:>7}", format!("{bottom_degc} °C"));
        }
    }
    println!("\n{}", "-".repeat(14 + 2 * (3 + 8 * BOTTOMS_DEGC.len())));
    // First order: halfway down, and at the bottom.
    row("going down", |bottom_degc| {
        let halfway_degc = 0.5 * (TOP_DEGC + bottom_degc);
        [COLD_DEGC, TOP_DEGC, halfway_degc]
    })?;
    row("turned", |bottom_degc| [COLD_DEGC, TOP_DEGC, bottom_degc])?;
    // Nested: on the way back up, and where it left.
    for share in [0.25, 0.5, 0.75, 1.0] {
        row(&format!("{:.0} % back", 100.0 * share), |bottom_degc| {
            let upward_degc = bottom_degc + share * (TOP_DEGC - bottom_degc);
            [TOP_DEGC, bottom_degc, upward_degc]
        })?;
    }
    println!("\nGap of closure, fraction on return minus fraction when left:");
    print!("{:>14}", "");
    for rule in [Rule::LastReversal, Rule::Nested] {
        print!("  |");
        for bottom_degc in BOTTOMS_DEGC {
            let [left, _, back] = fractions(rule, [TOP_DEGC, bottom_degc, TOP_DEGC])?;
            // Without the sign of a zero.
            print!(" {:7.4}", (back - left).abs());
        }
    }
    println!(
        "\n\nThe paper's operator closes only loops so wide that both of their branches end on the limiting\n\
         curves, here from {:.0} K on.",
        std::f64::consts::PI * 8.0 / 0.8
    );
    Ok(())
}
