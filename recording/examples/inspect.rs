//! Says what is in a recording and what stands in the way of identification, before anybody fits
//! anything to it.
//!
//! `cargo run -p recording --example inspect` for a generated recording,
//! `cargo run -p recording --example inspect -- run3.csv duty` for a file with default columns.

use std::error::Error;
use std::io::Write;

use recording::{
    Quantity, ReadOptions, Recording, RecordingError, RecordingParts, inspect, read_csv,
};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let recording = match arguments.next() {
        Some(path) => {
            let quantity = match arguments.next().as_deref() {
                Some("duty") => Quantity::Duty,
                Some("voltage") => Quantity::Voltage,
                Some("power") => Quantity::Power,
                _ => Quantity::Current,
            };
            read_csv(path, &ReadOptions::new(quantity))?
        }
        None => generated()?,
    };

    let inspection = inspect(&recording);
    let warnings = inspection.warnings();
    let mut stdout = std::io::stdout();
    writeln!(
        stdout,
        "{}: {} samples, {:?}",
        inspection.name, inspection.n_samples, inspection.sampling
    )?;
    for channel in [&inspection.drive, &inspection.output] {
        let (low, high, unit) = (channel.lowest, channel.highest, &channel.unit);
        write!(stdout, "{}: {low} to {high} {unit}", channel.role)?;
        match channel.quantization_step {
            Some(step) => writeln!(stdout, ", in steps of {step:.6} {unit}")?,
            None => writeln!(stdout)?,
        }
    }
    writeln!(
        stdout,
        "cycles: {}, repeated: {}, holds: {}",
        inspection.cycles.len(),
        inspection.repeats.map_or(0, |repeats| repeats.cycles.len()),
        inspection.holds.len()
    )?;
    if let Some(floor) = inspection.noise_floor {
        match floor.upper() {
            Some(upper) => writeln!(stdout, "noise: {:.6} to {upper:.6}", floor.lower())?,
            None => writeln!(stdout, "noise: at least {:.6}", floor.lower())?,
        }
    }
    for warning in &warnings {
        writeln!(stdout, "- {warning}")?;
    }
    Ok(())
}

/// Two minutes on, two minutes off, three times; a rod that answers with 20 s, a potentiometer of
/// 20.6 µm.
fn generated() -> Result<Recording, RecordingError> {
    let (dt_s, tau_s, step_mm) = (0.2, 20.0, 0.0206);
    let drive: Vec<f64> = (0..3800)
        .map(|k| {
            if k >= 200 && (k - 200) % 1200 < 600 {
                1.8
            } else {
                0.0
            }
        })
        .collect();
    let mut displacement_mm = 0.0;
    let output = drive.iter().map(|current_a| {
        let measured = (displacement_mm / step_mm + 0.25_f64).round() * step_mm;
        displacement_mm += (2.0 * current_a - displacement_mm) * dt_s / tau_s;
        measured
    });
    Recording::new(RecordingParts {
        name: "three pulses".to_owned(),
        time_s: Some((0..3800).map(|k| f64::from(k) * dt_s).collect()),
        output: output.collect(),
        drive,
        output_unit: "mm".to_owned(),
        ..RecordingParts::default()
    })
}
