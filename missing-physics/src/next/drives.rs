//! The library of runs that a rig could play.

use crate::next::bench::{Bench, Levels};

/// Longest rest before a run, s: it tells the offset and the noise, and that the rod is cold.
pub(crate) const REST_S: f64 = 10.0;

/// Most of the longest run that the limits allow which is rest.
const REST_SHARE: f64 = 0.05;

/// Fewest samples of half a period.
const FEWEST_SAMPLES: f64 = 2.0;

/// A run, sample by sample.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Played {
    /// Description of the run, for people.
    pub(crate) name: String,
    /// A value a sample.
    pub(crate) drive: Vec<f64>,
}

/// Which levels a run takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reach {
    Full,
    Working,
    Middle,
}

/// Kind of a run; times in time constants of the rod.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Triangle { period: f64, most: usize },
    Square { period: f64, most: usize },
    Staircase { hold: f64, steps: usize },
    Cascade { leg: f64, turns: usize },
    HotDwell { dwell: f64, rest: f64 },
    ColdRest { rest: f64, period: f64 },
    Pulses { width: f64, rest: f64, steps: usize },
    Chirp { slowest: f64, fastest: f64 },
    Exercise { period: f64, most: usize },
    Apart { period: f64, rest: f64, most: usize },
}

/// A run before its levels are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plan {
    kind: Kind,
    reach: Reach,
}

/// A straight stretch of a drive.
#[derive(Debug, Clone, Copy)]
enum Leg {
    /// From where the last one ended.
    Ramp {
        to: f64,
        length_s: f64,
    },
    Hold {
        at: f64,
        length_s: f64,
    },
}

/// All runs, in a fixed order.
pub(crate) fn library() -> Vec<Plan> {
    use Kind::{
        Apart, Cascade, Chirp, ColdRest, Exercise, HotDwell, Pulses, Square, Staircase, Triangle,
    };
    use Reach::{Full, Middle, Working};
    let mut plans = Vec::new();
    let mut plan = |kind: Kind, reaches: &[Reach]| {
        plans.extend(reaches.iter().map(|&reach| Plan { kind, reach }));
    };
    for (period, most) in [(3.0, 6), (10.0, 4), (30.0, 2)] {
        plan(Triangle { period, most }, &[Full, Working, Middle]);
    }
    for (period, most) in [(0.5, 24), (2.0, 12), (2.0, 3), (8.0, 4)] {
        plan(Square { period, most }, &[Full, Working, Middle]);
    }
    for (hold, steps) in [(1.0, 8), (4.0, 6)] {
        plan(Staircase { hold, steps }, &[Full, Working]);
    }
    for leg in [2.0, 6.0] {
        plan(Cascade { leg, turns: 10 }, &[Full, Working]);
    }
    for dwell in [10.0, 25.0] {
        plan(HotDwell { dwell, rest: 10.0 }, &[Full, Working]);
    }
    for (rest, period) in [(15.0, 6.0), (15.0, 20.0)] {
        plan(ColdRest { rest, period }, &[Full]);
    }
    for (width, rest) in [(0.3, 2.0), (1.0, 4.0)] {
        let steps = 8;
        plan(Pulses { width, rest, steps }, &[Full]);
    }
    let (slowest, fastest) = (8.0, 0.25);
    plan(Chirp { slowest, fastest }, &[Full, Working, Middle]);
    for most in [10, 40] {
        plan(Exercise { period: 3.0, most }, &[Full, Working]);
    }
    let (period, rest, most) = (8.0, 12.0, 6);
    plan(Apart { period, rest, most }, &[Full]);
    plans
}

