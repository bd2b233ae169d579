//! The plant as a system of differential equations with memory.

use crate::heat_flow::{Cells, HeatFlow, Moment};
use crate::integrator::{Step, System};
use crate::l2p::{L2p, L2pMemory};
use crate::layout::Layout;
use crate::load::{Load, Pull};
use crate::root::rising_root;
use crate::sensor::Electronics;
use crate::{Hysteresis, TruthError, TruthPlant};

/// Accuracy to which a temperature or a shift is solved for, K: far below any tolerance of a step.
const ROOT_TOLERANCE_K: f64 = 1e-11;
/// Units of the state per stroke of slip: scaled so, the slip is held to the tolerance in kelvins.
const SLIP_UNITS_PER_STROKE: f64 = 100.0;

/// Conditions within a sample: a pair holds the values at its start and its end, linear in between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    pub(crate) start_s: f64,
    pub(crate) length_s: f64,
    pub(crate) ambient_degc: [f64; 2],
    pub(crate) draught: [f64; 2],
}

/// The drive as it leaves the supply: an exponential within each constant piece.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Level {
    from_s: f64,
    from: f64,
    target: f64,
}

/// The plant under way.
#[derive(Debug)]
pub(crate) struct Rig<'a, H: Hysteresis> {
    plant: &'a TruthPlant,
    operator: &'a H,
    r_operator: Option<L2p>,
    pub(crate) layout: Layout,
    load: Load,
    heat_flow: HeatFlow<'a>,
    supply_tau_s: f64,
    cell_length_m: Vec<f64>,
    /// ΔH/C_p.
    latent_k: f64,
    /// True if the fraction acts on the rates.
    fraction_matters: bool,
    memory: Vec<H::Memory>,
    r_memory: Vec<L2pMemory>,
    level: Level,
    sample: Sample,
    // What belongs to the state last looked at, and how the enthalpy rose with the temperature up to it.
    enthalpy_k: Vec<f64>,
    slope: Vec<f64>,
    temperature_degc: Vec<f64>,
    fraction: Vec<f64>,
    shift_k: f64,
    pull: Pull,
    // What has come about so far.
    committed_m: f64,
    mean_fraction: f64,
    path: f64,
    /// At both ends of the sample: a step of the loop would be a reversal.
    fatigue_ends: [f64; 2],
    fatigue_share: f64,
    friction_n: f64,
    electronics: Option<Electronics>,
    /// Reading of the transducer, m.
    seen_m: f64,
}

impl<'a, H: Hysteresis> Rig<'a, H> {
    /// The plant at rest, and its state.
    pub(crate) fn at_rest(
        plant: &'a TruthPlant,
        operator: &'a H,
        sample: Sample,
    ) -> Result<(Self, Vec<f64>), TruthError> {
        let mut rig = Self::new(plant, operator, sample)?;
        let start_degc = plant.ambient_degc;
        // The load may have moved the loop from where the material rests. Its heat comes after, or it would count.
        rig.settle(&rig.rest_state(start_degc, 0.0), 0.0, true);
        let (driving_degc, fraction) = (rig.driving_degc(0), rig.fraction[0]);
        rig.memory.fill(operator.rest(driving_degc));
        rig.mean_fraction = fraction;
        rig.latent_k = plant.latent_heat.map_or(0.0, |latent| {
            latent.enthalpy_j_per_kg / plant.rod.specific_heat_j_per_kg_k
        });
        let state = rig.rest_state(start_degc, fraction);
        rig.committed_m = rig.pull.displacement_m;
        rig.seen_m = rig.transduced_m(rig.committed_m);
        rig.electronics = plant
            .output_filter
            .map(|filter| Electronics::at_rest(filter, rig.seen_m));
        Ok((rig, state))
    }

