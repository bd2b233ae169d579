//! Obstacles to identification in a recording.

use std::fmt;

use crate::clipping::{Clipping, Side};
use crate::drive_noise::DriveNoise;
use crate::inspect::{Channel, Inspection, LONG_HOLD_S, MOVING, SETTLE_S};
use crate::sampling::Sampling;
use crate::slip::Slip;
use crate::stuck::Stuck;
use crate::wild::Wild;

/// Fewest samples at rest, from which an offset is taken. Our choice.
const FEWEST_AT_REST: usize = 10;

/// Fewest steps of the converter over which an output that is to be modeled moves. Our choice.
const FEWEST_STEPS: f64 = 20.0;

/// A step above this share of the noise breaks tests that take noise for independent of the signal.
const COARSE_STEP: f64 = 0.5;

/// Steps that differ by less than this share of the median step are not worth a warning.
const MILD_JITTER: f64 = 0.01;

/// Obstacle to identification in a recording; displays as what was found, what it means and what to do.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// There is no time.
    Untimed,
    /// Drive or output never changes.
    NeverChanges {
        /// `drive` or `output`.
        role: &'static str,
    },
    /// Samples are missing.
    Gaps {
        /// How many gaps there are.
        gaps: usize,
        /// Time before the longest, s.
        start_s: f64,
        /// Length of the longest, s.
        longest_s: f64,
    },
    /// Steps differ by more than 1 % of the median step.
    Jitter {
        /// Median step, s.
        median_dt_s: f64,
        /// Shortest step, s.
        min_dt_s: f64,
        /// Longest step, s.
        max_dt_s: f64,
    },
    /// The recording does not start at rest.
    NoRest {
        /// Samples before the drive rises.
        samples: usize,
    },
    /// There are fewer than two whole cycles.
    FewCycles {
        /// Whole cycles.
        cycles: usize,
    },
    /// The drive rises to one level at one rate only.
    OneRate,
    /// At its highest the drive does not bring the output to an end.
    MovesAtHighestDrive {
        /// Change within the last fifth of the stretch, as a share of the output's range.
        share: f64,
        /// The highest drive.
        drive: f64,
        /// Its unit.
        unit: String,
    },
    /// Samples do not belong to their series.
    Wild {
        /// Which.
        wild: Wild,
        /// True if fits replace them.
        is_replaced: bool,
    },
    /// The output slips.
    Slip(Slip),
    /// The logger repeats a value of the output.
    Stuck(Stuck),
    /// The column of the drive is noisy.
    NoisyDrive {
        /// By how much, and whether the rod felt it.
        noise: DriveNoise,
        /// True if fits smooth the drive.
        is_smoothed: bool,
    },
    /// The output or the temperature is flat at an extreme, other than at rest before the drive rises.
    Flat {
        /// `output` or `temperature`.
        role: &'static str,
        /// Where and how often.
        clipping: Clipping,
        /// Unit of the extreme.
        unit: String,
    },
    /// The output moves over few steps of its converter.
    FewSteps {
        /// Range of the output over the step.
        steps: f64,
        /// The step.
        step: f64,
        /// Its unit.
        unit: String,
    },
    /// Rounding is a large part of the noise.
    CoarseSteps {
        /// The step.
        step: f64,
        /// Standard deviation of the noise.
        noise: f64,
        /// Unit of both.
        unit: String,
    },
    /// The noise floor is a lower bound only.
    LowerBoundOnly {
        /// Holds of more than 60 s, none of them settled.
        holds: usize,
        /// The bound; 0 where no noise is seen.
        noise: f64,
        /// Its unit.
        unit: String,
    },
}

impl Warning {
    /// The warnings of an inspection, what concerns everything first.
    pub(crate) fn of(inspection: &Inspection) -> Vec<Self> {
        let untimed = inspection.sampling == Sampling::Untimed;
        let mut found = Vec::new();
        found.extend(untimed.then_some(Self::Untimed));
        let changing = [&inspection.drive, &inspection.output];
        let still = changing.into_iter().filter(|channel| is_still(channel));
        found.extend(still.map(|channel| Self::NeverChanges { role: channel.role }));
        found.extend(Self::of_sampling(inspection));
        found.extend(inspection.wild.iter().map(|wild| Self::Wild {
            wild: wild.clone(),
            is_replaced: inspection.is_mended,
        }));
        found.extend(inspection.slips.iter().cloned().map(Self::Slip));
        found.extend(inspection.stuck.clone().map(Self::Stuck));
        found.extend(inspection.drive_noise.iter().map(|noise| Self::NoisyDrive {
            noise: noise.clone(),
            is_smoothed: inspection.is_mended && noise.is_of_the_sensor,
        }));
        if !is_still(&inspection.drive) && !untimed {
            found.extend(Self::of_drive(inspection));
        }
        let sensors = [Some(&inspection.output), inspection.temperature.as_ref()];
        for channel in sensors.into_iter().flatten() {
            // Before the drive rises nothing else is expected.
            let at_rest = |clipping: &&Clipping| {
                let end = clipping.first + clipping.longest;
                clipping.occasions == 1 && end <= inspection.rest_samples + 1
            };
            let flat = channel.flat.iter().filter(|clipping| !at_rest(clipping));
            let flat = flat.map(|clipping| Self::Flat {
                role: channel.role,
                clipping: *clipping,
                unit: channel.unit.clone(),
            });
            found.extend(flat);
        }
        found.extend(Self::of_noise(inspection));
        found
    }

