//! From the zones to the displacement.

use wiener::widest_vectors;

use crate::conduction::ZONES;
use crate::effect::{Instant, Moment, Seen, Standing};
use crate::hypothesis::{OwnMemory, Place, SeenState};
use crate::plant::Plants;
use crate::state::{PlantsState, Zone};

impl<const L: usize> Plants<L> {
    /// Displacement at an instant of the sample.
    #[inline(never)]
    pub(crate) fn show(
        &self,
        state: &mut PlantsState<L>,
        moment: &Moment,
        instant: Instant,
        displacement: &mut [f64; L],
    ) {
        widest_vectors(
            #[inline(always)]
            || {
                let (mut shown, seen) = self.stroke(state, instant);
                self.effects
                    .displacement(&mut state.rod, moment, &seen, &mut shown);
                *displacement = shown;
            },
        );
        if let (Some(own), Instant::End) = (&state.own, instant) {
            self.show_own(own, state, displacement);
        }
    }

    /// Adds what own hypotheses add to the displacement.
    #[inline(never)]
    pub(crate) fn show_own(
        &self,
        own: &OwnMemory<L>,
        state: &PlantsState<L>,
        displacement: &mut [f64; L],
    ) {
        let rod = self.seen_by_own(state, None);
        self.own.add(Place::Displacement, own, &rod, displacement);
    }

    /// State of a zone, or of the whole rod, as own hypotheses see it.
    pub(crate) fn seen_by_own(
        &self,
        state: &PlantsState<L>,
        zone: Option<&Zone<L>>,
    ) -> SeenState<L> {
        let of_zone = |zone: &Zone<L>| (zone.fraction, zone.temperature_degc);
        let (fraction, temperature_degc) =
            zone.map_or_else(|| self.mean_of(state, of_zone), of_zone);
        SeenState {
            time_s: state.time_s,
            temperature_degc,
            transformed: core::array::from_fn(|l| self.scale.transformed(l, fraction[l])),
        }
    }

    /// Displacement by the fraction alone.
    #[inline(always)]
    pub(crate) fn stroke(&self, state: &PlantsState<L>, instant: Instant) -> ([f64; L], Seen<L>) {
        let (fraction, expanded_k) = self.mean_of(
            state,
            #[inline(always)]
            |zone| self.moved_by(zone, instant),
        );
        let displacement = self.read_out(&fraction);
        let seen = Seen {
            expanded_k,
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

    /// The fraction of a zone that counts for the displacement, and the warming by which it expands, K.
    #[inline(always)]
    fn moved_by(&self, zone: &Zone<L>, instant: Instant) -> ([f64; L], [f64; L]) {
        let (mut fraction, temperature_degc) = if instant == Instant::Middle {
            (zone.middle_fraction, zone.middle_degc)
        } else {
            (zone.fraction, zone.temperature_degc)
        };
        let mut transformed = [0.0; L];
        for l in 0..L {
            transformed[l] = self.scale.transformed(l, fraction[l]);
        }
        let at = Standing {
            temperature_degc,
            transformed,
        };
        if self.path.stands_in_zone {
            self.effects.stroke(&zone.effects, &at, &mut fraction);
        }
        (fraction, self.effects.thermal_expansion.expanded_k(&at))
    }

    /// Means over the length of the rod of two things that each zone has.
    #[inline(always)]
    fn mean_of(
        &self,
        state: &PlantsState<L>,
        of_zone: impl Fn(&Zone<L>) -> ([f64; L], [f64; L]),
    ) -> ([f64; L], [f64; L]) {
        let (one, other) = of_zone(&state.middle);
        let Some(ends) = &state.ends else {
            return (one, other);
        };
        let (mut ones, mut others) = ([one; ZONES], [other; ZONES]);
        for (z, cell) in ends.cells.iter().enumerate() {
            (ones[z + 1], others[z + 1]) = of_zone(cell);
        }
        (self.mean(&ones), self.mean(&others))
    }

    /// Mean over the length of the rod of what the zones have.
    #[inline(always)]
    pub(crate) fn mean<const Z: usize>(&self, of_zones: &[[f64; L]; Z]) -> [f64; L] {
        let mut mean = of_zones[0];
        for z in 1..Z {
            for l in 0..L {
                let difference = of_zones[z][l] - of_zones[0][l];
                mean[l] += self.effects.end_conduction.share[z][l] * difference;
            }
        }
        mean
    }
}
