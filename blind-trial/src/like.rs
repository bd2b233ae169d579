use identify::Rod;
use recording::{NoiseConfig, Quantity, Recording, inspect, noise_floor};
use sha2::{Digest, Sha256};
use truth_plant::{DriveKind, DriveProfile, TruthPlant};

use crate::answer::hex;
use crate::known::{Known, SpecificHeat};

/// Samples of a user's drive that a case is simulated over at most.
const MOST_SAMPLES: usize = 50_000;

/// A user's own rig and drive, around which cases are drawn: what the rod file says is so, the rest is drawn.
///
/// The loss of heat is such that the largest drive just completes the transformation. Noise is as large a share of the
/// stroke as in the recording, if it has the output. The drive is held between samples of its mean length.
#[derive(Debug, Clone, PartialEq)]
pub struct Like {
    pub(crate) known: Known,
    pub(crate) profile: DriveProfile,
    rod: Rod,
    kind: DriveKind,
    /// Standard deviation of the noise over the range of the output.
    noise_share: Option<f64>,
}

/// Why no case can be drawn around a rig.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LikeError {
    /// Without time there is no dynamics to try.
    #[error(
        "{file}: a static loop; cases need a drive in time (kind current, duty, voltage or power)"
    )]
    Static {
        /// The rod file, or the recording.
        file: String,
    },
    /// A duty is of a voltage.
    #[error("{file}: supply_v is missing in [drive]: what a duty is of")]
    Supply {
        /// The rod file.
        file: String,
    },
    /// Nothing would move.
    #[error("{file}: the drive is 0 throughout: cases need one that heats")]
    NoDrive {
        /// The recording.
        file: String,
    },
    /// Too long for a trial of many cases.
    #[error(
        "{file}: {n_samples} samples; at most {MOST_SAMPLES}: give a shorter run, or one that is sampled less often"
    )]
    TooLong {
        /// The recording.
        file: String,
        /// Its length.
        n_samples: usize,
    },
}

impl Like {
    /// A rig as its rod file describes it, under the drive of a recording.
    ///
    /// # Errors
    ///
    /// [`LikeError`] with the file and what it lacks.
    pub fn new(rod: &Rod, recording: &Recording) -> Result<Self, LikeError> {
        let file = || rod.file.clone();
        let name = || recording.name().to_owned();
        let kind = match (rod.drive_kind, rod.supply_v) {
            (Quantity::Current, _) => DriveKind::Current,
            (Quantity::Voltage, _) => DriveKind::Voltage,
            (Quantity::Power, _) => DriveKind::Power,
            (Quantity::Duty, Some(supply_v)) => DriveKind::Duty { supply_v },
            (Quantity::Duty, None) => return Err(LikeError::Supply { file: file() }),
            _ => return Err(LikeError::Static { file: file() }),
        };
        let time_s = recording.time_s();
        let [first_s, .., last_s] = time_s else {
            return Err(LikeError::Static { file: name() });
        };
        let n_samples = time_s.len();
        if n_samples > MOST_SAMPLES {
            return Err(LikeError::TooLong {
                file: name(),
                n_samples,
            });
        }
        if recording.largest_drive() <= 0.0 {
            return Err(LikeError::NoDrive { file: name() });
        }
        let dt_s = (last_s - first_s) / (n_samples - 1) as f64;
        Ok(Self {
            known: known(rod, recording),
            profile: DriveProfile {
                drive: recording.held_drive(dt_s, n_samples),
                dt_s,
            },
            noise_share: noise_share(recording),
            rod: rod.clone(),
            kind,
        })
    }

    /// Tells rigs apart: SHA-256 of all that is known of it.
    pub(crate) fn digest(&self) -> String {
        hex(&Sha256::digest(format!("{self:?}").as_bytes()))
    }

    /// A drawn plant with what is known of the rig in its place.
    pub(crate) fn made_of(&self, drawn: TruthPlant) -> TruthPlant {
        let mut plant = drawn;
        let (rod, own) = (&mut plant.rod, &self.rod);
        let set = |place: &mut f64, known: Option<f64>| *place = known.unwrap_or(*place);
        set(&mut rod.diameter_m, own.diameter_m);
        set(&mut rod.length_m, own.length_m);
        set(
            &mut rod.specific_heat_j_per_kg_k,
            own.specific_heat_j_per_kg_k,
        );
        set(&mut rod.resistance_ohm_per_m, own.resistance_ohm_per_m);
        set(&mut plant.ambient_degc, own.ambient_degc);
        plant.drive = self.kind;
        let largest = self.profile.drive.iter().copied();
        plant.completed_by(largest.map(f64::abs).fold(0.0, f64::max))
    }

    /// Standard deviation of the output's noise, m, for a drawn plant.
    pub(crate) fn noise_m(&self, plant: &TruthPlant) -> Option<f64> {
        self.noise_share.map(|share| share * plant.stroke_m)
    }
}

