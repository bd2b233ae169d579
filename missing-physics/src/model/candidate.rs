//! Candidates for missing physics, and sets of them.

use std::fmt;

use crate::{EffectId, EffectInfo, EffectSet, Hypothesis};

/// Candidate for missing physics: an effect of the catalogue, or a hypothesis of one's own.
#[derive(Clone, Copy)]
pub enum Candidate {
    /// An effect of the catalogue.
    Effect(EffectId),
    /// The hypothesis with this number of those in [`Setting::hypotheses`](crate::Setting::hypotheses).
    Own(usize, &'static [Hypothesis]),
}

impl Candidate {
    /// The catalogue, then the hypotheses.
    pub(crate) fn all(hypotheses: &'static [Hypothesis]) -> impl Iterator<Item = Self> {
        let own = (0..hypotheses.len()).map(move |number| Self::Own(number, hypotheses));
        EffectId::ALL.into_iter().map(Self::Effect).chain(own)
    }

    /// The name of a loop of another family: another shape of the loop.
    pub(crate) fn other_loop() -> Self {
        let found = EffectId::ALL
            .into_iter()
            .find(|effect| effect.info().names_loop_families);
        let Some(effect) = found else {
            unreachable!("the catalogue has one");
        };
        effect.into()
    }

    /// Description of the candidate, known before any recording is looked at.
    #[must_use]
    pub fn info(self) -> &'static EffectInfo {
        match self {
            Self::Effect(effect) => effect.info(),
            Self::Own(number, hypotheses) => hypotheses[number].info(),
        }
    }

    /// Name in files, flags and reports.
    #[must_use]
    pub fn id(self) -> &'static str {
        self.info().id
    }

    /// The effect of the catalogue; `None` for a hypothesis of one's own.
    #[must_use]
    pub fn effect(self) -> Option<EffectId> {
        match self {
            Self::Effect(effect) => Some(effect),
            Self::Own(..) => None,
        }
    }

    /// True if it acts like another one in every rig.
    pub(crate) fn acts_like(self, other: Self) -> bool {
        let mut alike = self.info().acts_like.iter();
        alike.any(|&alike| Self::from(alike) == other)
    }
}

impl From<EffectId> for Candidate {
    fn from(effect: EffectId) -> Self {
        Self::Effect(effect)
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Effect(one), Self::Effect(other)) => one == other,
            // Of one diagnosis: its list of hypotheses is the same.
            (Self::Own(one, _), Self::Own(other, _)) => one == other,
            _ => false,
        }
    }
}

impl Eq for Candidate {}

impl PartialEq<EffectId> for Candidate {
    fn eq(&self, other: &EffectId) -> bool {
        self.effect() == Some(*other)
    }
}

impl fmt::Debug for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

/// A set of candidates.
#[derive(Clone, Copy, Default)]
pub struct CandidateSet {
    effects: EffectSet,
    /// One bit a hypothesis.
    own: u8,
    hypotheses: &'static [Hypothesis],
}

impl CandidateSet {
    /// Nothing: the baseline.
    pub const EMPTY: Self = Self {
        effects: EffectSet::EMPTY,
        own: 0,
        hypotheses: &[],
    };

    /// Some effects of the catalogue, and all hypotheses.
    pub(crate) fn all(effects: EffectSet, hypotheses: &'static [Hypothesis]) -> Self {
        let wanted = |candidate: &Candidate| {
            candidate
                .effect()
                .is_none_or(|effect| effects.contains(effect))
        };
        Candidate::all(hypotheses).filter(wanted).collect()
    }

    /// One candidate.
    #[must_use]
    pub fn of(candidate: impl Into<Candidate>) -> Self {
        Self::EMPTY.with(candidate)
    }

    /// This set and one candidate more.
    #[must_use]
    pub fn with(self, candidate: impl Into<Candidate>) -> Self {
        match candidate.into() {
            Candidate::Effect(effect) => Self {
                effects: self.effects.with(effect),
                ..self
            },
            Candidate::Own(number, hypotheses) => Self {
                own: self.own | 1 << number,
                hypotheses,
                ..self
            },
        }
    }

    /// This set and one candidate less.
    #[must_use]
    pub fn without(self, candidate: impl Into<Candidate>) -> Self {
        match candidate.into() {
            Candidate::Effect(effect) => Self {
                effects: self.effects.without(effect),
                ..self
            },
            Candidate::Own(number, _) => Self {
                own: self.own & !(1 << number),
                ..self
            },
        }
    }

    /// Number of its candidates.
    #[must_use]
    pub fn len(self) -> usize {
        self.effects.len() + self.own.count_ones() as usize
    }

    /// True if a candidate is in the set.
    #[must_use]
    pub fn contains(self, candidate: impl Into<Candidate>) -> bool {
        match candidate.into() {
            Candidate::Effect(effect) => self.effects.contains(effect),
            Candidate::Own(number, _) => self.own & 1 << number != 0,
        }
    }

    /// True if the set is empty.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// Its candidates: the catalogue's in its order, then the hypotheses.
    pub fn iter(self) -> impl Iterator<Item = Candidate> {
        Candidate::all(self.hypotheses).filter(move |&candidate| self.contains(candidate))
    }

    /// Those of the catalogue.
    #[must_use]
    pub fn effects(self) -> EffectSet {
        self.effects
    }

    /// The hypotheses that a plant with this set needs: none, or all that there are.
    pub(crate) fn hypotheses(self) -> &'static [Hypothesis] {
        if self.own == 0 { &[] } else { self.hypotheses }
    }
}

impl PartialEq for CandidateSet {
    fn eq(&self, other: &Self) -> bool {
        (self.effects, self.own) == (other.effects, other.own)
    }
}

impl Eq for CandidateSet {}

impl fmt::Debug for CandidateSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

impl From<EffectSet> for CandidateSet {
    fn from(effects: EffectSet) -> Self {
        Self {
            effects,
            ..Self::EMPTY
        }
    }
}

impl FromIterator<Candidate> for CandidateSet {
    fn from_iter<T: IntoIterator<Item = Candidate>>(candidates: T) -> Self {
        candidates.into_iter().fold(Self::EMPTY, Self::with)
    }
}
