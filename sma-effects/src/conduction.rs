//! Heat along the rod: exact over a sample as far as it is linear.

use crate::state::Zone;

/// Cells of an end, from the middle to the clamp.
pub(crate) const CELLS: usize = 5;
/// Zones of a rod that has ends: the middle, and the cells.
pub(crate) const ZONES: usize = 1 + CELLS;
/// The zones, and the clamp.
pub(crate) const NODES: usize = ZONES + 1;
/// The clamp among the nodes.
pub(crate) const CLAMP: usize = ZONES;

/// Largest rate times length, at most, of a length whose exponential is taken by its series.
const SHORT: f64 = 0.125;
/// Terms of that series: what is left out is below 1e-14.
const TERMS: usize = 8;
/// Most doublings of a length: enough for 1e17 times the fastest rate.
const MOST_DOUBLINGS: u32 = 60;

/// Half of the difference of the conductivities of austenite and martensite over their sum: 18 and 8.6 W/(m K), makers'
/// data of nickel-titanium.
const CHANGE: f64 = (18.0 - 8.6) / (18.0 + 8.6);

/// A number for each pair of nodes, in each lane.
pub(crate) type Square<const L: usize> = [[[f64; L]; NODES]; NODES];

/// The two halves of the way from each zone to the next node toward the clamp, in each lane.
pub(crate) type Ways<const L: usize> = [[[f64; L]; 2]; ZONES];

/// A number for each zone, in each lane.
pub(crate) type PerZone<const L: usize> = [[f64; L]; ZONES];

/// Both ends of a rod, which are alike: cells, and what they are clamped in.
#[derive(Debug, Clone, PartialEq)]
#[repr(align(64))]
pub(crate) struct Ends<const L: usize> {
    pub(crate) cells: [Zone<L>; CELLS],
    /// The clamps above the surroundings, K.
    pub(crate) clamp_k: [f64; L],
    pub(crate) transfers: Transfers<L>,
    pub(crate) beyond: BeyondMean<L>,
}

/// Rate of conduction beyond that at the mean conductivity, at the start of the last part of a sample that had a length.
#[derive(Debug, Clone, PartialEq)]
#[repr(align(64))]
pub(crate) struct BeyondMean<const L: usize> {
    rate_k_per_s: PerZone<L>,
    length_s: [f64; L],
}

impl<const L: usize> BeyondMean<L> {
    /// Before a run.
    pub(crate) const NONE: Self = Self {
        rate_k_per_s: [[0.0; L]; ZONES],
        length_s: [0.0; L],
    };

    /// The rate that counts for a part of a sample, K/s: that in its middle, on the line through its start and the start of the
    /// part before, a longer one cut short.
    #[inline(always)]
    pub(crate) fn over(&mut self, start_k_per_s: &PerZone<L>, length_s: &[f64; L]) -> PerZone<L> {
        let mut counted = *start_k_per_s;
        for l in 0..L {
            let before_s = self.length_s[l];
            let ahead = if before_s > length_s[l] {
                0.5 * length_s[l] / before_s
            } else if before_s > 0.0 {
                0.5
            } else {
                0.0
            };
            let has_length = length_s[l] > 0.0;
            for z in 0..ZONES {
                let start = start_k_per_s[z][l];
                let before = self.rate_k_per_s[z][l];
                counted[z][l] += ahead * (start - before);
                self.rate_k_per_s[z][l] = if has_length { start } else { before };
            }
            self.length_s[l] = if has_length { length_s[l] } else { before_s };
        }
        counted
    }
}

