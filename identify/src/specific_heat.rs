//! How an uncertain heat capacity widens what is said of temperatures.

use crate::{Bounds, Fit, FittedParameter, ParameterState, Rod};

/// The temperatures of a model whose differences scale with that of the rod: those above ambient, then
/// those that are differences.
const CENTERS: [&str; 2] = ["loop_center_degc", "antagonist_center_degc"];
const DIFFERENCES: [&str; 7] = [
    "loop_half_width_k",
    "loop_spread_k",
    "start_rise_k",
    "start_since_reversal_k",
    "antagonist_half_width_k",
    "antagonist_spread_k",
    "antagonist_start_rise_k",
];

/// A specific heat and the range that the rod file gives it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpecificHeat {
    value: f64,
    range: Bounds,
    ambient_degc: f64,
}

impl SpecificHeat {
    /// `None` if the rod file gives no range, or not all that makes temperatures known.
    pub(crate) fn of(rod: &Rod, ambient_degc: f64) -> Option<Self> {
        rod.material()?;
        Some(Self {
            value: rod.specific_heat_j_per_kg_k?,
            range: rod.specific_heat_range?,
            ambient_degc,
        })
    }

    /// Widens the intervals of temperatures to hold for the whole range.
    ///
    /// ```text
    /// T - T_a ∝ R i² τ/(m C_p):   all temperature differences times C_p0/C_p give the same displacement
    /// ```
    ///
    /// Nothing is widened where a recorded temperature fixes the scale, or where one of the temperatures is
    /// fixed and the others could not follow. Returns whether it was.
    pub(crate) fn widen(self, fit: &mut Fit) -> bool {
        let follows = |parameter: &FittedParameter| {
            let name = parameter.info.name;
            !(CENTERS.contains(&name) || DIFFERENCES.contains(&name))
                || parameter.info.state == ParameterState::Free
                // A start at ambient stays there.
                || parameter.info.state == ParameterState::Fixed(0.0)
        };
        if fit.temperature_rmse_k.is_some() || !fit.parameters.iter().all(follows) {
            return false;
        }
        let factors = [self.value / self.range.upper, self.value / self.range.lower];
        for parameter in &mut fit.parameters {
            let zero = match parameter.info.name {
                name if CENTERS.contains(&name) => self.ambient_degc,
                name if DIFFERENCES.contains(&name) => 0.0,
                _ => continue,
            };
            for interval in parameter.intervals.iter_mut().flatten() {
                // Below zero the larger factor makes the lower end.
                let end = |end: f64, choose: fn(f64, f64) -> f64| {
                    zero + choose((end - zero) * factors[0], (end - zero) * factors[1])
                };
                *interval = Bounds {
                    lower: end(interval.lower, f64::min),
                    upper: end(interval.upper, f64::max),
                };
            }
        }
        true
    }
}
