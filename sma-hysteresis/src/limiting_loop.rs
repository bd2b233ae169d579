use core::f64::consts::{FRAC_2_PI, FRAC_PI_2};
use core::fmt;

use crate::HysteresisError;
use crate::elementary::atan_quotient;
use crate::error::{finite, positive_k};

/// Direction of the temperature, δ = sign(dT/dt), and with it the limiting curve that applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branch {
    /// Temperature rises, δ = +1.
    Heating,
    /// Temperature falls, δ = -1.
    Cooling,
}

impl Branch {
    /// δ: +1 on heating, -1 on cooling.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Branch::Heating => 1.0,
            Branch::Cooling => -1.0,
        }
    }
}

impl fmt::Display for Branch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Branch::Heating => "heating",
            Branch::Cooling => "cooling",
        })
    }
}

/// Shape of the limiting loop of one material.
///
/// The default is a wire of medium transformation temperature; give your own center and widths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopParams {
    /// Middle of the loop `T_mid`, °C.
    pub loop_center_degc: f64,
    /// Half of the loop's width `T_c`, K; > 0.
    pub loop_half_width_k: f64,
    /// Spread of the transformation over temperature `h_0`, K; > 0.
    pub loop_spread_k: f64,
    /// Fraction in the middle of the loop `ξ_0`; ½ for a fraction from 0 to 1.
    pub fraction_center: f64,
    /// Half of the loop's height `ξ_s`, not 0; ½ for the transformed (austenite) fraction, -½ for the
    /// martensite fraction, which falls on heating.
    pub fraction_swing: f64,
}

impl Default for LoopParams {
    fn default() -> Self {
        Self {
            loop_center_degc: 70.0,
            loop_half_width_k: 10.0,
            loop_spread_k: 5.0,
            fraction_center: 0.5,
            fraction_swing: 0.5,
        }
    }
}

/// The limiting loop of `L` materials side by side.
///
/// ```text
/// ξ = F(T, δ) = (2 ξ_s/π) atan((T - T_mid - δ T_c)/h_0) + ξ_0     [Sadeghi, eq. 4]
/// T_L = T_mid + h_0 tan(π (ξ - ξ_0)/(2 ξ_s)) + δ T_c              [Sadeghi, eq. 6]
/// ```
///
/// Both curves are one function of the *anhysteretic temperature* `T - T_mid - δ T_c`: the
/// temperature at which a loop of zero width would have this fraction. The operator remembers that
/// temperature, and no `tan` is needed at a reversal. With [`LimitingLoop::with_asymmetry`] it is
/// (T - T_mid - δ T_c)/k_δ.
///
/// # Differs from the source
///
/// The source's T is relative to the middle of the loop; here it is in °C and `T_mid` is a
/// parameter. Eq. 6 is printed without `ξ_0`: with it, eqs 4 and 6 are inverse to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitingLoop<const L: usize> {
    center_degc: [f64; L],
    half_width_k: [f64; L],
    spread_k: [f64; L],
    fraction_center: [f64; L],
    /// 2 ξ_s/π.
    fraction_per_radian: [f64; L],
    /// k_δ on heating and on cooling.
    widening: [[f64; L]; 2],
}

impl<const L: usize> LimitingLoop<L> {
    /// Checks the parameters of each lane.
    ///
    /// # Errors
    ///
    /// [`HysteresisError::NotPositive`] for a width that is not finite and > 0, [`HysteresisError::Width`] for one of no loop,
    /// [`HysteresisError::NotFinite`] for a center, [`HysteresisError::NoSwing`] for `ξ_s` = 0.
    pub fn new(lanes: [LoopParams; L]) -> Result<Self, HysteresisError> {
        for lane in &lanes {
            finite("loop_center_degc", lane.loop_center_degc, "°C")?;
            positive_k("loop_half_width_k", lane.loop_half_width_k)?;
            positive_k("loop_spread_k", lane.loop_spread_k)?;
            finite("fraction_center", lane.fraction_center, "(fraction)")?;
            if !(lane.fraction_swing.is_finite() && lane.fraction_swing.abs() > 0.0) {
                return Err(HysteresisError::NoSwing {
                    value: lane.fraction_swing,
                });
            }
        }
        Ok(Self {
            center_degc: lanes.each_ref().map(|lane| lane.loop_center_degc),
            half_width_k: lanes.each_ref().map(|lane| lane.loop_half_width_k),
            spread_k: lanes.each_ref().map(|lane| lane.loop_spread_k),
            fraction_center: lanes.each_ref().map(|lane| lane.fraction_center),
            fraction_per_radian: lanes.each_ref().map(|lane| FRAC_2_PI * lane.fraction_swing),
            widening: [[1.0; L]; 2],
        })
    }

