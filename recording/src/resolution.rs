//! Steps and dead zone of a supply, told by the drive that it gave.

use crate::Recording;
use crate::ordered::Ordered;
use crate::quantization::quantization_step;

/// Step over the drive's range: below, no loop sees it; above, it is a stair that somebody drove.
const STEP: std::ops::RangeInclusive<f64> = 0.9e-3..=0.02;

/// Single steps from which a supply is known to make them.
const SINGLE_STEPS: usize = 20;

/// Share of the single steps after which the drive stays for a sample, at least: a generator takes one a sample.
const STAYS: f64 = 0.5;

/// Times that a drive goes from nothing to the edge of a dead zone, or back, at least.
const CROSSINGS: usize = 3;

/// Levels beyond the edge of a dead zone whose distances say how finely the drive was set there.
const LEVELS: usize = 5;

/// Width of a dead zone over these distances, and over the range of the drive, at least.
const WIDTH: [f64; 2] = [5.0, 0.02];

/// How finely a supply can be set; `None` where a recording does not tell.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DriveResolution {
    /// Step from one drive to the next, in the unit of the drive.
    pub step: Option<f64>,
    /// Lowest drive beside nothing, in the unit of the drive.
    pub dead_zone: Option<f64>,
}

/// How finely the supply behind a drive can be set.
///
/// A *step* is told by a drive that stays at each of its levels on its way, and then goes on by one: from a thousandth to
/// a fiftieth of its range. Finer ones do not matter, and coarser ones are stairs. A *dead zone* is told by a drive that goes continuously down to
/// a level, and from there to nothing, or back, three times at least; a drive that is negative has none.
#[must_use]
pub fn drive_resolution(recording: &Recording) -> DriveResolution {
    let drive = recording.drive();
    let range = Ordered::new(drive).range();
    if range <= 0.0 {
        return DriveResolution::default();
    }
    DriveResolution {
        step: step(drive, range),
        dead_zone: dead_zone(drive, range),
    }
}

fn step(drive: &[f64], range: f64) -> Option<f64> {
    let step = quantization_step(drive).filter(|step| STEP.contains(&(step / range)))?;
    let changes: Vec<f64> = drive
        .windows(2)
        .map(|two| (two[1] - two[0]) / step)
        .collect();
    let is_single = |change: f64| (change.abs() - 1.0).abs() < 0.25;
    let pairs = changes.windows(2).filter(|two| is_single(two[0]));
    let (n, stays) = pairs.fold((0, 0), |(n, stays), two| {
        (n + 1, stays + usize::from(two[1].abs() < 0.25))
    });
    (n >= SINGLE_STEPS && stays as f64 >= STAYS * n as f64).then_some(step)
}

fn dead_zone(drive: &[f64], range: f64) -> Option<f64> {
    if drive.iter().any(|value| *value < 0.0) {
        return None;
    }
    let mut levels: Vec<f64> = drive.iter().copied().filter(|value| *value > 0.0).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let (&edge, &last) = (levels.first()?, levels.get(LEVELS)?);
    let apart = (last - edge) / LEVELS as f64;
    let at_edge = |value: f64| value > 0.0 && value <= last;
    let crossings = drive
        .windows(2)
        .filter(|two| (two[0] == 0.0 && at_edge(two[1])) || (two[1] == 0.0 && at_edge(two[0])))
        .count();
    let is_wide = edge > WIDTH[0] * apart && edge > WIDTH[1] * range;
    (is_wide && crossings >= CROSSINGS).then_some(edge)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RecordingParts;

    fn of(drive: impl Iterator<Item = f64>) -> DriveResolution {
        let drive: Vec<f64> = drive.collect();
        let n = drive.len();
        let recording = Recording::new(RecordingParts {
            time_s: Some((0..n).map(|k| 0.1 * k as f64).collect()),
            drive,
            output: vec![0.0; n],
            ..RecordingParts::default()
        });
        drive_resolution(&recording.unwrap())
    }

    /// Ramps up and down in so many samples, by the share of the way.
    fn ramps(period: usize) -> impl Iterator<Item = f64> {
        (0..4 * period).map(move |k| 1.0 - (2.0 * (k % period) as f64 / period as f64 - 1.0).abs())
    }

    #[test]
    fn counts_of_a_converter_are_steps_and_a_generator_has_none() {
        let counts = of(ramps(2000).map(|share| (255.0 * 0.6 * share).round() / 255.0));
        let step = counts.step.unwrap();
        assert!((step - 1.0 / 255.0).abs() < 1e-12, "{step}");
        assert_eq!(counts.dead_zone, None);
        // A level a sample; digits; stairs of ten levels; a single step; nothing.
        let none = DriveResolution::default();
        assert_eq!(of(ramps(100).map(|share| 3.0 * share)), none);
        assert_eq!(
            of(ramps(9000).map(|share| (1e4 * share).round() / 1e4)),
            none
        );
        assert_eq!(
            of(ramps(2000).map(|share| (10.0 * share).round() / 10.0)),
            none
        );
        assert_eq!(of((0..400).map(|k| f64::from(k / 200))), none);
        assert_eq!(of((0..400).map(|_| 0.0)), none);
    }

    #[test]
    fn what_a_supply_leaves_out_above_nothing_is_its_dead_zone() {
        let cut = |share: f64| if share < 0.1 { 0.0 } else { 2.0 * share };
        let found = of(ramps(1000).map(cut)).dead_zone.unwrap();
        assert!((found - 0.2).abs() < 0.005, "{found}");
        // Once up and once down; a drive that begins there; levels that are as far apart; one that is negative, too.
        assert_eq!(of(ramps(1000).take(1000).map(cut)).dead_zone, None);
        let above = |share: f64| 0.2 + 1.8 * share;
        assert_eq!(of(ramps(1000).map(above)).dead_zone, None);
        let coarse = |share: f64| (5.0 * share).round() / 5.0;
        assert_eq!(of(ramps(1000).map(coarse)).dead_zone, None);
        let turned = |share: f64| if share < 0.1 { -share } else { 2.0 * share };
        assert_eq!(of(ramps(1000).map(turned)).dead_zone, None);
    }
}
