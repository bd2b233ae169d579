//! The second plant: one mass, the classic Runge-Kutta method in equal steps, and loops of relays or kinetics.
//!
//! Between two steps every relay that is due switches, one after the other, and the mass gives or takes the heat of each
//! at once; kinetics are a rate beside that of the temperature. The error of this splitting is of first order in the step,
//! and a step is a small part of a sample.

mod film;
mod heat;
mod material;
mod relays;
mod rk4;
mod tanaka;

pub(crate) use material::LumpedLoop;
pub use relays::RelayLoop;
pub use tanaka::TanakaLoop;

use crate::load::{Load, Pull};
use crate::rig::Sample;
use crate::sensor::Electronics;
use crate::simulate::Machine;
use crate::{TruthError, TruthPlant};
use heat::{Air, Wire};
use material::Material;
use relays::Relays;
use rk4::{STATES, State};

/// Places in the state: temperature and fraction of each wire, …
const TEMPERATURE: [usize; 2] = [0, 2];
const FRACTION: [usize; 2] = [1, 3];
/// … temperature of the fittings, °C, and of the bead, what has slipped, m, and the drive behind the supply.
const FITTING: usize = 4;
const BEAD: usize = 5;
const SLIP: usize = 6;
const AMPLITUDE: usize = 7;

/// Steps of a sample at least.
const STEPS: f64 = 8.0;
/// Steps of a sample at least where the path within it is filtered, delayed or rubbed.
const FINE_STEPS: f64 = 24.0;
/// Steps of the wire's time constant, and of a lag's, at least.
const STEPS_OF_TIME_CONSTANT: f64 = 400.0;
const STEPS_OF_LAG: f64 = 20.0;

/// Fraction by which the load's answer is differentiated.
const SMALL_FRACTION: f64 = 1e-4;
/// Turns in which the shift by stress at rest is found, each a half of the rest of the way.
const SETTLING_TURNS: usize = 60;

/// The lumped plant under way.
#[derive(Debug)]
pub(crate) struct Lumped<'a> {
    plant: &'a TruthPlant,
    wire: Wire<'a>,
    load: Load,
    /// Of each wire.
    materials: Vec<Material>,
    /// Of each wire, where there is an R-phase.
    r_phase: Vec<Relays>,
    /// Heat of transformation over specific heat, K.
    latent_k: f64,
    state: State,
    sample: Sample,
    longest_step_s: f64,
    /// Command to the supply.
    target: f64,
    /// Cycles so far, in halves of the way of the fraction.
    cycles: f64,
    /// Share of the fatigue that has come about, at both ends of the sample.
    worn: [f64; 2],
    friction_n: f64,
    end_m: f64,
    electronics: Option<Electronics>,
    /// Reading of the transducer, m.
    seen_m: f64,
}

impl<'a> Lumped<'a> {
    /// The plant at rest.
    pub(crate) fn at_rest(plant: &'a TruthPlant, loops: LumpedLoop, sample: Sample) -> Self {
        let wire = Wire::new(plant);
        let n_wires = wire.n_wires();
        let start_degc = plant.ambient_degc;
        let mut state = [0.0; STATES];
        for place in TEMPERATURE.into_iter().chain([FITTING]) {
            state[place] = start_degc;
        }
        if let Some(bead) = plant.thermocouple {
            state[BEAD] = bead.rest_degc(start_degc, start_degc);
        }
        let r_phase = plant.r_phase.map(|r_phase| {
            // A normal distribution of this deviation has the quartiles' slope of the spread asked for.
            let deviation_k = 1.25 * r_phase.spread_k;
            let mut relays = relays::narrow(r_phase.center_degc, r_phase.half_width_k, deviation_k);
            relays.rest(start_degc);
            vec![relays; n_wires]
        });
        let mut rig = Self {
            plant,
            load: Load {
                spring: plant.bias_spring,
                change: plant.spring_change,
                stop: plant.end_stop,
                rod_stiffness_n_per_m: plant.rod.stiffness_n_per_m(),
            },
            materials: vec![loops.cooled_to(start_degc); n_wires],
            r_phase: r_phase.unwrap_or_default(),
            latent_k: plant.latent_heat.map_or(0.0, |latent| {
                latent.enthalpy_j_per_kg / plant.rod.specific_heat_j_per_kg_k
            }),
            state,
            longest_step_s: longest_step_s(plant, sample.length_s),
            sample,
            target: 0.0,
            cycles: 0.0,
            worn: [0.0; 2],
            friction_n: 0.0,
            end_m: 0.0,
            electronics: None,
            seen_m: 0.0,
            wire,
        };
        rig.settle(loops);
        rig
    }

