use std::fmt;

use serde::{Deserialize, Serialize};
use truth_plant::Addition;

use crate::TrialError;

/// Family of cases: the properties that its cases have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// Nothing concealed, white noise.
    CleanWhite,
    /// Nothing concealed, autoregressive noise.
    CleanAr,
    /// Nothing concealed, 1/f noise.
    CleanOneOverF,
    /// Nothing concealed, steps of the converter coarser than the noise.
    CleanQuantized,
    /// Nothing concealed, outliers.
    CleanOutliers,
    /// One effect of the catalogue at half its usual size, at that, at twice that; white or autoregressive noise.
    Single,
    /// One effect as in [`Family::Single`], with 1/f noise, coarse steps or outliers.
    HardNoise,
    /// Two effects of the catalogue.
    Pair,
    /// One effect, and a loop that is not of the baseline model's family.
    OtherLoop,
    /// Such a loop alone.
    OtherLoopClean,
    /// One effect that no catalogue has.
    Outside,
    /// One effect, struck from the catalogue with its aliases.
    Deleted,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 12] = [
        Self::CleanWhite,
        Self::CleanAr,
        Self::CleanOneOverF,
        Self::CleanQuantized,
        Self::CleanOutliers,
        Self::Single,
        Self::HardNoise,
        Self::Pair,
        Self::OtherLoop,
        Self::OtherLoopClean,
        Self::Outside,
        Self::Deleted,
    ];

    /// Its name in files and flags.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::CleanWhite => "clean-white",
            Self::CleanAr => "clean-ar",
            Self::CleanOneOverF => "clean-one-over-f",
            Self::CleanQuantized => "clean-quantized",
            Self::CleanOutliers => "clean-outliers",
            Self::Single => "single",
            Self::HardNoise => "hard-noise",
            Self::Pair => "pair",
            Self::OtherLoop => "other-loop",
            Self::OtherLoopClean => "other-loop-clean",
            Self::Outside => "outside",
            Self::Deleted => "deleted",
        }
    }

    /// True if its loops are of another family than the baseline model's, whatever the plant.
    fn has_other_loop(self) -> bool {
        matches!(self, Self::OtherLoop | Self::OtherLoopClean)
    }

    /// The family of that name.
    ///
    /// # Errors
    ///
    /// [`TrialError::UnknownFamily`] with all names.
    pub fn parse(id: &str) -> Result<Self, TrialError> {
        let mut all = Self::ALL.into_iter();
        all.find(|family| family.id() == id)
            .ok_or_else(|| TrialError::UnknownFamily {
                id: id.to_owned(),
                known: Self::ALL.map(Self::id).join(" "),
            })
    }

    /// Number of cases of a published table.
    #[must_use]
    pub fn published(self) -> u64 {
        match self {
            Self::CleanWhite
            | Self::CleanAr
            | Self::CleanOneOverF
            | Self::CleanQuantized
            | Self::CleanOutliers => 300,
            Self::Single => 4 * 3 * N_NAMED,
            Self::HardNoise => 3 * N_NAMED,
            Self::Pair => 80,
            Self::OtherLoop => 2 * N_NAMED,
            Self::OtherLoopClean => 30,
            Self::Outside => 10 * OUTSIDE.len() as u64,
            Self::Deleted => 4 * N_NAMED,
        }
    }

    /// True if nothing is concealed and the loop is that of the baseline model.
    #[must_use]
    pub fn is_clean(self) -> bool {
        matches!(
            self,
            Self::CleanWhite
                | Self::CleanAr
                | Self::CleanOneOverF
                | Self::CleanQuantized
                | Self::CleanOutliers
        )
    }
}

impl fmt::Display for Family {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

/// Additions that a catalogue knows.
const N_NAMED: u64 = 21;

/// Additions that no catalogue has. A source's impedance is not among them: it shows through a resistance that changes
/// with the phase, which has a name.
pub(crate) const OUTSIDE: [Addition; 6] = [
    Addition::Draughts,
    Addition::MountSlip,
    Addition::MainsHum,
    Addition::SecondRod,
    Addition::SpringChange,
    Addition::ConvectionDip,
];

/// Additions that a catalogue knows.
pub(crate) fn named() -> Vec<Addition> {
    let known = |addition: &Addition| addition.catalogue_id().is_some();
    Addition::ALL.into_iter().filter(known).collect()
}

/// How cases are recorded, and of what they are made.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Default, Serialize, Deserialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum Era {
    /// One plant, every recording as the guide asks for it, one for training: the first published table.
    #[default]
    Guided,
    /// Two plants that share no code for heat or loop, recordings as labs make them.
    Lab,
}

/// One case of a trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct CaseId {
    /// How it is recorded.
    #[serde(default, skip_serializing_if = "Era::is_guided")]
    pub era: Era,
    /// Its family.
    pub family: Family,
    /// Its number in the family, from 0.
    pub number: u64,
}

impl Era {
    /// All of them.
    const ALL: [Self; 2] = [Self::Guided, Self::Lab];

    /// Its name in files.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::Guided => "guided",
            Self::Lab => "lab",
        }
    }

    fn is_guided(&self) -> bool {
        *self == Self::Guided
    }
}

impl CaseId {
    /// A case as labs record it.
    #[must_use]
    pub fn lab(family: Family, number: u64) -> Self {
        let era = Era::Lab;
        Self {
            era,
            family,
            number,
        }
    }

    /// A case that is recorded as the guide asks.
    #[must_use]
    pub fn guided(family: Family, number: u64) -> Self {
        let era = Era::Guided;
        Self {
            era,
            family,
            number,
        }
    }

    /// True if its loop is of another family than the baseline model's: a name in the transformation is neither right nor
    /// wrong there.
    pub(crate) fn has_other_loop(self) -> bool {
        self.family.has_other_loop() || self.has_second_plant()
    }

