//! Which of a rod's temperatures can be known from current and displacement? The same recording is
//! fitted twice: with heat capacity and resistance given, and without.

#![allow(clippy::print_stdout, reason = "an example talks")]

use std::error::Error;
use std::ops::ControlFlow;

use identify::{Fit, FitConfig, WienerModel, fit};
use recording::{Quantity, Recording, RecordingParts};
use rig_files::rod_file;
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Drive, Plant, Profile, Wiener, WienerParams, run};

const KNOWN: &str = "
[rod]
diameter_mm = 1.0
density_kg_per_m3 = 6450.0
specific_heat_j_per_kg_k = 500.0
resistance_ohm_per_m = 1.2
[surroundings]
ambient_degc = 21.0
";

const UNKNOWN: &str = "surroundings.ambient_degc = 21.0";

/// A rod with its loop at 70 °C, heated and cooled four times, each time less.
fn recorded() -> Result<Recording, Box<dyn Error>> {
    let rod = RodParams {
        diameter_m: 1e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 500.0,
        resistance_ohm_per_m: 1.2,
        convective_coefficient_w_per_m2_k: 90.0,
    };
    let params = WienerParams {
        heat: rod.heat_balance()?,
        limiting_loop: LoopParams {
            loop_half_width_k: 8.0,
            loop_spread_k: 6.0,
            ..LoopParams::default()
        },
        zeta: 0.8,
        gain: 3.0,
        offset: 0.2,
    };
    let drive: Vec<f64> = (0..800)
        .map(|k| {
            if k / 100 % 2 == 0 {
                4.0 - 0.002 * f64::from(k)
            } else {
                1.0
            }
        })
        .collect();
    let model = Wiener::new(Drive::Current, Rule::LastReversal, &[params])?;
    let profile = Profile::uniform(&drive, 0.25, 21.0)?;
    let mut output = Vec::new();
    run(&model, &mut model.rest(21.0), &profile, |_, shown| {
        output.push(shown.displacement[0])
    });
    Ok(Recording::new(RecordingParts {
        name: "generated".to_owned(),
        time_s: Some((0..800).map(|k| 0.25 * f64::from(k)).collect()),
        drive_quantity: Quantity::Current,
        drive,
        output_unit: "mm".to_owned(),
        output,
        ..RecordingParts::default()
    })?)
}

fn identified(rod: &str, training: &[Recording]) -> Result<Fit, Box<dyn Error>> {
    let model = WienerModel::new(
        &rod_file::parse("rod.toml", rod)?,
        Rule::LastReversal,
        training,
    )?;
    Ok(fit(&model, training, &FitConfig::default(), &mut |_| {
        ControlFlow::Continue(())
    })?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let training = [recorded()?];
    let known = identified(KNOWN, &training)?;
    let unknown = identified(UNKNOWN, &training)?;
    println!("{:<22}{:>10}{:>10}{:>10}", "", "truth", "known", "unknown");
    println!(
        "{:<22}{:>10}{:>10.1e}{:>10.1e}",
        "RMSE (mm)", "", known.train_rmse, unknown.train_rmse
    );
    let value = |fit: &Fit, name| {
        fit.parameter(name)
            .map_or(f64::NAN, |found| found.values[0])
    };
    for (name, truth) in [
        ("tau_s", 8.958),
        ("loop_center_degc", 70.0),
        ("loop_half_width_k", 8.0),
    ] {
        let (with, without) = (value(&known, name), value(&unknown, name));
        println!("{name:<22}{truth:>10.3}{with:>10.3}{without:>10.3}");
    }
    let ratio = |fit| (value(fit, "loop_center_degc") - 21.0) / value(fit, "loop_half_width_k");
    println!(
        "{:<22}{:>10.3}{:>10.3}{:>10.3}",
        "(center-ambient)/width",
        49.0 / 8.0,
        ratio(&known),
        ratio(&unknown)
    );
    println!(
        "\nBoth meet the recording equally well. Without heat capacity and resistance the time constant and \
         the ratio are right, the temperatures are not: give both, or record a temperature."
    );
    Ok(())
}