    /// The loop with branches of different spreads, not in the paper: relative differences a of each lane.
    ///
    /// ```text
    /// ξ = F(T, δ) with h_0 k_δ in place of h_0,   k_δ = 1 - δ a
    /// ```
    ///
    /// Where the two curves cross, far from the middle, a branch that starts beyond its own curve comes back to it as
    /// one from within does.
    ///
    /// **The fraction jumps** at some reversals of an asymmetric loop, which no branch that is as steep as its limiting curve
    /// can lead to: kinetics where |a| ≥ T_c/(2.25 h_0), since their curves cross where a transformation is under way; and
    /// [`Rule::Nested`](crate::Rule::Nested) at the return point of a minor loop whose other branch is steeper.
    ///
    /// # Errors
    ///
    /// [`HysteresisError::Asymmetry`] unless |a| < 1.
    pub fn with_asymmetry(mut self, asymmetry: [f64; L]) -> Result<Self, HysteresisError> {
        if let Some(value) = asymmetry
            .into_iter()
            .find(|value| value.is_nan() || value.abs() >= 1.0)
        {
            return Err(HysteresisError::Asymmetry { value });
        }
        self.widening = [asymmetry.map(|a| 1.0 - a), asymmetry.map(|a| 1.0 + a)];
        Ok(self)
    }

    /// Fraction on a limiting curve, eq. 4.
    #[must_use]
    pub fn fraction(&self, branch: Branch, temperature_degc: [f64; L]) -> [f64; L] {
        core::array::from_fn(|l| {
            let sign = branch.sign();
            let level_k = self.limiting_level_k(l, sign, self.relative_k(l, temperature_degc[l]));
            self.fraction_at(l, level_k)
        })
    }

    /// Temperature at which a limiting curve has a fraction, °C, eq. 6: the inverse of
    /// [`LimitingLoop::fraction`].
    ///
    /// # Errors
    ///
    /// [`HysteresisError::Unreachable`] for a fraction on or beyond the curve's asymptotes, or NaN.
    pub fn temperature_degc(
        &self,
        branch: Branch,
        fraction: [f64; L],
    ) -> Result<[f64; L], HysteresisError> {
        let mut temperature_degc = [0.0; L];
        for l in 0..L {
            let level_k = self.level_of(l, branch, fraction[l])?;
            let own_k = level_k * self.widening(l, branch.sign());
            temperature_degc[l] =
                self.center_degc[l] + own_k + branch.sign() * self.half_width_k[l];
        }
        Ok(temperature_degc)
    }

    /// T̂ = T - T_mid, K.
    #[inline(always)]
    pub(crate) fn relative_k(&self, lane: usize, temperature_degc: f64) -> f64 {
        temperature_degc - self.center_degc[lane]
    }

    /// T_mid + T̂, °C.
    pub(crate) fn absolute_degc(&self, lane: usize, relative_k: f64) -> f64 {
        self.center_degc[lane] + relative_k
    }

    #[inline(always)]
    pub(crate) fn half_width_k(&self, lane: usize) -> f64 {
        self.half_width_k[lane]
    }

    #[inline(always)]
    pub(crate) fn spread_k(&self, lane: usize) -> f64 {
        self.spread_k[lane]
    }

    /// k_δ.
    #[inline(always)]
    pub(crate) fn widening(&self, lane: usize, sign: f64) -> f64 {
        let [heating, cooling] = &self.widening;
        if sign > 0.0 {
            heating[lane]
        } else {
            cooling[lane]
        }
    }

    /// Anhysteretic temperature on a limiting curve.
    pub(crate) fn limiting_level_k(&self, lane: usize, sign: f64, relative_k: f64) -> f64 {
        (relative_k - sign * self.half_width_k[lane]) / self.widening(lane, sign)
    }

    /// Fraction at an anhysteretic temperature.
    #[inline(always)]
    pub(crate) fn fraction_at(&self, lane: usize, level_k: f64) -> f64 {
        self.fraction_per_radian[lane] * atan_quotient(level_k, self.spread_k[lane])
            + self.fraction_center[lane]
    }

    /// Derivative of [`LimitingLoop::fraction_at`], 1/K.
    #[inline(always)]
    pub(crate) fn fraction_slope_at(&self, lane: usize, level_k: f64) -> f64 {
        let spread_k = self.spread_k[lane];
        self.fraction_per_radian[lane] * spread_k / (spread_k * spread_k + level_k * level_k)
    }

    /// Fraction where a share of the material has transformed, and how much it changes with the share.
    #[inline(always)]
    pub(crate) fn fraction_of_share(&self, lane: usize, share: f64) -> (f64, f64) {
        let swing = FRAC_PI_2 * self.fraction_per_radian[lane];
        (
            self.fraction_center[lane] + swing * (2.0 * share - 1.0),
            2.0 * swing,
        )
    }

    /// Anhysteretic temperature of a fraction; `branch` only names the curve in the error.
    pub(crate) fn level_of(
        &self,
        lane: usize,
        branch: Branch,
        fraction: f64,
    ) -> Result<f64, HysteresisError> {
        let radian = (fraction - self.fraction_center[lane]) / self.fraction_per_radian[lane];
        if radian.abs() < FRAC_PI_2 {
            Ok(self.spread_k[lane] * libm::tan(radian))
        } else {
            let swing = FRAC_PI_2 * self.fraction_per_radian[lane].abs();
            Err(HysteresisError::Unreachable {
                value: fraction,
                branch,
                lower: self.fraction_center[lane] - swing,
                upper: self.fraction_center[lane] + swing,
            })
        }
    }
}