impl Plan {
    /// The run with all drives scaled by `scale` (0 to 1); `None` if it does not fit the bench.
    pub(crate) fn played(&self, bench: &Bench, scale: f64) -> Option<Played> {
        let levels = match self.reach {
            Reach::Full => bench.full,
            Reach::Working => bench.working,
            Reach::Middle => bench.middle,
        };
        let levels = Levels {
            low: three_digits(scale * levels.low),
            high: three_digits(scale * levels.high),
        };
        let rest_s = REST_S.min(REST_SHARE * bench.longest_s);
        let after_rest = Bench {
            longest_s: bench.longest_s - rest_s,
            ..bench.clone()
        };
        let (name, legs) = (levels.high > levels.low)
            .then(|| self.kind.legs(&after_rest, levels))
            .flatten()?;
        let mut drive = vec![0.0; (rest_s / bench.dt_s).floor() as usize];
        drive.extend(sampled(&legs, bench.dt_s));
        (drive.len() <= bench.most_samples() && drive.len() > 1).then_some(Played { name, drive })
    }
}

impl Kind {
    /// Its name and course; `None` if no part of it fits the bench. Long, for each kind's words stand beside its
    /// course.
    fn legs(self, bench: &Bench, levels: Levels) -> Option<(String, Vec<Leg>)> {
        let Levels { low, high } = levels;
        let range = range(levels, &bench.unit);
        // In whole samples, so that every period is like the others.
        let time = |taus: f64| {
            let samples = (taus * bench.tau_s / bench.dt_s).round();
            (samples >= FEWEST_SAMPLES).then_some(samples * bench.dt_s)
        };
        let count = |one_s: f64, rest_s: f64, most: usize| {
            let fit = ((bench.longest_s - rest_s) / one_s * (1.0 + 1e-9)).floor();
            (fit >= 1.0).then(|| most.min(fit as usize))
        };
        let ramp = |to, length_s| Leg::Ramp { to, length_s };
        let hold = |at, length_s| Leg::Hold { at, length_s };
        Some(match self {
            Kind::Triangle { period, most } => {
                let half_s = time(0.5 * period)?;
                let n = count(2.0 * half_s, 0.0, most)?;
                (
                    format!(
                        "triangle wave, {} period, {range}, {}",
                        seconds(2.0 * half_s),
                        periods(n)
                    ),
                    repeated(&[ramp(high, half_s), ramp(low, half_s)], n, low),
                )
            }
            Kind::Square { period, most } => {
                let half_s = time(0.5 * period)?;
                let n = count(2.0 * half_s, 0.0, most)?;
                (
                    format!(
                        "square wave, {} period, {range}, {}",
                        seconds(2.0 * half_s),
                        periods(n)
                    ),
                    repeated(&[hold(high, half_s), hold(low, half_s)], n, low),
                )
            }
            Kind::Staircase { hold: taus, steps } => {
                let hold_s = time(taus)?;
                let level = |k: usize| low + (high - low) * k as f64 / steps as f64;
                let up = (0..=steps).chain((0..steps).rev());
                (
                    format!(
                        "staircase up and down in {steps} steps, {} a step, {range}",
                        seconds(hold_s)
                    ),
                    up.map(|k| hold(level(k), hold_s)).collect(),
                )
            }
            Kind::Cascade { leg, turns } => {
                let leg_s = time(leg)?;
                let center = f64::midpoint(low, high);
                let mut legs = vec![ramp(high, leg_s), ramp(low, leg_s)];
                legs.extend((1..turns).map(|k| {
                    let reach = 0.5 * (high - low) * (1.0 - k as f64 / turns as f64);
                    let side = if k % 2 == 1 { reach } else { -reach };
                    ramp(center + side, leg_s)
                }));
                legs.push(ramp(low, leg_s));
                (
                    format!(
                        "triangles that shrink, {} a leg, {} legs, {range}",
                        seconds(leg_s),
                        legs.len()
                    ),
                    legs,
                )
            }
            Kind::HotDwell { dwell, rest } => {
                let (rest_s, dwell_s) = (time(rest)?, time(dwell)?);
                (
                    format!(
                        "{} at {}, then {} of rest",
                        seconds(dwell_s),
                        level(high, &bench.unit),
                        seconds(rest_s)
                    ),
                    vec![
                        hold(low, 0.1 * rest_s),
                        hold(high, dwell_s),
                        hold(0.0, rest_s),
                    ],
                )
            }
            Kind::ColdRest { rest, period } => {
                let (rest_s, half_s) = (time(rest)?, time(0.5 * period)?);
                (
                    format!(
                        "{} of rest, then one triangle of {}, {range}",
                        seconds(rest_s),
                        seconds(2.0 * half_s)
                    ),
                    vec![
                        hold(low, rest_s),
                        ramp(high, half_s),
                        ramp(low, half_s),
                        hold(low, 0.2 * rest_s),
                    ],
                )
            }
            Kind::Pulses { width, rest, steps } => {
                let (width_s, rest_s) = (time(width)?, time(rest)?);
                let height = |k: usize| low + (high - low) * (0.3 + 0.7 * k as f64 / steps as f64);
                (
                    format!(
                        "{steps} pulses of rising height, {} each, {} apart, {range}",
                        seconds(width_s),
                        seconds(rest_s)
                    ),
                    (1..=steps)
                        .flat_map(|k| [hold(height(k), width_s), hold(low, rest_s)])
                        .collect(),
                )
            }
            Kind::Chirp { slowest, fastest } => {
                let (from_s, to_s) = (time(0.5 * slowest)?, time(0.5 * fastest)?);
                let mut legs = Vec::new();
                let mut half_s = from_s;
                while half_s >= to_s * (1.0 - 1e-9) {
                    let whole_s = (half_s / bench.dt_s).round() * bench.dt_s;
                    legs.extend([hold(high, whole_s), hold(low, whole_s)]);
                    half_s /= 2_f64.sqrt();
                }
                (
                    format!(
                        "square waves of ever shorter period, {} to {}, {range}",
                        seconds(2.0 * from_s),
                        seconds(2.0 * to_s)
                    ),
                    legs,
                )
            }
            Kind::Exercise { period, most } => {
                let (half_s, rest_s) = (time(0.5 * period)?, time(5.0)?);
                let n = count(2.0 * half_s, 3.0 * rest_s, most)?;
                let mut legs = repeated(&[hold(high, half_s), hold(low, half_s)], n, low);
                legs.extend([hold(low, rest_s), ramp(high, rest_s), ramp(low, rest_s)]);
                (
                    format!(
                        "square wave, {} period, {range}, {}, then a rest and a triangle of {}",
                        seconds(2.0 * half_s),
                        periods(n),
                        seconds(2.0 * rest_s)
                    ),
                    legs,
                )
            }
            Kind::Apart { period, rest, most } => {
                let (half_s, rest_s) = (time(0.5 * period)?, time(rest)?);
                let n = count(2.0 * half_s + rest_s, 0.0, most)?;
                let one = [ramp(high, half_s), ramp(low, half_s), hold(low, rest_s)];
                (
                    format!(
                        "{n} triangles of {}, {range}, {} of rest after each",
                        seconds(2.0 * half_s),
                        seconds(rest_s)
                    ),
                    repeated(&one, n, low),
                )
            }
        })
    }
}

