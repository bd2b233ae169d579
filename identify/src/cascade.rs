//! Parts common to all models of a driven rig: its drive, its surroundings, and the lanes they run in.

use recording::{Recording, Sampling};
use wiener::hysteresis::Rule;
use wiener::{Block, Drive, Ensemble, Member, Profile, Start, WienerParams};

use crate::{IdentifyError, Rod};

/// A rig but for the parameters of its rod.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cascade {
    pub(crate) drive: Drive,
    pub(crate) rule: Rule,
    /// Temperature of the surroundings where a recording does not have it, °C.
    pub(crate) ambient_degc: Option<f64>,
}

/// Where a recording starts.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StartAbove {
    /// Temperature above the surroundings, K.
    pub(crate) rise_k: f64,
    /// Place between the limiting curves, 0 (heating) to 1 (cooling).
    pub(crate) share: f64,
    /// By how much it was heated since it last turned, K.
    pub(crate) since_reversal_k: f64,
}

impl StartAbove {
    /// Cold, cooled along the limiting curve.
    pub(crate) const REST: Self = Self {
        rise_k: 0.0,
        share: 1.0,
        since_reversal_k: 0.0,
    };
}

impl Cascade {
    pub(crate) fn new(rod: &Rod, rule: Rule) -> Result<Self, IdentifyError> {
        Ok(Self {
            drive: rod.drive()?,
            rule,
            ambient_degc: rod.ambient_degc,
        })
    }

    /// Simulates points in lockstep; `member` says what a point means.
    pub(crate) fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
        member: impl Fn(&[f64]) -> (WienerParams, StartAbove),
    ) -> Result<(), IdentifyError> {
        self.simulate_driven(points, recording, recording.drive(), visit, member)
    }

    /// Simulates points in lockstep under another drive than that of the recording, of as many samples.
    pub(crate) fn simulate_driven(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        drive: &[f64],
        visit: &mut dyn FnMut(Block<'_>),
        member: impl Fn(&[f64]) -> (WienerParams, StartAbove),
    ) -> Result<(), IdentifyError> {
        let profile = self.profile_driven(recording, drive)?;
        let members: Vec<Member> = points
            .iter()
            .map(|point| {
                let (params, start) = member(point);
                Member {
                    params,
                    start: Start {
                        temperature_degc: profile.first_ambient_degc() + start.rise_k,
                        share: start.share,
                        since_reversal_k: start.since_reversal_k,
                    },
                }
            })
            .collect();
        let ensemble = Ensemble {
            drive: self.drive,
            rule: self.rule,
        };
        Ok(ensemble.run(&members, &profile, visit)?)
    }

    pub(crate) fn profile<'a>(
        &self,
        recording: &'a Recording,
    ) -> Result<Profile<'a>, IdentifyError> {
        self.profile_driven(recording, recording.drive())
    }

    fn profile_driven<'a>(
        &self,
        recording: &'a Recording,
        drive: &'a [f64],
    ) -> Result<Profile<'a>, IdentifyError> {
        let untimed = || IdentifyError::Untimed {
            recording: recording.name().to_owned(),
        };
        let recorded = recording.ambient_degc();
        let ambient_degc = match (self.ambient_degc, recorded) {
            (_, Some(recorded)) => recorded[0],
            (Some(ambient_degc), None) => ambient_degc,
            (None, None) => {
                return Err(IdentifyError::Missing {
                    file: recording.name().to_owned(),
                    key: "ambient_degc",
                    why: "the rod file does not give it either",
                });
            }
        };
        let profile = match recording.sampling() {
            Sampling::Uniform { dt_s } => Profile::uniform(drive, dt_s, ambient_degc)?,
            Sampling::Jittered { .. } => Profile::timed(drive, recording.time_s(), ambient_degc)?,
            Sampling::Untimed => return Err(untimed()),
        };
        Ok(match recorded {
            Some(recorded) => profile.with_ambient(recorded)?,
            None => profile,
        })
    }
}

/// Temperature of the surroundings when the training begins, °C.
pub(crate) fn ambient_degc(rod: &Rod, training: &[Recording]) -> Result<f64, IdentifyError> {
    let recorded = training
        .iter()
        .find_map(|recording| recording.ambient_degc());
    recorded
        .map(|recorded| recorded[0])
        .or(rod.ambient_degc)
        .ok_or_else(|| IdentifyError::Missing {
            file: rod.file.clone(),
            key: "surroundings.ambient_degc",
            why: "no recording has a column for it either",
        })
}