    fn of_sampling(inspection: &Inspection) -> Vec<Self> {
        let longest = inspection
            .gaps
            .iter()
            .max_by(|a, b| a.dt_s.total_cmp(&b.dt_s));
        let gaps = longest.map(|longest| Self::Gaps {
            gaps: inspection.gaps.len(),
            start_s: longest.start_s,
            longest_s: longest.dt_s,
        });
        let jitter = match inspection.sampling {
            Sampling::Jittered {
                median_dt_s,
                min_dt_s,
                max_dt_s,
            } if (max_dt_s - min_dt_s) > MILD_JITTER * median_dt_s => Some(Self::Jitter {
                median_dt_s,
                min_dt_s,
                max_dt_s,
            }),
            _ => None,
        };
        gaps.into_iter().chain(jitter).collect()
    }

    fn of_drive(inspection: &Inspection) -> Vec<Self> {
        let samples = inspection.rest_samples;
        let rest = (samples < FEWEST_AT_REST).then_some(Self::NoRest { samples });
        let cycles = inspection.cycles.len();
        let cycles = (cycles < 2).then_some(Self::FewCycles { cycles });
        let drive = &inspection.drive;
        let moves = inspection
            .motion_at_highest_drive
            .filter(|share| *share > MOVING)
            .map(|share| Self::MovesAtHighestDrive {
                share,
                drive: drive.highest,
                unit: drive.unit.clone(),
            });
        let one_rate = inspection.has_one_rate.then_some(Self::OneRate);
        rest.into_iter()
            .chain(cycles)
            .chain(one_rate)
            .chain(moves)
            .collect()
    }

    fn of_noise(inspection: &Inspection) -> Vec<Self> {
        let output = &inspection.output;
        let unit = || output.unit.clone();
        let mut found = Vec::new();
        let noise = inspection
            .noise_floor
            .map(|floor| floor.upper().unwrap_or(floor.lower()));
        if let Some(step) = output.quantization_step {
            let steps = output.range() / step;
            if steps < FEWEST_STEPS {
                found.push(Self::FewSteps {
                    steps,
                    step,
                    unit: unit(),
                });
            }
            if let Some(noise) = noise.filter(|noise| step > COARSE_STEP * noise) {
                found.push(Self::CoarseSteps {
                    step,
                    noise,
                    unit: unit(),
                });
            }
        }
        if let Some(floor) = inspection
            .noise_floor
            .filter(|floor| floor.is_lower_bound_only())
        {
            found.push(Self::LowerBoundOnly {
                holds: inspection.holds.len(),
                noise: floor.lower(),
                unit: unit(),
            });
        }
        found
    }
}

fn is_still(channel: &Channel) -> bool {
    channel.highest <= channel.lowest
}

/// Number and unit, without a unit of one.
pub(crate) struct WithUnit<'a>(pub(crate) f64, pub(crate) &'a str);

impl fmt::Display for WithUnit<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value, unit) = self;
        match *unit {
            "1" => write!(f, "{}", Short(*value)),
            unit => write!(f, "{} {unit}", Short(*value)),
        }
    }
}

/// Writes a number and its unit, without a unit of one, into a text under way.
pub(crate) fn quantity(f: &mut fmt::Formatter<'_>, value: f64, unit: &str) -> fmt::Result {
    write!(f, "{}", WithUnit(value, unit))
}

/// The ends of a span, s, as they are written for a user to copy: to the microsecond.
pub(crate) fn copied(span_s: [f64; 2]) -> [f64; 2] {
    span_s.map(|time_s| (time_s * 1e6).round() / 1e6)
}

/// How often.
struct Times(usize);

impl fmt::Display for Times {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            1 => write!(f, "once"),
            times => write!(f, "{times} times"),
        }
    }
}

