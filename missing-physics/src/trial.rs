//! Errors of models on parts of the training that they have not seen, against the noise.

use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;

use identify::IdentifyError;

use crate::CandidateSet;
use crate::case::Node;
use crate::floor::Measured;
use crate::folds::{Fold, HeldOut, folds, held_out, mean_square};
use crate::search::Search;

/// Factor by which the variance of the noise may differ between holds, repeats and the rest.
pub(crate) const KNOWN: f64 = 1.1;

/// Recordings from which whole ones are left out in turn.
const FEWEST_RECORDINGS: usize = 3;

/// Parts of the training that are left out in turn, each with a refit.
const PARTS: usize = 4;

/// Gap between training and held-out samples, time constants.
const GAP: f64 = 5.0;

/// Held-out errors of a model where it stood.
#[derive(Debug)]
struct Known {
    effects: CandidateSet,
    coordinates: Vec<f64>,
    parts: Rc<[HeldOut]>,
}

/// Normal quantile of a lower bound of 95 %.
const ONE_SIDED: f64 = 1.645;

/// A share of the explainable error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Share {
    pub(crate) value: f64,
    /// What it is at least, by how much the parts differ.
    pub(crate) lower: f64,
}

/// The held-out errors of models of one case.
#[derive(Debug)]
pub(crate) struct Trial {
    folds: Vec<Fold>,
    /// Whether models are refitted without each part: what is far from the recordings is not linear.
    refits: bool,
    known: RefCell<Vec<Known>>,
    /// Mean square of the baseline's.
    pub(crate) baseline: f64,
    /// Standard error of that over the noise.
    error: f64,
    /// Variance of the noise.
    pub(crate) noise: f64,
}

impl Trial {
    pub(crate) fn of(
        search: &Search<'_>,
        noise: &Measured,
        tau_s: f64,
    ) -> Result<Self, IdentifyError> {
        let mut trial = Self {
            folds: folds(search.case, GAP * tau_s),
            refits: search.is_misfit(),
            known: RefCell::default(),
            baseline: 0.0,
            error: 0.0,
            noise: noise.gate,
        };
        let baseline = search.baseline();
        trial.baseline = trial.held_out(search, baseline)?;
        let spread = (2.0 / baseline.noise.output.n_effective).sqrt();
        trial.error = (trial.baseline * spread).hypot(trial.noise * noise.relative_error);
        Ok(trial)
    }

    /// Mean square error of a model on what it has not seen of the training.
    pub(crate) fn held_out(&self, search: &Search<'_>, node: &Node) -> Result<f64, IdentifyError> {
        Ok(mean_square(&self.parts(search, node)?))
    }

    /// What a model leaves, to weigh its effects by: on what it has not seen. Where that is whole recordings, other
    /// drives than those it was fitted to, it is far out, which is for the whole model to stand, and each effect is weighed by
    /// what it brings to all.
    pub(crate) fn left(&self, search: &Search<'_>, node: &Node) -> Result<f64, IdentifyError> {
        if self.leaves_recordings(search) {
            Ok(node.mean_square())
        } else {
            self.held_out(search, node)
        }
    }

    /// Whether whole recordings are left out in turn: another rate or amplitude is the harder test.
    fn leaves_recordings(&self, search: &Search<'_>) -> bool {
        self.refits && search.case.training.len() >= FEWEST_RECORDINGS
    }

    /// Errors of a model on each part of the training that it has not seen.
    fn parts(&self, search: &Search<'_>, node: &Node) -> Result<Rc<[HeldOut]>, IdentifyError> {
        let known = self.known.borrow();
        let is_it =
            |known: &&Known| known.effects == node.effects && known.coordinates == node.coordinates;
        if let Some(known) = known.iter().find(is_it) {
            return Ok(Rc::clone(&known.parts));
        }
        drop(known);
        let parts: Rc<[HeldOut]> = if self.leaves_recordings(search) {
            search.case.without_recordings(node)?.into()
        } else if self.refits {
            let parts: Vec<Vec<Range<usize>>> = (0..PARTS)
                .map(|part| {
                    let own = self.folds.iter().skip(part).step_by(PARTS);
                    own.map(|fold| fold.scored.clone()).collect()
                })
                .collect();
            search.case.without_parts(node, &parts)?.into()
        } else {
            let sensitivities = search.sensitivities(node)?;
            let residual = held_out(node, &sensitivities, &self.folds);
            let scored = self.folds.iter().map(|fold| fold.scored.clone());
            scored.map(|part| HeldOut::of(&residual[part])).collect()
        };
        self.known.borrow_mut().push(Known {
            effects: node.effects,
            coordinates: node.coordinates.clone(),
            parts: Rc::clone(&parts),
        });
        Ok(parts)
    }

    /// Whether the baseline leaves more than noise beyond doubt.
    pub(crate) fn is_resolved(&self) -> bool {
        self.baseline - self.noise > 2.0 * self.error
    }

    /// Share of the explainable error that a model explains where it was not fitted.
    pub(crate) fn explained(
        &self,
        search: &Search<'_>,
        node: &Node,
    ) -> Result<Option<Share>, IdentifyError> {
        if !self.is_resolved() || node.effects.is_empty() {
            return Ok(None);
        }
        let [before, after] = [search.baseline(), node].map(|node| self.parts(search, node));
        let (before, after) = (before?, after?);
        let without = |left_out: Option<usize>| {
            let of = |parts: &[HeldOut]| {
                let kept = parts.iter().enumerate();
                let kept = kept.filter(|(k, _)| Some(*k) != left_out);
                mean_square(&kept.map(|(_, part)| *part).collect::<Vec<_>>())
            };
            (of(&before) - of(&after)) / (of(&before) - self.noise)
        };
        let share = without(None);
        // Jackknife over the parts.
        let m = before.len() as f64;
        let moved: f64 = (0..before.len())
            .map(|k| (without(Some(k)) - share).powi(2))
            .sum();
        Ok(Some(Share {
            value: share,
            lower: share - ONE_SIDED * ((m - 1.0) / m * moved).sqrt(),
        }))
    }

    /// Whether a model leaves more than the noise that was measured.
    pub(crate) fn far_off(node: &Node, noise: &Measured) -> bool {
        let error = (2.0 / node.noise.output.n_effective)
            .sqrt()
            .hypot(noise.relative_error);
        node.mean_square() > KNOWN * noise.highest() * (1.0 + 2.0 * error)
    }

    /// Whether the share by the noise floor says more than that by the lack of fit: the baseline leaves much more
    /// than noise, and the model does, too, or what it leaves is no noise.
    pub(crate) fn tells(&self, node: &Node, noise: &Measured) -> bool {
        self.is_resolved() && (Self::far_off(node, noise) || noise.is_unsteady(node.mean_square()))
    }
}