    /// True if its rig is of the second plant: in turn, and for every effect of a family that goes round.
    pub(crate) fn has_second_plant(self) -> bool {
        let turn = match self.family {
            // Each of the plants has two loops here, in turn.
            Family::OtherLoop | Family::OtherLoopClean => self.number / 2,
            // An even number of effects.
            Family::Outside => self.number + self.number / OUTSIDE.len() as u64,
            _ => self.number,
        };
        self.era == Era::Lab && turn % 2 == 1
    }
}

impl fmt::Display for CaseId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let era = match self.era {
            Era::Guided => "",
            Era::Lab => "lab-",
        };
        write!(f, "{era}{}-{:04}", self.family, self.number)
    }
}

/// How many cases of each family a trial has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    era: Era,
    /// Cases of each family.
    counts: Vec<(Family, u64)>,
    /// Which of them are to be run: every n-th, from the i-th.
    shard: (usize, usize),
}

impl Plan {
    /// The cases of a published table, of some families; of all, if none is given.
    #[must_use]
    pub fn published(families: &[Family]) -> Self {
        Self::with(Era::Lab, families, Family::published)
    }

    /// Those of the first published table, recorded as the guide asks: to compare.
    #[must_use]
    pub fn guided(families: &[Family]) -> Self {
        Self::with(Era::Guided, families, Family::published)
    }

    /// About so many cases in all, in the proportions of the published table, at least one a family.
    #[must_use]
    pub fn of_about(n_cases: u64, families: &[Family]) -> Self {
        let all: u64 = chosen(families).map(Family::published).sum();
        Self::with(Era::Lab, families, |family| {
            ((family.published() * n_cases + all / 2) / all).clamp(1, family.published())
        })
    }

    /// Every effect that a catalogue knows, alone, at its usual size, half and twice that, for a user's own drive.
    #[must_use]
    pub fn singles() -> Self {
        Self::with(Era::Guided, &[Family::Single], |_| 3 * N_NAMED)
    }

    fn with(era: Era, families: &[Family], count: impl Fn(Family) -> u64) -> Self {
        Self {
            era,
            counts: chosen(families)
                .map(|family| (family, count(family)))
                .collect(),
            shard: (0, 1),
        }
    }

    /// Every n-th of its cases, from the i-th; `i` from 0, below `n`.
    #[must_use]
    pub fn shard(mut self, i: usize, n: usize) -> Self {
        self.shard = (i, n.max(1));
        self
    }

    /// The cases that are to be run, in their order.
    #[must_use]
    pub fn cases(&self) -> Vec<CaseId> {
        let (i, n) = self.shard;
        self.whole().skip(i).step_by(n).collect()
    }

    /// All cases in their order, whatever the shard.
    pub(crate) fn whole(&self) -> impl Iterator<Item = CaseId> {
        let era = self.era;
        self.counts.iter().flat_map(move |&(family, n)| {
            (0..n).map(move |number| CaseId {
                era,
                family,
                number,
            })
        })
    }

    /// The plan of a text as it is displayed; `None` if it is none.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut words = text.split(' ');
        let era = words.next()?;
        let era = Era::ALL.into_iter().find(|one| one.id() == era)?;
        let count = |word: &str| {
            let (family, n) = word.split_once('=')?;
            Some((Family::parse(family).ok()?, n.parse().ok()?))
        };
        Some(Self {
            era,
            counts: words.map(count).collect::<Option<_>>()?,
            shard: (0, 1),
        })
    }
}

/// The era and how many cases of each family, whatever the shard.
impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.era.id())?;
        let mut counts = self.counts.iter();
        counts.try_for_each(|(family, n)| write!(f, " {family}={n}"))
    }
}

/// The families that are given, in their order; all, if none is.
fn chosen(families: &[Family]) -> impl Iterator<Item = Family> {
    Family::ALL
        .into_iter()
        .filter(move |family| families.is_empty() || families.contains(family))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_files() {
        for family in Family::ALL {
            assert_eq!(Family::parse(family.id()).unwrap(), family);
            let json = serde_json::to_string(&family).unwrap();
            assert_eq!(json, format!("{:?}", family.id()));
        }
        let text = Family::parse("clean").unwrap_err().to_string();
        assert!(text.starts_with("no family \"clean\"; there are: clean-white "));
    }

    #[test]
    fn the_published_table_has_enough_cases() {
        assert_eq!(named().len() as u64, N_NAMED);
        let n = |clean: bool| -> u64 {
            let all = Family::ALL.into_iter();
            all.filter(|family| family.is_clean() == clean)
                .map(Family::published)
                .sum()
        };
        assert_eq!(n(true), 1500);
        assert!(n(false) >= 600, "{}", n(false));
    }

    #[test]
    fn shards_make_up_the_whole() {
        let whole = Plan::of_about(60, &[]);
        assert!((50..75).contains(&whole.cases().len()));
        let mut shards: Vec<CaseId> = (0..3)
            .flat_map(|i| whole.clone().shard(i, 3).cases())
            .collect();
        shards.sort();
        assert_eq!(shards, whole.cases());
    }

    #[test]
    fn a_plan_is_read_as_it_is_written() {
        for plan in [Plan::published(&[]), Plan::guided(&[Family::Pair])] {
            let text = plan.to_string();
            assert_eq!(Plan::parse(&text), Some(plan.clone()));
            assert_eq!(plan.shard(1, 4).to_string(), text);
        }
        let pairs = Plan::guided(&[Family::Pair]).to_string();
        assert_eq!(pairs, "guided pair=80");
        assert_eq!(Plan::parse("clean-ar-0000"), None);
    }
}
