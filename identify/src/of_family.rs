//! Parameters of other loop families beyond those of the paper's loop.

use wiener::hysteresis::LoopFamily;

use crate::{Bounds, ParameterInfo, Scale};

/// Names of the parameters that are the shape of a loop of relays or kinetics.
pub const SHAPE_PARAMETERS: [&str; 3] = ["loop_bend_1", "loop_bend_2", "loop_bend_3"];

/// Ends of these parameters. Bends within them let no slope turn its sign.
const SHAPE_ENDS: [[f64; 2]; 3] = [[-0.333, 0.333], [-0.333, 0.666], [-0.333, 0.333]];

/// Name of the tails of a loop of relays.
const RELAY_TAILS: &str = "relay_tails";

/// Name of the sharpness with which kinetics set in.
pub const ONSET_SHARPNESS: &str = "onset_sharpness";

/// Names of the parameters that are a second population of relays, in the order of
/// [`SecondPopulation`](wiener::hysteresis::SecondPopulation).
pub const SECOND_POPULATION_PARAMETERS: [&str; 5] = [
    "second_share",
    "second_shift",
    "second_log_half_width",
    "second_log_spread",
    "second_zeta_difference",
];

/// Ends of these parameters: the second population is the smaller one, and lies where the first has relays, too, or next to them. The
/// operator itself takes more.
const SECOND_POPULATION_ENDS: [[f64; 2]; 5] = [
    [0.0, 0.5],
    [-4.0, 4.0],
    [-1.5, 1.5],
    [-1.5, 1.5],
    [-1.0, 1.0],
];

/// True if a loop of another family has a parameter that the paper's loop does not have.
#[must_use]
pub fn is_of_family(name: &str) -> bool {
    SHAPE_PARAMETERS.contains(&name)
        || [RELAY_TAILS, ONSET_SHARPNESS].contains(&name)
        || SECOND_POPULATION_PARAMETERS.contains(&name)
}

/// Parameters of a family that the paper's loop does not have, behind those of the baseline model: of a loop of relays or kinetics
/// three bends ([`Hysteresis::with_bends`](wiener::hysteresis::Hysteresis::with_bends)), of kinetics the sharpness of their onset
/// ([`LoopFamily::Kinetics`]), and of relays their tails ([`LoopFamily::Relays`]) and a second population of them
/// ([`SecondPopulation`](wiener::hysteresis::SecondPopulation)). In files of earlier versions, which lack some of them, these are 0.
#[must_use]
pub fn parameters_of_family(family: LoopFamily) -> Vec<ParameterInfo> {
    let searched = |name, [lower, upper]: [f64; 2]| {
        ParameterInfo::searched(name, "1", Scale::Linear, Bounds { lower, upper })
    };
    let shape = SHAPE_PARAMETERS.iter().zip(SHAPE_ENDS);
    let shape = shape.map(|(name, ends)| searched(name, ends));
    match family {
        LoopFamily::Proximity => Vec::new(),
        LoopFamily::Kinetics => shape
            .chain([searched(ONSET_SHARPNESS, [0.0, 1.0])])
            .collect(),
        LoopFamily::Relays => {
            let admissible = Bounds {
                lower: 0.0,
                upper: 4.0,
            };
            let tails = ParameterInfo {
                admissible,
                ..searched(RELAY_TAILS, [0.0, 2.0])
            };
            let second = SECOND_POPULATION_PARAMETERS
                .iter()
                .zip(SECOND_POPULATION_ENDS);
            let second = second.map(|(name, ends)| searched(name, ends));
            shape.chain([tails]).chain(second).collect()
        }
    }
}
