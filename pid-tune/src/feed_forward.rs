use wiener::thermal::{HeatBalance, Reach, ThermalError};

use crate::TuneError;

/// Current that brings a rod to a temperature in a given time, A; 0 where it cannot cool that fast.
///
/// [`HeatBalance::current_to_reach_a`] (`[Sadeghi, eq. 3]`), for the `feed_forward` of a
/// [`Sample`](crate::Sample) or a [`ClosedLoop`](crate::ClosedLoop). From a temperature to itself it is the
/// current that holds it, whatever the time:
///
/// ```text
/// i = sqrt((T - T_a)/λ)
/// ```
///
/// Which temperature an output needs is a matter of the rod's past; the limiting curve of the direction in
/// which it moves is a start, and the controller does the rest.
///
/// # Errors
///
/// [`TuneError::Thermal`] for a temperature that is not finite or a time that is not finite and > 0.
pub fn feed_forward_a(heat: &HeatBalance, reach: &Reach) -> Result<f64, TuneError> {
    match heat.current_to_reach_a(reach) {
        Err(ThermalError::CannotCool { .. } | ThermalError::BelowAmbient { .. }) => Ok(0.0),
        current_a => Ok(current_a?),
    }
}
