//! Number of rates at which recordings pass through the loop: one, or more.

use crate::Recording;

/// Share of the largest drive by which it moves in a swing.
const A_SWING: f64 = 0.2;

/// Slopes, and heights above the resting drive, of swings that are alike differ by no more than this factor.
const ALIKE: f64 = 1.3;

/// A swing within so many samples is a step.
const STEP_SAMPLES: usize = 2;

/// A passage of the drive from one turning point to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Swing {
    /// Level where it ends, share of the largest.
    to: f64,
    /// Change of the level over time, 1/s, positive; infinite for a step, not a number for stairs.
    slope_per_s: f64,
    is_rise: bool,
}

/// True if the drives of recordings rise to one level at one rate only, and fall likewise.
///
/// At one rate, the lag of the output behind the temperature and the width of the loop have the same effect on the output.
/// Time constant, center and half width then trade against one another; only the shape of the branches tells them apart.
/// False for a drive that never moves by a fifth of its largest value, and for static data.
#[must_use]
pub fn has_one_rate(recordings: &[Recording]) -> bool {
    let largest = recordings
        .iter()
        .map(Recording::largest_drive)
        .fold(0.0, f64::max);
    let swings: Vec<Swing> = recordings
        .iter()
        .flat_map(|recording| swings(recording, largest))
        .collect();
    let one_of = |is_rise: bool| {
        let mut ways = swings.iter().filter(|swing| swing.is_rise == is_rise);
        let Some(first) = ways.next() else {
            return true;
        };
        first.is_like(first) && ways.all(|swing| swing.is_like(first))
    };
    !swings.is_empty() && one_of(true) && one_of(false)
}

impl Swing {
    fn is_like(&self, other: &Self) -> bool {
        let alike = |a: f64, b: f64| a.max(b) <= ALIKE * a.min(b);
        let ends = [self.to, other.to];
        // Ends near rest are alike whatever their ratio.
        let same_end =
            (ends[0] - ends[1]).abs() < (ALIKE - 1.0) * A_SWING || alike(ends[0], ends[1]);
        same_end && alike(self.slope_per_s, other.slope_per_s)
    }
}

/// Turning points of the level with smaller ones passed over, and the swings between them.
fn swings(recording: &Recording, largest: f64) -> Vec<Swing> {
    let time_s = recording.time_s();
    if time_s.is_empty() || largest <= 0.0 {
        return Vec::new();
    }
    let quantity = recording.drive_quantity();
    let levels: Vec<f64> = recording
        .drive()
        .iter()
        .map(|drive| quantity.level(*drive) / largest)
        .collect();
    let mut turns = vec![0];
    // The extreme since the last turn, in the direction in which the level goes; at first in both.
    let (mut low, mut high) = (0, 0);
    let mut is_rising: Option<bool> = None;
    for (k, level) in levels.iter().enumerate() {
        if *level < levels[low] {
            low = k;
        }
        if *level > levels[high] {
            high = k;
        }
        let has_risen = *level > levels[low] + A_SWING;
        let has_fallen = *level < levels[high] - A_SWING;
        match is_rising {
            None | Some(false) if has_risen => {
                turns.push(low);
                (is_rising, high) = (Some(true), k);
            }
            None | Some(true) if has_fallen => {
                turns.push(high);
                (is_rising, low) = (Some(false), k);
            }
            _ => {}
        }
    }
    // A swing that the end of the recording cuts off is no other.
    let last = is_rising.map(|rising| if rising { high } else { low });
    turns.extend(last.filter(|&k| k + 1 < levels.len()));
    turns
        .windows(2)
        .filter_map(|ends| swing(&levels[ends[0]..=ends[1]], &time_s[ends[0]..=ends[1]]))
        .collect()
}

