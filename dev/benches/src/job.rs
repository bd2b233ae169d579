//! Identification of a recording that was simulated from a known truth.

use std::path::PathBuf;

use fixtures::shared;
use pso::Bound;
use recording::{Quantity, ReadOptions, Recording, read_csv};
use serde::Deserialize;
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::{HeatBalanceParams, ThermalConstants};
use wiener::{
    Block, Drive, Ensemble, Member, Profile, Start, WienerError, WienerParams, widest_vectors,
};

/// Coordinates of a point of the job: τ, `T_mid`, `T_c`, `h_0`, ζ, gain, offset.
pub const N_COORDINATES: usize = 7;

/// Most lanes of a block of an [`Ensemble`].
const MOST_LANES: usize = 32;

/// Parameters of the truth, in its order.
const NAMES: [&str; 8] = [
    "tau_s",
    "lambda_C_per_A2",
    "Tm_C",
    "Tc_C",
    "h0_C",
    "zeta",
    "gain_mm",
    "offset_mm",
];

/// λ among them: fixed, as it only sets the scale of temperature.
const LAMBDA: usize = 1;

/// The rig of the job as a `rod.toml`, for [`identify`].
pub const ROD_TOML: &str = r#"[surroundings]
ambient_degc = 25.0

[drive]
kind = "current"

[columns]
time = "time_s"
drive = "current_a"
output = "displacement_mm"

[model]
lambda_k_per_a2 = { fixed = 24.0 }
"#;

