//! The end of a sample where heat and transformation depend on each other.

use crate::bracket::Bracket;
use crate::effect::{Acting, Before, Flow, Shift, Trial};
use crate::plant::Plants;
use crate::state::Zone;

/// Smallest derivative of the residual that is believed: keeps a step of Newton's finite and uphill.
const SMALLEST_SLOPE: f64 = 0.1;

/// Expected error of a trial at which a lane stays, K: far below what a difference of two simulations shows.
const NEAR_K: f64 = 1e-10;

/// A part of a sample of `Z` zones: what it starts from, and what acts.
#[derive(Debug)]
#[repr(align(64))]
pub(crate) struct Problem<'a, const L: usize, const Z: usize> {
    pub(crate) acting: &'a Acting<L>,
    pub(crate) before: [Before<L>; Z],
    /// Temperatures at its end without heat beyond the baseline's, °C.
    pub(crate) reference_degc: [[f64; L]; Z],
    /// Rise of the temperature of each zone per heat flow into each, K m/W.
    pub(crate) sensitivity_k_m_per_w: [[[f64; L]; Z]; Z],
    /// By how much own hypotheses shift the loop in each zone, K; their heat is in the reference already.
    pub(crate) own_shift_k: [[f64; L]; Z],
}

/// Where zones are at the end of a part, as tried or as found.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Ending<const L: usize, const Z: usize> {
    /// Temperatures that drive the hysteresis, °C.
    pub(crate) driving_degc: [[f64; L]; Z],
    /// Transformed shares, and their slopes over those temperatures, 1/K.
    pub(crate) transformed: [[f64; L]; Z],
    pub(crate) slope_per_k: [[f64; L]; Z],
}

/// A trial of all zones and what follows from it.
#[derive(Debug)]
#[repr(align(64))]
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