    /// With the material where it rests without a load.
    fn new(plant: &'a TruthPlant, operator: &'a H, sample: Sample) -> Result<Self, TruthError> {
        let layout = Layout::new(plant);
        let elements = layout.elements();
        let start_degc = plant.ambient_degc;
        let r_operator = match plant.r_phase {
            Some(r_phase) => Some(r_phase.narrow_loop().operator()?),
            None => None,
        };
        let memory = operator.rest(start_degc);
        let fraction = operator.fraction(&memory, start_degc);
        Ok(Self {
            plant,
            operator,
            r_operator,
            layout,
            load: Load {
                spring: plant.bias_spring,
                change: plant.spring_change,
                stop: plant.end_stop,
                rod_stiffness_n_per_m: plant.rod.stiffness_n_per_m(),
            },
            heat_flow: HeatFlow::new(plant, layout),
            supply_tau_s: plant.supply.map_or(0.0, |supply| supply.time_constant_s),
            cell_length_m: plant.rod.cell_lengths_m(),
            latent_k: 0.0,
            fraction_matters: plant.phase_resistivity.is_some()
                || plant.stress_coupling.is_some()
                || plant.mount_slip.is_some()
                || plant.end_fittings.is_some(),
            memory: vec![memory; elements],
            r_memory: r_operator
                .map(|operator| vec![operator.rest(start_degc); elements])
                .unwrap_or_default(),
            level: Level {
                from_s: 0.0,
                from: 0.0,
                target: 0.0,
            },
            sample,
            enthalpy_k: vec![start_degc; elements],
            slope: vec![1.0; elements],
            temperature_degc: vec![start_degc; elements],
            fraction: vec![fraction; elements],
            shift_k: 0.0,
            pull: Pull {
                displacement_m: 0.0,
                surplus_n: 0.0,
            },
            committed_m: 0.0,
            mean_fraction: fraction,
            path: 0.0,
            fatigue_ends: [0.0; 2],
            fatigue_share: 0.0,
            friction_n: 0.0,
            electronics: None,
            seen_m: 0.0,
        })
    }

    fn rest_state(&self, start_degc: f64, fraction: f64) -> Vec<f64> {
        let mut state = vec![start_degc; self.layout.n_states];
        state[..self.layout.elements()].fill(start_degc + self.latent_k * fraction);
        if let (Some(bead), Some(thermocouple)) = (self.layout.bead, self.plant.thermocouple) {
            state[bead] = thermocouple.rest_degc(start_degc, start_degc);
        }
        if let Some(slip) = self.layout.slip {
            state[slip] = 0.0;
        }
        state
    }

    /// The next sample begins; its time counts from 0.
    pub(crate) fn begin(&mut self, sample: Sample) {
        self.sample = sample;
        if let Some(fatigue) = self.plant.fatigue {
            self.fatigue_ends = [self.fatigue_ends[1], fatigue.share(self.path)];
        }
    }

    /// The supply is told another value, at a time in the sample.
    pub(crate) fn command(&mut self, at_s: f64, target: f64) {
        let from = self.amplitude(at_s);
        self.level = Level {
            from_s: at_s,
            from,
            target,
        };
    }

    /// The piece that was commanded ends with the sample.
    pub(crate) fn end_sample(&mut self) {
        let from = self.amplitude(self.sample.length_s);
        self.level = Level {
            from_s: 0.0,
            from,
            target: self.level.target,
        };
    }

    /// The drive behind the supply.
    fn amplitude(&self, time_s: f64) -> f64 {
        let Level {
            from_s,
            from,
            target,
        } = self.level;
        if self.supply_tau_s > 0.0 {
            target + (from - target) * (-(time_s - from_s) / self.supply_tau_s).exp()
        } else {
            target
        }
    }

    /// Finds temperatures, fractions and the pull of a state.
    fn settle(&mut self, state: &[f64], time_s: f64, with_fraction: bool) {
        self.fatigue_share = self.between(self.fatigue_ends, time_s);
        let Some(coupling) = self.plant.stress_coupling else {
            self.settle_cells(state, 0.0, with_fraction);
            if with_fraction {
                self.pull = self.balance(state, time_s);
            }
            return;
        };
        let rod = self.plant.rod;
        let guess_k = self.shift_k;
        // More shift, less transformed, less pull: the difference rises with slope 1 or more.
        self.shift_k = rising_root((guess_k, 1.0), 10.0 * ROOT_TOLERANCE_K, |shift_k| {
            self.settle_cells(state, shift_k, true);
            self.pull = self.balance(state, time_s);
            shift_k - coupling.shift_k(&rod, self.pull.surplus_n)
        });
    }

    fn settle_cells(&mut self, state: &[f64], shift_k: f64, with_fraction: bool) {
        let shift_k = shift_k + self.fatigue_shift_k();
        for j in 0..self.layout.elements() {
            let (temperature_degc, fraction) = self.settle_cell(j, state[j], shift_k);
            let warming_k = temperature_degc - self.temperature_degc[j];
            let slope = (state[j] - self.enthalpy_k[j]) / warming_k;
            if slope.is_finite() {
                self.slope[j] = slope;
            }
            self.enthalpy_k[j] = state[j];
            self.temperature_degc[j] = temperature_degc;
            if with_fraction {
                self.fraction[j] =
                    fraction.unwrap_or_else(|| self.loop_fraction(j, temperature_degc - shift_k));
            }
        }
    }