/// Rate at which conduction warms each zone beyond that at the mean conductivity, K/s, by what has transformed.
///
/// ```text
/// -A_zj (w/(w_z/κ_z + w_j/κ_j) - 1) (u_j - u_z),   w = w_z + w_j,   κ = k/k̄ = 1 + 0.353 (2ξ - 1)
/// ```
#[inline(always)]
pub(crate) fn beyond_mean_k_per_s<const L: usize>(
    beyond_per_s: &Square<L>,
    ways: &Ways<L>,
    above_k: &[[f64; L]; NODES],
    transformed: &PerZone<L>,
) -> PerZone<L> {
    let mut rate_k_per_s = [[0.0; L]; ZONES];
    for z in 0..ZONES {
        let next = z + 1;
        for l in 0..L {
            let [inner, outer] = [ways[z][0][l], ways[z][1][l]];
            let conducts = |zone: usize| 1.0 + CHANGE * (2.0 * transformed[zone][l] - 1.0);
            let here = conducts(z);
            // A contact does not transform.
            let there = if next == CLAMP { 1.0 } else { conducts(next) };
            let resistance = inner * there + outer * here;
            let excess = (inner + outer) * (here * there) / resistance - 1.0;
            let apart_k = excess * (above_k[next][l] - above_k[z][l]);
            rate_k_per_s[z][l] -= beyond_per_s[z][next][l] * apart_k;
            if next < ZONES {
                rate_k_per_s[next][l] += beyond_per_s[next][z][l] * apart_k;
            }
        }
    }
    rate_k_per_s
}

/// Lengths of time whose transfers are at hand.
const AT_HAND: usize = 64;

/// Bits of a length that do not count: lengths within 1e-7 of one another, as differences of rounded times are, share
/// a transfer.
const BEYOND_NOTICE: u64 = (1 << 29) - 1;

/// Transfers over the last lengths that were asked for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Transfers<const L: usize> {
    known: Vec<Transfer<L>>,
    /// Which one is replaced next, once as many as may be are known.
    next: usize,
}

impl<const L: usize> Transfers<L> {
    /// None yet.
    pub(crate) const NONE: Self = Self {
        known: Vec::new(),
        next: 0,
    };

    /// That over a length in each lane, s; `beyond_per_s` is A.
    #[inline(always)]
    pub(crate) fn over(
        &mut self,
        length_s: &[f64; L],
        per_tau_s: &[f64; L],
        beyond_per_s: &Square<L>,
    ) -> &Transfer<L> {
        let length_s = length_s.map(|length_s| f64::from_bits(length_s.to_bits() & !BEYOND_NOTICE));
        let known = self
            .known
            .iter()
            .position(|known| known.length_s.map(f64::to_bits) == length_s.map(f64::to_bits));
        let slot = known.unwrap_or_else(|| {
            let transfer = Transfer::over(length_s, per_tau_s, beyond_per_s);
            if self.known.len() < AT_HAND {
                self.known.push(transfer);
                return self.known.len() - 1;
            }
            let slot = self.next;
            self.known[slot] = transfer;
            self.next = (slot + 1) % AT_HAND;
            slot
        });
        &self.known[slot]
    }
}

/// Change of the temperatures above the surroundings over a length of time, beyond the change of each zone by itself.
///
/// ```text
/// du/dt = -(1/τ + A) u + p/C
/// u_1 = (e + W) u_0 + (s + Y) p/C,   e = e^(-t/τ),   s = ∫ e^(-t/τ) dt
/// ```
///
/// A row of A that is 0 leaves rows of W and Y that are 0, to the last bit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(crate) struct Transfer<const L: usize> {
    length_s: [f64; L],
    /// e.
    kept: [f64; L],
    /// s.
    own_s: [f64; L],
    /// W.
    moved: Square<L>,
    /// Y, s.
    pub(crate) warmed_s: Square<L>,
}

impl<const L: usize> Transfer<L> {
    const NONE: Self = Self {
        length_s: [0.0; L],
        kept: [1.0; L],
        own_s: [0.0; L],
        moved: [[[0.0; L]; NODES]; NODES],
        warmed_s: [[[0.0; L]; NODES]; NODES],
    };

    /// By the series for a short length, doubled until it is the whole.
    #[inline(never)]
    fn over(length_s: [f64; L], per_tau_s: &[f64; L], beyond_per_s: &Square<L>) -> Self {
        let mut doublings = [0; L];
        let mut short_s = length_s;
        let mut most = 0;
        for l in 0..L {
            let row = |row: &[[f64; L]; NODES]| row.iter().map(|rate| rate[l].abs()).sum::<f64>();
            let fastest_per_s = per_tau_s[l] + beyond_per_s.iter().map(row).fold(0.0, f64::max);
            while short_s[l] * fastest_per_s > SHORT && doublings[l] < MOST_DOUBLINGS {
                short_s[l] *= 0.5;
                doublings[l] += 1;
            }
            most = most.max(doublings[l]);
        }
        let mut transfer = Self::over_short(&short_s, per_tau_s, beyond_per_s);
        for doubled in 0..most {
            transfer.double(&doublings.map(|doublings| doubled < doublings));
        }
        transfer.length_s = length_s;
        transfer
    }