/// The swing between two turning points, its slope from where it has left the first to where it comes to the second.
fn swing(levels: &[f64], time_s: &[f64]) -> Option<Swing> {
    /// Share of the way that is no part of the slope, at either end: holds belong to no swing.
    const MARGIN: f64 = 0.1;
    let (from, to) = (*levels.first()?, *levels.last()?);
    let way = to - from;
    if way.abs() < A_SWING {
        return None;
    }
    let done = |level: &f64| (level - from) / way;
    let come = levels
        .iter()
        .position(|level| done(level) >= 1.0 - MARGIN)?;
    // Before that: a drive that wavers may have gone back almost to where it began, and come again.
    let left = levels[..come]
        .iter()
        .rposition(|level| done(level) <= MARGIN)?;
    let held = levels[left..=come]
        .windows(2)
        .filter(|two| (two[1] - two[0]).abs() <= 0.0);
    let slope_per_s = if come <= left + STEP_SAMPLES {
        f64::INFINITY
    } else if 2 * held.count() > come - left {
        // Held on the way: the rod comes to rest at levels between.
        f64::NAN
    } else {
        (1.0 - 2.0 * MARGIN) * way.abs() / (time_s[come] - time_s[left])
    };
    Some(Swing {
        to,
        slope_per_s,
        is_rise: way > 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Quantity, RecordingParts};

    fn recording(levels: impl Iterator<Item = f64>) -> Recording {
        let drive: Vec<f64> = levels.collect();
        Recording::new(RecordingParts {
            time_s: Some((0..drive.len()).map(|k| 0.1 * k as f64).collect()),
            output: drive.clone(),
            drive,
            ..RecordingParts::default()
        })
        .unwrap()
    }

    fn steps(period: usize, height: f64) -> Recording {
        recording((0..600).map(move |k| {
            if k % (2 * period) < period {
                0.0
            } else {
                height
            }
        }))
    }

    fn triangles(period: usize, height: f64) -> Recording {
        let part = move |k: usize| (k % (2 * period)) as f64 / period as f64;
        recording((0..600).map(move |k| height * (1.0 - (part(k) - 1.0).abs())))
    }

    /// Found by fuzzing.
    #[test]
    fn a_drive_that_goes_back_almost_the_whole_way_is_no_fault() {
        let wavering = [0.5, 0.29, 0.485, 0.285, 1.0, 1.0, 0.0, 0.0];
        let powers = Recording::new(RecordingParts {
            time_s: Some((0..8).map(f64::from).collect()),
            drive_quantity: Quantity::Power,
            drive: wavering.to_vec(),
            output: wavering.to_vec(),
            ..RecordingParts::default()
        });
        assert!(!has_one_rate(&[powers.unwrap()]));
    }

    #[test]
    fn equal_steps_are_one_rate_and_so_are_equal_triangles() {
        assert!(has_one_rate(&[steps(100, 1.8)]));
        assert!(has_one_rate(&[triangles(100, 1.8)]));
        assert!(has_one_rate(&[triangles(290, 0.4)]));
        assert!(
            has_one_rate(&[triangles(80, 0.4)]),
            "cut off in its last rise"
        );
    }

    #[test]
    fn other_heights_slopes_and_shapes_are_others() {
        assert!(!has_one_rate(&[steps(100, 1.8), steps(100, 1.0)]));
        assert!(!has_one_rate(&[triangles(100, 1.8), triangles(50, 1.8)]));
        assert!(!has_one_rate(&[triangles(100, 1.8), steps(100, 1.8)]));
        let stairs = recording((0..600).map(|k| (k / 60 % 6) as f64));
        let sweep = recording((0..600).map(|k| 1.0 + (1e-4 * (k * k) as f64).sin()));
        assert!(!has_one_rate(&[sweep]));
        assert!(!has_one_rate(&[stairs]));
    }

    #[test]
    fn a_drive_that_hardly_moves_has_no_rate() {
        assert!(!has_one_rate(&[recording((0..50).map(|_| 1.0))]));
        assert!(!has_one_rate(&[recording(
            (0..50).map(|k| 1.0 + 0.05 * f64::from(u8::from(k > 20)))
        )]));
    }
}
