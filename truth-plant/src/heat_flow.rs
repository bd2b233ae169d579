//! Where heat comes from and goes to.

use crate::Supply;
use crate::TruthPlant;
use crate::layout::Layout;
use crate::loss::Loss;

/// Temperatures and fractions of all cells.
#[derive(Debug)]
pub(crate) struct Cells<'a> {
    pub(crate) temperature_degc: &'a [f64],
    pub(crate) fraction: &'a [f64],
}

/// Drive and surroundings at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moment {
    /// The drive behind the supply.
    pub(crate) amplitude: f64,
    pub(crate) ambient_degc: f64,
    /// Factor of convection.
    pub(crate) draught: f64,
}

/// Heating, losses and conduction.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HeatFlow<'a> {
    plant: &'a TruthPlant,
    layout: Layout,
    loss: Loss,
    supply: Supply,
    heat_capacity_j_per_m_k: f64,
    perimeter_m: f64,
    section_m2: f64,
    cell_length_m: Vec<f64>,
    /// Conductance of all rods when cold, S.
    cold_conductance_s: f64,
}

impl<'a> HeatFlow<'a> {
    pub(crate) fn new(plant: &'a TruthPlant, layout: Layout) -> Self {
        let rod = &plant.rod;
        let cold_s = 1.0 / (rod.resistance_ohm_per_m * rod.length_m);
        let second = plant
            .second_rod
            .map_or(0.0, |second| 1.0 / second.resistance_ratio);
        Self {
            plant,
            layout,
            loss: Loss {
                diameter_m: rod.diameter_m,
                convective_coefficient_w_per_m2_k: plant.convective_coefficient_w_per_m2_k,
                free: plant
                    .free_convection
                    .map(|free| free.scaled(rod.diameter_m, plant.ambient_degc)),
                radiation: plant.radiation,
                dip: plant.convection_dip,
            },
            supply: plant.supply.unwrap_or_default(),
            heat_capacity_j_per_m_k: rod.heat_capacity_j_per_m_k(),
            perimeter_m: rod.perimeter_m(),
            section_m2: rod.section_m2(),
            cell_length_m: rod.cell_lengths_m(),
            cold_conductance_s: cold_s * (1.0 + second),
        }
    }

    /// Rates of the enthalpies, over C_p, and of the fittings' temperatures, K/s.
    pub(crate) fn rates(
        &self,
        cells: &Cells<'_>,
        moment: &Moment,
        state: &[f64],
        rates: &mut [f64],
    ) {
        self.heat(cells, moment, rates);
        if let (Some(_), Some(first)) = (self.plant.end_fittings, self.layout.fittings) {
            // Without fittings nothing makes the cells of a rod differ.
            self.conduct(cells, rates);
            self.fit(cells, moment, (first, state), rates);
        }
    }

    /// Resistance over length of a cell, Ω/m.
    fn resistance_ohm_per_m(&self, cells: &Cells<'_>, j: usize) -> f64 {
        let mut resistance = self.plant.rod.resistance_ohm_per_m;
        if let Some(second) = self.plant.second_rod.filter(|_| j >= self.layout.cells) {
            resistance *= second.resistance_ratio;
        }
        if let Some(phase) = self.plant.phase_resistivity {
            let warming_k = cells.temperature_degc[j] - self.plant.ambient_degc;
            resistance *= phase.factor(cells.fraction[j], warming_k);
        }
        resistance
    }

    /// Heating less losses to the air.
    fn heat(&self, cells: &Cells<'_>, moment: &Moment, rates: &mut [f64]) {
        let n_cells = self.layout.cells;
        let mut resistances_ohm = [0.0; 2];
        let resistances_ohm = &mut resistances_ohm[..self.layout.strands];
        for (strand, total_ohm) in resistances_ohm.iter_mut().enumerate() {
            let parts_ohm = self
                .cell_length_m
                .iter()
                .enumerate()
                .map(|(cell, length_m)| {
                    length_m * self.resistance_ohm_per_m(cells, strand * n_cells + cell)
                });
            *total_ohm = parts_ohm.sum();
        }
        let mut square_currents_a2 = [0.0; 2];
        self.plant.drive.square_currents_a2(
            (&self.supply, self.cold_conductance_s),
            moment.amplitude,
            resistances_ohm,
            &mut square_currents_a2,
        );
        for (j, rate) in rates[..self.layout.elements()].iter_mut().enumerate() {
            let heating_w_per_m =
                square_currents_a2[j / n_cells] * self.resistance_ohm_per_m(cells, j);
            let air = (moment.ambient_degc, moment.draught);
            let flux_w_per_m2 = self.loss.flux_w_per_m2(cells.temperature_degc[j], air);
            *rate =
                (heating_w_per_m - self.perimeter_m * flux_w_per_m2) / self.heat_capacity_j_per_m_k;
        }
    }

    /// From the middle of a cell to its end, K/W.
    fn half_cell_k_per_w(&self, cells: &Cells<'_>, j: usize) -> f64 {
        let conductivity = &self.plant.rod.conductivity;
        let conductivity_w_per_m_k = conductivity.at(cells.fraction[j], cells.temperature_degc[j]);
        0.5 * self.cell_length_m[j % self.layout.cells] / (conductivity_w_per_m_k * self.section_m2)
    }

    fn cell_j_per_k(&self, j: usize) -> f64 {
        self.heat_capacity_j_per_m_k * self.cell_length_m[j % self.layout.cells]
    }

    /// Heat along the rods.
    fn conduct(&self, cells: &Cells<'_>, rates: &mut [f64]) {
        for strand in 0..self.layout.strands {
            let first = strand * self.layout.cells;
            let mut left_k_per_w = self.half_cell_k_per_w(cells, first);
            for j in first..first + self.layout.cells - 1 {
                let right_k_per_w = self.half_cell_k_per_w(cells, j + 1);
                let drop_k = cells.temperature_degc[j + 1] - cells.temperature_degc[j];
                let flow_w = drop_k / (left_k_per_w + right_k_per_w);
                rates[j] += flow_w / self.cell_j_per_k(j);
                rates[j + 1] -= flow_w / self.cell_j_per_k(j + 1);
                left_k_per_w = right_k_per_w;
            }
        }
    }

    /// Heat into the fittings, whose temperatures stand from `first` on in the state.
    fn fit(
        &self,
        cells: &Cells<'_>,
        moment: &Moment,
        (first, state): (usize, &[f64]),
        rates: &mut [f64],
    ) {
        let Some(fittings) = self.plant.end_fittings else {
            return;
        };
        for end in 0..2 * self.layout.strands {
            let (strand, is_last) = (end / 2, end % 2);
            let j = strand * self.layout.cells + is_last * (self.layout.cells - 1);
            let fitting = first + end;
            // Without contact 1/0 is infinite, and nothing flows.
            let resistance_k_per_w =
                1.0 / fittings.contact_w_per_k + self.half_cell_k_per_w(cells, j);
            let flow_w = (cells.temperature_degc[j] - state[fitting]) / resistance_k_per_w;
            let lost_w = fittings.loss_w_per_k * (state[fitting] - moment.ambient_degc);
            rates[j] -= flow_w / self.cell_j_per_k(j);
            rates[fitting] = (flow_w - lost_w) / fittings.heat_capacity_j_per_k;
        }
    }
}
