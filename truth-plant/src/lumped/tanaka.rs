use super::relays::RelayLoop;
use crate::error::{TruthError, within};

/// A temperature that is equal but for rounding, K.
const EQUAL_K: f64 = 1e-9;

/// Exponential kinetics: what is left of a phase transforms in proportion to the change of temperature.
///
/// ```text
/// heating above A_s:  dξ/dT = a (1 - ξ)          cooling below M_s:  dξ/dT = m ξ
/// ```
///
/// K. Tanaka: *A thermomechanical sketch of shape memory effect: one-dimensional tensile behavior*, Res Mechanica 18,
/// pp. 251-263, 1986; here in its rate form. A transformation that was left waits until the temperature at which it was
/// left, unless the other one has begun in between: partial cycles have no other memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TanakaLoop {
    /// Martensite start M_s, °C; -100 to 200.
    pub martensite_start_degc: f64,
    /// Rate of the transformation to martensite m, 1/K; 0.02 to 2.
    pub martensite_rate_per_k: f64,
    /// Austenite start A_s, °C; -100 to 200.
    pub austenite_start_degc: f64,
    /// Rate of the transformation to austenite a, 1/K; 0.02 to 2.
    pub austenite_rate_per_k: f64,
}

impl Default for TanakaLoop {
    fn default() -> Self {
        Self {
            martensite_start_degc: 54.0,
            martensite_rate_per_k: 0.2,
            austenite_start_degc: 62.0,
            austenite_rate_per_k: 0.2,
        }
    }
}

impl TanakaLoop {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        let start = -100.0..=200.0;
        within(
            "martensite_start_degc",
            self.martensite_start_degc,
            start.clone(),
        )?;
        within("austenite_start_degc", self.austenite_start_degc, start)?;
        within(
            "martensite_rate_per_k",
            self.martensite_rate_per_k,
            0.02..=2.0,
        )?;
        within(
            "austenite_rate_per_k",
            self.austenite_rate_per_k,
            0.02..=2.0,
        )
    }

    pub(crate) fn with_spread_ratio(self, ratio: f64) -> Self {
        Self {
            austenite_rate_per_k: self.austenite_rate_per_k * ratio.sqrt(),
            martensite_rate_per_k: self.martensite_rate_per_k / ratio.sqrt(),
            ..self
        }
    }

    /// Domains that transform over the same temperatures, and remember.
    pub(crate) fn remembering(self) -> RelayLoop {
        // An exponential's mean and deviation are both 1/rate.
        let [up_k, down_k] = [
            1.0 / self.austenite_rate_per_k,
            1.0 / self.martensite_rate_per_k,
        ];
        let cooling_center_degc = self.martensite_start_degc - down_k;
        RelayLoop {
            heating_center_degc: (self.austenite_start_degc + up_k).max(cooling_center_degc),
            heating_deviation_k: up_k.clamp(0.5, 40.0),
            cooling_center_degc,
            cooling_deviation_k: down_k.clamp(0.5, 40.0),
            correlation: 0.6,
            tails: 0.0,
        }
    }

    /// Kinetics that have cooled to a temperature from far above.
    pub(crate) fn cooled_to(self, temperature_degc: f64) -> Kinetics {
        Kinetics {
            law: self,
            fraction: self.cooled_fraction(temperature_degc),
            left_heating_degc: f64::NEG_INFINITY,
            left_cooling_degc: temperature_degc,
        }
    }

    fn cooled_fraction(&self, temperature_degc: f64) -> f64 {
        let below_k = (self.martensite_start_degc - temperature_degc).max(0.0);
        (-self.martensite_rate_per_k * below_k).exp()
    }
}

/// The law with what it remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Kinetics {
    law: TanakaLoop,
    /// At the end of the last step.
    pub(crate) fraction: f64,
    /// Where each transformation was left; infinite when the other has begun since.
    left_heating_degc: f64,
    left_cooling_degc: f64,
}

impl Kinetics {
    /// dξ/dT on heating or cooling through a temperature, 1/K.
    pub(crate) fn slope_per_k(
        &self,
        fraction: f64,
        temperature_degc: f64,
        is_heating: bool,
    ) -> f64 {
        let law = &self.law;
        let from_up = law.austenite_start_degc.max(self.left_heating_degc);
        let from_down = law.martensite_start_degc.min(self.left_cooling_degc);
        if is_heating && temperature_degc >= from_up - EQUAL_K {
            law.austenite_rate_per_k * (1.0 - fraction).max(0.0)
        } else if !is_heating && temperature_degc <= from_down + EQUAL_K {
            law.martensite_rate_per_k * fraction.max(0.0)
        } else {
            0.0
        }
    }

    /// A step has led to a fraction at a temperature.
    pub(crate) fn commit(&mut self, fraction: f64, temperature_degc: f64) {
        if fraction > self.fraction {
            (self.left_heating_degc, self.left_cooling_degc) = (temperature_degc, f64::INFINITY);
        } else if fraction < self.fraction {
            (self.left_heating_degc, self.left_cooling_degc) =
                (f64::NEG_INFINITY, temperature_degc);
        }
        self.fraction = fraction;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In small steps to a temperature.
    fn to(kinetics: &mut Kinetics, at_degc: &mut f64, goal_degc: f64) -> f64 {
        let n = 4_000;
        let step_k = (goal_degc - *at_degc) / f64::from(n);
        for _ in 0..n {
            let slope = kinetics.slope_per_k(kinetics.fraction, *at_degc, step_k > 0.0);
            *at_degc += step_k;
            kinetics.commit(kinetics.fraction + slope * step_k, *at_degc);
        }
        kinetics.fraction
    }

    #[test]
    fn full_branches_are_the_exponentials() {
        let (mut at, mut kinetics) = (20.0, TanakaLoop::default().cooled_to(20.0));
        let up = to(&mut kinetics, &mut at, 67.0);
        let left = kinetics.law.cooled_fraction(20.0);
        let expected = 1.0 - (1.0 - left) * (-1.0_f64).exp();
        assert!((up - expected).abs() < 2e-3, "{up} {expected}");
        to(&mut kinetics, &mut at, 140.0);
        let down = to(&mut kinetics, &mut at, 49.0);
        assert!((down - (-1.0_f64).exp()).abs() < 2e-3, "{down}");
    }

    #[test]
    fn an_excursion_in_which_nothing_transforms_leaves_no_trace() {
        let (mut at, mut kinetics) = (20.0, TanakaLoop::default().cooled_to(20.0));
        let before = to(&mut kinetics, &mut at, 66.0);
        to(&mut kinetics, &mut at, 56.0);
        let back = to(&mut kinetics, &mut at, 65.99);
        assert!((back - before).abs() < 1e-9);
    }
}
