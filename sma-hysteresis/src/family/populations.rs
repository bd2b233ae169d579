//! Relays of two populations.

use super::relays::Relays;
use super::{Along, Transforms, Way};
use crate::HysteresisError;
use crate::limiting_loop::LimitingLoop;

/// A second population of relays beside the first, as of grains of another kind or of a part of a wire that is loaded otherwise. Tails,
/// bends and the asymmetry of the branches are those of the first.
///
/// ```text
/// distribution = (1 - s) D(T_mid, T_c, h_0, ζ) + s D(T_mid + d h_0, e^a T_c, e^b h_0, ζ + c)
/// ```
///
/// The default, with s = 0, is none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SecondPopulation {
    /// Its share s of all relays, 0 to 1.
    pub share: f64,
    /// Distance d of its middle from that of the first, in spreads h_0; -10 to 10.
    pub shift: f64,
    /// Logarithm a of its half width over that of the first; -3 to 3.
    pub log_half_width: f64,
    /// Logarithm b of its spread over that of the first; -3 to 3.
    pub log_spread: f64,
    /// Difference c of its ζ from that of the first; -1 to 1.
    pub zeta_difference: f64,
}

impl SecondPopulation {
    /// True if it has no relays.
    pub(crate) fn is_none(&self) -> bool {
        self.share <= 0.0
    }

    pub(crate) fn check(&self) -> Result<(), HysteresisError> {
        let ranges = [
            ("share", self.share, 0.0, 1.0),
            ("shift", self.shift, -10.0, 10.0),
            ("log_half_width", self.log_half_width, -3.0, 3.0),
            ("log_spread", self.log_spread, -3.0, 3.0),
            ("zeta_difference", self.zeta_difference, -1.0, 1.0),
        ];
        let outside = ranges
            .into_iter()
            .find(|&(_, value, lower, upper)| !(lower..=upper).contains(&value));
        outside.map_or(Ok(()), |(name, value, lower, upper)| {
            Err(HysteresisError::SecondPopulation {
                name,
                value,
                lower,
                upper,
            })
        })
    }
}

/// Relays of two populations of lanes side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Populations<const L: usize> {
    pub(super) first: Relays<L>,
    second: Relays<L>,
    /// Share of the second.
    share: [f64; L],
}

impl<const L: usize> Populations<L> {
    pub(super) fn new(
        first: Relays<L>,
        limits: &LimitingLoop<L>,
        zeta: [f64; L],
        second: [SecondPopulation; L],
    ) -> Self {
        Self {
            first,
            second: first.beside(limits, zeta, &second),
            share: second.map(|one| one.share),
        }
    }

    /// Both, each changed alike.
    pub(super) fn map(self, change: impl Fn(Relays<L>) -> Relays<L>) -> Self {
        Self {
            first: change(self.first),
            second: change(self.second),
            ..self
        }
    }

    /// Of both, by their shares.
    #[inline(always)]
    fn mixed(&self, lane: usize, first: f64, second: f64) -> f64 {
        let share = self.share[lane];
        (1.0 - share) * first + share * second
    }
}

impl<const L: usize> Transforms<L> for Populations<L> {
    #[inline(always)]
    fn along(&self, lane: usize, sign: f64, start_k: f64) -> Along {
        let first = self.first.along(lane, sign, start_k);
        let second = self.second.along(lane, sign, start_k);
        Along {
            fixed: first.fixed,
            scale: self.mixed(lane, first.scale, second.scale),
            further: second.fixed,
        }
    }

    /// w is linear in the distribution.
    #[inline(always)]
    fn way(&self, lane: usize, sign: f64, along: &Along, temperature_k: f64) -> Way {
        let from_none = |fixed| Along {
            fixed,
            scale: 0.0,
            further: 0.0,
        };
        let (first, per_k) = self
            .first
            .way(lane, sign, &from_none(along.fixed), temperature_k);
        let (second, second_per_k) =
            self.second
                .way(lane, sign, &from_none(along.further), temperature_k);
        (
            self.mixed(lane, first, second) - sign * along.scale,
            self.mixed(lane, per_k, second_per_k),
        )
    }
}
