//! Parameters of other loop families beyond those of the paper's loop.

use wiener::hysteresis::LoopFamily;

use crate::{Bounds, ParameterInfo, Scale};

/// Name of the tails of a loop of relays.
pub(crate) const RELAY_TAILS: &str = "relay_tails";

/// Parameters of a family that the paper's loop does not have, behind those of the baseline model: of relays their tails, see
/// [`LoopFamily::Relays`]. None where a model file of an earlier version says nothing of them: they are 0 there.
#[must_use]
pub fn parameters_of_family(family: LoopFamily) -> Vec<ParameterInfo> {
    match family {
        LoopFamily::Proximity | LoopFamily::Kinetics => Vec::new(),
        LoopFamily::Relays => {
            let searched = Bounds {
                lower: 0.0,
                upper: 2.0,
            };
            let admissible = Bounds {
                lower: 0.0,
                upper: 4.0,
            };
            vec![ParameterInfo {
                admissible,
                ..ParameterInfo::searched(RELAY_TAILS, "1", Scale::Linear, searched)
            }]
        }
    }
}