    /// Finds the fraction at rest under its own stress, and starts what hangs at the end from there.
    fn settle(&mut self, loops: LumpedLoop) {
        let start_degc = self.plant.ambient_degc;
        let mut shift_k = 0.0;
        for _ in 0..SETTLING_TURNS {
            let material = loops.cooled_to(start_degc - shift_k);
            for wire in 0..self.wire.n_wires() {
                self.state[FRACTION[wire]] = material.fraction();
            }
            self.materials.fill(material);
            let found_k = self.shift_k(&self.state, 0.0);
            if self.plant.stress_coupling.is_none() || (found_k - shift_k).abs() < 1e-9 {
                break;
            }
            shift_k += 0.5 * (found_k - shift_k);
        }
        self.end_m = self.pull(&self.state, 0.0).displacement_m;
        self.seen_m = self.transduced_m(self.end_m);
        let filter = self.plant.output_filter;
        self.electronics = filter.map(|filter| Electronics::at_rest(filter, self.seen_m));
    }

    fn n_wires(&self) -> usize {
        self.wire.n_wires()
    }

    /// Straight between both ends of the sample.
    fn between(&self, [from, to]: [f64; 2], time_s: f64) -> f64 {
        from + (to - from) * time_s / self.sample.length_s
    }

    /// Stroke under the preload alone, m.
    fn free_stroke_m(&self, state: &State, time_s: f64) -> f64 {
        let plant = self.plant;
        let n_wires = self.n_wires();
        let (mut share, mut strain) = (0.0, 0.0);
        for wire in 0..n_wires {
            let (degc, fraction) = (state[TEMPERATURE[wire]], state[FRACTION[wire]]);
            let left = match (plant.r_phase, self.r_phase.get(wire)) {
                // What is R keeps its own strain.
                (Some(r_phase), Some(relays)) => {
                    fraction * (1.0 - relays.fraction()) * r_phase.strain_share
                }
                _ => 0.0,
            };
            share += (fraction - left) / n_wires as f64;
            if let Some(expansion) = plant.thermal_expansion {
                let warming_k = degc - plant.ambient_degc;
                let martensite = (1.0 - fraction) * expansion.martensite_per_k;
                let austenite = fraction * expansion.austenite_per_k;
                strain += (martensite + austenite) * warming_k / n_wires as f64;
            }
        }
        let worn = self.between(self.worn, time_s);
        let lost = plant
            .fatigue
            .map_or(0.0, |fatigue| worn * fatigue.stroke_loss);
        plant.stroke_m * (1.0 - lost) * share - plant.rod.length_m * strain
    }

    fn pull(&self, state: &State, time_s: f64) -> Pull {
        let free_m = self.free_stroke_m(state, time_s) - state[SLIP];
        self.load.balance(free_m, self.sample.start_s + time_s)
    }

    /// How far stress and wear have moved the loop, K.
    fn shift_k(&self, state: &State, time_s: f64) -> f64 {
        let plant = self.plant;
        let worn = self.between(self.worn, time_s);
        let by_wear_k = plant.fatigue.map_or(0.0, |fatigue| worn * fatigue.shift_k);
        let by_stress_k = plant.stress_coupling.map_or(0.0, |coupling| {
            let stress_pa = self.pull(state, time_s).surplus_n / plant.rod.section_m2();
            stress_pa / coupling.clausius_clapeyron_pa_per_k
        });
        by_wear_k + by_stress_k
    }

