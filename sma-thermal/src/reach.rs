use crate::error::{finite_degc, positive};
use crate::{HeatBalance, ThermalError};

/// A temperature to be reached in a given time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Temperature now `T_i`, °C.
    pub from_degc: f64,
    /// Temperature wanted T, °C.
    pub to_degc: f64,
    /// Temperature of the surroundings `T_a`, °C.
    pub ambient_degc: f64,
    /// Time allowed t, s; > 0.
    pub within_s: f64,
}

impl HeatBalance<1> {
    /// Constant current that brings the rod to a temperature in a given time, A; ≥ 0.
    ///
    /// ```text
    /// i = sqrt(((T - T_a) - (T_i - T_a) e^(-t/τ)) / (λ (1 - e^(-t/τ))))     [Sadeghi, eq. 3]
    ///   = sqrt(((T - T_i) + (T_i - T_a) a) / (λ a)),   a = 1 - e^(-t/τ)
    /// ```
    ///
    /// The inverse of eq. 2. The second form keeps its digits for t far below τ, where the first
    /// subtracts nearly equal temperatures.
    ///
    /// # Errors
    ///
    /// A negative radicand: [`ThermalError::CannotCool`], or [`ThermalError::BelowAmbient`] where no
    /// other time would help. [`ThermalError::NotFinite`] for a temperature, [`ThermalError::NotPositive`]
    /// for the time.
    pub fn current_to_reach_a(&self, reach: &Reach) -> Result<f64, ThermalError> {
        let from_degc = finite_degc("from_degc", reach.from_degc)?;
        let to_degc = finite_degc("to_degc", reach.to_degc)?;
        let ambient_degc = finite_degc("ambient_degc", reach.ambient_degc)?;
        let within_s = positive("within_s", reach.within_s, "s")?;
        let [tau_s] = self.tau_s();
        let retained = libm::exp(-within_s / tau_s);
        let approached = -libm::expm1(-within_s / tau_s);
        let heated_k = (to_degc - from_degc) + (from_degc - ambient_degc) * approached;
        let coolest_degc = ambient_degc + (from_degc - ambient_degc) * retained;
        // The same but for rounding, which may refuse nothing that is just reached.
        if heated_k < 0.0 && to_degc < coolest_degc {
            return Err(if to_degc < ambient_degc && to_degc <= from_degc {
                ThermalError::BelowAmbient {
                    to_degc,
                    ambient_degc,
                }
            } else {
                ThermalError::CannotCool {
                    to_degc,
                    within_s,
                    coolest_degc,
                }
            });
        }
        let [lambda_k_per_a2] = self.lambda_k_per_a2();
        Ok(libm::sqrt(
            heated_k.max(0.0) / (lambda_k_per_a2 * approached),
        ))
    }
}
