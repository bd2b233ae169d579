use missing_physics::{EffectId, EffectSet, EffectValues, Role};
use serde::{Deserialize, Serialize};

use crate::{Made, NoiseKind, StudyError};

/// Standard deviation of the noise, share of the stroke.
const NOISE_SHARE: f64 = 0.0015;

/// Coefficient of the colored noise.
const PHI: f64 = 0.8;

/// Sizes of a single effect, over its typical one; the first round has the typical one.
const MULTIPLES: [f64; 3] = [1.0, 0.5, 2.0];

/// Seeds of a single effect at one size.
const SEEDS_OF_A_SINGLE: u64 = 3;

/// Rigs of a study of clean recordings.
const CLEAN: u64 = 200;

/// Rigs of a study of intervals.
const COVERAGE: u64 = 200;

/// Between the seeds of two studies: none has a rig of another, nor one on which the method was tuned.
const SEEDS_APART: u64 = 1_000_000;

/// A numbered list of made-up rigs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Study {
    /// The plain model with white noise: nothing is to be found.
    CleanWhite,
    /// The plain model with autoregressive noise.
    CleanAr1,
    /// One effect at half its typical size, at that, and at twice that.
    Single,
    /// One effect at its typical size, then struck from the catalogue, and its aliases after it.
    Removed,
    /// Intervals of the latent heat.
    CoverageLatentHeat,
    /// Intervals of the backlash.
    CoverageBacklash,
    /// Intervals of the drift of the surroundings.
    CoverageAmbientDrift,
}

/// An effect in a rig, and how many times its typical size it has.
pub(crate) type Concealed = (EffectId, f64);

impl Study {
    /// Every study.
    pub const ALL: [Self; 7] = [
        Self::CleanWhite,
        Self::CleanAr1,
        Self::Single,
        Self::Removed,
        Self::CoverageLatentHeat,
        Self::CoverageBacklash,
        Self::CoverageAmbientDrift,
    ];

    /// Its name in files and on the command line.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Study::CleanWhite => "clean-white",
            Study::CleanAr1 => "clean-ar1",
            Study::Single => "single",
            Study::Removed => "removed",
            Study::CoverageLatentHeat => "coverage-latent-heat",
            Study::CoverageBacklash => "coverage-backlash",
            Study::CoverageAmbientDrift => "coverage-ambient-drift",
        }
    }

    /// The study of that name.
    ///
    /// # Errors
    ///
    /// [`StudyError::UnknownStudy`] with all names.
    pub fn parse(id: &str) -> Result<Self, StudyError> {
        Self::ALL
            .into_iter()
            .find(|study| study.id() == id)
            .ok_or_else(|| StudyError::UnknownStudy {
                id: id.to_owned(),
                known: Self::ALL.map(Self::id).join(" "),
            })
    }

    /// Number of its cases.
    #[must_use]
    pub fn n_cases(self) -> u64 {
        let effects = EffectId::ALL.len() as u64;
        match self {
            Study::CleanWhite | Study::CleanAr1 => CLEAN,
            Study::Single => effects * MULTIPLES.len() as u64 * SEEDS_OF_A_SINGLE,
            Study::Removed => effects * SEEDS_OF_A_SINGLE,
            Study::CoverageLatentHeat | Study::CoverageBacklash | Study::CoverageAmbientDrift => {
                COVERAGE
            }
        }
    }

    /// The rig of a case. Effects change fastest with its number, then sizes, then rounds of seeds; a number
    /// beyond [`n_cases`](Self::n_cases) is another round.
    #[must_use]
    pub fn made(self, case: u64) -> Made {
        let concealed = self.concealed(case);
        Made {
            effects: concealed.map_or(EffectSet::EMPTY, |(effect, _)| EffectSet::of(effect)),
            values: concealed.map_or(EffectValues::default(), |(effect, multiple)| {
                values(effect, multiple)
            }),
            noise: match self {
                Study::CleanAr1 => NoiseKind::Autoregressive(PHI),
                _ => NoiseKind::White,
            },
            noise_share: NOISE_SHARE,
            seed: SEEDS_APART * (1 + self as u64) + case,
        }
    }

    pub(crate) fn concealed(self, case: u64) -> Option<Concealed> {
        let effects = EffectId::ALL.len() as u64;
        let cyclic = EffectId::ALL[(case % effects) as usize];
        match self {
            Study::CleanWhite | Study::CleanAr1 => None,
            Study::Single => {
                let round = (case / effects) as usize;
                Some((cyclic, MULTIPLES[round % MULTIPLES.len()]))
            }
            Study::Removed => Some((cyclic, 1.0)),
            Study::CoverageLatentHeat => Some((EffectId::LatentHeat, 1.0)),
            Study::CoverageBacklash => Some((EffectId::Backlash, 1.0)),
            Study::CoverageAmbientDrift => Some((EffectId::AmbientDrift, 1.0)),
        }
    }
}

/// Some times the typical sizes, within the bounds.
fn values(effect: EffectId, multiple: f64) -> EffectValues {
    let mut values = EffectValues::typical(effect, multiple);
    for (index, parameter) in effect.info().parameters.iter().enumerate() {
        if let Some(value) = values.slot(effect, index) {
            *value = value.clamp(parameter.bounds[0], parameter.bounds[1]);
        }
    }
    values
}

/// The sizes of an effect, in its order.
pub(crate) fn sizes(effect: EffectId, values: &EffectValues) -> Vec<f64> {
    let parameters = effect.info().parameters.iter().enumerate();
    parameters
        .filter(|(_, parameter)| parameter.role == Role::Size)
        .filter_map(|(index, _)| values.get(effect, index))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_files() {
        for study in Study::ALL {
            assert_eq!(Study::parse(study.id()).unwrap(), study);
            let json = serde_json::to_string(&study).unwrap();
            assert_eq!(json, format!("{:?}", study.id()));
        }
    }

    #[test]
    fn an_unknown_study_is_answered_with_all_names() {
        let text = Study::parse("clean").unwrap_err().to_string();
        assert!(
            text.starts_with("no study \"clean\"; there are: clean-white clean-ar1 "),
            "{text}"
        );
    }

    #[test]
    fn every_value_of_every_case_is_within_its_bounds() {
        for case in 0..Study::Single.n_cases() {
            let made = Study::Single.made(case);
            made.values.checked(made.effects).unwrap();
        }
    }
}
