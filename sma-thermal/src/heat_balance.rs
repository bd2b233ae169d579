use crate::ThermalError;
use crate::error::positive;

/// Coefficients of eq. 1, each per meter of rod.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeatBalanceParams {
    /// Heat capacity `m C_p`, J/(m K); > 0.
    pub heat_capacity_j_per_m_k: f64,
    /// Conductance to the surroundings h A, W/(m K); > 0.
    pub conductance_w_per_m_k: f64,
    /// Resistance R, Ω/m; > 0.
    pub resistance_ohm_per_m: f64,
}

impl HeatBalanceParams {
    /// The heat balance with a time constant τ, s, and a current constant λ, K/A², where neither the
    /// capacity nor the resistance is known.
    ///
    /// Temperatures depend on τ and λ alone; the conductance is set to 1 W/(m K), so that powers
    /// come out in units of it.
    #[must_use]
    pub fn from_constants(constants: ThermalConstants) -> Self {
        Self {
            heat_capacity_j_per_m_k: constants.tau_s,
            conductance_w_per_m_k: 1.0,
            resistance_ohm_per_m: constants.lambda_k_per_a2,
        }
    }
}

/// The two constants of eq. 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThermalConstants {
    /// Time constant τ = m C_p/(h A), s; > 0.
    pub tau_s: f64,
    /// Current constant λ = R/(h A), K/A²; > 0: the steady rise above ambient per square ampere.
    pub lambda_k_per_a2: f64,
}

/// Heat balance of `L` rods side by side, each of uniform temperature, heated by its own resistance.
///
/// ```text
/// m C_p dT/dt = i² R - h A (T - T_a)     [Sadeghi, eq. 1]
/// τ = m C_p/(h A),   λ = R/(h A)         [Sadeghi, under eq. 2]
/// ```
///
/// Left out: radiation, latent heat, conduction along the rod and into the clamps, a resistance or
/// convective coefficient that changes.
///
/// # Differs from the source
///
/// Eq. 1 is printed as two cases; cooling is the first with i = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct HeatBalance<const L: usize = 1> {
    tau_s: [f64; L],
    /// 1/(h A): one multiplication a sample instead of a division.
    rise_k_m_per_w: [f64; L],
    resistance_ohm_per_m: [f64; L],
}

/// Decay of a temperature difference over one sample. Made by [`HeatBalance::over`], once for a fixed
/// sample time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Sample<const L: usize = 1> {
    dt_s: f64,
    /// Time constants that it was made for.
    tau_s: [f64; L],
    /// e^(-dt/τ), the share of a difference that is left.
    retained: [f64; L],
}

impl<const L: usize> Sample<L> {
    /// Length of the sample, s.
    #[inline(always)]
    #[must_use]
    pub fn dt_s(&self) -> f64 {
        self.dt_s
    }

    /// True if [`HeatBalance::over`] makes this sample of this heat balance and time. A caller can keep the
    /// sample while neither changes.
    #[inline(always)]
    #[must_use]
    pub fn is_of(&self, heat: &HeatBalance<L>, dt_s: f64) -> bool {
        // Bits, because NaN is unequal to itself; all lanes, because a branch in each costs more.
        let mut difference = self.dt_s.to_bits() ^ dt_s.to_bits();
        for l in 0..L {
            difference |= self.tau_s[l].to_bits() ^ heat.tau_s[l].to_bits();
        }
        difference == 0
    }
}

/// Inputs that act on the rods during one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heating<const L: usize = 1> {
    /// Heating power i² R, W/m.
    pub power_w_per_m: [f64; L],
    /// Temperature of the surroundings `T_a`, °C.
    pub ambient_degc: f64,
}

impl<const L: usize> HeatBalance<L> {
    /// Checks the parameters of each lane.
    ///
    /// # Errors
    ///
    /// [`ThermalError::NotPositive`] for a value that is not finite and > 0.
    pub fn new(lanes: [HeatBalanceParams; L]) -> Result<Self, ThermalError> {
        for lane in &lanes {
            positive(
                "heat_capacity_j_per_m_k",
                lane.heat_capacity_j_per_m_k,
                "J/(m K)",
            )?;
            positive(
                "conductance_w_per_m_k",
                lane.conductance_w_per_m_k,
                "W/(m K)",
            )?;
            positive("resistance_ohm_per_m", lane.resistance_ohm_per_m, "Ω/m")?;
        }
        Ok(Self {
            tau_s: lanes
                .each_ref()
                .map(|lane| lane.heat_capacity_j_per_m_k / lane.conductance_w_per_m_k),
            rise_k_m_per_w: lanes
                .each_ref()
                .map(|lane| 1.0 / lane.conductance_w_per_m_k),
            resistance_ohm_per_m: lanes.each_ref().map(|lane| lane.resistance_ohm_per_m),
        })
    }

    /// Time constant τ, s.
    #[must_use]
    pub fn tau_s(&self) -> [f64; L] {
        self.tau_s
    }

    /// Current constant λ, K/A².
    #[must_use]
    pub fn lambda_k_per_a2(&self) -> [f64; L] {
        core::array::from_fn(|l| self.resistance_ohm_per_m[l] * self.rise_k_m_per_w[l])
    }

    /// Resistance R, Ω/m.
    #[inline(always)]
    #[must_use]
    pub fn resistance_ohm_per_m(&self) -> [f64; L] {
        self.resistance_ohm_per_m
    }

    /// Prepares a sample of `dt_s` ≥ 0 seconds; 0 leaves every temperature as it
    /// is, up to rounding; `NaN` gives `NaN`.
    #[must_use]
    pub fn over(&self, dt_s: f64) -> Sample<L> {
        Sample {
            dt_s,
            tau_s: self.tau_s,
            retained: self.tau_s.map(|tau_s| libm::exp(-dt_s / tau_s)),
        }
    }

    /// Temperature after one sample of constant heating, °C, exactly.
    ///
    /// ```text
    /// T - T_a = (T_i - T_a) e^(-t/τ) + i² λ (1 - e^(-t/τ))     [Sadeghi, eq. 2]
    /// ```
    ///
    /// A rod in balance stays there to the last bit.
    ///
    /// # Differs from the source
    ///
    /// Eq. 2 is printed for "the rod maximum temperature" in two cases; it is the temperature at any
    /// time, and cooling is i = 0.
    #[inline(always)]
    #[must_use]
    pub fn step(
        &self,
        temperature_degc: [f64; L],
        heating: &Heating<L>,
        sample: &Sample<L>,
    ) -> [f64; L] {
        let mut next_degc = [0.0; L];
        for l in 0..L {
            let steady_rise_k = heating.power_w_per_m[l] * self.rise_k_m_per_w[l];
            let balance_degc = heating.ambient_degc + steady_rise_k;
            next_degc[l] = balance_degc + (temperature_degc[l] - balance_degc) * sample.retained[l];
        }
        next_degc
    }

    /// How much warmer one more watt per meter makes the rod within one sample, K m/W: for the Newton
    /// step of a heating power that depends on the temperature at the end of the sample.
    ///
    /// ```text
    /// dT/dP = (1 - e^(-t/τ))/(h A)     (derivative of HeatBalance::step)
    /// ```
    ///
    /// From 0 for no time to 1/(h A) for a long one; the start does not count.
    #[inline(always)]
    #[must_use]
    pub fn sensitivity_k_m_per_w(&self, sample: &Sample<L>) -> [f64; L] {
        let mut sensitivity = [0.0; L];
        for l in 0..L {
            sensitivity[l] = self.rise_k_m_per_w[l] * (1.0 - sample.retained[l]);
        }
        sensitivity
    }
}
