//! The end of a sample where heat and transformation depend on each other.

use crate::bracket::Bracket;
use crate::effect::{Acting, Before, Flow, Mapped, Shift, Trial};
use crate::heat::Reference;
use crate::plant::ExtendedPlant;
use crate::state::Zone;

/// Smallest derivative of the residual that is believed: keeps a step of Newton's finite and uphill.
const SMALLEST_SLOPE: f64 = 0.1;

/// Expected error of a trial at which a lane stays, K: far below what a difference of two simulations shows.
const NEAR_K: f64 = 1e-10;

/// A part of a sample of `Z` zones: what it starts from, and what acts.
#[derive(Debug)]
pub(crate) struct Problem<'a, const L: usize, const Z: usize> {
    pub(crate) acting: &'a Acting<L>,
    pub(crate) before: &'a [Before<L>; Z],
    pub(crate) reference: &'a [Reference<L>; Z],
    /// By how much own hypotheses shift the loop in each zone, K; their heat is in the reference already.
    pub(crate) own_shift_k: &'a [[f64; L]; Z],
}

/// A trial of all zones and what follows from it.
#[derive(Debug)]
pub(crate) struct Evaluated<const L: usize, const Z: usize> {
    pub(crate) trial: [Trial<L>; Z],
    pub(crate) shift: [Shift<L>; Z],
    pub(crate) flow: [Flow<L>; Z],
}

impl<const L: usize, const Z: usize> Evaluated<L, Z> {
    pub(crate) const ZERO: Self = Self {
        trial: [Trial::ZERO; Z],
        shift: [Shift::ZERO; Z],
        flow: [Flow::ZERO; Z],
    };
}

impl<const L: usize> ExtendedPlant<L> {
    /// Temperatures that drive the hysteresis at the end of the sample, °C, and the slopes of the
    /// transformed share there, 1/K.
    ///
    /// ```text
    /// θ_z = B_z + g_z,   g_z = S_z q̄_z - ΔT_z
    /// ```
    ///
    /// with the baseline's temperature B, its sensitivity S, the extra heat flow q̄ and the shift of the
    /// loop ΔT, the latter two functions of all θ. Newton's step is written from B,
    ///
    /// ```text
    /// θ = B + (I - G)⁻¹ (g + G (B - θ_t)),   G = ∂g/∂θ at the trial θ_t,
    /// ```
    ///
    /// so that g = 0 gives B to the last bit from any trial. The first trial is the start of the sample,
    /// whose slope is known.
    ///
    /// A step m_k after one of m_(k-1) leaves m_k²/m_(k-1), or less where steps shrink ever faster. A lane whose
    /// error is small stays where it is, whatever the others still need.
    #[inline(always)]
    pub(crate) fn solve<const Z: usize>(
        &self,
        problem: &Problem<'_, L, Z>,
        zones: &[&mut Zone<L>; Z],
        driving: &mut [[f64; L]; Z],
        slope: &mut [[f64; L]; Z],
    ) {
        let mut share = [[0.0; L]; Z];
        for z in 0..Z {
            driving[z] = zones[z].driving_degc;
            slope[z] = zones[z].slope_per_k;
            share[z] = zones[z].transformed;
        }
        let mut bracket = Bracket::open();
        let mut at = Evaluated::ZERO;
        self.evaluate(problem, zones, [driving, &share, slope], &mut at);
        let mut moved_k = self.newton_step(problem, &at, &mut bracket, driving);
        // m_k² - error m_(k-1): not above 0 where a lane stays; NaN never does.
        let mut open = [f64::INFINITY; L];
        for _ in 0..self.newton_iterations {
            let (tried, known) = (*driving, *slope);
            for z in 0..Z {
                self.look(zones[z], &driving[z], &mut share[z], &mut slope[z]);
            }
            self.evaluate(problem, zones, [driving, &share, slope], &mut at);
            let before_k = moved_k;
            moved_k = self.newton_step(problem, &at, &mut bracket, driving);
            let mut all_stay = true;
            for l in 0..L {
                let stays = open[l] <= 0.0;
                for z in 0..Z {
                    driving[z][l] = if stays { tried[z][l] } else { driving[z][l] };
                    slope[z][l] = if stays { known[z][l] } else { slope[z][l] };
                }
                let next = moved_k[l] * moved_k[l] - NEAR_K * before_k[l];
                open[l] = if stays { open[l] } else { next };
                all_stay &= open[l] <= 0.0;
            }
            if all_stay {
                break;
            }
        }
    }

