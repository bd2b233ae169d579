//! Settings of a diagnosis.

use identify::{FitConfig, Limits};

use crate::{EffectSet, Setting};

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
                starts: 16,
                ..FitConfig::default()
            },
            seed: 1,
        }
    }
}