    /// How the shift changes with the fraction of a wire, K.
    fn shift_slope_k(&self, wire: usize, state: &State, time_s: f64) -> f64 {
        if self.plant.stress_coupling.is_none() {
            return 0.0;
        }
        let mut more = *state;
        more[FRACTION[wire]] += SMALL_FRACTION;
        (self.shift_k(&more, time_s) - self.shift_k(state, time_s)) / SMALL_FRACTION
    }

    fn rates(&self, time_s: f64, state: &State) -> State {
        let (plant, n_wires) = (self.plant, self.n_wires());
        let mut rates = [0.0; STATES];
        let air = Air {
            ambient_degc: self.between(self.sample.ambient_degc, time_s),
            draught: self.between(self.sample.draught, time_s),
        };
        let lag_s = plant.supply.map_or(0.0, |supply| supply.time_constant_s);
        let drive = if lag_s > 0.0 {
            rates[AMPLITUDE] = (self.target - state[AMPLITUDE]) / lag_s;
            state[AMPLITUDE]
        } else {
            self.target
        };
        let at = |wire: usize| {
            let warming_k = state[TEMPERATURE[wire]] - plant.ambient_degc;
            (state[FRACTION[wire]], warming_k)
        };
        let wires = [at(0), at(1)];
        let heating_w = self.wire.heating_w(drive, &wires[..n_wires]);
        let shift_k = self.shift_k(state, time_s);
        let mut ends_w = 0.0;
        for wire in 0..n_wires {
            let (degc, fraction) = (state[TEMPERATURE[wire]], state[FRACTION[wire]]);
            let to_end_w = self.wire.end_flow_w(degc, state[FITTING]);
            ends_w += to_end_w;
            let net_w = heating_w[wire] - self.wire.loss_w(degc, air) - to_end_w;
            let slope = self.materials[wire].slope_per_k(fraction, degc - shift_k, net_w > 0.0);
            // Of a rise in temperature the loop sees what its own shift leaves, and the mass what the phase takes up.
            let slope = slope / (1.0 + slope * self.shift_slope_k(wire, state, time_s));
            let rate = net_w / (self.wire.capacity_j_per_k * (1.0 + self.latent_k * slope));
            rates[TEMPERATURE[wire]] = rate;
            rates[FRACTION[wire]] = slope * rate;
        }
        rates[FITTING] = self
            .wire
            .fitting_rate_k_per_s(ends_w, state[FITTING], air.ambient_degc);
        if let Some(bead) = plant.thermocouple {
            rates[BEAD] = bead.rate_k_per_s(state[0], state[BEAD], air.ambient_degc);
        }
        if let Some(mount) = plant.mount_slip {
            let surplus_n = self.pull(state, time_s).surplus_n;
            rates[SLIP] = mount.rate_m_per_s(self.load.preload_n() + surplus_n);
        }
        rates
    }

    /// The material follows the state that a step has led to, and what hangs at the end the material.
    fn follow(&mut self, time_s: f64, length_s: f64) {
        let before = self.mean_fraction();
        for wire in 0..self.n_wires() {
            self.transform(wire, time_s);
            if let Some(relays) = self.r_phase.get_mut(wire) {
                relays.follow(self.state[TEMPERATURE[wire]]);
            }
        }
        let after: f64 = self.materials.iter().map(Material::fraction).sum();
        self.cycles += 0.5 * (after / self.n_wires() as f64 - before).abs();
        let end_m = self.pull(&self.state, time_s).displacement_m;
        let moved_m = end_m - self.end_m;
        self.end_m = end_m;
        let mut guide_m = end_m;
        if let Some(friction) = self.plant.friction {
            self.friction_n = friction.force_n(self.friction_n, moved_m);
            guide_m -= self.friction_n / friction.coupling_stiffness_n_per_m;
        }
        self.seen_m = self.transduced_m(guide_m);
        if let Some(electronics) = &mut self.electronics {
            electronics.advance(self.seen_m, length_s);
        }
    }