    /// Temperature of a cell from its enthalpy over C_p, and its fraction if that was needed.
    fn settle_cell(&self, j: usize, enthalpy_k: f64, shift_k: f64) -> (f64, Option<f64>) {
        if self.latent_k > 0.0 {
            let mut fraction = 0.0;
            let temperature_degc = rising_root(
                (self.temperature_degc[j], self.slope[j]),
                ROOT_TOLERANCE_K,
                |temperature_degc| {
                    fraction = self.loop_fraction(j, temperature_degc - shift_k);
                    temperature_degc + self.latent_k * fraction - enthalpy_k
                },
            );
            (temperature_degc, Some(fraction))
        } else {
            (enthalpy_k, None)
        }
    }

    fn loop_fraction(&self, j: usize, driving_degc: f64) -> f64 {
        self.operator.fraction(&self.memory[j], driving_degc)
    }

    fn fatigue_shift_k(&self) -> f64 {
        self.plant
            .fatigue
            .map_or(0.0, |fatigue| self.fatigue_share * fatigue.shift_k)
    }

    /// The temperature that drives the loop of a cell.
    fn driving_degc(&self, j: usize) -> f64 {
        self.temperature_degc[j] - self.shift_k - self.fatigue_shift_k()
    }

    fn balance(&self, state: &[f64], time_s: f64) -> Pull {
        let free_m = self.free_stroke_m() - self.slip_m(state);
        self.load.balance(free_m, self.sample.start_s + time_s)
    }

    fn slip_m(&self, state: &[f64]) -> f64 {
        let slip = self.layout.slip.map_or(0.0, |slip| state[slip]);
        slip * self.plant.stroke_m / SLIP_UNITS_PER_STROKE
    }

    /// Stroke under the preload alone.
    fn free_stroke_m(&self) -> f64 {
        let plant = self.plant;
        let (mut share_m, mut extension_m) = (0.0, 0.0);
        for j in 0..self.layout.elements() {
            let (fraction, temperature_degc) = (self.fraction[j], self.temperature_degc[j]);
            let mut active = fraction;
            if let (Some(r_phase), Some(operator)) = (plant.r_phase, &self.r_operator) {
                let austenite = operator.fraction(&self.r_memory[j], temperature_degc);
                active = fraction * (1.0 - r_phase.strain_share * (1.0 - austenite));
            }
            let length_m = self.cell_length_m[j % self.layout.cells];
            share_m += length_m * active;
            if let Some(expansion) = plant.thermal_expansion {
                let warming_k = temperature_degc - plant.ambient_degc;
                extension_m += length_m * expansion.strain(fraction, warming_k);
            }
        }
        let strands = self.layout.strands as f64;
        let share = share_m / (plant.rod.length_m * strands);
        let loss = plant
            .fatigue
            .map_or(0.0, |fatigue| self.fatigue_share * fatigue.stroke_loss);
        plant.stroke_m * (1.0 - loss) * share - extension_m / strands
    }

    /// Reading of the transducer at a displacement of its guide, m.
    fn transduced_m(&self, displacement_m: f64) -> f64 {
        let read_m = match self.plant.sensor_cubic {
            Some(cubic) => cubic.read_m(displacement_m, self.plant.stroke_m),
            None => displacement_m,
        };
        read_m + self.plant.offset_m
    }

    /// Displacement as it leaves the electronics, without what is added to it.
    pub(crate) fn output_m(&self) -> f64 {
        self.electronics
            .as_ref()
            .map_or(self.seen_m, Electronics::output_m)
    }

    /// Temperature of the middle of the (first) rod.
    pub(crate) fn middle_degc(&self) -> f64 {
        let cells = self.layout.cells;
        let (left, right) = ((cells - 1) / 2, cells / 2);
        0.5 * (self.temperature_degc[left] + self.temperature_degc[right])
    }

    pub(crate) fn bead_degc(&self, state: &[f64]) -> Option<f64> {
        self.layout.bead.map(|bead| state[bead])
    }

    pub(crate) fn mean_fraction(&self) -> f64 {
        self.mean_fraction
    }

    fn between(&self, ends: [f64; 2], time_s: f64) -> f64 {
        ends[0] + (ends[1] - ends[0]) * time_s / self.sample.length_s
    }

