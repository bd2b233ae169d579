use crate::{CostWeights, TuneError};

/// Decades by which the weights are shifted at the gentle end, and at the fast one.
const DECADES: [f64; 2] = [0.5, 1.0];

/// A knob from gentle (0) over balanced (½) to fast (1): how much more than balanced do time and error count?
///
/// ```text
/// MSE, rise time, settling time:  w 10^s     s = ½ (2 pace - 1) below ½, 2 pace - 1 above
/// energy, overshoot:              w 10^-s
/// ```
///
/// The faster, the less the best controller has of the first three terms of eq. 13, weighed and summed, and the
/// more of the other two; one term by itself may go the other way. A response that starts with a saturated
/// drive and ends without an overshoot can hardly be better in either: then the knob has little to choose from.
///
/// The decades are our own choice. Most of the energy is what holds the output where it shall be: with a whole
/// decade at the gentle end, standing still is the cheapest response of a slow rod
/// (`examples/paper_rods.rs`), and with any weights it gets cheap in a run that is not long compared with the rise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace(f64);

impl Pace {
    /// ½: leaves the weights as they are.
    pub const BALANCED: Self = Self(0.5);

    /// Accepts 0 to 1.
    ///
    /// # Errors
    ///
    /// [`TuneError::Pace`] for anything else.
    pub fn new(pace: f64) -> Result<Self, TuneError> {
        if (0.0..=1.0).contains(&pace) {
            Ok(Self(pace))
        } else {
            Err(TuneError::Pace { value: pace })
        }
    }

    /// The weights for this pace, from balanced ones.
    #[must_use]
    pub fn weigh(self, balanced: &CostWeights) -> CostWeights {
        let [gentle, fast] = DECADES;
        let decades = if self.0 < 0.5 { gentle } else { fast };
        let faster = libm::exp10(decades * (2.0 * self.0 - 1.0));
        CostWeights {
            mse: balanced.mse * faster,
            rise_time: balanced.rise_time * faster,
            settling_time: balanced.settling_time * faster,
            energy: balanced.energy / faster,
            overshoot: balanced.overshoot / faster,
        }
    }
}
