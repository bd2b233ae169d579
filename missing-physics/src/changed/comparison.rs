//! Everything that may have changed in some runs, compared with no change.

use std::f64::consts::LN_2;

use identify::{
    ForwardModel, IdentifyError, ParameterState, ParameterVector, Scope, in_parallel,
    try_in_parallel,
};
use recording::order::falling;

use crate::changed::discrepancy::Discrepancy;
use crate::changed::first_order::{Tried, alternatives};
use crate::changed::joint::{Joint, Runs};
use crate::changed::version::{AsLarge, Version, What};
use crate::model::case::Case;
use crate::{Belongs, Candidate, CandidateSet};

/// Ways of an effect that are followed to their ends, the likeliest to first order.
const WAYS: usize = 2;

/// Changes from whose ends no change is searched again, what they must gain, and what that must gain, nats.
const LED_BY: usize = 4;
const LEADS: f64 = 2.0;
const BETTER: f64 = 0.5;

/// Rounds of that.
const ROUNDS: usize = 4;

/// The likeliest changes that are told apart on more samples, at most.
const TOLD_APART: usize = 6;

/// A change at the end of its search.
#[derive(Debug, Clone)]
pub(crate) struct Ended {
    pub(crate) what: What,
    /// Logarithm of its density over that of no change.
    pub(crate) nats: f64,
    pub(crate) joint: Joint,
}

/// Some runs, and which of them may have changed.
#[derive(Debug)]
pub(crate) struct Comparison<'a> {
    pub(crate) case: &'a Case<'a>,
    pub(crate) runs: &'a Runs,
    pub(crate) which: &'a [usize],
    pub(crate) changed: &'a [usize],
    pub(crate) discrepancy: Discrepancy,
    /// Effects that may have appeared.
    pub(crate) catalogue: CandidateSet,
    /// True if changes of laws are considered, too.
    pub(crate) with_laws: bool,
}

