//! Where a run starts.

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
    /// A rod whose past is unknown: `share` = 0 on the heating curve, 1 on the cooling curve, as in
    /// [`Hysteresis::between_limiting_curves`](wiener::hysteresis::Hysteresis::between_limiting_curves).
    /// All of it has that temperature, all lags have settled and the drive was off before.
    pub(crate) fn between_limiting_curves(
        &self,
        temperature_degc: [f64; L],
        share: [f64; L],
    ) -> PlantsState<L> {
        let with_ends = self.effects.active.contains(EffectId::EndConduction);
        let middle = self.start_zone(temperature_degc, share);
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
    fn start_zone(&self, temperature_degc: [f64; L], share: [f64; L]) -> Zone<L> {
        let mut zone = self.zone_at(temperature_degc, share);
        if !(self.path.shifts | self.own.has(Place::Shift)) {
            return zone;
        }
        let mut driving_degc = temperature_degc;
        let mut bracket = Bracket::<L>::open();
        let shift_k = &mut |driving_degc: [f64; L]| {
            self.put(&mut zone, driving_degc, share);
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
        self.put(&mut zone, driving_degc, share);
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
    fn zone_at(&self, driving_degc: [f64; L], share: [f64; L]) -> Zone<L> {
        let mut zone = Zone {
            temperature_degc: driving_degc,
            driving_degc,
            fraction: [0.0; L],
            transformed: [0.0; L],
            slope_per_k: [0.0; L],
            middle_fraction: [0.0; L],
            middle_degc: driving_degc,
            memory: self.hysteresis.between_limiting_curves(driving_degc, share),
            effects: self.effects.zone(&ZoneStart {
                driving_degc,
                share,
            }),
        };
        self.look_around(&mut zone);
        zone
    }

    /// Puts a zone where [`Plants::zone_at`] makes one.
    fn put(&self, zone: &mut Zone<L>, driving_degc: [f64; L], share: [f64; L]) {
        self.hysteresis
            .restart(&mut zone.memory, driving_degc, share);
        zone.effects = self.effects.zone(&ZoneStart {
            driving_degc,
            share,
        });
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