    /// ```text
    /// W = Σ_n (-t)ⁿ/n! B_n,   Y = t Σ_n (-t)ⁿ/(n + 1)! B_n,   B_n = (1/τ + A)ⁿ - τ⁻ⁿ,   n ≥ 1
    /// ```
    fn over_short(short_s: &[f64; L], per_tau_s: &[f64; L], beyond_per_s: &Square<L>) -> Self {
        let mut over = Self {
            own_s: *short_s,
            ..Self::NONE
        };
        // (-t)ⁿ/n! B_n, and (-t/τ)ⁿ/n!.
        let mut term = [[[0.0; L]; NODES]; NODES];
        let mut own = [1.0; L];
        for n in 1..=TERMS {
            let (per_n, per_next) = (1.0 / n as f64, 1.0 / (n as f64 + 1.0));
            let mut next = of_neighbors(beyond_per_s, &term);
            for i in 0..NODES {
                for j in 0..NODES {
                    for l in 0..L {
                        let sum = next[i][j][l]
                            + per_tau_s[l] * term[i][j][l]
                            + own[l] * beyond_per_s[i][j][l];
                        next[i][j][l] = -short_s[l] * per_n * sum;
                        over.moved[i][j][l] += next[i][j][l];
                        over.warmed_s[i][j][l] += short_s[l] * per_next * next[i][j][l];
                    }
                }
            }
            term = next;
            for l in 0..L {
                own[l] *= -(short_s[l] * per_tau_s[l]) * per_n;
                over.kept[l] += own[l];
                over.own_s[l] += short_s[l] * per_next * own[l];
            }
        }
        over
    }

    /// Over twice the time, in some lanes.
    ///
    /// ```text
    /// W' = 2eW + W²,   Y' = (1 + e)Y + sW + WY,   e' = e²,   s' = (1 + e)s
    /// ```
    fn double(&mut self, in_lane: &[bool; L]) {
        let squared = product(&self.moved, &self.moved);
        let warmed = product(&self.moved, &self.warmed_s);
        for i in 0..NODES {
            for j in 0..NODES {
                for l in 0..L {
                    let (moved, warmed_s) = (self.moved[i][j][l], self.warmed_s[i][j][l]);
                    let twice = 2.0 * self.kept[l] * moved + squared[i][j][l];
                    let twice_s =
                        (1.0 + self.kept[l]) * warmed_s + self.own_s[l] * moved + warmed[i][j][l];
                    self.moved[i][j][l] = if in_lane[l] { twice } else { moved };
                    self.warmed_s[i][j][l] = if in_lane[l] { twice_s } else { warmed_s };
                }
            }
        }
        for l in 0..L {
            if in_lane[l] {
                self.own_s[l] *= 1.0 + self.kept[l];
                self.kept[l] *= self.kept[l];
            }
        }
    }

    /// Contribution of conduction to a node's temperature, K. `above_k`: the nodes above the surroundings at the start.
    #[inline(always)]
    pub(crate) fn moved_k(&self, node: usize, above_k: &[[f64; L]; NODES]) -> [f64; L] {
        let mut moved_k = [0.0; L];
        for j in 0..NODES {
            for l in 0..L {
                moved_k[l] += self.moved[node][j][l] * above_k[j][l];
            }
        }
        moved_k
    }

    /// The clamps at the end, K above the surroundings; `rate_k_per_s` is p/C of the zones.
    #[inline(always)]
    pub(crate) fn clamp_k(
        &self,
        above_k: &[[f64; L]; NODES],
        rate_k_per_s: &[[f64; L]; ZONES],
    ) -> [f64; L] {
        let mut clamp_k = self.moved_k(CLAMP, above_k);
        for l in 0..L {
            clamp_k[l] += self.kept[l] * above_k[CLAMP][l];
            for z in 0..ZONES {
                clamp_k[l] += self.warmed_s[CLAMP][z][l] * rate_k_per_s[z][l];
            }
        }
        clamp_k
    }
}

