//! From the zones to the displacement.

use crate::effect::{Instant, Moment, Seen, Standing};
use crate::hypothesis::{OwnMemory, Place, SeenState};
use crate::plant::ExtendedPlant;
use crate::state::{ExtendedState, Zone};

impl<const L: usize> ExtendedPlant<L> {
    /// Displacement at an instant of the sample.
    #[inline(always)]
    pub(crate) fn show(
        &self,
        state: &mut ExtendedState<L>,
        moment: &Moment,
        instant: Instant,
    ) -> [f64; L] {
        let (mut displacement, seen) = self.stroke(state, instant);
        self.effects
            .displacement(&mut state.rod, moment, &seen, &mut displacement);
        if let (Some(own), Instant::End) = (&state.own, instant) {
            self.show_own(own, state, &mut displacement);
        }
        displacement
    }

    /// Adds what own hypotheses add to the displacement.
    #[inline(never)]
    pub(crate) fn show_own(
        &self,
        own: &OwnMemory<L>,
        state: &ExtendedState<L>,
        displacement: &mut [f64; L],
    ) {
        let rod = self.seen_by_own(state, None);
        self.own.add(Place::Displacement, own, &rod, displacement);
    }

    /// What own hypotheses see of a zone, or of the whole rod.
    pub(crate) fn seen_by_own(
        &self,
        state: &ExtendedState<L>,
        zone: Option<&Zone<L>>,
    ) -> SeenState<L> {
        let first = zone.unwrap_or(&state.middle);
        let mut temperature_degc = first.temperature_degc;
        let mut fraction = first.fraction;
        if let (None, Some(ends)) = (zone, &state.ends) {
            temperature_degc = self.mean(&[temperature_degc, ends.temperature_degc]);
            fraction = self.mean(&[fraction, ends.fraction]);
        }
        SeenState {
            time_s: state.time_s,
            temperature_degc,
            transformed: core::array::from_fn(|l| self.scale.transformed(l, fraction[l])),
        }
    }

    /// Displacement by the fraction alone.
    #[inline(always)]
    pub(crate) fn stroke(&self, state: &ExtendedState<L>, instant: Instant) -> ([f64; L], Seen<L>) {
        let (mut fraction, mut temperature_degc) = self.moved_by(&state.middle, instant);
        if let Some(ends) = &state.ends {
            let (of_ends, ends_degc) = self.moved_by(ends, instant);
            fraction = self.mean(&[fraction, of_ends]);
            temperature_degc = self.mean(&[temperature_degc, ends_degc]);
        }
        let displacement = self.read_out(&fraction);
        let seen = Seen {
            temperature_degc,
            instant,
        };
        (displacement, seen)
    }

    /// gain ξ + offset.
    #[inline(always)]
    pub(crate) fn read_out(&self, fraction: &[f64; L]) -> [f64; L] {
        let mut displacement = [0.0; L];
        for l in 0..L {
            displacement[l] = self.gain[l] * fraction[l] + self.offset[l];
        }
        displacement
    }

    /// The fraction of a zone that counts for the displacement, and its temperature, °C.
    #[inline(always)]
    fn moved_by(&self, zone: &Zone<L>, instant: Instant) -> ([f64; L], [f64; L]) {
        let (mut fraction, temperature_degc) = if instant == Instant::Middle {
            (zone.middle_fraction, zone.middle_degc)
        } else {
            (zone.fraction, zone.temperature_degc)
        };
        if self.path.stands_in_zone {
            let mut transformed = [0.0; L];
            for l in 0..L {
                transformed[l] = self.scale.transformed(l, fraction[l]);
            }
            let at = Standing {
                temperature_degc,
                transformed,
            };
            self.effects.stroke(&zone.effects, &at, &mut fraction);
        }
        (fraction, temperature_degc)
    }

    /// Mean over the length of the rod of what the zones have.
    #[inline(always)]
    pub(crate) fn mean<const Z: usize>(&self, of_zones: &[[f64; L]; Z]) -> [f64; L] {
        let mut mean = of_zones[0];
        if Z > 1 {
            for l in 0..L {
                let difference = of_zones[Z - 1][l] - mean[l];
                mean[l] += self.effects.end_conduction.share[l] * difference;
            }
        }
        mean
    }
}
