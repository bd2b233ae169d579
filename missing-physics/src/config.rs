//! Settings of a diagnosis.

use std::time::Duration;

use identify::{FitConfig, Limits};

use crate::{EffectSet, Setting};

/// How widely a diagnosis searches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Effort {
    /// Six starts of the baseline model ([`Self::starts`], to be set in [`DiagnoseConfig::baseline`]); loops of other families and other
    /// starting points of the chosen model are left out.
    Quick,
    /// Sixteen starts at most; loops of other families where they may do instead of the findings. Trials are made with this.
    #[default]
    Normal,
    /// Forty-eight starts, and loops of other families wherever one of them comes near, relays of two populations among them.
    Thorough,
}

impl Effort {
    /// Independent starts of the baseline model.
    #[must_use]
    pub fn starts(self) -> u64 {
        match self {
            Self::Quick => 6,
            Self::Normal => 16,
            Self::Thorough => 48,
        }
    }

    /// True if these are enough once eight all end at one minimum.
    #[must_use]
    pub fn until_agreed(self) -> bool {
        self != Self::Thorough
    }
}

/// Part of a search that may be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// Loops of other families than the paper's.
    OtherLoops,
    /// Effects beside those that were found, and others in their place.
    MoreEffects,
    /// Other starting points of the chosen model.
    OtherStarts,
    /// The run that would tell rivals apart.
    NextRun,
}

impl Part {
    /// All parts, in the order of a search.
    pub const ALL: [Self; 4] = [
        Self::OtherLoops,
        Self::MoreEffects,
        Self::OtherStarts,
        Self::NextRun,
    ];

    /// Name in files.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            Self::OtherLoops => "other_loops",
            Self::MoreEffects => "more_effects",
            Self::OtherStarts => "other_starts",
            Self::NextRun => "next_run",
        }
    }
}

/// Settings of a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagnoseConfig {
    /// Facts known of the rig beyond its baseline, and hypotheses of one's own, which compete with the catalogue.
    pub setting: Setting,
    /// Effects of the catalogue that may be found.
    pub catalogue: EffectSet,
    /// Limits of the rig, which the proposed run keeps.
    pub limits: Limits,
    /// Search of the baseline.
    pub baseline: FitConfig,
    /// How widely is searched beyond the baseline.
    pub effort: Effort,
    /// Time after which no part is begun that may be left out: the best so far is refitted, judged and reported. Which parts that
    /// are depends on the machine. `None` for no limit.
    pub time_limit: Option<Duration>,
    /// Seed of everything that is drawn.
    pub seed: u64,
}

impl Default for DiagnoseConfig {
    fn default() -> Self {
        Self {
            setting: Setting::default(),
            catalogue: EffectSet::all(),
            limits: Limits::default(),
            baseline: FitConfig {
                starts: Effort::Normal.starts(),
                until_agreed: Effort::Normal.until_agreed(),
                ..FitConfig::default()
            },
            effort: Effort::Normal,
            time_limit: None,
            seed: 1,
        }
    }
}