/// Product in which the left factor has rates between neighbors alone.
fn of_neighbors<const L: usize>(rates: &Square<L>, right: &Square<L>) -> Square<L> {
    let mut product = [[[0.0; L]; NODES]; NODES];
    for i in 0..NODES {
        for k in i.saturating_sub(1)..NODES.min(i + 2) {
            for j in 0..NODES {
                for l in 0..L {
                    product[i][j][l] += rates[i][k][l] * right[k][j][l];
                }
            }
        }
    }
    product
}

fn product<const L: usize>(left: &Square<L>, right: &Square<L>) -> Square<L> {
    let mut product = [[[0.0; L]; NODES]; NODES];
    for i in 0..NODES {
        for k in 0..NODES {
            for j in 0..NODES {
                for l in 0..L {
                    product[i][j][l] += left[i][k][l] * right[k][j][l];
                }
            }
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    /// A chain that exchanges at `per_s` and a clamp that follows slowly.
    fn chain(per_s: f64) -> Square<1> {
        let mut beyond_per_s = [[[0.0]; NODES]; NODES];
        for i in 1..ZONES {
            beyond_per_s[i][i] = [2.0 * per_s];
            beyond_per_s[i][i - 1] = [-per_s];
            beyond_per_s[i][i + 1] = [-per_s];
        }
        beyond_per_s[CLAMP][CLAMP] = [-0.09];
        beyond_per_s[CLAMP][ZONES - 1] = [-0.01];
        beyond_per_s
    }

    /// By many small steps of the fourth order.
    fn stepped(beyond_per_s: &Square<1>, per_tau_s: f64, length_s: f64) -> [f64; NODES] {
        let n_steps = 20_000;
        let step_s = length_s / f64::from(n_steps);
        let rate = |u: &[f64; NODES]| -> [f64; NODES] {
            core::array::from_fn(|i| {
                let lost: f64 = (0..NODES).map(|j| beyond_per_s[i][j][0] * u[j]).sum();
                let heated = if i < ZONES { 3.0 } else { 0.0 };
                heated - per_tau_s * u[i] - lost
            })
        };
        let mut u: [f64; NODES] = core::array::from_fn(|i| 10.0 - i as f64);
        for _ in 0..n_steps {
            let ahead = |k: &[f64; NODES], share: f64| -> [f64; NODES] {
                core::array::from_fn(|i| u[i] + share * step_s * k[i])
            };
            let first = rate(&u);
            let second = rate(&ahead(&first, 0.5));
            let third = rate(&ahead(&second, 0.5));
            let fourth = rate(&ahead(&third, 1.0));
            u = core::array::from_fn(|i| {
                u[i] + step_s / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i])
            });
        }
        u
    }

    #[test]
    fn it_is_the_solution_of_the_differential_equation() {
        for (per_s, length_s) in [(0.3, 0.1), (2.0, 1.0), (40.0, 5.0)] {
            let (per_tau_s, beyond_per_s) = (0.1, chain(per_s));
            let transfer = Transfer::over([length_s], &[per_tau_s], &beyond_per_s);
            let start: [[f64; 1]; NODES] = core::array::from_fn(|i| [10.0 - i as f64]);
            let expected = stepped(&beyond_per_s, per_tau_s, length_s);
            let own_s = -f64::exp_m1(-length_s * per_tau_s) / per_tau_s;
            for i in 0..ZONES {
                let mut end_k = (-length_s * per_tau_s).exp() * start[i][0] + own_s * 3.0;
                end_k += transfer.moved_k(i, &start)[0];
                let warmed_s: f64 = (0..ZONES).map(|j| transfer.warmed_s[i][j][0]).sum();
                end_k += warmed_s * 3.0;
                assert_abs_diff_eq!(end_k, expected[i], epsilon = 1e-9);
            }
            let clamp_k = transfer.clamp_k(&start, &[[3.0]; ZONES])[0];
            assert_abs_diff_eq!(clamp_k, expected[CLAMP], epsilon = 1e-9);
        }
    }

    #[test]
    fn a_zone_that_nothing_reaches_is_left_alone_to_the_last_bit() {
        let transfer = Transfer::over([3.0], &[0.1], &chain(7.0));
        for j in 0..NODES {
            assert_eq!(transfer.moved[0][j][0].to_bits(), 0.0_f64.to_bits());
            assert_eq!(transfer.warmed_s[0][j][0].to_bits(), 0.0_f64.to_bits());
        }
    }
}
