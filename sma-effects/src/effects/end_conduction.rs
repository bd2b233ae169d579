use crate::conduction::{CELLS, CLAMP, NODES, Square, Ways, ZONES};
use crate::effect::{Base, Effect, without_memory};
use crate::info::{Belongs, EffectBlock, EffectInfo, Presence, Smoothness};
use crate::{EffectParameter, EffectValues};

/// Lengths of the cells of an end from the middle to the clamp, over the length ℓ on which a fin cools.
const CELL_LENGTHS: [f64; CELLS] = [1.2, 0.7, 0.45, 0.3, 0.2];
/// Way from the last cell to where the middle has its temperature, at most, over ℓ.
const INTO_MIDDLE: f64 = 0.9;

parameters! {
    /// The ends of the rod lose heat to the clamps.
    ///
    /// ```text
    /// C dT/dt = P - hA (T - T_a) + ∂/∂x (k S ∂T/∂x) + …     along the rod, S its section
    /// k S ∂T/∂x = k S (T - T_c)/(c ℓ)                  at a clamp, through a contact like c ℓ of rod
    /// τ_c d(T_c - T_a)/dt = w (T_1 - T_a) - (T_c - T_a)     clamps, at T_a before the run
    /// ```
    ///
    /// The rod in finite volumes: the middle, and two ends that are alike, five cells each of 1.2, 0.7, 0.45, 0.3 and 0.2
    /// times the length ℓ = √(k D/(4 h)) over which a fin cools, all shorter by 1/(1 + 2.85 φ) where φ = 2ℓ/L says that
    /// the rod is short; T_1 is the temperature of the cell at the clamp. Each has its own hysteresis memory and takes
    /// part in every other effect; what the rod shows is the mean over its length, but for the recorded temperature, which is
    /// that of the middle.
    ///
    /// Austenite conducts twice as well as martensite, 18 and 8.6 W/(m K) by makers' data of nickel-titanium:
    /// k = k̄ (1 + 0.353 (2ξ - 1)), and ℓ is of the mean k̄.
    /// Conduction at k̄ is exact over a sample; what it is beyond that counts with its value in the middle of the sample,
    /// extrapolated from the start of this one and the one before.
    EndConduction {
        /// Share of the length on which the ends cool φ = 2ℓ/L; 0 to 0.6.
        end_share: EffectParameter::size("1", 0.2, [0.0, 0.6])
            .literature([0.01, 0.6], "computed: 2 × 5.7 mm (D = 0.5 mm, h = 70) of 1 m to 2 × 34 mm (3 mm, 12) of 110 mm"),
        /// Resistance of the contact to the clamp over that of a length ℓ of the rod c; 0 to 20. A partner: without
        /// ends it does nothing.
        contact_ratio: EffectParameter::partner("1", 0.5, [0.0, 20.0], &[0.1, 0.25, 0.5, 1.0, 2.0])
            // A contact that insulates.
            .up_to_an_end(),
        /// Rise of the clamps in the end over that of the rod's ends w; 0 (they stay at ambient) to 0.95. A partner.
        clamp_warming: EffectParameter::partner("1", 0.2, [0.0, 0.95], &[])
            // Clamps that warm up with the rod.
            .up_to_an_end(),
        /// Time constant of the clamps τ_c, s; 0 to 20,000. A partner: with w = 0 it does nothing either.
        clamp_s: EffectParameter::partner("s", 200.0, [0.0, 20_000.0], &[])
            // Longer than a run takes.
            .up_to_an_end(),
    }
}

pub(super) const INFO: EffectInfo = EffectInfo {
    id: "end-conduction",
    name: "heat conduction into the clamps",
    block: EffectBlock::HeatBalance,
    flexible: false,
    smoothness: Smoothness::Smooth,
    needs: &[],
    parameters: PARAMETERS,
    equation: "C ∂T/∂t = P - hA (T - T_a) + ∂/∂x (k(ξ) S ∂T/∂x),  cold at both clamps",
    sentence: "{value} of the length cools toward the clamps, through contacts that resist like {partner} of a cooling length",
    belongs_to: Belongs::Rig,
    presence: Presence::Seldom,
    acts_like: &[],
    needs_in_recording: &[],
    costly: true,
    ..EffectInfo::ORDINARY
};

