use crate::{CostWeights, TuneError};

/// Decades by which [`Pace`] shifts a weight from its middle to an end.
const DECADES: f64 = 0.5;

/// A knob from gentle (0) over balanced (½) to fast (1).
///
/// It shifts the weights of eq. 13 by up to half a decade, and so the two kinds by a decade against each other:
///
/// ```text
/// MSE, rise time, settling time:  w 10^(pace - ½)
/// energy, overshoot:              w 10^(½ - pace)
/// ```
///
/// Half a decade is our own choice. Most of the energy is what holds the output where it shall be: with weights
/// another half decade apart, standing still is the cheapest response of a slow rod (`examples/paper_rods.rs`),
/// and with any weights it gets cheap in a run that is not long compared with the rise.
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
        let faster = libm::exp10(DECADES * (2.0 * self.0 - 1.0));
        CostWeights {
            mse: balanced.mse * faster,
            rise_time: balanced.rise_time * faster,
            settling_time: balanced.settling_time * faster,
            energy: balanced.energy / faster,
            overshoot: balanced.overshoot / faster,
        }
    }
}
