//! Within which limits runs are tried: those of the rig, and what the likeliest model says of the rod.

use identify::{IdentifyError, Limits, predict};
use recording::{Quantity, Recording, RecordingParts};

use crate::model::case::{Case, Node};
use crate::model::elsewhere::without_drifts;

/// Most samples of a run: what a look at all runs may cost.
const MOST_SAMPLES: f64 = 20_000.0;

/// Lowest and highest drive of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Levels {
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// Bench that runs are made for: time step, longest run, and levels of the drive.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bench {
    /// Time between samples, s.
    pub(crate) dt_s: f64,
    /// Time constant of the rod, s.
    pub(crate) tau_s: f64,
    /// Longest run, s.
    pub(crate) longest_s: f64,
    /// From nothing to the largest drive.
    pub(crate) full: Levels,
    /// Between which the rod transforms all but completely, either way.
    pub(crate) working: Levels,
    /// Between which it stays in the middle of its stroke.
    pub(crate) middle: Levels,
    /// Unit of the drive; "1" for a pure number.
    pub(crate) unit: String,
}

impl Bench {
    /// Samples of the longest run.
    pub(crate) fn most_samples(&self) -> usize {
        (self.longest_s / self.dt_s * (1.0 + 1e-9)).floor() as usize
    }
}

/// Bench that runs are made for: the limits of the rig, and the rod as the likeliest model describes it.
pub(crate) fn bench(
    case: &Case<'_>,
    node: &Node,
    limits: &Limits,
    hottest_degc: f64,
) -> Result<Bench, IdentifyError> {
    let point = without_drifts(&node.model, &node.points[0]);
    let infos = identify::ForwardModel::parameters(&node.model);
    let tau = infos.iter().position(|info| info.name == "tau_s");
    let steps_s = case
        .training
        .iter()
        .filter_map(|recording| recording.sampling().usual_dt_s());
    // What the logger has done it can do.
    let dt_s = steps_s.fold(f64::INFINITY, f64::min);
    let lengths_s = case.training.iter().map(|recording| {
        let time_s = recording.time_s();
        time_s.last().copied().unwrap_or(0.0) - time_s.first().copied().unwrap_or(0.0)
    });
    let longest_s = 2.0 * lengths_s.fold(0.0, f64::max);
    let drives = case.training.iter().map(Recording::largest_drive);
    let largest = drives.fold(0.0, f64::max);
    let most = limits.drive_max.unwrap_or(largest);
    let most = match case.training[0].drive_quantity() {
        Quantity::Duty => most.min(1.0),
        _ => most,
    };
    let full = Levels {
        low: 0.0,
        high: most,
    };
    let mut bench = Bench {
        dt_s,
        tau_s: tau.map_or(dt_s, |tau| point[tau]),
        longest_s: limits
            .duration_s
            .unwrap_or(longest_s)
            .min(MOST_SAMPLES * dt_s),
        full,
        // Until it is known where the rod transforms.
        working: full,
        middle: full,
        unit: case.training[0].drive_unit().to_owned(),
    };
    levels(case, node, &point, &mut bench, hottest_degc)?;
    Ok(bench)
}

/// The limit of temperature: that of the rig; where there is none or temperatures are known up to a factor only, what
/// the rod came to in the training. A limit of the drive alone says that the rod stands that drive.
pub(crate) fn hottest_degc(
    case: &Case<'_>,
    node: &Node,
    limits: &Limits,
) -> Result<f64, IdentifyError> {
    /// How much more than in the training it may be heated.
    const MARGIN: f64 = 1.05;
    match (limits.temperature_max_degc, limits.drive_max) {
        (Some(limit_degc), _) if case.base.knows_temperature() => return Ok(limit_degc),
        (None, Some(_)) => return Ok(f64::INFINITY),
        _ => {}
    }
    let mut hottest_degc = f64::NEG_INFINITY;
    for (point, recording) in node.points.iter().zip(case.training) {
        let [start_degc, peak_degc] = start_and_peak_degc(node, point, recording)?;
        hottest_degc = hottest_degc.max(start_degc + MARGIN * (peak_degc - start_degc));
    }
    Ok(hottest_degc)
}