/// Shortest time constant of the clamps, s: what is faster follows at once.
const SHORTEST_CLAMP_S: f64 = 1e-3;

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lanes<const L: usize> {
    /// Share of the length that each zone has; 1 less the others for the middle.
    pub(crate) share: [[f64; L]; ZONES],
    /// A of [`Transfer`](crate::conduction::Transfer), 1/s.
    pub(crate) beyond_per_s: Square<L>,
    /// Ways from each zone to the next node, over ℓ.
    pub(crate) ways: Ways<L>,
}

impl<const L: usize> Effect<L> for Lanes<L> {
    without_memory!();

    fn new(values: &[EffectValues; L], base: &Base<'_, L>) -> Self {
        let tau_s = base.tau_s();
        let mut lanes = Self {
            share: [[0.0; L]; ZONES],
            beyond_per_s: [[[0.0; L]; NODES]; NODES],
            ways: [[[1.0; L]; 2]; ZONES],
        };
        for l in 0..L {
            let ends = &values[l].end_conduction;
            // Lengths over ℓ.
            let shrunk = 1.0 / (1.0 + CELL_LENGTHS.iter().sum::<f64>() * ends.end_share);
            let lengths = CELL_LENGTHS.map(|length| length * shrunk);
            lanes.share[0][l] = 1.0;
            for z in 1..ZONES {
                lanes.share[z][l] = ends.end_share * lengths[z - 1];
                lanes.share[0][l] -= lanes.share[z][l];
            }
            let ways = ways(ends, &lengths, shrunk);
            let per_s = exchanged(ends, tau_s[l], &lengths, shrunk, &ways);
            for z in 0..ZONES {
                for side in 0..2 {
                    lanes.ways[z][side][l] = ways[z][side];
                }
            }
            for i in 0..NODES {
                for j in 0..NODES {
                    lanes.beyond_per_s[i][j][l] = per_s[i][j];
                }
            }
        }
        lanes
    }
}

/// A rate for each pair of nodes, 1/s.
type Rates = [[f64; NODES]; NODES];

/// Ways from the middle of each zone to the face that it shares with the next node, and on to the middle of that, over ℓ: into
/// the middle of the rod not farther than where it has its temperature, into the clamp through the contact.
fn ways(ends: &EndConduction, lengths: &[f64; CELLS], shrunk: f64) -> [[f64; 2]; ZONES] {
    core::array::from_fn(|z| {
        let inner = match z {
            // Half of the middle is as long as `shrunk / end_share`.
            0 => 1.0 / (1.0 / INTO_MIDDLE).hypot(2.0 * ends.end_share / shrunk),
            _ => 0.5 * lengths[z - 1],
        };
        let outer = lengths.get(z).map_or(ends.contact_ratio, |next| 0.5 * next);
        [inner, outer]
    })
}

/// Rates of exchange between the nodes: ℓ²/τ over the product of a zone's length and the way to its neighbor.
fn exchanged(
    ends: &EndConduction,
    tau_s: f64,
    lengths: &[f64; CELLS],
    shrunk: f64,
    ways: &[[f64; 2]; ZONES],
) -> Rates {
    let mut per_s = [[0.0; NODES]; NODES];
    // The inverse of a node's length; a clamp has none.
    let per_length = |node: usize| match node {
        0 => ends.end_share / shrunk,
        CLAMP => 0.0,
        _ => 1.0 / lengths[node - 1],
    };
    for (z, [inner, outer]) in ways.iter().enumerate() {
        let rate = 1.0 / ((inner + outer) * tau_s);
        let next = (z + 1, per_length(z + 1));
        exchange(&mut per_s, (z, per_length(z)), next, rate);
    }
    // The clamp by itself: its rate less the 1/τ that every node has.
    let clamp_per_s = 1.0 / ends.clamp_s.max(SHORTEST_CLAMP_S);
    per_s[CLAMP][CLAMP] = clamp_per_s - 1.0 / tau_s;
    per_s[CLAMP][ZONES - 1] = -ends.clamp_warming * clamp_per_s;
    per_s
}

/// Adds what two nodes exchange; each comes with the inverse of its length.
fn exchange(per_s: &mut Rates, (i, of_i): (usize, f64), (j, of_j): (usize, f64), rate: f64) {
    per_s[i][i] += rate * of_i;
    per_s[i][j] -= rate * of_i;
    per_s[j][j] += rate * of_j;
    per_s[j][i] -= rate * of_j;
}
