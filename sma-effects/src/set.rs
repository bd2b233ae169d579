use crate::EffectId;

/// A set of effects.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct EffectSet {
    bits: u32,
}

impl EffectSet {
    /// No effect: the baseline.
    pub const EMPTY: Self = Self { bits: 0 };

    /// Every effect.
    #[must_use]
    pub fn all() -> Self {
        EffectId::ALL.into_iter().collect()
    }

    /// One effect.
    #[inline(always)]
    #[must_use]
    pub const fn of(effect: EffectId) -> Self {
        Self {
            bits: 1 << effect as u32,
        }
    }

    /// This set and one effect more.
    #[inline(always)]
    #[must_use]
    pub const fn with(self, effect: EffectId) -> Self {
        Self {
            bits: self.bits | Self::of(effect).bits,
        }
    }

    /// This set and one effect less.
    #[must_use]
    pub const fn without(self, effect: EffectId) -> Self {
        Self {
            bits: self.bits & !Self::of(effect).bits,
        }
    }

    /// Number of its effects.
    #[must_use]
    pub const fn len(self) -> usize {
        self.bits.count_ones() as usize
    }

    pub(crate) const fn with_if(self, wanted: bool, effect: EffectId) -> Self {
        if wanted { self.with(effect) } else { self }
    }

    /// True if an effect is in the set.
    #[inline(always)]
    #[must_use]
    pub const fn contains(self, effect: EffectId) -> bool {
        self.bits & Self::of(effect).bits != 0
    }

    /// True if any effect is in both sets.
    #[inline(always)]
    #[must_use]
    pub const fn meets(self, other: Self) -> bool {
        self.bits & other.bits != 0
    }

    /// True if the set is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.bits == 0
    }

    /// Its effects, in the order of [`EffectId::ALL`].
    pub fn iter(self) -> impl Iterator<Item = EffectId> {
        EffectId::ALL
            .into_iter()
            .filter(move |&effect| self.contains(effect))
    }
}

impl FromIterator<EffectId> for EffectSet {
    fn from_iter<T: IntoIterator<Item = EffectId>>(effects: T) -> Self {
        effects.into_iter().fold(Self::EMPTY, Self::with)
    }
}
