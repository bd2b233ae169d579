//! Inspection of a recording.

use crate::adapt::Adaptation;
use crate::clipping::{Clipping, clipping};
use crate::cycles::{Cycle, Repeats, cycles, repeats};
use crate::drive_noise::{DriveNoise, drive_noise};
use crate::holds::{Hold, holds, range};
use crate::mended::mended;
use crate::noise::{NoiseFloor, noise_floor_of};
use crate::quantization::quantization_step;
use crate::rates::has_one_rate;
use crate::recording::Recording;
use crate::sampling::{Gap, Sampling};
use crate::slip::{Slip, slips};
use crate::stuck::{Stuck, stuck};
use crate::warning::Warning;
use crate::wild::{Wild, wild};

/// A hold that tells of noise and drift is longer than this, s.
pub const LONG_HOLD_S: f64 = 60.0;

/// The output of a hold is taken to have settled after this, s, unless it is seen to move still.
pub const SETTLE_S: f64 = 30.0;

/// The drive rests below this share of its range, and is at its highest above the rest of it.
const NEAR_END: f64 = 0.05;

/// Part of a stretch at the highest drive that shows whether the output still moves there.
const LAST_PART: usize = 5;

/// Fewest samples of that part.
const FEWEST_LAST: usize = 4;

/// Change of the output within it that counts as moving, as a share of its range.
pub(crate) const MOVING: f64 = 0.02;

/// Range, resolution and clipping of one column of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// `drive`, `antagonist`, `output`, `temperature`, `ambient`, `stress` or `resistance`.
    pub role: &'static str,
    /// Unit of the numbers below.
    pub unit: String,
    /// Lowest value.
    pub lowest: f64,
    /// Highest value.
    pub highest: f64,
    /// Step of the converter, where one is seen: [`quantization_step`].
    pub quantization_step: Option<f64>,
    /// Extremes at which it is flat: [`clipping`].
    pub flat: Vec<Clipping>,
}

impl Channel {
    fn of(role: &'static str, unit: &str, values: &[f64]) -> Self {
        let (lowest, highest) = range(values.iter().copied());
        Self {
            role,
            unit: unit.to_owned(),
            lowest,
            highest,
            quantization_step: quantization_step(values),
            flat: clipping(values),
        }
    }

    /// Highest less lowest value, at most the largest number that there is.
    #[must_use]
    pub fn range(&self) -> f64 {
        (self.highest - self.lowest).min(f64::MAX)
    }
}

/// Properties of a recording, as far as they can be told without a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// Name of the recording.
    pub name: String,
    /// Adaptations of the file that made it readable.
    pub adaptations: Vec<Adaptation>,
    /// Its samples.
    pub n_samples: usize,
    /// From the first time stamp to the last, s; `None` for static data.
    pub duration_s: Option<f64>,
    /// How time advances.
    pub sampling: Sampling,
    /// Where samples are missing.
    pub gaps: Vec<Gap>,
    /// The drive.
    pub drive: Channel,
    /// The drive of an actuator that pulls the other way.
    pub antagonist: Option<Channel>,
    /// The output.
    pub output: Channel,
    /// The measured temperature of the actuator.
    pub temperature: Option<Channel>,
    /// The measured temperature of the surroundings.
    pub ambient: Option<Channel>,
    /// The measured stress in the actuator.
    pub stress: Option<Channel>,
    /// The measured resistance of the actuator, where a current flows.
    pub resistance: Option<Channel>,
    /// Samples before the drive first leaves the lowest 5 % of its range; all, if it never changes.
    pub rest_samples: usize,
    /// Change of the output, as a share of its range, within the last fifth of a stretch in which
    /// the drive is in the highest 5 % of its range: the least of all such stretches whose noise
    /// lets 2 % be seen. `None` where there is none, and for static data.
    pub motion_at_highest_drive: Option<f64>,
    /// Holds of more than [`LONG_HOLD_S`].
    pub holds: Vec<Hold>,
    /// Whole cycles of the drive.
    pub cycles: Vec<Cycle>,
    /// Cycles that the drive repeats.
    pub repeats: Option<Repeats>,
    /// True if the drive rises to one level at one rate only: [`has_one_rate`].
    pub has_one_rate: bool,
    /// Samples that do not belong to their series.
    pub wild: Vec<Wild>,
    /// Where the output slips.
    pub slips: Vec<Slip>,
    /// Where the logger repeats a value of the output.
    pub stuck: Option<Stuck>,
    /// Noise in the column of the drive.
    pub drive_noise: Option<DriveNoise>,
    /// True if all other fields describe the recording without wild samples, slips and noise of the drive, as fits take it.
    pub is_mended: bool,
    /// Noise of the output; `None` for static data and for fewer than three neighboring samples.
    pub noise_floor: Option<NoiseFloor>,
}

impl Inspection {
    /// Obstacles to identification in the recording, each with its meaning and a remedy.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        Warning::of(self)
    }
}

