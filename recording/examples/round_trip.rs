//! Writes a recording to CSV, reads it back, and decides whether it can be simulated at a fixed
//! step and whether it can be used for identification.
//!
//! `cargo run -p recording --example round_trip`

use std::error::Error;
use std::io::Write;

use recording::{Quantity, ReadOptions, Recording, RecordingParts, Sampling, parse_csv, write_csv};

fn main() -> Result<(), Box<dyn Error>> {
    // A current pulse on a rod that answers with 20 s, sampled by a clock that prints milliseconds.
    let (dt_s, tau_s) = (0.287, 20.0);
    let time_s: Vec<f64> = (0..400)
        .map(|k| (f64::from(k) * dt_s * 1000.0_f64).round() / 1000.0)
        .collect();
    let drive: Vec<f64> = time_s
        .iter()
        .map(|t| if (10.0..60.0).contains(t) { 1.8 } else { 0.0 })
        .collect();
    let mut displacement_mm = 0.0;
    let output = drive
        .iter()
        .map(|current_a| {
            let measured = displacement_mm;
            displacement_mm += (2.0 * current_a - displacement_mm) * dt_s / tau_s;
            measured
        })
        .collect();
    let generated = Recording::new(RecordingParts {
        name: "pulse.csv".to_owned(),
        time_s: Some(time_s),
        drive_quantity: Quantity::Current,
        drive,
        output_unit: "mm".to_owned(),
        output,
        ..RecordingParts::default()
    })?;

    let mut csv = Vec::new();
    write_csv(&generated, &mut csv)?;
    let recording = parse_csv(
        csv.as_slice(),
        "pulse.csv",
        &ReadOptions::new(Quantity::Current),
    )?;
    if recording != generated {
        return Err("the recording did not survive being written and read".into());
    }

    recording.check_identifiable()?;
    let mut stdout = std::io::stdout();
    match recording.sampling() {
        Sampling::Uniform { dt_s } => writeln!(
            stdout,
            "{}: {} samples, fixed step {dt_s} s",
            recording.name(),
            recording.len()
        )?,
        Sampling::Jittered { median_dt_s, .. } => writeln!(
            stdout,
            "{}: jittered around {median_dt_s} s",
            recording.name()
        )?,
        Sampling::Untimed => writeln!(stdout, "{}: static data", recording.name())?,
    }

    // The same pulse, recorded with the drive unplugged: readable, but nothing to identify.
    let unplugged = "time_s,current_a,displacement_mm\n0,0,0\n0.287,0,0\n0.574,0,0\n";
    let recording = parse_csv(
        unplugged.as_bytes(),
        "unplugged.csv",
        &ReadOptions::new(Quantity::Current),
    )?;
    if let Err(fault) = recording.check_identifiable() {
        writeln!(stdout, "{fault}")?;
    }
    Ok(())
}
