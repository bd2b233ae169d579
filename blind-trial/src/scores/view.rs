//! Properties of one case.

use std::collections::BTreeSet;

use sma_effects::{EffectBlock, EffectId};

use crate::{CaseLine, Named};

/// Oracle score from which an effect counts as visible, standard deviations.
pub const VISIBLE_T: f64 = 5.0;

/// Effects that belong to their recording: they are not carried to another one.
pub(super) const DRIFTS: [&str; 3] = ["ambient-drift", "sensor-drift", "functional-fatigue"];

/// Probability from which on a name is stated with confidence.
const CONFIDENT: f64 = 0.8;

/// Misfit over the true noise from which on it is not adequate, whatever is said of it.
pub(super) const MISFIT: f64 = 5.0;

impl CaseLine {
    /// True if all concealed effects were visible.
    pub(super) fn is_visible(&self) -> bool {
        let oracles = &self.opened.oracles;
        !oracles.is_empty() && oracles.iter().all(|oracle| oracle.t >= VISIBLE_T)
    }

    /// True if all concealed effects were visible beside what a diagnosis must leave open, too.
    pub(super) fn is_visible_beside_all_that_is_open(&self) -> bool {
        let is_seen = |t: Option<f64>| t.is_some_and(|t| t >= VISIBLE_T);
        let mut oracles = self.opened.oracles.iter();
        self.is_visible() && oracles.all(|oracle| is_seen(oracle.t_open))
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

    /// All names that are stated and are right or wrong.
    pub(super) fn stated(&self) -> BTreeSet<&str> {
        let names = self.verdict.findings.iter().flat_map(Named::set);
        names.filter(|name| self.is_right(name).is_some()).collect()
    }

    pub(super) fn states_all(&self) -> bool {
        let stated = self.stated();
        self.truths().all(|truth| stated.contains(truth))
    }

    /// The strongest name that is right or wrong; `None` if there is none.
    pub(super) fn top(&self) -> Option<&str> {
        let mut names = self.verdict.findings.iter().map(|one| one.effect.as_str());
        names.find(|name| self.is_right(name).is_some())
    }

    /// True if the strongest name is the truth or one of its aliases.
    pub(super) fn is_near(&self) -> bool {
        let mut aliases = self.opened.aliases.iter().flatten();
        self.top()
            .is_some_and(|top| top == self.truth() || aliases.any(|alias| alias == top))
    }

    /// True if a block is blamed, and it is that of the effect.
    pub(super) fn locates(&self) -> bool {
        let block = self.verdict.block.as_ref();
        let truth = block_of(self.truth());
        block.is_some_and(|(block, _)| Some(block.as_str()) == truth.map(EffectBlock::id))
    }

    /// True if a name is right; `None` if it is neither right nor wrong, in the transformation of a loop that is not of the
    /// baseline model's family.
    pub(super) fn is_right(&self, effect: &str) -> Option<bool> {
        let is_right = self.truths().any(|truth| truth == effect);
        let is_of_the_loop = block_of(effect) == Some(EffectBlock::Transformation);
        (is_right || !(is_of_the_loop && self.case.has_other_loop())).then_some(is_right)
    }

    /// True if a wrong name is stated, and nothing in its place that is right or of the loop.
    pub(super) fn is_wrong(&self) -> bool {
        let findings = &self.verdict.findings;
        findings
            .iter()
            .any(|finding| finding.set().all(|name| self.is_right(name) == Some(false)))
    }

    /// True if a wrong name is stated with confidence.
    pub(super) fn is_wrong_and_sure(&self) -> bool {
        let wrong = |finding: &Named| {
            finding.probability > CONFIDENT && self.is_right(&finding.effect) == Some(false)
        };
        self.verdict.findings.iter().any(wrong)
    }

    /// True if something is said to be missing that no name accounts for.
    pub(super) fn is_unexplained(&self) -> bool {
        self.verdict.verdict == "unexplained"
    }

    /// True if nothing is said to be missing.
    pub(super) fn is_adequate(&self) -> bool {
        self.verdict.verdict == "adequate"
    }

    /// True if something is said to be left beside names that are right or of the loop, where the loop is of another family.
    pub(super) fn is_in_part_by_another_loop(&self) -> bool {
        self.case.has_other_loop()
            && self.verdict.verdict == "explained_in_part"
            && !self.is_wrong()
    }

    /// True if the baseline model misses the training recordings by many times the noise.
    pub(super) fn misfits(&self) -> bool {
        self.verdict.plain.train >= MISFIT * self.opened.noise_mm
    }

    /// Of every concealed effect that was to be seen and whose size can be compared: whether it is excluded at that size or
    /// below.
    pub(super) fn exclusions(&self) -> impl Iterator<Item = bool> {
        let opened = &self.opened;
        let pairs = opened.sizes.iter().zip(&opened.excluded_above);
        pairs
            .zip(&opened.oracles)
            .filter_map(|((size, above), oracle)| {
                let size = size.filter(|_| oracle.t >= VISIBLE_T)?;
                Some(above.is_some_and(|above| above <= size))
            })
    }

    /// How the rig was recorded; `None` where all were as the guide asks.
    pub(super) fn recording(&self) -> Option<&str> {
        self.opened.answer.recording.as_deref()
    }

    /// Which plant made the recordings; `None` where there was one.
    pub(super) fn plant(&self) -> Option<&str> {
        self.opened.answer.plant.as_deref()
    }
}

/// The block of an effect; `None` if the catalogue does not have it.
pub(super) fn block_of(id: &str) -> Option<EffectBlock> {
    Some(EffectId::parse(id).ok()?.info().block)
}
