//! What can be said of one case.

use std::collections::BTreeSet;

use missing_physics::{EffectBlock, EffectId};

use crate::{CaseLine, Named};

/// Oracle score from which an effect counts as visible, standard deviations.
pub const VISIBLE_T: f64 = 5.0;

/// Effects that belong to their recording: they are not carried to another one.
pub(super) const DRIFTS: [&str; 3] = ["ambient-drift", "sensor-drift", "functional-fatigue"];

/// Probability from which on a name is stated with confidence.
const CONFIDENT: f64 = 0.8;

impl CaseLine {
    /// Whether all that is concealed was to be seen.
    pub(super) fn is_visible(&self) -> bool {
        let oracles = &self.opened.oracles;
        !oracles.is_empty() && oracles.iter().all(|oracle| oracle.t >= VISIBLE_T)
    }

    /// Catalogue names of what is concealed.
    pub(super) fn truths(&self) -> impl Iterator<Item = &str> {
        let concealed = self.opened.answer.concealed.iter();
        concealed.filter_map(|one| one.effect.as_deref())
    }

    /// The first of them; empty if there is none.
    pub(super) fn truth(&self) -> &str {
        self.truths().next().unwrap_or_default()
    }

    /// All names that are stated.
    pub(super) fn stated(&self) -> BTreeSet<&str> {
        self.verdict.findings.iter().flat_map(Named::set).collect()
    }

    pub(super) fn states_all(&self) -> bool {
        let stated = self.stated();
        self.truths().all(|truth| stated.contains(truth))
    }

    /// The strongest name; `None` if there is none.
    pub(super) fn top(&self) -> Option<&str> {
        self.verdict
            .findings
            .first()
            .map(|finding| finding.effect.as_str())
    }

    /// Whether the strongest name is the truth or one of its aliases.
    pub(super) fn is_near(&self) -> bool {
        let mut aliases = self.opened.aliases.iter().flatten();
        self.top()
            .is_some_and(|top| top == self.truth() || aliases.any(|alias| alias == top))
    }

    /// Whether a block is blamed, and it is that of the effect.
    pub(super) fn locates(&self) -> bool {
        let block = self.verdict.block.as_ref();
        let truth = block_of(self.truth());
        block.is_some_and(|(block, _)| Some(block.as_str()) == truth.map(EffectBlock::id))
    }

    /// Whether a name that is not the truth is stated with confidence.
    pub(super) fn is_wrong_and_sure(&self) -> bool {
        let wrong = |finding: &Named| {
            finding.probability > CONFIDENT && !self.truths().any(|truth| truth == finding.effect)
        };
        self.verdict.findings.iter().any(wrong)
    }
}

/// The block of an effect; `None` if the catalogue does not have it.
pub(super) fn block_of(id: &str) -> Option<EffectBlock> {
    Some(EffectId::parse(id).ok()?.info().block)
}
