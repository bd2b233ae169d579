//! The hysteresis of a zone, with what effects make of its fraction.

use wiener::widest_vectors;

use crate::effect::Mapped;
use crate::plant::Plants;
use crate::state::Zone;

impl<const L: usize> Plants<L> {
    /// Fraction and slope of a zone at a driving temperature, °C, without going there.
    #[inline(always)]
    pub(crate) fn sense(&self, zone: &Zone<L>, driving_degc: &[f64; L]) -> Mapped<L> {
        let sensed = self.hysteresis.peek(&zone.memory, *driving_degc);
        let mut mapped = Mapped {
            fraction: sensed.fraction,
            slope_per_k: sensed.slope_per_k,
        };
        if self.path.changes_fraction {
            self.effects
                .fraction(&zone.effects, driving_degc, &mut mapped);
        }
        mapped
    }

    /// `sense` as a function call, not inlined.
    #[inline(never)]
    pub(crate) fn sense_apart(&self, zone: &Zone<L>, driving_degc: &[f64; L]) -> Mapped<L> {
        widest_vectors(
            #[inline(always)]
            || self.sense(zone, driving_degc),
        )
    }

    /// The fraction alone, as a call.
    #[inline(never)]
    pub(crate) fn fraction_apart(&self, zone: &Zone<L>, driving_degc: &[f64; L]) -> [f64; L] {
        widest_vectors(
            #[inline(always)]
            || self.sense(zone, driving_degc).fraction,
        )
    }

    /// Takes the hysteresis of a zone to a driving temperature, °C; returns the fraction there.
    #[inline(always)]
    pub(crate) fn go(&self, zone: &mut Zone<L>, driving_degc: &[f64; L]) -> [f64; L] {
        let mut mapped = Mapped {
            fraction: self.hysteresis.commit(&mut zone.memory, *driving_degc),
            slope_per_k: [0.0; L],
        };
        if self.path.changes_fraction {
            self.effects
                .fraction(&zone.effects, driving_degc, &mut mapped);
        }
        mapped.fraction
    }

    /// `go` as a function call, not inlined.
    #[inline(never)]
    pub(crate) fn go_apart(&self, zone: &mut Zone<L>, driving_degc: &[f64; L]) -> [f64; L] {
        widest_vectors(
            #[inline(always)]
            || self.go(zone, driving_degc),
        )
    }
}
