//! A run, sample by sample.

use crate::lumped::{Lumped, LumpedLoop};
use crate::random::{Random, Stream};
use crate::rig::Sample;
use crate::surroundings::Weather;
use crate::volumes::Volumes;
use crate::{Hysteresis, Traces, TruthError, TruthPlant};

/// Millimeters of a meter.
const MM_PER_M: f64 = 1e3;

/// A plant under way, taken from sample to sample.
pub(crate) trait Machine {
    /// The next sample begins; its time counts from 0.
    fn begin(&mut self, sample: Sample);
    /// The supply is told `target` over a span of the sample, s; `index` is the sample's.
    fn advance(&mut self, target: f64, span_s: (f64, f64), index: usize) -> Result<(), TruthError>;
    /// The sample ends.
    fn end_sample(&mut self);
    /// Displacement as it leaves the electronics, without what is added to it.
    fn output_m(&self) -> f64;
    /// Temperature of the middle of the (first) rod.
    fn middle_degc(&self) -> f64;
    /// Temperature of the bead, if there is one.
    fn bead_degc(&self) -> Option<f64>;
    /// Transformed fraction, the mean over all rods.
    fn mean_fraction(&self) -> f64;
}

/// How long a run is, and where its randomness comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Course {
    pub(crate) n_samples: usize,
    pub(crate) dt_s: f64,
    pub(crate) seed: u64,
}

/// Commands to the supply within the last sample, each with the time in the sample, s, from which it holds: with a dead
/// time, an old command ends in the midst of a sample.
fn pieces(drive: &[f64], dt_s: f64, dead_time_s: f64) -> [(f64, f64); 2] {
    let whole = (dead_time_s / dt_s).floor();
    let rest_s = dead_time_s - whole * dt_s;
    let late = |samples: usize| match (drive.len() - 1).checked_sub(samples) {
        Some(index) => drive[index],
        None => 0.0,
    };
    let whole = whole as usize;
    [(0.0, late(whole + 1)), (rest_s, late(whole))]
}

/// Conditions of a run beside the plant.
#[derive(Debug)]
struct World {
    course: Course,
    weather: Weather,
}

impl World {
    fn new(plant: &TruthPlant, course: Course) -> Self {
        let Course {
            n_samples,
            dt_s,
            seed,
        } = course;
        let weather = Weather::new(
            plant.ambient_degc,
            plant.ambient_drift,
            plant.draughts,
            (n_samples, dt_s, seed),
        );
        Self { course, weather }
    }

    fn sample(&self, k: usize) -> Sample {
        let Self { course, weather } = self;
        Sample {
            start_s: k as f64 * course.dt_s,
            length_s: course.dt_s,
            ambient_degc: [weather.ambient_degc[k], weather.ambient_degc[k + 1]],
            draught: [weather.draught[k], weather.draught[k + 1]],
        }
    }
}

/// A run of the rod in volumes, whose drive is asked for at every sample, with what the sensor shows there, mm.
pub(crate) fn run<H: Hysteresis>(
    plant: &TruthPlant,
    operator: &H,
    course: Course,
    controller: &mut dyn FnMut(usize, f64) -> f64,
) -> Result<Traces, TruthError> {
    let world = World::new(plant, course);
    let volumes = Volumes::at_rest(plant, operator, world.sample(0))?;
    go(plant, volumes, &world, controller)
}

/// A run of the lumped rod, whose drive is asked for at every sample, with what the sensor shows there, mm.
pub(crate) fn run_lumped(
    plant: &TruthPlant,
    loops: LumpedLoop,
    course: Course,
    controller: &mut dyn FnMut(usize, f64) -> f64,
) -> Result<Traces, TruthError> {
    let world = World::new(plant, course);
    let lumped = Lumped::at_rest(plant, loops, world.sample(0));
    go(plant, lumped, &world, controller)
}

fn go(
    plant: &TruthPlant,
    mut machine: impl Machine,
    world: &World,
    controller: &mut dyn FnMut(usize, f64) -> f64,
) -> Result<Traces, TruthError> {
    let World { course, weather } = world;
    let Course {
        n_samples,
        dt_s,
        seed,
    } = *course;
    let dead_time_s = plant.supply.map_or(0.0, |supply| supply.dead_time_s);
    let noise_m = plant.displacement_noise.map_or_else(
        || vec![0.0; n_samples],
        |noise| noise.series(n_samples, Random::new(seed, Stream::DisplacementNoise)),
    );
    let range = plant.drive.range();
    let mut traces = Traces::with_capacity(n_samples);
    for k in 0..n_samples {
        read(plant, &machine, weather, (k, dt_s), &mut traces);
        let shown_mm = recorded_mm(plant, traces.quiet_displacement_mm[k], noise_m[k]);
        traces.displacement_mm.push(shown_mm);
        let value = controller(k, shown_mm);
        if !range.contains(&value) {
            return Err(TruthError::Drive {
                index: k,
                value,
                lowest: *range.start(),
                highest: *range.end(),
            });
        }
        traces.drive.push(value);
        machine.begin(world.sample(k));
        let [old, new] = pieces(&traces.drive, dt_s, dead_time_s);
        for ((from_s, target), to_s) in [(old, new.0), (new, dt_s)] {
            if to_s > from_s {
                machine.advance(target, (from_s, to_s), k)?;
            }
        }
        machine.end_sample();
    }
    traces.ambient_degc = weather.read(plant.ambient_sensor, seed);
    traces.thermocouple_degc = traces.quiet_thermocouple_degc.clone();
    if let Some(noise) = plant.temperature_noise {
        let noise_k = noise.series(n_samples, Random::new(seed, Stream::TemperatureNoise));
        for (value, noise_k) in traces.thermocouple_degc.iter_mut().zip(noise_k) {
            *value += noise_k;
        }
    }
    Ok(traces)
}

/// The sensor's displacement with noise and the converter's steps.
fn recorded_mm(plant: &TruthPlant, quiet_mm: f64, noise_m: f64) -> f64 {
    let noisy_m = quiet_mm / MM_PER_M + noise_m;
    let read_m = match plant.converter {
        Some(converter) => converter.read_m(noisy_m),
        None => noisy_m,
    };
    read_m * MM_PER_M
}

/// Reads the channels at the start of a sample, still without noise.
fn read(
    plant: &TruthPlant,
    machine: &impl Machine,
    weather: &Weather,
    (k, dt_s): (usize, f64),
    traces: &mut Traces,
) {
    let time_s = k as f64 * dt_s;
    let mut displacement_m = machine.output_m();
    if let Some(drift) = plant.sensor_drift {
        let ambient_rise_k = weather.ambient_degc[k] - weather.ambient_degc[0];
        displacement_m += drift.offset_m(time_s, ambient_rise_k);
    }
    if let Some(hum) = plant.mains_hum {
        displacement_m += hum.at_m(time_s);
    }
    let middle_degc = machine.middle_degc();
    traces.time_s.push(time_s);
    traces.quiet_displacement_mm.push(displacement_m * MM_PER_M);
    traces.temperature_degc.push(middle_degc);
    traces
        .quiet_thermocouple_degc
        .push(machine.bead_degc().unwrap_or(middle_degc));
    traces.fraction.push(machine.mean_fraction());
}
