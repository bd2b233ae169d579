//! Parameters of other loop families beyond those of the paper's loop.

use wiener::hysteresis::LoopFamily;

use crate::{Bounds, ParameterInfo, Scale};

/// Names of the parameters that are the shape of a loop of relays or kinetics.
pub const SHAPE_PARAMETERS: [&str; 4] = [
    "branch_asymmetry",
    "loop_bend_1",
    "loop_bend_2",
    "loop_bend_3",
];

/// Ends of these parameters. Bends within them let no slope turn its sign, and with such asymmetries both branches hardly ever
/// cross.
const SHAPE_ENDS: [[f64; 2]; 4] = [
    [-0.3, 0.3],
    [-0.333, 0.333],
    [-0.333, 0.666],
    [-0.333, 0.333],
];

/// Name of the tails of a loop of relays.
const RELAY_TAILS: &str = "relay_tails";

/// True if a loop of another family has a parameter that the paper's loop does not have.
pub(crate) fn is_of_family(name: &str) -> bool {
    SHAPE_PARAMETERS.contains(&name) || name == RELAY_TAILS
}

/// Parameters of a family that the paper's loop does not have, behind those of the baseline model: of a loop of relays or kinetics
/// the difference of its branches' spreads ([`LimitingLoop::with_asymmetry`](wiener::hysteresis::LimitingLoop::with_asymmetry)) and
/// three bends ([`Hysteresis::with_bends`](wiener::hysteresis::Hysteresis::with_bends)), and of relays their tails
/// ([`LoopFamily::Relays`]). In files of earlier versions, which lack some of them, these are 0.
#[must_use]
pub fn parameters_of_family(family: LoopFamily) -> Vec<ParameterInfo> {
    let searched = |name, [lower, upper]: [f64; 2]| {
        ParameterInfo::searched(name, "1", Scale::Linear, Bounds { lower, upper })
    };
    let shape = SHAPE_PARAMETERS.iter().zip(SHAPE_ENDS);
    let shape = shape.map(|(name, ends)| searched(name, ends));
    match family {
        LoopFamily::Proximity => Vec::new(),
        LoopFamily::Kinetics => shape.collect(),
        LoopFamily::Relays => {
            let admissible = Bounds {
                lower: 0.0,
                upper: 4.0,
            };
            let tails = ParameterInfo {
                admissible,
                ..searched(RELAY_TAILS, [0.0, 2.0])
            };
            shape.chain([tails]).collect()
        }
    }
}
