use crate::L2pLoop;
use crate::error::{TruthError, within};

/// The transformation takes up enthalpy and gives it back.
///
/// ```text
/// E = T + (ΔH/C_p) ξ,     m C_p dE/dt = heating - losses
/// ```
///
/// The enthalpy E is integrated, and T follows from it on the branch. So energy is conserved by construction, whatever the
/// hysteresis, and no slope of a branch is needed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatentHeat {
    /// Enthalpy of transformation ΔH, J/kg; 0 to 60,000. Typical: 12,000.
    pub enthalpy_j_per_kg: f64,
}

/// Austenite becomes R-phase before it becomes martensite, in a narrow loop of its own.
///
/// ```text
/// stroke share = ξ a + (1 - r) ξ (1 - a)        a austenite share of what is not martensite, r share of R-strain
/// ```
///
/// Its loop hardly moves with stress, and its heat is left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RPhase {
    /// Strain of the R-phase over that of martensite r; 0 to 0.8. Typical: 0.15.
    pub strain_share: f64,
    /// Middle of its loop, °C; -50 to 200. Typical: between the branches of the main loop.
    pub center_degc: f64,
    /// Half width, K; 0.1 to 10. Typical: 1.5.
    pub half_width_k: f64,
    /// Spread, K; 0.1 to 20. Typical: 1.
    pub spread_k: f64,
}

/// Every transformation moves the loop and takes a little of the stroke, less and less.
///
/// ```text
/// s = 1 - exp(-n/n_0),   n = ½ ∫|dξ|;   ΔT = s ΔT_∞,   stroke → stroke (1 - s l_∞)
/// ```
///
/// Fatigue that comes about in a sample takes effect over the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fatigue {
    /// Shift of the loop in the end ΔT_∞, K; -30 to 30. Typical: -6.
    pub shift_k: f64,
    /// Loss of stroke in the end l_∞; 0 to 0.5. Typical: 0.05.
    pub stroke_loss: f64,
    /// Cycles after which 63 % has come n_0; 0.1 to 1e6. Typical: 5, a new wire.
    pub cycles: f64,
}

/// The branches of the loop spread differently.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopAsymmetry {
    /// Spread of the cooling branch over that of the heating branch; 0.2 to 5. Typical: 1.8.
    pub cooling_over_heating_spread: f64,
}

/// Both phases expand, martensite less. The rod becomes longer, which counts against the stroke.
///
/// ```text
/// u → u - L ((1 - ξ) α_M + ξ α_A) (T - T_0)
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThermalExpansion {
    /// Of martensite α_M, 1/K; 0 to 1e-4. Typical: 6.6e-6.
    pub martensite_per_k: f64,
    /// Of austenite α_A, 1/K; 0 to 1e-4. Typical: 11e-6.
    pub austenite_per_k: f64,
}

impl LatentHeat {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("enthalpy_j_per_kg", self.enthalpy_j_per_kg, 0.0..=6e4)
    }
}

impl RPhase {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("strain_share", self.strain_share, 0.0..=0.8)?;
        within("center_degc", self.center_degc, -50.0..=200.0)?;
        within("half_width_k", self.half_width_k, 0.1..=10.0)?;
        within("spread_k", self.spread_k, 0.1..=20.0)
    }

    pub(crate) fn narrow_loop(&self) -> L2pLoop {
        L2pLoop {
            loop_center_degc: self.center_degc,
            loop_half_width_k: self.half_width_k,
            loop_spread_k: self.spread_k,
            zeta: 1.0,
            cooling_over_heating_spread: 1.0,
            nested: true,
        }
    }
}

impl Fatigue {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("shift_k", self.shift_k, -30.0..=30.0)?;
        within("stroke_loss", self.stroke_loss, 0.0..=0.5)?;
        within("cycles", self.cycles, 0.1..=1e6)
    }

    /// s.
    pub(crate) fn share(&self, cycles: f64) -> f64 {
        -(-cycles / self.cycles).exp_m1()
    }
}

impl LoopAsymmetry {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within(
            "cooling_over_heating_spread",
            self.cooling_over_heating_spread,
            0.2..=5.0,
        )
    }
}

impl ThermalExpansion {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("martensite_per_k", self.martensite_per_k, 0.0..=1e-4)?;
        within("austenite_per_k", self.austenite_per_k, 0.0..=1e-4)
    }

    /// Strain at a temperature above that of the start.
    pub(crate) fn strain(&self, fraction: f64, warming_k: f64) -> f64 {
        let per_k =
            self.martensite_per_k + fraction * (self.austenite_per_k - self.martensite_per_k);
        per_k * warming_k
    }
}