    /// Takes the memory of a cell through the extremum of its enthalpy, if it had one within a step.
    fn commit_extremum(&mut self, j: usize, step: &Step<'_>) {
        let ends = (step.start_rates[j], step.end_rates[j]);
        if ends.0 * ends.1 >= 0.0 {
            return;
        }
        let enthalpy_k = hermite_extremum((step.start[j], step.end[j]), ends, step.length_s);
        let shift_k = self.shift_k + self.fatigue_shift_k();
        let (temperature_degc, _) = self.settle_cell(j, enthalpy_k, shift_k);
        self.operator
            .commit(&mut self.memory[j], temperature_degc - shift_k);
        if let Some(operator) = &self.r_operator {
            operator.commit(&mut self.r_memory[j], temperature_degc);
        }
    }

    /// Takes what hangs at the rod's end on to the state last settled.
    fn move_load(&mut self, length_s: f64) {
        let moved_m = self.pull.displacement_m - self.committed_m;
        self.committed_m = self.pull.displacement_m;
        let mut guide_m = self.pull.displacement_m;
        if let Some(friction) = self.plant.friction {
            self.friction_n = friction.force_n(self.friction_n, moved_m);
            guide_m -= self.friction_n / friction.coupling_stiffness_n_per_m;
        }
        self.seen_m = self.transduced_m(guide_m);
        if let Some(electronics) = &mut self.electronics {
            electronics.advance(self.seen_m, length_s);
        }
    }
}

impl<H: Hysteresis> System for Rig<'_, H> {
    fn rates(&mut self, time_s: f64, state: &[f64], rates: &mut [f64]) {
        self.settle(state, time_s, self.fraction_matters);
        let moment = Moment {
            amplitude: self.amplitude(time_s),
            ambient_degc: self.between(self.sample.ambient_degc, time_s),
            draught: self.between(self.sample.draught, time_s),
        };
        let cells = Cells {
            temperature_degc: &self.temperature_degc,
            fraction: &self.fraction,
        };
        self.heat_flow.rates(&cells, &moment, state, rates);
        if let (Some(bead), Some(thermocouple)) = (self.layout.bead, self.plant.thermocouple) {
            rates[bead] =
                thermocouple.rate_k_per_s(self.middle_degc(), state[bead], moment.ambient_degc);
        }
        if let (Some(slip), Some(mount)) = (self.layout.slip, self.plant.mount_slip) {
            let force_n = self.load.preload_n() + self.pull.surplus_n;
            rates[slip] = mount.rate_m_per_s(force_n) * SLIP_UNITS_PER_STROKE / self.plant.stroke_m;
        }
    }

    fn accept(&mut self, step: &Step<'_>) {
        for j in 0..self.layout.elements() {
            self.commit_extremum(j, step);
        }
        self.settle(step.end, step.end_s, self.fraction_matters);
        let mut sum = 0.0;
        for j in 0..self.layout.elements() {
            let driving_degc = self.driving_degc(j);
            self.fraction[j] = self.operator.commit(&mut self.memory[j], driving_degc);
            if let Some(operator) = &self.r_operator {
                operator.commit(&mut self.r_memory[j], self.temperature_degc[j]);
            }
            sum += self.cell_length_m[j % self.layout.cells] * self.fraction[j];
        }
        let mean_fraction = sum / (self.plant.rod.length_m * self.layout.strands as f64);
        self.path += 0.5 * (mean_fraction - self.mean_fraction).abs();
        self.mean_fraction = mean_fraction;
        self.pull = self.balance(step.end, step.end_s);
        self.move_load(step.length_s);
    }
}

/// Extremum of the cubic through two points with the given slopes of opposite signs.
fn hermite_extremum(values: (f64, f64), rates: (f64, f64), length_s: f64) -> f64 {
    let rise = values.1 - values.0;
    let (m0, m1) = (rates.0 * length_s, rates.1 * length_s);
    // Slope a s² + b s + m0 over the share s of the step.
    let a = 3.0 * (m0 + m1) - 6.0 * rise;
    let b = 6.0 * rise - 4.0 * m0 - 2.0 * m1;
    let root = (b * b - 4.0 * a * m0).max(0.0).sqrt();
    let q = -0.5 * (b + root.copysign(b));
    let candidates = [q / a, m0 / q];
    let s = candidates
        .into_iter()
        .find(|s| (0.0..=1.0).contains(s))
        .unwrap_or(0.5);
    values.0 + s * (m0 + s * (0.5 * b + s * a / 3.0))
}

#[cfg(test)]
mod tests {
    use super::hermite_extremum;

    #[test]
    fn the_extremum_of_a_parabola_is_found() {
        // 1 + 4 s (1 - s) over two seconds.
        let top = hermite_extremum((1.0, 1.0), (2.0, -2.0), 2.0);
        assert!((top - 2.0).abs() < 1e-14, "{top}");
    }
}