/// Why a job cannot be loaded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JobError {
    /// Recording or truth is not beside the workspace.
    #[error("../shared/{file} is not beside the workspace: this program needs it")]
    Absent {
        /// File, relative to the folder of shared material.
        file: &'static str,
    },
    /// The truth cannot be read.
    #[error("{}: cannot be read", .file.display())]
    Unreadable {
        /// File.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The truth is not what this program expects.
    #[error("{}: not a truth", .file.display())]
    Truth {
        /// File.
        file: PathBuf,
        /// Error of the parser.
        source: serde_json::Error,
    },
    /// The truth has other parameters, or a list of another length.
    #[error("{}: {list} must belong to {NAMES:?}", .file.display())]
    Parameters {
        /// File.
        file: PathBuf,
        /// Key of the list.
        list: &'static str,
    },
    /// The recording is refused.
    #[error(transparent)]
    Recording(#[from] recording::RecordingError),
}

#[derive(Debug, Deserialize)]
struct Truth {
    dt_s: f64,
    #[serde(rename = "Ta_C")]
    ambient_degc: f64,
    #[serde(rename = "xs")]
    fraction_swing: f64,
    #[serde(rename = "x0")]
    fraction_center: f64,
    names: Vec<String>,
    #[serde(rename = "true")]
    values: Vec<f64>,
    #[serde(rename = "lb")]
    lower: Vec<f64>,
    #[serde(rename = "ub")]
    upper: Vec<f64>,
}

/// The job: minimize the mean squared error of a Wiener model over a recording of 4,000 samples, by the
/// seven parameters that displacement and current alone can tell.
///
/// Points are searched on a linear scale, gain and offset among the coordinates. The
/// truth lies inside the bounds.
#[derive(Debug, Clone)]
pub struct Job {
    recording: Recording,
    dt_s: f64,
    ambient_degc: f64,
    lambda_k_per_a2: f64,
    fraction_center: f64,
    fraction_swing: f64,
    bounds: Vec<Bound>,
}

impl Job {
    /// Loads `performance/recording.csv` and `performance/truth.json` of the shared material beside the
    /// workspace.
    ///
    /// # Errors
    ///
    /// [`JobError`].
    pub fn load() -> Result<Self, JobError> {
        let path = |file| shared::path(file).ok_or(JobError::Absent { file });
        let file = path("performance/truth.json")?;
        let recording = read_csv(
            path("performance/recording.csv")?,
            &ReadOptions::new(Quantity::Current),
        )?;
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(source) => return Err(JobError::Unreadable { file, source }),
        };
        let truth: Truth = match serde_json::from_str(&text) {
            Ok(truth) => truth,
            Err(source) => return Err(JobError::Truth { file, source }),
        };
        if truth.names != NAMES {
            return Err(JobError::Parameters {
                file,
                list: "names",
            });
        }
        for (list, values) in [
            ("true", &truth.values),
            ("lb", &truth.lower),
            ("ub", &truth.upper),
        ] {
            if values.len() != NAMES.len() {
                return Err(JobError::Parameters { file, list });
            }
        }
        let searched = |k: &usize| *k != LAMBDA;
        Ok(Self {
            recording,
            dt_s: truth.dt_s,
            ambient_degc: truth.ambient_degc,
            lambda_k_per_a2: truth.values[LAMBDA],
            fraction_center: truth.fraction_center,
            fraction_swing: truth.fraction_swing,
            bounds: (0..NAMES.len())
                .filter(searched)
                .map(|k| Bound {
                    lower: truth.lower[k],
                    upper: truth.upper[k],
                })
                .collect(),
        })
    }

    /// The recording.
    #[must_use]
    pub fn recording(&self) -> &Recording {
        &self.recording
    }

    /// Bounds of the coordinates.
    #[must_use]
    pub fn bounds(&self) -> &[Bound] {
        &self.bounds
    }

    /// Sample time, s.
    #[must_use]
    pub fn dt_s(&self) -> f64 {
        self.dt_s
    }

    /// Temperature of the surroundings, °C.
    #[must_use]
    pub fn ambient_degc(&self) -> f64 {
        self.ambient_degc
    }

    /// Drive profile of the rod.
    ///
    /// # Errors
    ///
    /// Errors of [`Profile::uniform`].
    pub fn profile(&self) -> Result<Profile<'_>, WienerError> {
        Profile::uniform(self.recording.drive(), self.dt_s, self.ambient_degc)
    }

    /// The model at a point of [`N_COORDINATES`] coordinates.
    ///
    /// # Panics
    ///
    /// If the point is shorter.
    #[must_use]
    pub fn params(&self, point: &[f64]) -> WienerParams {
        WienerParams {
            heat: HeatBalanceParams::from_constants(ThermalConstants {
                tau_s: point[0],
                lambda_k_per_a2: self.lambda_k_per_a2,
            }),
            limiting_loop: LoopParams {
                loop_center_degc: point[1],
                loop_half_width_k: point[2],
                loop_spread_k: point[3],
                fraction_center: self.fraction_center,
                fraction_swing: self.fraction_swing,
            },
            zeta: point[4],
            gain: point[5],
            offset: point[6],
        }
    }

    /// Mean squared error at each point, mm², in their order: simulated in lockstep on this thread.
    ///
    /// # Errors
    ///
    /// Errors of the model.
    pub fn costs(&self, points: &[impl AsRef<[f64]>]) -> Result<Vec<f64>, WienerError> {
        let members: Vec<Member> = points
            .iter()
            .map(|point| Member {
                params: self.params(point.as_ref()),
                start: Start::rest(self.ambient_degc),
            })
            .collect();
        let ensemble = Ensemble {
            drive: Drive::Current,
            rule: Rule::LastReversal,
        };
        let mut sums = vec![0.0; points.len()];
        ensemble.run(&members, &self.profile()?, &mut |block| {
            let output = &self.recording.output()[block.first_sample..];
            let sums = &mut sums[block.first_member..][..block.members];
            widest_vectors(
                #[inline(always)]
                || add_squares(sums, &block, output),
            );
        })?;
        let n = self.recording.len() as f64;
        Ok(sums.into_iter().map(|sum| sum / n).collect())
    }
}

/// Adds the squared errors of a block to the sums of its members, sample after sample.
#[inline(always)]
fn add_squares(sums: &mut [f64], block: &Block<'_>, output: &[f64]) {
    let mut lanes = [0.0; MOST_LANES];
    lanes[..sums.len()].copy_from_slice(sums);
    for (row, y) in block.displacement.chunks_exact(block.stride).zip(output) {
        for (sum, f) in lanes.iter_mut().zip(row) {
            let error = f - y;
            *sum += error * error;
        }
    }
    sums.copy_from_slice(&lanes[..sums.len()]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_file() {
        let file = PathBuf::from("truth.json");
        let absent = JobError::Absent { file: "truth.json" };
        assert_eq!(
            absent.to_string(),
            "../shared/truth.json is not beside the workspace: this program needs it"
        );
        let unreadable = JobError::Unreadable {
            file: file.clone(),
            source: std::io::Error::other("broken"),
        };
        assert_eq!(unreadable.to_string(), "truth.json: cannot be read");
        let source = serde_json::from_str::<Truth>("{}").unwrap_err();
        let truth = JobError::Truth {
            file: file.clone(),
            source,
        };
        assert_eq!(truth.to_string(), "truth.json: not a truth");
        let parameters = JobError::Parameters { file, list: "ub" };
        let text = parameters.to_string();
        assert!(text.starts_with("truth.json: ub must belong to [\"tau_s\", "));
    }
}