/// So many times, from the given level.
fn repeated(legs: &[Leg], times: usize, from: f64) -> Vec<Leg> {
    let start = Leg::Hold {
        at: from,
        length_s: 0.0,
    };
    std::iter::once(start)
        .chain(legs.iter().copied().cycle().take(legs.len() * times))
        .collect()
}

fn sampled(legs: &[Leg], dt_s: f64) -> Vec<f64> {
    let mut drive = Vec::new();
    let (mut start_s, mut from) = (0.0, 0.0);
    for &leg in legs {
        let (to, length_s) = match leg {
            Leg::Ramp { to, length_s } | Leg::Hold { at: to, length_s } => (to, length_s),
        };
        let end_s = start_s + length_s;
        let last = (end_s / dt_s).round() as usize;
        drive.extend((drive.len()..last).map(|k| match leg {
            Leg::Hold { at, .. } => at,
            Leg::Ramp { .. } => {
                let share = (k as f64 * dt_s - start_s) / length_s;
                from + (to - from) * share.clamp(0.0, 1.0)
            }
        }));
        (start_s, from) = (end_s, to);
    }
    drive
}

/// The value with three digits, never a larger one.
fn three_digits(value: f64) -> f64 {
    if value <= 0.0 {
        return 0.0;
    }
    let unit = 10_f64.powf(value.log10().floor() - 2.0);
    // What is three digits already stays.
    let floor = (value / unit + 1e-6).floor() * unit;
    floor.min(value)
}