    /// Transformed share and slope of a zone at a trial temperature.
    #[inline(always)]
    fn look(
        &self,
        zone: &Zone<L>,
        driving_degc: &[f64; L],
        share: &mut [f64; L],
        slope: &mut [f64; L],
    ) {
        let sensed = self.hysteresis.peek(&zone.memory, *driving_degc);
        let mut mapped = Mapped {
            fraction: sensed.fraction,
            slope_per_k: sensed.slope_per_k,
        };
        self.effects
            .fraction(&zone.effects, driving_degc, &mut mapped);
        for l in 0..L {
            share[l] = self.scale.transformed(l, mapped.fraction[l]);
            slope[l] = self.scale.slope_per_k(l, mapped.slope_per_k[l]);
        }
    }

    /// Shifts and flows at a trial: driving temperature, transformed share and its slope.
    #[inline(always)]
    pub(crate) fn evaluate<const Z: usize>(
        &self,
        problem: &Problem<'_, L, Z>,
        zones: &[&mut Zone<L>; Z],
        [driving, share, slope]: [&[[f64; L]; Z]; 3],
        at: &mut Evaluated<L, Z>,
    ) {
        let mean = self.mean(share);
        let mut bend = [[0.0; L]; Z];
        for z in 0..Z {
            let before = &problem.before[z];
            for l in 0..L {
                let flatter_per_k = before.slope_per_k[l] - slope[z][l];
                let change_k = driving[z][l] - before.driving_degc[l];
                bend[z][l] = flatter_per_k * change_k * (1.0 / 12.0);
            }
        }
        let mean_bend = self.mean(&bend);
        for z in 0..Z {
            let (effects, before) = (&zones[z].effects, &problem.before[z]);
            let trial = &mut at.trial[z];
            trial.driving_degc = driving[z];
            trial.transformed = share[z];
            trial.slope_per_k = slope[z];
            trial.mean = mean;
            trial.bend = bend[z];
            trial.mean_bend = mean_bend;
            at.shift[z] = Shift {
                kelvin: problem.own_shift_k[z],
                ..Shift::ZERO
            };
            self.effects.shift(effects, before, trial, &mut at.shift[z]);
            for l in 0..L {
                trial.temperature_degc[l] = driving[z][l] + at.shift[z].kelvin[l];
            }
            at.flow[z] = Flow::ZERO;
            self.effects
                .flow(problem.acting, before, trial, &mut at.flow[z]);
        }
        if Z > 1 {
            self.exchange(problem, at);
        }
    }

    /// Heat between the zones, and from the ends to the clamps: equations of
    /// [`EndConduction`](crate::EndConduction). The end's loss at its own temperature stands in its own
    /// heat balance.
    #[inline(always)]
    fn exchange<const Z: usize>(&self, problem: &Problem<'_, L, Z>, at: &mut Evaluated<L, Z>) {
        let ends = &self.effects.end_conduction;
        let (middle, end) = (0, Z - 1);
        for l in 0..L {
            let start_degc = problem.before[middle].temperature_degc[l];
            let change_k = at.trial[middle].temperature_degc[l] - start_degc;
            let end_start_degc = problem.before[end].temperature_degc[l];
            let end_change_k = at.trial[end].temperature_degc[l] - end_start_degc;
            let own = problem.before[middle].counted[l];
            let across = problem.counted_across(middle, l);
            let warmer_k = (start_degc + own * change_k) - (end_start_degc + across * end_change_k);
            at.flow[middle].w_per_m[l] -= ends.to_ends_w_per_m_k[l] * warmer_k;
            at.flow[middle].per_k[l] -= own * ends.to_ends_w_per_m_k[l];
            let across = problem.counted_across(end, l);
            let above_k = start_degc + across * change_k - problem.acting.ambient_degc[l];
            at.flow[end].w_per_m[l] += ends.to_clamp_w_per_m_k[l] * above_k;
        }
    }

