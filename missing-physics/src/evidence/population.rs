//! All models that were looked at, with what each is worth.

use crate::evidence::audit::Anonymous;
use crate::evidence::worth::Evidence;
use crate::model::elsewhere::is_drift;
use crate::{Candidate, CandidateSet, LoopFamily};

/// Logarithm of the odds against something that nobody has listed: as against any one that is listed.
pub(crate) const UNLISTED: f64 = -3.0;

/// Nats within which another model does as well: odds of 20 to 1.
const AS_WELL: f64 = 3.0;

/// A model of the population.
#[derive(Debug, Clone)]
pub(crate) struct Model {
    /// Curves of its loop's branches.
    pub(crate) family: LoopFamily,
    /// Its effects.
    pub(crate) effects: CandidateSet,
    /// Its names beyond the baseline model: a loop of another family counts as another shape of the loop.
    pub(crate) names: CandidateSet,
    /// Logarithm of its prior: whether such effects are there, and of that size.
    pub(crate) ln_prior: f64,
    /// Effects that stand against a bound which is no end of what can be.
    pub(crate) pressed: CandidateSet,
    /// Effects too small for their names.
    pub(crate) slight: CandidateSet,
    pub(crate) evidence: Evidence,
    /// With a curve of any shape on top, where that was asked for.
    pub(crate) anonymous: Option<Anonymous>,
}

impl Model {
    /// Logarithm of its prior and density.
    pub(crate) fn worth(&self) -> f64 {
        self.ln_prior + self.evidence.total()
    }

    /// Logarithm of its prior and density with the curve on top.
    pub(crate) fn worth_with_curve(&self) -> Option<f64> {
        let anonymous = self.anonymous.as_ref()?;
        Some(self.ln_prior + UNLISTED + anonymous.evidence.total())
    }

    /// True if it may be chosen: its effects are within their possible ranges, and as large as their names say.
    pub(crate) fn is_admissible(&self) -> bool {
        self.pressed.is_empty() && self.slight.is_empty()
    }

    /// True if each of its names has a form of its own, and none could take any shape. A loop other than the paper's could:
    /// if it is asked for, no formula of a loop is exact here.
    pub(crate) fn is_rigid(&self) -> bool {
        self.names.iter().all(|name| !name.info().flexible)
    }

    /// True if each of its names but that of the loop has a form of its own.
    fn is_rigid_beside_the_loop(&self) -> bool {
        let other_loop = Candidate::other_loop();
        let mut names = self.names.iter().filter(|&name| name != other_loop);
        names.all(|name| !name.info().flexible)
    }

    /// Mean square of the output that a curve finds beyond the model; 0 where it finds nothing more.
    pub(crate) fn found_by_curve(&self) -> f64 {
        let with_curve = self.anonymous.as_ref().filter(|_| !self.is_whole());
        let with = with_curve.map_or(f64::INFINITY, |one| one.evidence.squares()[0]);
        (self.evidence.squares()[0] - with).max(0.0) / self.evidence.n_outputs as f64
    }

    /// True if a curve finds nothing more.
    pub(crate) fn is_whole(&self) -> bool {
        self.worth_with_curve()
            .is_some_and(|with_curve| with_curve < self.worth())
    }
}

/// Models of one set of recordings on the same blocks.
#[derive(Debug, Clone, Default)]
pub(crate) struct Population {
    /// The plain one first.
    pub(crate) models: Vec<Model>,
}

impl Population {
    /// The baseline model.
    pub(crate) fn plain(&self) -> &Model {
        &self.models[0]
    }