/// A number with three digits at most.
pub(crate) fn short(value: f64) -> String {
    let exponent = if value == 0.0 {
        0.0
    } else {
        value.abs().log10().floor()
    };
    let text = format!("{value:.*}", (2.0 - exponent).clamp(0.0, 6.0) as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

pub(crate) fn seconds(value_s: f64) -> String {
    short(value_s) + " s"
}

fn level(value: f64, unit: &str) -> String {
    match unit {
        "1" => short(value),
        unit => format!("{} {unit}", short(value)),
    }
}

fn range(levels: Levels, unit: &str) -> String {
    format!(
        "drive {} to {}",
        short(levels.low),
        level(levels.high, unit)
    )
}

fn periods(n: usize) -> String {
    if n == 1 {
        "1 period".to_owned()
    } else {
        format!("{n} periods")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bench() -> Bench {
        Bench {
            dt_s: 0.1,
            tau_s: 10.0,
            longest_s: 600.0,
            full: Levels {
                low: 0.0,
                high: 2.4,
            },
            working: Levels {
                low: 0.8,
                high: 2.0,
            },
            middle: Levels {
                low: 1.2,
                high: 1.6,
            },
            unit: "A".to_owned(),
        }
    }

    fn all(bench: &Bench, scale: f64) -> Vec<Played> {
        library()
            .iter()
            .filter_map(|plan| plan.played(bench, scale))
            .collect()
    }

    #[test]
    fn every_run_stays_within_the_limits() {
        let some = all(&bench(), 1.0);
        assert!(some.len() >= 30, "{} runs", some.len());
        for longest_s in [600.0, 90.0, 7.0] {
            let bench = Bench {
                longest_s,
                ..bench()
            };
            for played in all(&bench, 0.77) {
                assert!(played.drive.len() as f64 * bench.dt_s <= longest_s + 1e-9);
                let ends = (0.0..=0.77 * 2.4 + 1e-12, &played.name);
                assert!(
                    played.drive.iter().all(|drive| ends.0.contains(drive)),
                    "{}",
                    ends.1
                );
            }
        }
    }

    #[test]
    fn names_are_words_of_a_lab_and_differ() {
        let mut names: Vec<String> = all(&bench(), 1.0).into_iter().map(|one| one.name).collect();
        let wanted = "square wave, 20 s period, drive 0 to 2.4 A, 12 periods";
        assert!(names.iter().any(|name| name == wanted), "{names:?}");
        let n = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), n);
    }

    #[test]
    fn a_square_wave_is_square() {
        let plan = Plan {
            kind: Kind::Square {
                period: 0.1,
                most: 3,
            },
            reach: Reach::Full,
        };
        let played = plan.played(&bench(), 1.0).unwrap();
        let one = [[2.4; 5], [0.0; 5]].concat();
        let rest = vec![0.0; 100];
        assert_eq!(played.drive, [rest, one.repeat(3)].concat());
    }

    #[test]
    fn a_drive_is_rounded_down() {
        for (value, text) in [
            (2.399_9, "2.39"),
            (0.012_345, "0.0123"),
            (1.5, "1.5"),
            (0.0, "0"),
        ] {
            let rounded = three_digits(value);
            assert!(rounded <= value);
            assert_eq!(short(rounded), text);
        }
        assert!(three_digits(f64::NAN).is_nan());
    }
}