impl Comparison<'_> {
    /// Where no change leads, and all changes, the likeliest first.
    ///
    /// A change may lead to laws and states that no change had not found: it is searched again from there, so that what is compared
    /// is the change alone.
    pub(crate) fn made(&self, mut none: Joint) -> Result<(Joint, Vec<Ended>), IdentifyError> {
        let mut round = 1;
        loop {
            let before = self.nats(&none);
            let mut found = self.ends(&none)?;
            let leading = found.iter().take(LED_BY);
            let leading: Vec<&Ended> = leading.filter(|one| one.nats > before + LEADS).collect();
            let again = try_in_parallel(&leading, |one| {
                let version = none.version.clone();
                let from = one.joint.in_version(&version, self.runs.len());
                let here = Joint::at(self.case, version, from)?;
                let there = self.settled(here.clone())?;
                // Fewer squares need not be more density.
                let both = [here, there].map(|joint| (self.nats(&joint), joint));
                Ok(both.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)))
            })?;
            let best = again
                .into_iter()
                .flatten()
                .max_by(|a, b| a.0.total_cmp(&b.0));
            let better = best.filter(|(nats, _)| *nats > before + BETTER);
            match better {
                Some((_, better)) if round < ROUNDS => none = better,
                _ => {
                    let (unchanged, none) = better.unwrap_or((before, none));
                    for one in &mut found {
                        one.nats -= unchanged;
                    }
                    return Ok((none, found));
                }
            }
            round += 1;
        }
    }

    /// Tells changes apart by this comparison, where they were found by another, which says how likely the likeliest of them is.
    pub(crate) fn told_apart(&self, leading: &mut [Ended]) -> Result<(), IdentifyError> {
        let likeliest = leading[0].nats;
        let told = try_in_parallel(leading, |one| {
            let (version, start) = (one.joint.version.clone(), one.joint.coordinates.clone());
            Ok(self.nats(&self.settled(Joint::at(self.case, version, start)?)?))
        })?;
        let highest = told.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for (one, nats) in leading.iter_mut().zip(told) {
            one.nats = likeliest + nats - highest;
        }
        Ok(())
    }

    pub(crate) fn settled(&self, joint: Joint) -> Result<Joint, IdentifyError> {
        joint.settled(self.case, self.runs, self.which, &self.discrepancy)
    }

    fn nats(&self, joint: &Joint) -> f64 {
        joint.nats(self.runs, self.which, &self.discrepancy)
    }

    /// Effects to first order, with the ways in which they may be there.
    fn to_first_order(&self, joint: &Joint) -> Result<Vec<(Candidate, Vec<Tried>)>, IdentifyError> {
        let n_runs = self.runs.len();
        let points = joint.points(n_runs);
        let model = joint.version.model().clone();
        let vector = ParameterVector::new(model.parameters(), n_runs);
        let coordinates = vector.coordinates(|parameter, run| Some(points[run][parameter]));
        let node = self.case.node(model, coordinates, points, 0)?;
        let alternatives = alternatives(self.case, self.runs, &node, self.catalogue)?;
        let system = joint.system(self.runs, self.which, &self.discrepancy);
        Ok(in_parallel(&alternatives, |one| {
            (one.effect, one.tried(self.runs, &system, self.changed))
        }))
    }

    /// All changes at the ends of their searches, the likeliest first.
    fn ends(&self, none: &Joint) -> Result<Vec<Ended>, IdentifyError> {
        let effects = self.to_first_order(none)?;
        let mut starts: Vec<(What, Version, Vec<f64>)> = Vec::new();
        for (effect, tried) in &effects {
            let ways = tried.iter().take(WAYS);
            for (tried, as_large) in
                ways.flat_map(|tried| AsLarge::ALL.map(|as_large| (tried, as_large)))
            {
                let (version, start) = self.with_effect(none, (*effect, as_large), tried);
                starts.push((What::Effect(*effect), version, start));
            }
        }
        if self.with_laws {
            let infos = none.version.model().parameters().iter().enumerate();
            let laws = infos.filter(|(_, info)| {
                info.scope == Scope::Shared && info.state == ParameterState::Free
            });
            for (law, _) in laws {
                let version = none.version.with_law(law, &none.point(0));
                let start = none.in_version(&version, self.runs.len());
                starts.push((What::Law(law), version, start));
            }
        }
        let mut ended = try_in_parallel(&starts, |(what, version, start)| {
            let joint = self.settled(Joint::at(self.case, version.clone(), start.clone())?)?;
            // Of two priors of its sizes the better one counts, as the half of both.
            let halved = if matches!(what, What::Effect(_)) {
                LN_2
            } else {
                0.0
            };
            let (what, nats) = (*what, self.nats(&joint) - halved);
            Ok(Ended { what, nats, joint })
        })?;
        falling(&mut ended, |one| one.nats);
        let mut seen: Vec<What> = Vec::new();
        ended.retain(|one| {
            let is_first = !seen.contains(&one.what);
            seen.push(one.what);
            is_first
        });
        Ok(ended)
    }

    /// A version in which an effect has appeared, and where its search starts.
    fn with_effect(
        &self,
        none: &Joint,
        (effect, as_large): (Candidate, AsLarge),
        tried: &Tried,
    ) -> (Version, Vec<f64>) {
        let model = self.case.model(none.version.model().active().with(effect));
        let version = none.version.with_effect(model, effect, as_large);
        let mut start = none.in_version(&version, self.runs.len());
        let vector = ParameterVector::new(version.parameters(), self.runs.len());
        let info = effect.info();
        let first = version.model().first_parameter(effect);
        // The knots of a drift start at nothing.
        if let Some(first) = first.filter(|_| info.belongs_to != Belongs::Recording) {
            let partner = info.screened_partner().map(|(partner, _)| partner);
            let own = [(Some(0), Some(tried.size)), (partner, tried.partner)];
            let bounds = vector.bounds();
            for (k, value) in own {
                let place = k.and_then(|k| vector.coordinate_of(first + k, 0));
                if let (Some(place), Some(value)) = (place, value) {
                    start[place] = value.clamp(bounds[place].lower, bounds[place].upper);
                }
            }
        }
        (version, start)
    }
}

/// How many of the likeliest changes are to be told apart on more samples.
pub(crate) fn to_tell_apart(found: &[Ended]) -> usize {
    let leading = found.iter().take(TOLD_APART);
    leading.filter(|one| one.nats > LEADS).count()
}
