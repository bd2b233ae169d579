use crate::{Input, Output, Plant, WienerError};

/// Checked input of a plant: drive over time, and the temperature of the surroundings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile<'a> {
    drive: &'a [f64],
    clock: Clock<'a>,
    ambient: Ambient<'a>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Clock<'a> {
    Every(f64),
    At(&'a [f64]),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Ambient<'a> {
    Constant(f64),
    Recorded(&'a [f64]),
}

impl<'a> Profile<'a> {
    /// Samples of one length `dt_s`, s, in surroundings of one temperature.
    ///
    /// # Errors
    ///
    /// [`WienerError`] for an empty drive, a sample time that is not finite and > 0, and any value that
    /// is not finite.
    pub fn uniform(drive: &'a [f64], dt_s: f64, ambient_degc: f64) -> Result<Self, WienerError> {
        if !(dt_s > 0.0 && dt_s.is_finite()) {
            return Err(WienerError::SampleTime { value: dt_s });
        }
        Self::checked(drive, Clock::Every(dt_s), ambient_degc)
    }

    /// Samples at the times `time_s`, s, of the drive's length.
    ///
    /// # Errors
    ///
    /// As [`Profile::uniform`], and [`WienerError::FallingTime`] for a time that does not rise,
    /// [`WienerError::UnequalLength`].
    pub fn timed(
        drive: &'a [f64],
        time_s: &'a [f64],
        ambient_degc: f64,
    ) -> Result<Self, WienerError> {
        equal_length("time_s", time_s.len(), drive.len())?;
        all_finite("time_s", time_s)?;
        if let Some(k) = (1..time_s.len()).find(|&k| time_s[k] <= time_s[k - 1]) {
            return Err(WienerError::FallingTime {
                index: k,
                value: time_s[k],
                before: time_s[k - 1],
            });
        }
        Self::checked(drive, Clock::At(time_s), ambient_degc)
    }

    /// Replaces the temperature of the surroundings by a recorded one, °C, of the drive's length.
    ///
    /// # Errors
    ///
    /// [`WienerError::UnequalLength`], [`WienerError::NotFinite`].
    pub fn with_ambient(self, ambient_degc: &'a [f64]) -> Result<Self, WienerError> {
        equal_length("ambient_degc", ambient_degc.len(), self.drive.len())?;
        all_finite("ambient_degc", ambient_degc)?;
        Ok(Self {
            ambient: Ambient::Recorded(ambient_degc),
            ..self
        })
    }

    fn checked(drive: &'a [f64], clock: Clock<'a>, ambient_degc: f64) -> Result<Self, WienerError> {
        if drive.is_empty() {
            return Err(WienerError::EmptyProfile);
        }
        all_finite("drive", drive)?;
        all_finite("ambient_degc", &[ambient_degc])?;
        Ok(Self {
            drive,
            clock,
            ambient: Ambient::Constant(ambient_degc),
        })
    }

    /// Number of samples, at least 1.
    #[must_use]
    #[allow(clippy::len_without_is_empty, reason = "a profile is never empty")]
    pub fn len(&self) -> usize {
        self.drive.len()
    }

    /// Drive of a sample that exists.
    #[inline(always)]
    pub(crate) fn drive(&self, k: usize) -> f64 {
        self.drive[k]
    }

    /// Length of a sample, s, after one of `before_s`; the last one is as long as the one before it.
    ///
    /// Steps that differ by no more than the rounding of the times are equal to the last bit: a plant computes again what belongs to a
    /// length only for another one.
    #[inline(always)]
    pub(crate) fn dt_s(&self, k: usize, before_s: f64) -> f64 {
        match self.clock {
            Clock::Every(dt_s) => dt_s,
            Clock::At(time_s) if time_s.len() < 2 => 0.0,
            Clock::At(time_s) => {
                let k = k.min(time_s.len() - 2);
                let (start_s, end_s) = (time_s[k], time_s[k + 1]);
                let dt_s = end_s - start_s;
                // Each time is rounded by half of this at most.
                let rounding_s = f64::EPSILON * start_s.abs().max(end_s.abs());
                if (dt_s - before_s).abs() <= 2.0 * rounding_s {
                    before_s
                } else {
                    dt_s
                }
            }
        }
    }

    /// Temperature of the surroundings during a sample, °C.
    #[inline(always)]
    pub(crate) fn ambient_degc(&self, k: usize) -> f64 {
        match self.ambient {
            Ambient::Constant(ambient_degc) => ambient_degc,
            Ambient::Recorded(ambient_degc) => ambient_degc[k],
        }
    }

    /// Temperature of the surroundings at the start, °C.
    #[must_use]
    pub fn first_ambient_degc(&self) -> f64 {
        self.ambient_degc(0)
    }
}

/// Runs one plant from a state through a profile and shows its output at every sample: `visit` gets
/// the sample's number and the output *before* the sample's drive acts.
///
/// The state is left at the end of the last sample.
pub fn run<Q: Plant>(
    plant: &Q,
    state: &mut Q::State,
    profile: &Profile<'_>,
    mut visit: impl FnMut(usize, Output),
) {
    let mut dt_s = f64::NAN;
    for k in 0..profile.len() {
        visit(k, plant.output(state));
        let input = Input {
            drive: [profile.drive(k)],
            ambient_degc: profile.ambient_degc(k),
        };
        dt_s = profile.dt_s(k, dt_s);
        plant.step(state, &input, dt_s);
    }
}

fn equal_length(name: &'static str, found: usize, expected: usize) -> Result<(), WienerError> {
    if found == expected {
        Ok(())
    } else {
        Err(WienerError::UnequalLength {
            name,
            found,
            expected,
        })
    }
}

fn all_finite(name: &'static str, values: &[f64]) -> Result<(), WienerError> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(WienerError::NotFinite {
            name,
            index,
            value: values[index],
        }),
    }
}