    /// Relays switch one by one, each with its heat and its pull; kinetics have moved already.
    fn transform(&mut self, wire: usize, time_s: f64) {
        loop {
            let shift_k = self.shift_k(&self.state, time_s);
            let driving_degc = self.state[TEMPERATURE[wire]] - shift_k;
            let fraction = self.state[FRACTION[wire]].clamp(0.0, 1.0);
            let relays = match &mut self.materials[wire] {
                Material::Kinetics(kinetics) => {
                    kinetics.commit(fraction, driving_degc);
                    self.state[FRACTION[wire]] = fraction;
                    return;
                }
                Material::Relays(relays) => relays,
            };
            let Some(change) = relays.switch(driving_degc) else {
                return;
            };
            self.state[FRACTION[wire]] = relays.fraction();
            self.state[TEMPERATURE[wire]] -= self.latent_k * change;
        }
    }

    fn transduced_m(&self, displacement_m: f64) -> f64 {
        let stroke_m = self.plant.stroke_m;
        let read_m = self.plant.sensor_cubic.map_or(displacement_m, |cubic| {
            cubic.read_m(displacement_m, stroke_m)
        });
        read_m + self.plant.offset_m
    }
}

impl Machine for Lumped<'_> {
    fn begin(&mut self, sample: Sample) {
        self.sample = sample;
        if let Some(fatigue) = self.plant.fatigue {
            self.worn = [self.worn[1], fatigue.share(self.cycles)];
        }
    }

    fn advance(
        &mut self,
        target: f64,
        (from_s, to_s): (f64, f64),
        index: usize,
    ) -> Result<(), TruthError> {
        self.target = target;
        let n_steps = ((to_s - from_s) / self.longest_step_s).ceil().max(1.0);
        let length_s = (to_s - from_s) / n_steps;
        for k in 0..n_steps as usize {
            let start_s = from_s + k as f64 * length_s;
            self.state = rk4::step(&self.state, (start_s, length_s), |time_s, state| {
                self.rates(time_s, state)
            });
            if !self.state.iter().all(|number| number.is_finite()) {
                return Err(TruthError::Diverged { index });
            }
            self.follow(start_s + length_s, length_s);
        }
        Ok(())
    }

    fn end_sample(&mut self) {}

    fn output_m(&self) -> f64 {
        let electronics = self.electronics.as_ref();
        electronics.map_or(self.seen_m, Electronics::output_m)
    }

    fn middle_degc(&self) -> f64 {
        self.state[TEMPERATURE[0]]
    }

    fn bead_degc(&self) -> Option<f64> {
        self.plant.thermocouple.map(|_| self.state[BEAD])
    }

    fn mean_fraction(&self) -> f64 {
        let sum: f64 = self.materials.iter().map(Material::fraction).sum();
        sum / self.n_wires() as f64
    }
}

fn longest_step_s(plant: &TruthPlant, sample_s: f64) -> f64 {
    let is_fine = plant.output_filter.is_some() || plant.friction.is_some();
    let mut longest_s = sample_s / if is_fine { FINE_STEPS } else { STEPS };
    longest_s = longest_s
        .min(plant.time_constant_s() / STEPS_OF_TIME_CONSTANT)
        .min(plant.longest_step_s);
    let supply_s = plant.supply.map(|supply| supply.time_constant_s);
    let bead_s = plant
        .thermocouple
        .map(|bead| bead.contact_k_per_w * bead.heat_capacity_j_per_k);
    for lag_s in [supply_s, bead_s].into_iter().flatten() {
        if lag_s > 0.0 {
            longest_s = longest_s.min(lag_s / STEPS_OF_LAG);
        }
    }
    longest_s
}