/// A number with about four significant digits.
pub(crate) struct Short(pub(crate) f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = self.0.abs();
        if (1e-3..1e6).contains(&magnitude) {
            let decimals = 3 - magnitude.log10().floor() as i32;
            let scale = 10_f64.powi(decimals);
            write!(f, "{}", (self.0 * scale).round() / scale)
        } else if magnitude > 0.0 {
            write!(f, "{:.3e}", self.0)
        } else {
            write!(f, "0")
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Untimed => write!(
                f,
                "no time: only a static loop can be identified, no time constant; record with a \
                 time column"
            ),
            Self::NeverChanges { role } => write!(
                f,
                "{role} never changes: there is nothing to identify; check the column and the \
                 wiring"
            ),
            Self::Gaps {
                gaps,
                start_s,
                longest_s,
            } => write!(
                f,
                "gaps: {gaps}, the longest {} s after time_s = {start_s}: what the drive did there \
                 is unknown, and with it the state after it; cut the recording there",
                Short(*longest_s)
            ),
            Self::Jitter {
                median_dt_s,
                min_dt_s,
                max_dt_s,
            } => write!(
                f,
                "steps of {} s to {} s about {} s: a fixed step would show as dead time; keep the \
                 time stamps, or resample",
                Short(*min_dt_s),
                Short(*max_dt_s),
                Short(*median_dt_s)
            ),
            Self::NoRest { samples } => write!(
                f,
                "samples at rest before the drive rises: {samples}: offset and initial state are \
                 not measured and must be fitted; start with {FEWEST_AT_REST} samples or more, \
                 cold and undriven"
            ),
            Self::FewCycles { cycles } => write!(
                f,
                "whole cycles: {cycles}: nothing can be held out, nor drift told from a slow \
                 response; record at least 2, better 3 equal ones"
            ),
            Self::OneRate => write!(
                f,
                "the drive rises to one level at one rate: the time constant, the loop's center and its width trade against \
                 one another; record a second run at another rate or to another level, a slow ramp beside steps say, and \
                 fit both together"
            ),
            Self::MovesAtHighestDrive { share, drive, unit } => {
                write!(f, "at the highest drive, ")?;
                quantity(f, *drive, unit)?;
                write!(
                    f,
                    ", the output still moves, by {} % of its range in the last fifth of the \
                     time: it is not seen to settle or saturate, and the far end of the loop is a \
                     guess; hold longer, or drive higher if the rig allows",
                    Short(100.0 * share)
                )
            }
            Self::Wild {
                wild,
                is_replaced: true,
            } => write!(
                f,
                "{wild}, {} in a fit; as_recorded = true under [columns] keeps what was recorded",
                wild.replacement()
            ),
            Self::Wild {
                wild,
                is_replaced: false,
            } => write!(f, "{wild}: {}", wild.advice()),
            Self::Slip(slip) => write!(f, "{slip}"),
            Self::Stuck(stuck) => write!(f, "{stuck}"),
            Self::NoisyDrive {
                noise,
                is_smoothed: true,
            } => write!(
                f,
                "{noise}, at rest, too, so the rod did not see it: in a fit {}; as_recorded = true under [columns] keeps it",
                noise.replacement()
            ),
            Self::NoisyDrive { noise, .. } if noise.is_of_the_sensor => write!(
                f,
                "{noise}, at rest, too, so the rod did not see it: a fit of all samples as recorded takes it for heat"
            ),
            Self::NoisyDrive { noise, .. } => write!(
                f,
                "{noise}, but none is seen at rest, so the rod may have seen it: fits take it as it is; if it is of the logger, give \
                 them the set point instead"
            ),
            Self::Flat {
                role,
                clipping,
                unit,
            } => {
                let side = match clipping.side {
                    Side::Lowest => "lowest",
                    Side::Highest => "highest",
                };
                write!(f, "{role} is flat at its {side}, ")?;
                quantity(f, clipping.at, unit)?;
                write!(
                    f,
                    ": {} samples, {}: at rest or against a stop, that is right; at \
                     the limit of a sensor, those samples are not measured and must not be fitted",
                    clipping.samples,
                    Times(clipping.occasions)
                )
            }
            Self::FewSteps { steps, step, unit } => {
                write!(f, "output moves over {} steps of ", Short(*steps))?;
                quantity(f, *step, unit)?;
                write!(
                    f,
                    ": its converter hides most of the loop; use a finer range or a longer lever"
                )
            }
            Self::CoarseSteps { step, noise, unit } => {
                write!(f, "output comes in steps of ")?;
                quantity(f, *step, unit)?;
                write!(f, " at a noise of ")?;
                quantity(f, *noise, unit)?;
                write!(
                    f,
                    ": rounding follows the signal, so what is left of a fit is not independent \
                     noise; repeat cycles, or record with a finer converter"
                )
            }
            Self::LowerBoundOnly { holds, noise, unit } => {
                if *holds == 0 {
                    write!(f, "no hold of {LONG_HOLD_S} s and no three repeated cycles")?;
                } else {
                    write!(
                        f,
                        "no hold of {LONG_HOLD_S} s in which the output is at rest after \
                         {SETTLE_S} s, and no three repeated cycles"
                    )?;
                }
                write!(f, ": the noise floor, ")?;
                quantity(f, *noise, unit)?;
                write!(
                    f,
                    ", is a lower bound only, and so is any share explained; hold the drive for \
                     {LONG_HOLD_S} s at rest, and repeat a cycle three times"
                )
            }
        }
    }
}
