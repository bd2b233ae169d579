//! Makes a fleet to try `sma batch` on: wires of one type, a recording each, some of which conceal physics, and some of which
//! are damaged.
//!
//! `cargo run --release -p sma-cli --example make_fleet -- DIR 200 20` makes 200 recordings in a folder that is not there yet,
//! 20 of them damaged. Without arguments it makes a fleet of six, two of them damaged, and removes it again.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

use truth_plant::{
    Converter, Draw, LatentHeat, Noise, NoiseKind, Shape, Supply, Traces, TruthPlant,
};

/// Sample time times samples of a recording, s.
const DURATION_S: f64 = 600.0;

/// Samples of a recording.
const SAMPLES: usize = 1500;

type Made<T> = Result<T, Box<dyn Error>>;

/// Ways in which a recording is damaged.
const DAMAGES: [&str; 10] = [
    "no numbers in a column",
    "two columns of the output",
    "a line that was cut off",
    "time that falls",
    "an empty file",
    "a header alone",
    "no column of the output",
    "a drive that never changes",
    "an output that never changes",
    "no text",
];

/// A wire: a third conceals latent heat, every fifth a supply that answers late.
fn wire(number: usize) -> TruthPlant {
    // Runs through 0..1 without an order that would show.
    let share = (number * 37 % 101) as f64 / 101.0;
    TruthPlant {
        convective_coefficient_w_per_m2_k: 55.0 + 15.0 * share,
        latent_heat: (number % 3 == 1).then_some(LatentHeat {
            enthalpy_j_per_kg: 12_000.0 + 6_000.0 * share,
        }),
        supply: (number % 5 == 2).then_some(Supply {
            dead_time_s: 0.6 + 0.4 * share,
            ..Supply::default()
        }),
        displacement_noise: Some(Noise {
            kind: NoiseKind::White,
            deviation: 5e-6,
        }),
        converter: Some(Converter {
            full_scale_m: 10e-3,
            lowest_m: -1e-3,
            bits: 16,
        }),
        ..TruthPlant::default()
    }
}

/// Rod file of all wires: what is known of them.
pub(crate) fn rod_file() -> String {
    let TruthPlant {
        rod, ambient_degc, ..
    } = TruthPlant::default();
    format!(
        "[rod]\ndiameter_mm = {}\nlength_mm = {}\ndensity_kg_per_m3 = {}\nspecific_heat_j_per_kg_k = {}\n\
         resistance_ohm_per_m = {}\n\n[surroundings]\nambient_degc = {ambient_degc}\n",
        rod.diameter_m * 1e3,
        rod.length_m * 1e3,
        rod.density_kg_per_m3,
        rod.specific_heat_j_per_kg_k,
        rod.resistance_ohm_per_m,
    )
}

fn csv(traces: &Traces) -> String {
    let mut text = "time_s,current_a,displacement_mm\n".to_owned();
    for k in 0..traces.time_s.len() {
        let (time_s, drive, shown) = (traces.time_s[k], traces.drive[k], traces.displacement_mm[k]);
        // Writing to a string does not fail.
        let _ = writeln!(text, "{time_s:.3},{drive:.4},{shown:.4}");
    }
    text
}

/// The recording of a wire.
pub(crate) fn recording(number: usize, n_samples: usize) -> Made<String> {
    let plant = wire(number);
    let drive = Draw::new(1)
        .drive(Shape::InnerLoops, &plant, n_samples)
        .drive;
    let dt_s = DURATION_S / n_samples as f64;
    Ok(csv(&plant.simulate(&drive, dt_s, number as u64)?))
}

/// A recording with a fault, in one of ten ways.
pub(crate) fn damaged(recording: &str, way: usize) -> Vec<u8> {
    let lines: Vec<&str> = recording.lines().collect();
    let line = lines.len() / 2;
    let changed = |change: &dyn Fn(usize, &str) -> String| {
        let lines = lines.iter().enumerate();
        let text: String = lines.map(|(k, line)| change(k, line) + "\n").collect();
        text.into_bytes()
    };
    let in_line = |text: &str| {
        changed(&|k, own| {
            if k == line {
                text.to_owned()
            } else {
                own.to_owned()
            }
        })
    };
    let with_column = |column: usize, value: &str| {
        changed(&|k, own| {
            let mut cells: Vec<&str> = own.split(',').collect();
            if k > 0 {
                cells[column] = value;
            }
            cells.join(",")
        })
    };
    match DAMAGES[way % DAMAGES.len()] {
        "no numbers in a column" => with_column(2, "-"),
        "two columns of the output" => changed(&|k, own| match k {
            0 => format!("{own},Displacement_mm"),
            _ => format!("{own},1.5"),
        }),
        "a line that was cut off" => in_line("300,2"),
        "time that falls" => in_line("0.1,2.0,1.5"),
        "an empty file" => Vec::new(),
        "a header alone" => [lines[0], "\n"].concat().into_bytes(),
        "no column of the output" => {
            changed(&|_, own| own[..own.rfind(',').unwrap_or(own.len())].to_owned())
        }
        "a drive that never changes" => with_column(1, "2.0"),
        "an output that never changes" => with_column(2, "1.5"),
        _ => (0..4096u32).map(|k| (k * 89 % 256) as u8).collect(),
    }
}

/// Writes a fleet into a folder that is not there yet.
pub(crate) fn make(folder: &Path, n_rigs: usize, n_damaged: usize, n_samples: usize) -> Made<()> {
    fs::create_dir(folder)?;
    fs::write(folder.join("rod.toml"), rod_file())?;
    // Spread over the fleet.
    let every = n_rigs / n_damaged.max(1);
    for number in 0..n_rigs {
        let mut bytes = recording(number, n_samples)?.into_bytes();
        let way = number / every.max(1);
        if number % every.max(1) == every / 2 && way < n_damaged {
            bytes = damaged(std::str::from_utf8(&bytes)?, way);
        }
        fs::write(folder.join(format!("wire-{number:03}.csv")), bytes)?;
    }
    Ok(())
}

#[allow(
    dead_code,
    reason = "the test that includes this file has its own main"
)]
fn main() -> Made<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match &arguments[..] {
        [] => {
            let folder = std::env::temp_dir().join(format!("fleet-{}", std::process::id()));
            make(&folder, 6, 2, 300)?;
            Ok(fs::remove_dir_all(folder)?)
        }
        [folder, n_rigs, n_damaged] => make(
            Path::new(folder),
            n_rigs.parse()?,
            n_damaged.parse()?,
            SAMPLES,
        ),
        _ => Err("expected a folder, how many recordings, and how many of them are damaged".into()),
    }
}