/// Knowledge and records of the user. A temperature is recorded if a column is named for it, or if the recording has it.
fn known(rod: &Rod, recording: &Recording) -> Known {
    let load = rod.load.as_ref();
    Known {
        dimensions: rod.diameter_m.is_some() && rod.length_m.is_some(),
        temperature: rod.columns.temperature.is_some() || recording.temperature_degc().is_some(),
        ambient: rod.columns.ambient.is_some() || recording.ambient_degc().is_some(),
        spring: load.is_some_and(|load| load.spring_n_per_mm.is_some()),
        lever: load.is_some_and(|load| load.lever.is_some()),
        specific_heat: match (rod.specific_heat_j_per_kg_k, rod.specific_heat_range) {
            (_, Some(_)) => SpecificHeat::AsRange,
            (Some(_), None) => SpecificHeat::Exactly,
            (None, None) => SpecificHeat::NotAtAll,
        },
        resistance: rod.resistance_ohm_per_m.is_some(),
    }
}

fn noise_share(recording: &Recording) -> Option<f64> {
    let range = inspect(recording).output.range();
    let floor = noise_floor(recording, NoiseConfig::default())?;
    (range > 0.0).then(|| floor.lower() / range)
}

#[cfg(test)]
mod tests {
    use rig_files::rod_file;

    use super::*;
    use crate::{Case, CaseId, Family};
    use recording::RecordingParts;

    const ROD: &str = "[rod]\ndiameter_mm = 0.5\nlength_mm = 200.0\ndensity_kg_per_m3 = 6450.0\n\
                       specific_heat_j_per_kg_k = 500.0\n[surroundings]\nambient_degc = 24.0\n[drive]\nkind = \"current\"\n\
                       [columns]\noutput = \"displacement_mm\"\n";

    /// White, of unit variance.
    fn noise(k: usize) -> f64 {
        let hashed = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let hashed = (hashed ^ (hashed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11;
        12_f64.sqrt() * (hashed as f64 / (1_u64 << 53) as f64 - 0.5)
    }

    fn recording(drive: Vec<f64>) -> Recording {
        let n = drive.len();
        Recording::new(RecordingParts {
            name: "mine.csv".to_owned(),
            time_s: Some((0..n).map(|k| 0.1 * k as f64).collect()),
            drive_quantity: Quantity::Current,
            drive,
            output: (0..n)
                .map(|k| (k / 200 % 2) as f64 + 0.01 * noise(k))
                .collect(),
            ..RecordingParts::default()
        })
        .unwrap()
    }

    fn like() -> Like {
        let rod = rod_file::parse("rod.toml", ROD).unwrap();
        let drive = (0..2000).map(|k| f64::from(k / 500 % 2) * 1.8).collect();
        Like::new(&rod, &recording(drive)).unwrap()
    }

    #[test]
    fn what_the_rod_file_says_is_so_and_the_rest_is_drawn() {
        let like = like();
        let id = |number| CaseId::guided(Family::Single, number);
        let [one, other] = [0, 1].map(|number| Case::around(Some(&like), "a seed", id(number)));
        for case in [&one, &other] {
            assert!((case.truth.rod.diameter_m - 0.5e-3).abs() < 1e-15);
            assert!((case.truth.rod.length_m - 0.2).abs() < 1e-15);
            assert!((case.truth.ambient_degc - 24.0).abs() < 1e-12);
            assert_eq!(case.runs.training[0].profile.drive, like.profile.drive);
            assert!(!case.known.resistance && !case.known.temperature);
            // 0.01 of a range of 1 and the noise's own.
            let noise = case.truth.displacement_noise.unwrap();
            let share = noise.deviation / case.truth.stroke_m;
            assert!((share / 0.0097 - 1.0).abs() < 0.2, "{share}");
        }
        assert_ne!(one.truth.hysteresis, other.truth.hysteresis);
    }

    #[test]
    fn the_drive_completes_the_transformation() {
        let like = like();
        let id = CaseId::guided(Family::CleanWhite, 3);
        let recorded = Case::around(Some(&like), "a seed", id).record().unwrap();
        let largest = recorded.training[0]
            .fraction
            .iter()
            .copied()
            .fold(0.0, f64::max);
        assert!(largest > 0.9, "{largest}");
        assert!(recorded.training[0].fraction[0] < 0.1);
    }

    #[test]
    fn what_cannot_be_tried_is_refused_by_name() {
        let rod = rod_file::parse("rod.toml", ROD).unwrap();
        let still = Like::new(&rod, &recording(vec![0.0; 50]));
        assert_eq!(
            still.unwrap_err().to_string(),
            "mine.csv: the drive is 0 throughout: cases need one that heats"
        );
        let text = "[drive]\nkind = \"temperature\"\n[columns]\ndrive = \"t\"\noutput = \"y_mm\"\n";
        let static_rod = rod_file::parse("loop.toml", text).unwrap();
        let refused = Like::new(&static_rod, &recording(vec![1.0; 50]));
        assert!(
            refused
                .unwrap_err()
                .to_string()
                .starts_with("loop.toml: a static loop; ")
        );
    }
}