/// First and highest temperature of the rod itself, not of what a thermocouple sees of it.
pub(crate) fn start_and_peak_degc(
    node: &Node,
    point: &[f64],
    recording: &Recording,
) -> Result<[f64; 2], IdentifyError> {
    let mut point = point.to_vec();
    for effect in node.effects.iter().filter(|one| one.info().is_of_sensor()) {
        if let Some(first) = node.model.first_parameter(effect) {
            point[first..first + effect.info().parameters.len()].fill(0.0);
        }
    }
    let shown = predict(&node.model, &point, recording)?.temperature_degc;
    let peak_degc = shown.iter().copied().fold(shown[0], f64::max);
    Ok([shown[0], peak_degc])
}

/// Between which drives the rod transforms, from a slow staircase.
fn levels(
    case: &Case<'_>,
    node: &Node,
    point: &[f64],
    bench: &mut Bench,
    hottest_degc: f64,
) -> Result<(), IdentifyError> {
    const STEPS: usize = 24;
    /// Samples of a time constant, and of a hold.
    const PER_TAU: f64 = 8.0;
    const HOLD: usize = 32;
    let height = |k: usize| bench.full.high * k as f64 / STEPS as f64;
    let up_and_down: Vec<f64> = (0..=STEPS).chain((0..STEPS).rev()).map(height).collect();
    let drive = up_and_down
        .iter()
        .flat_map(|&level| std::iter::repeat_n(level, HOLD))
        .collect();
    let staircase = recording(case, drive, bench.tau_s / PER_TAU)?;
    let shown = predict(&node.model, point, &staircase)?;
    let start = shown.output[0];
    let stroke = shown
        .output
        .iter()
        .fold(0.0, |most: f64, y| most.max((y - start).abs()));
    let at_end = |k: usize| HOLD * (k + 1) - 1;
    let share = |k: usize| (shown.output[at_end(k)] - start).abs() / stroke;
    let rising = |least: f64| {
        let found = (0..=STEPS).find(|&k| share(k) >= least);
        height(found.unwrap_or(STEPS))
    };
    let falling = |most: f64| {
        let found = (STEPS..=2 * STEPS).find(|&k| share(k) <= most);
        found.map_or(0.0, |k| up_and_down[k])
    };
    let is_safe = |k: &usize| shown.temperature_degc[at_end(*k)] <= hottest_degc;
    let safe = height((0..=STEPS).rfind(is_safe).unwrap_or(0));
    let levels = |low: f64, high: f64| Levels {
        low: low.min(high),
        high: high.max(low).min(safe),
    };
    let (working, middle) = (
        levels(falling(0.1), rising(0.9)),
        levels(falling(0.6), rising(0.6)),
    );
    (bench.working, bench.middle) = (working, middle);
    Ok(())
}

/// A recording of a drive, of which only what models need is known.
pub(crate) fn recording(
    case: &Case<'_>,
    drive: Vec<f64>,
    dt_s: f64,
) -> Result<Recording, IdentifyError> {
    let first = &case.training[0];
    let n_samples = drive.len();
    let ambient_degc = case
        .training
        .iter()
        .find_map(|recording| recording.ambient_degc())
        .map(|recorded| vec![recorded[0]; n_samples]);
    let has_thermometer = case
        .training
        .iter()
        .any(|recording| recording.temperature_degc().is_some());
    Ok(Recording::new(RecordingParts {
        name: "next experiment".to_owned(),
        time_s: Some((0..n_samples).map(|k| dt_s * k as f64).collect()),
        drive_quantity: first.drive_quantity(),
        drive,
        output_unit: first.output_unit().to_owned(),
        output: vec![0.0; n_samples],
        temperature_degc: has_thermometer.then(|| vec![0.0; n_samples]),
        ambient_degc,
        ..RecordingParts::default()
    })?)
}
