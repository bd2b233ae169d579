//! Where a run starts.

use wiener::Start;

use crate::EffectId;
use crate::bracket::Bracket;
use crate::conduction::{BeyondMean, Ends, Transfers};
use crate::effect::{Before, Instant, Mapped, Shift, Trial, ZoneStart};
use crate::hypothesis::{Place, SeenState};
use crate::plant::Plants;
use crate::state::{PlantsState, Zone};

/// Newton iterations for the start, which is sought once a run.
const START_ITERATIONS: usize = 30;
/// Step of the difference quotient there, K.
const START_STEP_K: f64 = 1e-4;

impl<const L: usize> Plants<L> {
    /// A rod where it starts in each lane, as in
    /// [`Hysteresis::restart_since_reversal`](wiener::hysteresis::Hysteresis::restart_since_reversal).
    /// All of it has that temperature, and is held there until the first sample: all lags have settled.
    pub(crate) fn starting(&self, starts: &[Start; L]) -> PlantsState<L> {
        let temperature_degc = starts.map(|start| start.temperature_degc);
        let share = starts.map(|start| start.share);
        let with_ends = self.effects.active.contains(EffectId::EndConduction);
        let middle = self.start_zone(starts);
        let ends = || {
            Box::new(Ends {
                cells: core::array::from_fn(|_| middle.clone()),
                clamp_k: [0.0; L],
                transfers: Transfers::NONE,
                beyond: BeyondMean::NONE,
            })
        };
        let mut state = PlantsState {
            ends: with_ends.then(ends),
            middle,
            sample: self.heat.balance.over(0.0),
            rod: self.effects.rod(),
            own: self.own.memory(temperature_degc, &share),
            time_s: 0.0,
            displacement: [0.0; L],
            recorded_degc: temperature_degc,
            residual_k: [0.0; L],
        };
        self.effects.over(&mut state.rod, 0.0);
        let (mut displacement, seen) = self.stroke(&state, Instant::End);
        let moment = self.moment(0.0, 0.0);
        self.effects
            .settle(&mut state.rod, &moment, &seen, &share, &mut displacement);
        if let Some(own) = &state.own {
            self.show_own(own, &state, &mut displacement);
        }
        state.displacement = displacement;
        self.effects
            .settle_temperature(&mut state.rod, &mut state.recorded_degc);
        state
    }

    /// A zone of a temperature: the one that drives the hysteresis is sought, θ + ΔT(θ) = T.
    fn start_zone(&self, starts: &[Start; L]) -> Zone<L> {
        let temperature_degc = starts.map(|start| start.temperature_degc);
        let share = starts.map(|start| start.share);
        let mut start = ZoneStart {
            driving_degc: temperature_degc,
            share,
            since_reversal_k: starts.map(|start| start.since_reversal_k),
        };
        let mut zone = self.zone_at(&start);
        if !(self.path.shifts | self.own.has(Place::Shift)) {
            return zone;
        }
        let mut driving_degc = temperature_degc;
        let since_reversal_k = start.since_reversal_k;
        // It does not count for the share, which alone shifts the loop, and takes a search of its own.
        start.since_reversal_k = [0.0; L];
        let mut bracket = Bracket::<L>::open();
        let shift_k = &mut |driving_degc: [f64; L]| {
            start.driving_degc = driving_degc;
            self.put(&mut zone, &start);
            self.start_shift_k(temperature_degc, &zone, &share)
        };
        for _ in 0..START_ITERATIONS {
            let beside_degc = driving_degc.map(|degc| degc + START_STEP_K);
            let here = shift_k(driving_degc);
            let beside = shift_k(beside_degc);
            let mut moved = false;
            for l in 0..L {
                let slope = (beside[l] - here[l]) / START_STEP_K;
                let back_k = temperature_degc[l] - driving_degc[l];
                let newton = temperature_degc[l] - (here[l] + slope * back_k) / (1.0 + slope);
                let next = bracket.next(l, driving_degc[l], here[l] - back_k, newton);
                moved |= next.to_bits() != driving_degc[l].to_bits();
                driving_degc[l] = next;
            }
            if !moved {
                break;
            }
        }
        start.driving_degc = driving_degc;
        start.since_reversal_k = since_reversal_k;
        self.put(&mut zone, &start);
        zone.temperature_degc = temperature_degc;
        zone.middle_degc = temperature_degc;
        zone
    }

    /// Shift of the loop of a rod of `temperature_degc`, K, if what drives the hysteresis is the temperature of the zone.
    fn start_shift_k(
        &self,
        temperature_degc: [f64; L],
        zone: &Zone<L>,
        share: &[f64; L],
    ) -> [f64; L] {
        let driving_degc = zone.driving_degc;
        let before = Before {
            temperature_degc: driving_degc,
            transformed: zone.transformed,
            mean: zone.transformed,
            ..Before::ZERO
        };
        let trial = Trial {
            driving_degc,
            temperature_degc: driving_degc,
            transformed: zone.transformed,
            slope_per_k: zone.slope_per_k,
            mean: zone.transformed,
            ..Trial::ZERO
        };
        let mut shift = Shift::ZERO;
        self.effects
            .shift(&zone.effects, &before, &trial, &mut shift);
        if let Some(own) = self.own.memory(temperature_degc, share) {
            let at = SeenState {
                time_s: 0.0,
                temperature_degc,
                transformed: zone.transformed,
            };
            self.own.add(Place::Shift, &own, &at, &mut shift.kelvin);
        }
        shift.kelvin
    }

    /// A zone whose temperature is the one that drives the hysteresis.
    fn zone_at(&self, start: &ZoneStart<L>) -> Zone<L> {
        let driving_degc = start.driving_degc;
        let mut zone = Zone {
            temperature_degc: driving_degc,
            driving_degc,
            fraction: [0.0; L],
            transformed: [0.0; L],
            slope_per_k: [0.0; L],
            middle_fraction: [0.0; L],
            middle_degc: driving_degc,
            memory: self.hysteresis.since_reversal(
                driving_degc,
                start.share,
                start.since_reversal_k,
            ),
            effects: self.effects.zone(start),
        };
        self.look_around(&mut zone);
        zone
    }

    /// Puts a zone where [`Plants::zone_at`] makes one.
    fn put(&self, zone: &mut Zone<L>, start: &ZoneStart<L>) {
        let driving_degc = start.driving_degc;
        self.hysteresis.restart_since_reversal(
            &mut zone.memory,
            driving_degc,
            start.share,
            start.since_reversal_k,
        );
        zone.effects = self.effects.zone(start);
        zone.temperature_degc = driving_degc;
        zone.driving_degc = driving_degc;
        zone.middle_degc = driving_degc;
        self.look_around(zone);
    }

    /// Shows a zone how far it has transformed.
    fn look_around(&self, zone: &mut Zone<L>) {
        let sensed = self.hysteresis.peek(&zone.memory, zone.driving_degc);
        let mut mapped = Mapped {
            fraction: sensed.fraction,
            slope_per_k: sensed.slope_per_k,
        };
        self.effects
            .fraction(&zone.effects, &zone.driving_degc, &mut mapped);
        let transformed = |l: usize| self.scale.transformed(l, mapped.fraction[l]);
        let slope_per_k = |l: usize| self.scale.slope_per_k(l, mapped.slope_per_k[l]);
        zone.fraction = mapped.fraction;
        zone.transformed = core::array::from_fn(transformed);
        zone.slope_per_k = core::array::from_fn(slope_per_k);
        zone.middle_fraction = mapped.fraction;
    }
}