    /// Goes to the next trial; returns how far, K.
    #[inline(always)]
    fn newton_step<const Z: usize>(
        &self,
        problem: &Problem<'_, L, Z>,
        at: &Evaluated<L, Z>,
        bracket: &mut Bracket<L>,
        driving: &mut [[f64; L]; Z],
    ) -> [f64; L] {
        let mut moved_k = [0.0; L];
        for l in 0..L {
            let derivative = self.derivative(problem, at, l);
            let mut wanted = [0.0; Z];
            let mut right = [0.0; Z];
            for z in 0..Z {
                let sensitivity = problem.reference[z].sensitivity_k_m_per_w[l];
                wanted[z] = sensitivity * at.flow[z].w_per_m[l] - at.shift[z].kelvin[l];
                right[z] = wanted[z];
                for j in 0..Z {
                    let ahead_k = problem.reference[j].end_degc[l] - driving[j][l];
                    right[z] += derivative[z][j] * ahead_k;
                }
            }
            let step = eliminate(&derivative, &right);
            for z in 0..Z {
                let end_degc = problem.reference[z].end_degc[l];
                let newton = end_degc + step[z];
                let tried = driving[z][l];
                // With two zones the residual of one need not rise in its own temperature alone.
                driving[z][l] = if Z == 1 {
                    bracket.next(l, tried, tried - end_degc - wanted[z], newton)
                } else {
                    newton
                };
                let here_k = (driving[z][l] - tried).abs();
                moved_k[l] = if moved_k[l] > here_k {
                    moved_k[l]
                } else {
                    here_k
                };
            }
        }
        moved_k
    }

    /// ∂g_z/∂θ_j.
    #[inline(always)]
    fn derivative<const Z: usize>(
        &self,
        problem: &Problem<'_, L, Z>,
        at: &Evaluated<L, Z>,
        l: usize,
    ) -> [[f64; Z]; Z] {
        let ends = &self.effects.end_conduction;
        // ∂p̄/∂θ_j, and ∂ΔT_z/∂θ_j.
        let mut mean_per_k = [0.0; Z];
        let mut shift_per_k = [[0.0; Z]; Z];
        for j in 0..Z {
            mean_per_k[j] = at.trial[j].slope_per_k[l];
            if Z > 1 {
                mean_per_k[j] *= if j > 0 {
                    ends.share[l]
                } else {
                    1.0 - ends.share[l]
                };
            }
        }
        for z in 0..Z {
            for j in 0..Z {
                shift_per_k[z][j] = at.shift[z].per_mean[l] * mean_per_k[j];
            }
            shift_per_k[z][z] += at.shift[z].per_k[l];
        }
        let mut derivative = [[0.0; Z]; Z];
        for z in 0..Z {
            let flow = &at.flow[z];
            let other = Z - 1 - z;
            let conductance = if z == 0 {
                &ends.to_ends_w_per_m_k
            } else {
                &ends.to_clamp_w_per_m_k
            };
            for j in 0..Z {
                let mut per_k =
                    flow.per_k[l] * shift_per_k[z][j] + flow.per_mean[l] * mean_per_k[j];
                if j == z {
                    per_k += flow.per_k[l] + flow.per_transformed[l] * at.trial[z].slope_per_k[l];
                }
                if Z > 1 {
                    let also = if j == other { 1.0 } else { 0.0 };
                    let across = problem.counted_across(z, l) * conductance[l];
                    per_k += across * (also + shift_per_k[other][j]);
                }
                let sensitivity = problem.reference[z].sensitivity_k_m_per_w[l];
                derivative[z][j] = sensitivity * per_k - shift_per_k[z][j];
            }
        }
        derivative
    }
}

impl<const L: usize, const Z: usize> Problem<'_, L, Z> {
    /// What counts of a change in the other zone for the flow into zone `z`: the other's path, into this
    /// zone; see [`counted`](crate::effect::counted).
    #[inline(always)]
    fn counted_across(&self, z: usize, l: usize) -> f64 {
        let (here, other) = (&self.before[z], &self.before[Z - 1 - z]);
        other.counted[l] + (here.rate[l] - other.rate[l]) * (1.0 / 12.0)
    }
}

/// (I - G)⁻¹ r for one zone or two.
#[inline(always)]
fn eliminate<const Z: usize>(derivative: &[[f64; Z]; Z], right: &[f64; Z]) -> [f64; Z] {
    let mut diagonal = [0.0; Z];
    for z in 0..Z {
        let slope = 1.0 - derivative[z][z];
        diagonal[z] = if slope < SMALLEST_SLOPE {
            SMALLEST_SLOPE
        } else {
            slope
        };
    }
    let mut step = [0.0; Z];
    if Z == 1 {
        step[0] = right[0] / diagonal[0];
        return step;
    }
    let last = Z - 1;
    let determinant = diagonal[0] * diagonal[last] - derivative[0][last] * derivative[last][0];
    for z in 0..Z {
        let other = last - z;
        let sum = right[z] * diagonal[other] + derivative[z][other] * right[other];
        step[z] = sum / determinant;
    }
    step
}
