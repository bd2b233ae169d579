//! Single samples that do not belong to a series.

use std::fmt;

use crate::Recording;
use crate::warning::quantity;

/// Distance from the middle of the neighbors, over what is usual, from which a sample is wild: noise comes no farther than six
/// times.
const FAR: f64 = 30.0;

/// How near the neighbors are to one another then, over that distance: beside a step they are not.
const ALIKE: f64 = 0.2;

/// Share of the range below which no distance is usual: a drive that is held has none.
const LEAST: f64 = 1e-3;

/// Share of the samples that may be wild; where there are more, they are what the series is like.
const MOST: f64 = 0.05;

/// Share of the samples from which a value is a level of the drive.
const A_LEVEL: f64 = 0.01;

/// Share of a drive's range that is a step: what the output does then is its answer.
const A_STEP: f64 = 0.1;

/// Single samples far from both of their neighbors, which agree: glitches of a logger, dropouts of a sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct Wild {
    /// `drive` or `output`.
    pub role: &'static str,
    /// Unit of the value.
    pub unit: String,
    /// The samples, counted from 0; at least one.
    pub samples: Vec<usize>,
    /// Value of the first.
    pub value: f64,
    /// Time of the first, s; `None` for static data.
    pub time_s: Option<f64>,
}

impl fmt::Display for Wild {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { role, value, .. } = self;
        match self.samples.len() {
            1 => write!(
                f,
                "a sample of the {role} stands far from both of its neighbors, "
            )?,
            n => write!(
                f,
                "{n} samples of the {role} stand far from both of their neighbors, the first "
            )?,
        }
        quantity(f, *value, &self.unit)?;
        match self.time_s {
            Some(time_s) => write!(f, " at {time_s} s")?,
            None => write!(f, " in sample {}", self.samples[0])?,
        }
        write!(
            f,
            ": if the rig did not see it, take it out of the file, or every fit follows it"
        )
    }
}

/// The wild samples of drive and output; drives of one sample that come again and again are none.
#[must_use]
pub fn wild(recording: &Recording) -> Vec<Wild> {
    let series = [
        ("drive", recording.drive_unit(), recording.drive()),
        ("output", recording.output_unit(), recording.output()),
    ];
    let large = A_STEP * Ordered::new(recording.drive()).range();
    let found = series.into_iter().filter_map(|(role, unit, values)| {
        let ordered = Ordered::new(values);
        let mut samples = wild_in(values, ordered.range());
        match role {
            "drive" => samples.retain(|&k| !ordered.has_level(values[k])),
            _ => samples.retain(|&k| !is_after_a_step(recording.drive(), large, k)),
        }
        let &first = samples.first()?;
        Some(Wild {
            role,
            unit: unit.to_owned(),
            value: values[first],
            time_s: recording.time_s().get(first).copied(),
            samples,
        })
    });
    found.collect()
}

/// The values of a series in ascending order.
struct Ordered(Vec<f64>);

impl Ordered {
    fn new(values: &[f64]) -> Self {
        let mut ordered = values.to_vec();
        ordered.sort_by(f64::total_cmp);
        Self(ordered)
    }

    /// From the first to the last hundredth: wild ones would stretch the range itself.
    fn range(&self) -> f64 {
        let at = |share: f64| self.0[(share * (self.0.len() - 1) as f64) as usize];
        at(0.99) - at(0.01)
    }

    /// Whether the series stands at a value again and again: a drive that switches may do so for a sample.
    fn has_level(&self, value: f64) -> bool {
        let near = LEAST * self.range();
        let below = self.0.partition_point(|other| *other < value - near);
        let up_to = self.0.partition_point(|other| *other <= value + near);
        (up_to - below) as f64 > A_LEVEL * self.0.len() as f64
    }
}

/// Whether the drive has just been switched, by a step that is large.
fn is_after_a_step(drive: &[f64], large: f64, k: usize) -> bool {
    let before = &drive[k.saturating_sub(2)..=k];
    before.windows(2).any(|two| (two[1] - two[0]).abs() > large)
}

fn wild_in(values: &[f64], range: f64) -> Vec<usize> {
    let bends: Vec<f64> = values
        .windows(3)
        .map(|three| three[1] - 0.5 * (three[0] + three[2]))
        .collect();
    if bends.is_empty() {
        return Vec::new();
    }
    let mut sizes: Vec<f64> = bends.iter().map(|bend| bend.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let usual = (1.4826 * sizes[sizes.len() / 2]).max(LEAST * range);
    if usual <= 0.0 {
        return Vec::new();
    }
    let is_wild = |k: &usize| {
        let bend = bends[k - 1].abs();
        bend > FAR * usual && (values[k + 1] - values[k - 1]).abs() < ALIKE * bend
    };
    let found: Vec<usize> = (1..values.len() - 1).filter(is_wild).collect();
    match found.len() as f64 <= MOST * values.len() as f64 {
        true => found,
        false => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(values: &[f64]) -> Vec<usize> {
        wild_in(values, Ordered::new(values).range())
    }

    fn smooth() -> Vec<f64> {
        let noise = |k: usize| 0.001 * (((k * k) as f64) * 0.7).sin();
        (0..400)
            .map(|k| (0.05 * k as f64).sin() + noise(k))
            .collect()
    }

    #[test]
    fn glitches_are_found_and_steps_are_not() {
        assert_eq!(found(&smooth()), []);
        let mut values = smooth();
        (values[50], values[301]) = (7.0, 0.0);
        assert_eq!(found(&values), [50, 301]);
        let mut drive = vec![0.0; 400];
        drive[100..200].fill(1.0);
        assert_eq!(found(&drive), []);
        drive[150] = 22.0;
        drive[300] = 0.5;
        assert_eq!(found(&drive), [150, 300]);
        // A pulse every ten samples is a drive.
        let pulses: Vec<f64> = (0..400).map(|k| f64::from(u8::from(k % 10 == 0))).collect();
        assert_eq!(found(&pulses), []);
        assert_eq!(found(&[1.0, 1.0]), []);
    }
}