impl<const L: usize> Plants<L> {
    /// Temperatures that drive the hysteresis at the end of the sample, °C, and the slopes of the
    /// transformed share there, 1/K.
    ///
    /// ```text
    /// θ_z = B_z + g_z,   g_z = Σ_k S_zk q̄_k - ΔT_z
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
        ending: &mut Ending<L, Z>,
    ) {
        for z in 0..Z {
            ending.driving_degc[z] = zones[z].driving_degc;
            ending.slope_per_k[z] = zones[z].slope_per_k;
            ending.transformed[z] = zones[z].transformed;
        }
        let mut bracket = Bracket::open();
        let mut at = Evaluated::ZERO;
        let mut moved_k = [0.0; L];
        // m_k² - error m_(k-1): not above 0 where a lane stays; NaN never does.
        let mut open = [f64::INFINITY; L];
        for iteration in 0..=self.newton_iterations {
            let tried = *ending;
            let is_first = iteration == 0;
            if !is_first {
                self.look(zones, ending);
            }
            self.evaluate(problem, zones, ending, &mut at);
            let before_k = moved_k;
            moved_k = self.newton_step(problem, &at, &mut bracket, &mut ending.driving_degc);
            if is_first {
                continue;
            }
            let mut all_stay = true;
            for l in 0..L {
                let stays = open[l] <= 0.0;
                for z in 0..Z {
                    let Ending {
                        driving_degc,
                        slope_per_k,
                        ..
                    } = ending;
                    driving_degc[z][l] = if stays {
                        tried.driving_degc[z][l]
                    } else {
                        driving_degc[z][l]
                    };
                    slope_per_k[z][l] = if stays {
                        tried.slope_per_k[z][l]
                    } else {
                        slope_per_k[z][l]
                    };
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

    /// Transformed shares and slopes at trial temperatures.
    #[inline(always)]
    fn look<const Z: usize>(&self, zones: &[&mut Zone<L>; Z], ending: &mut Ending<L, Z>) {
        for z in 0..Z {
            let driving_degc = &ending.driving_degc[z];
            let mapped = if Z == 1 {
                self.sense(zones[z], driving_degc)
            } else {
                self.sense_apart(zones[z], driving_degc)
            };
            for l in 0..L {
                ending.transformed[z][l] = self.scale.transformed(l, mapped.fraction[l]);
                ending.slope_per_k[z][l] = self.scale.slope_per_k(l, mapped.slope_per_k[l]);
            }
        }
    }

    /// Shifts and flows at a trial.
    #[inline(always)]
    pub(crate) fn evaluate<const Z: usize>(
        &self,
        problem: &Problem<'_, L, Z>,
        zones: &[&mut Zone<L>; Z],
        ending: &Ending<L, Z>,
        at: &mut Evaluated<L, Z>,
    ) {
        let Ending {
            driving_degc: driving,
            transformed: share,
            slope_per_k: slope,
        } = ending;
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
            // A rod of one temperature is the usual one; with zones, calls cost little beside the rest.
            if Z == 1 {
                self.effects.shift(effects, before, trial, &mut at.shift[z]);
            } else if self.path.shifts {
                self.effects
                    .shift_apart(effects, before, trial, &mut at.shift[z]);
            }
            for l in 0..L {
                trial.temperature_degc[l] = driving[z][l] + at.shift[z].kelvin[l];
            }
            at.flow[z] = Flow::ZERO;
            let flow = &mut at.flow[z];
            if Z == 1 {
                self.effects.flow(problem.acting, before, trial, flow);
            } else if self.path.flows {
                self.effects.flow_apart(problem.acting, before, trial, flow);
            }
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
        let derivative = self.derivative(problem, at);
        let mut wanted = [[0.0; L]; Z];
        for z in 0..Z {
            wanted[z] = problem.warmed_k(z, &at.flow);
            for l in 0..L {
                wanted[z][l] -= at.shift[z].kelvin[l];
            }
        }
        let mut step = wanted;
        for z in 0..Z {
            for j in 0..Z {
                for l in 0..L {
                    let ahead_k = problem.reference_degc[j][l] - driving[j][l];
                    step[z][l] += derivative[z][j][l] * ahead_k;
                }
            }
        }
        eliminate(derivative, &mut step);
        let mut moved_k = [0.0; L];
        for z in 0..Z {
            for l in 0..L {
                let end_degc = problem.reference_degc[z][l];
                let newton = end_degc + step[z][l];
                let tried = driving[z][l];
                // With more zones the residual of one need not rise in its own temperature alone.
                driving[z][l] = if Z == 1 {
                    bracket.next(l, tried, tried - end_degc - wanted[z][l], newton)
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

    /// ∂g_z/∂θ_j: each zone by itself, and through the mean of the rod.
    ///
    /// ```text
    /// G_zj = S_zj ∂q̄_j/∂θ_j - ∂ΔT_z/∂θ_z [z = j] + (Σ_k S_zk ∂q̄_k/∂p̄ - ∂ΔT_z/∂p̄) ∂p̄/∂θ_j
    /// ```
    #[inline(always)]
    fn derivative<const Z: usize>(
        &self,
        problem: &Problem<'_, L, Z>,
        at: &Evaluated<L, Z>,
    ) -> [[[f64; L]; Z]; Z] {
        let sensitivity = &problem.sensitivity_k_m_per_w;
        let mut own = [[0.0; L]; Z];
        let mut by_mean = [[0.0; L]; Z];
        let mut mean_per_k = [[0.0; L]; Z];
        for k in 0..Z {
            let (flow, shift) = (&at.flow[k], &at.shift[k]);
            for l in 0..L {
                let slope_per_k = at.trial[k].slope_per_k[l];
                own[k][l] =
                    flow.per_k[l] * (1.0 + shift.per_k[l]) + flow.per_transformed[l] * slope_per_k;
                by_mean[k][l] = flow.per_k[l] * shift.per_mean[l] + flow.per_mean[l];
                mean_per_k[k][l] = if Z > 1 {
                    slope_per_k * self.effects.end_conduction.share[k][l]
                } else {
                    slope_per_k
                };
            }
        }
        let mut derivative = [[[0.0; L]; Z]; Z];
        for z in 0..Z {
            let mut through_mean = [0.0; L];
            for l in 0..L {
                for k in 0..Z {
                    through_mean[l] += sensitivity[z][k][l] * by_mean[k][l];
                }
                through_mean[l] -= at.shift[z].per_mean[l];
            }
            for j in 0..Z {
                for l in 0..L {
                    derivative[z][j][l] =
                        sensitivity[z][j][l] * own[j][l] + through_mean[l] * mean_per_k[j][l];
                    if z == j {
                        derivative[z][j][l] -= at.shift[z].per_k[l];
                    }
                }
            }
        }
        derivative
    }
}

impl<const L: usize, const Z: usize> Problem<'_, L, Z> {
    /// By how much the flows into all zones warm one, K.
    #[inline(always)]
    pub(crate) fn warmed_k(&self, z: usize, flow: &[Flow<L>; Z]) -> [f64; L] {
        let mut warmed_k = [0.0; L];
        for l in 0..L {
            warmed_k[l] = self.sensitivity_k_m_per_w[z][z][l] * flow[z].w_per_m[l];
        }
        for k in (0..Z).filter(|&k| k != z) {
            for l in 0..L {
                warmed_k[l] += self.sensitivity_k_m_per_w[z][k][l] * flow[k].w_per_m[l];
            }
        }
        warmed_k
    }
}

/// (I - G)⁻¹ r in place of r.
#[inline(always)]
fn eliminate<const L: usize, const Z: usize>(
    mut derivative: [[[f64; L]; Z]; Z],
    right: &mut [[f64; L]; Z],
) {
    for z in 0..Z {
        for j in 0..Z {
            for l in 0..L {
                derivative[z][j][l] = if j == z {
                    1.0 - derivative[z][j][l]
                } else {
                    -derivative[z][j][l]
                };
            }
        }
    }
    let left = &mut derivative;
    for z in 0..Z {
        for l in 0..L {
            let pivot = left[z][z][l];
            left[z][z][l] = if pivot < SMALLEST_SLOPE {
                SMALLEST_SLOPE
            } else {
                pivot
            };
        }
        for below in z + 1..Z {
            let mut share = [0.0; L];
            for l in 0..L {
                share[l] = left[below][z][l] / left[z][z][l];
                right[below][l] -= share[l] * right[z][l];
            }
            for j in z + 1..Z {
                for l in 0..L {
                    left[below][j][l] -= share[l] * left[z][j][l];
                }
            }
        }
    }
    for z in (0..Z).rev() {
        for j in z + 1..Z {
            for l in 0..L {
                right[z][l] -= left[z][j][l] * right[j][l];
            }
        }
        for l in 0..L {
            right[z][l] /= left[z][z][l];
        }
    }
}