/// Inspects a recording.
///
/// Uses no model, and judges nothing: [`Inspection::warnings`] does. All fields but [`Inspection::wild`],
/// [`Inspection::slips`] and [`Inspection::drive_noise`] describe the [`mended`] recording. Holds of more than
/// [`LONG_HOLD_S`] count for the noise after [`SETTLE_S`]; [`noise_floor`](crate::noise_floor) takes other times where the
/// time constant is known. Never more than one channel is copied at a time: at most 50 bytes a sample beside the recording,
/// usually 16.
///
/// # Examples
///
/// ```
/// use recording::{Recording, RecordingParts, Warning, inspect};
///
/// // One pulse, at once and not for long.
/// let recording = Recording::new(RecordingParts {
///     time_s: Some((0..200).map(|k| 0.2 * f64::from(k)).collect()),
///     drive: (0..200).map(|k| if k < 100 { 1.8 } else { 0.0 }).collect(),
///     output_unit: "mm".to_owned(),
///     output: (0..200).map(|k| if k < 100 { 0.05 } else { 0.04 } * f64::from(k)).collect(),
///     ..RecordingParts::default()
/// })?;
/// let warnings = inspect(&recording).warnings();
/// assert!(warnings.contains(&Warning::NoRest { samples: 0 }));
/// assert!(warnings.contains(&Warning::FewCycles { cycles: 0 }));
/// # Ok::<(), recording::RecordingError>(())
/// ```
#[must_use]
pub fn inspect(recording: &Recording) -> Inspection {
    Inspection {
        wild: wild(recording),
        slips: slips(recording),
        stuck: stuck(recording),
        drive_noise: drive_noise(recording),
        is_mended: true,
        adaptations: recording.adaptations().to_vec(),
        ..inspect_as_recorded(&mended(recording))
    }
}

/// Inspects a recording whose fits take all samples as they are.
#[must_use]
pub fn inspect_as_recorded(recording: &Recording) -> Inspection {
    let time_s = recording.time_s();
    let duration_s = match (time_s.first(), time_s.last()) {
        (Some(first), Some(last)) => Some(last - first),
        _ => None,
    };
    let drive = Channel::of("drive", recording.drive_unit(), recording.drive());
    let output = Channel::of("output", recording.output_unit(), recording.output());
    let degrees = |role| move |values: &[f64]| Channel::of(role, "degC", values);
    let holds = holds(recording, LONG_HOLD_S);
    let repeats = repeats(recording);
    let noise_floor = noise_floor_of(
        recording,
        &holds,
        SETTLE_S,
        repeats.as_ref(),
        output.quantization_step,
    );
    Inspection {
        name: recording.name().to_owned(),
        has_one_rate: has_one_rate(std::slice::from_ref(recording)),
        wild: wild(recording),
        slips: slips(recording),
        stuck: stuck(recording),
        drive_noise: drive_noise(recording),
        is_mended: false,
        adaptations: recording.adaptations().to_vec(),
        n_samples: recording.len(),
        duration_s,
        sampling: recording.sampling(),
        gaps: recording.gaps(),
        temperature: recording.temperature_degc().map(degrees("temperature")),
        ambient: recording.ambient_degc().map(degrees("ambient")),
        stress: recording
            .stress_pa()
            .map(|values| Channel::of("stress", "Pa", values)),
        resistance: recording.resistance().and_then(|measured| {
            let ohm: Vec<f64> = measured.ohm().flatten().collect();
            (!ohm.is_empty()).then(|| Channel::of("resistance", "ohm", &ohm))
        }),
        rest_samples: rest_samples(recording),
        motion_at_highest_drive: noise_floor
            .and_then(|floor| motion_at_highest_drive(recording, output.range(), &floor)),
        drive,
        antagonist: recording
            .antagonist_drive()
            .map(|drive| Channel::of("antagonist", recording.drive_unit(), drive)),
        output,
        holds,
        cycles: cycles(recording),
        repeats,
        noise_floor,
    }
}

/// Samples before the drive first leaves the lowest part of its range.
fn rest_samples(recording: &Recording) -> usize {
    let quantity = recording.drive_quantity();
    // An antagonist moves the output as well.
    let levels = || {
        let antagonist = recording.antagonist_drive();
        let drives = recording.drive().iter().enumerate();
        drives.map(move |(k, drive)| {
            let other = antagonist.map_or(f64::NEG_INFINITY, |drive| quantity.level(drive[k]));
            quantity.level(*drive).max(other)
        })
    };
    let (lowest, highest) = range(levels());
    let low = lowest + NEAR_END * (highest - lowest).min(f64::MAX);
    levels()
        .position(|level| level > low)
        .unwrap_or(recording.len())
}

/// The least change of the output at the end of a stretch at the highest drive.
fn motion_at_highest_drive(
    recording: &Recording,
    output_range: f64,
    floor: &NoiseFloor,
) -> Option<f64> {
    let quantity = recording.drive_quantity();
    let levels = || recording.drive().iter().map(|drive| quantity.level(*drive));
    let (lowest, highest) = range(levels());
    if !(highest > lowest && output_range > 0.0) {
        return None;
    }
    let high = highest - NEAR_END * (highest - lowest).min(f64::MAX);
    // Means of halves, a number at a time: the sum of all may be too large for one.
    let mean = |values: &[f64]| values.iter().map(|y| y / values.len() as f64).sum::<f64>();
    let noise = floor.differences.standard_deviation;
    let motion = |start: usize, end: usize| {
        let n_last = ((end - start) / LAST_PART).max(FEWEST_LAST);
        let last = &recording.output()[end.checked_sub(n_last).filter(|from| *from >= start)?..end];
        let (early, late) = last.split_at(n_last / 2);
        // The centers of the halves are half of the part apart.
        let change = 2.0 * (mean(late) - mean(early)).abs() / output_range;
        let uncertainty = 3.0 * 4.0 * noise / (n_last as f64).sqrt() / output_range;
        (uncertainty <= MOVING.max(change)).then_some(change)
    };
    let mut least: Option<f64> = None;
    let mut start = None;
    for (k, level) in levels().chain([f64::NEG_INFINITY]).enumerate() {
        match start {
            None if level >= high => start = Some(k),
            Some(from) if level < high => {
                start = None;
                if let Some(change) = motion(from, k).filter(|change| change.is_finite()) {
                    least = Some(least.map_or(change, |least| least.min(change)));
                }
            }
            _ => {}
        }
    }
    least
}
