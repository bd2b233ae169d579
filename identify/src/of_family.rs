//! Parameters of other loop families beyond those of the paper's loop.

use wiener::hysteresis::LoopFamily;

use crate::{Bounds, ParameterInfo, Scale};

/// Names of those of them that are the shape of a loop of relays or kinetics.
pub const SHAPE_PARAMETERS: [&str; 4] = [
    FAMILY_PARAMETERS[0],
    FAMILY_PARAMETERS[1],
    FAMILY_PARAMETERS[2],
    FAMILY_PARAMETERS[3],
];

/// Names of the parameters that a loop of another family has beyond those of the paper's loop.
pub(crate) const FAMILY_PARAMETERS: [&str; 5] = [
    "branch_asymmetry",
    "loop_bend_1",
    "loop_bend_2",
    "loop_bend_3",
    "relay_tails",
];

/// Admissible ends of these parameters, and, within them, those that are searched. Bends within them let no slope turn its sign, and with such asymmetries both branches hardly ever cross.
const ENDS: [[[f64; 2]; 2]; 5] = [
    [[-0.3, 0.3], [-0.3, 0.3]],
    [[-0.333, 0.333], [-0.333, 0.333]],
    [[-0.333, 0.666], [-0.333, 0.666]],
    [[-0.333, 0.333], [-0.333, 0.333]],
    [[0.0, 4.0], [0.0, 2.0]],
];

/// Parameters of a family that the paper's loop does not have, behind those of the baseline model: of a loop of relays or kinetics
/// the difference of its branches' spreads ([`LimitingLoop::with_asymmetry`](wiener::hysteresis::LimitingLoop::with_asymmetry)) and
/// three bends ([`Hysteresis::with_bends`](wiener::hysteresis::Hysteresis::with_bends)), and of relays their tails
/// ([`LoopFamily::Relays`]). In files of earlier versions, which lack some of them, these are 0.
#[must_use]
pub fn parameters_of_family(family: LoopFamily) -> Vec<ParameterInfo> {
    let count = match family {
        LoopFamily::Proximity => 0,
        LoopFamily::Kinetics => 4,
        LoopFamily::Relays => 5,
    };
    let of = |(name, ends): (&&'static str, &[[f64; 2]; 2])| {
        let [admissible, searched] = ends.map(|[lower, upper]| Bounds { lower, upper });
        ParameterInfo {
            admissible,
            ..ParameterInfo::searched(name, "1", Scale::Linear, searched)
        }
    };
    let all = FAMILY_PARAMETERS.iter().zip(&ENDS);
    all.take(count).map(of).collect()
}
