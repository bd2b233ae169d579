//! The rig of the demonstration, simulated by equations that the models do not share.

use std::fmt::Write;

use pid_tune::{Pid, PidGains, PidParams, Sample};
use truth_plant::{
    Converter, Draw, LatentHeat, Noise, NoiseKind, Shape, Supply, Traces, TruthError, TruthPlant,
};

/// Effects that are concealed in it.
pub(crate) const CONCEALED: &str =
    "A wire that takes up 15 kJ/kg while it transforms, behind a supply that answers 0.8 s late.";

/// Sample time of its recordings, s.
pub(crate) const DT_S: f64 = 0.2;

/// Samples of a recording.
const SAMPLES: usize = 3000;

/// Millimeters of a meter.
const MM_PER_M: f64 = 1e3;

/// A wire of known diameter, resistance and specific heat, driven by a current.
pub(crate) fn rig() -> TruthPlant {
    TruthPlant {
        latent_heat: Some(LatentHeat {
            enthalpy_j_per_kg: 15_000.0,
        }),
        supply: Some(Supply {
            dead_time_s: 0.8,
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

/// Its rod file: the properties that are known.
pub(crate) fn rod_file(plant: &TruthPlant, drive_max: f64) -> String {
    let rod = &plant.rod;
    format!(
        "[rod]\ndiameter_mm = {}\nlength_mm = {}\ndensity_kg_per_m3 = {}\nspecific_heat_j_per_kg_k = {}\n\
         resistance_ohm_per_m = {}\n\n[surroundings]\nambient_degc = {}\n\n[drive]\nkind = \"current\"\n\n\
         [limits]\ndrive_max = {drive_max:.3}\n\n[columns]\ndrive = \"current_a\"\noutput = \"displacement_mm\"\n",
        rod.diameter_m * MM_PER_M,
        rod.length_m * MM_PER_M,
        rod.density_kg_per_m3,
        rod.specific_heat_j_per_kg_k,
        rod.resistance_ohm_per_m,
        plant.ambient_degc,
    )
}

/// A recording of the rig: of one that decides, or of one that is not seen.
pub(crate) fn recorded(plant: &TruthPlant, shape: Shape, seed: u64) -> Result<Traces, TruthError> {
    let drive = Draw::new(seed).drive(shape, plant, SAMPLES).drive;
    plant.simulate(&drive, DT_S, seed)
}

/// A recording as a logger writes it.
pub(crate) fn csv(traces: &Traces) -> String {
    let mut text = "time_s,current_a,displacement_mm\n".to_owned();
    for k in 0..traces.time_s.len() {
        let (time_s, drive, shown) = (traces.time_s[k], traces.drive[k], traces.displacement_mm[k]);
        // Writing to a string does not fail.
        let _ = writeln!(text, "{time_s:.1},{drive:.4},{shown:.4}");
    }
    text
}

/// The rig under a controller, through set points that are one a sample, mm.
pub(crate) fn controlled(
    plant: &TruthPlant,
    (params, gains): (PidParams, PidGains),
    setpoints_mm: &[f64],
    seed: u64,
) -> anyhow::Result<Traces> {
    let pid = Pid::new(params, &[gains])?;
    let mut state = pid.rest([plant.offset_m * MM_PER_M])?;
    let mut controller = |k: usize, shown_mm: f64| {
        let sample = Sample {
            setpoint: setpoints_mm[k],
            measured: [shown_mm],
            feed_forward: 0.0,
        };
        pid.step(&mut state, &sample).drive[0]
    };
    Ok(plant.controlled(setpoints_mm.len(), params.dt_s, seed, &mut controller)?)
}