    /// The most credible model that may be chosen; one in which all has a form of its own, or all but the loop, if that does as well: a curve of
    /// time takes what it can of any law.
    pub(crate) fn best(&self) -> &Model {
        let admissible = || self.models.iter().filter(|model| model.is_admissible());
        let worth = |a: &&Model, b: &&Model| a.worth().total_cmp(&b.worth());
        let best = admissible().max_by(worth).unwrap_or_else(|| self.plain());
        let of = |is: fn(&Model) -> bool| {
            let such = admissible().filter(|model| is(model)).max_by(worth);
            such.filter(|one| one.worth() > best.worth() - AS_WELL)
        };
        of(Model::is_rigid)
            .or_else(|| of(Model::is_rigid_beside_the_loop))
            .unwrap_or(best)
    }

    /// The models that are as credible as one, or more so: a model leads by what it says, too.
    pub(crate) fn as_credible_as(&self, one: &Model) -> impl Iterator<Item = &Model> {
        let least = one.worth() - AS_WELL;
        let admissible = self.models.iter().filter(|model| model.is_admissible());
        admissible.filter(move |model| model.worth() > least)
    }

    /// Sums of squares that there is no way below: the least of any model, or of any with a curve on top, channel by channel.
    pub(crate) fn ceiling(&self) -> [f64; 2] {
        let named = self.models.iter().map(|model| model.evidence.squares());
        let with_curve = self
            .models
            .iter()
            .filter_map(|model| model.anonymous.as_ref());
        let all = named.chain(with_curve.map(|one| one.evidence.squares()));
        all.fold([f64::INFINITY; 2], |least, squares| {
            [0, 1].map(|channel| squares[channel].min(least[channel]))
        })
    }

    /// Share of what could be explained that is lost from one sum of squares to another; of both channels the larger.
    pub(crate) fn share(&self, with: [f64; 2], without: [f64; 2]) -> f64 {
        self.share_beside(self.plain(), with, without)
    }

    /// Share of what could be explained beside the drifts of a model that is lost from one sum of squares to another; of what the baseline
    /// model leaves, if the model with its drifts alone was not visited.
    ///
    /// A drift is a curve of time: what its knots miss knows nothing of where the rod is, as long as the rod turns back between them. So what
    /// another effect explains need not be large beside a drift to be more than an error of its formula.
    pub(crate) fn share_beside_drifts(
        &self,
        model: &Model,
        with: [f64; 2],
        without: [f64; 2],
    ) -> f64 {
        let drifts = model.names.iter().filter(|&name| is_drift(name)).collect();
        let mut alone = self.models.iter().filter(|one| one.names == drifts);
        self.share_beside(alone.next().unwrap_or(self.plain()), with, without)
    }

    fn share_beside(&self, one: &Model, with: [f64; 2], without: [f64; 2]) -> f64 {
        let (plain, ceiling) = (one.evidence.squares(), self.ceiling());
        let of = |channel: usize| {
            let all = plain[channel] - ceiling[channel];
            // Of what is hardly anything a share says nothing.
            if all > LEAST * plain[channel] {
                (without[channel] - with[channel]) / all
            } else {
                0.0
            }
        };
        of(0).max(of(1))
    }

    /// The best that is left of a model without one of its names: with all others, or with those of them that do not vanish then.
    pub(crate) fn without(&self, model: &Model, name: Candidate) -> &Model {
        let parts = self.parts_without(model, name);
        let best = parts.max_by(|a, b| a.worth().total_cmp(&b.worth()));
        best.unwrap_or_else(|| self.plain())
    }

    /// Least sum of squares of the output that is left of a model without one of its names.
    pub(crate) fn least_without(&self, model: &Model, name: Candidate) -> f64 {
        let parts = self.parts_without(model, name);
        let squares = parts.map(|one| one.evidence.squares()[0]);
        squares.fold(self.plain().evidence.squares()[0], f64::min)
    }

    fn parts_without(&self, model: &Model, name: Candidate) -> impl Iterator<Item = &Model> {
        let left = model.names.without(name);
        let is_part = move |other: &&Model| other.names.iter().all(|one| left.contains(one));
        self.models.iter().filter(is_part)
    }
}

/// Share of a sum of squares below which there is nothing to explain.
const LEAST: f64 = 1e-3;
