use crate::Rod;
use crate::error::{TruthError, within};

/// A spring that pulls the rod back.
///
/// ```text
/// F = F_0 + K x,     x = u - (F - F_0)/k_r
/// ```
///
/// u is the stroke under the preload alone, k_r the rod's own stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BiasSpring {
    /// Stiffness K, N/m; 0 to 1e7.
    pub stiffness_n_per_m: f64,
    /// Force at the start of the stroke F_0, N; 0 to 1e5.
    pub preload_n: f64,
}

/// Clausius–Clapeyron: stress raises the temperatures of transformation.
///
/// ```text
/// ΔT = (F - F_0)/(A C)
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StressCoupling {
    /// Rise of the stress over that of the temperatures C, Pa/K; 1e6 to 5e7. Typical: 7e6.
    pub clausius_clapeyron_pa_per_k: f64,
}

/// The moving end meets a stop that gives way elastically.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndStop {
    /// Where it stands in the stroke, m; -1 to 1. Typical: 80 % of the stroke.
    pub position_m: f64,
    /// Stiffness of the contact, N/m; 0 to 1e9. Typical: ten times the rod's.
    pub contact_stiffness_n_per_m: f64,
}

/// The spring becomes another in the run: it relaxes, or its seat creeps. Its whole force is scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpringChange {
    /// When it begins, s; 0 to 1e6.
    pub at_s: f64,
    /// How long it takes, s; 0.1 to 1e6.
    pub over_s: f64,
    /// Force after over force before; 0.2 to 2. Typical: 0.8.
    pub ratio: f64,
}

/// The mount slips while the force is above what its friction holds.
///
/// ```text
/// ds/dt = μ max(0, F - F_s)        what has slipped is lost to the displacement
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MountSlip {
    /// Force that still holds F_s, N; 0 to 1e6.
    pub holding_force_n: f64,
    /// Speed over surplus force μ, m/(N s); 0 to 1. Typical: 3 % of the stroke in all of a run.
    pub mobility_m_per_n_s: f64,
}

/// Load that the moving end pulls at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Load {
    pub(crate) spring: Option<BiasSpring>,
    pub(crate) change: Option<SpringChange>,
    pub(crate) stop: Option<EndStop>,
    pub(crate) rod_stiffness_n_per_m: f64,
}

/// Where the moving end stands and what it pulls beyond the preload.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pull {
    pub(crate) displacement_m: f64,
    pub(crate) surplus_n: f64,
}

impl Load {
    pub(crate) fn preload_n(&self) -> f64 {
        self.spring.map_or(0.0, |spring| spring.preload_n)
    }

    /// The balance of forces at a stroke `free_m` under the preload alone, and a time.
    pub(crate) fn balance(&self, free_m: f64, time_s: f64) -> Pull {
        let spring = self.spring.unwrap_or(BiasSpring {
            stiffness_n_per_m: 0.0,
            preload_n: 0.0,
        });
        let factor = self.change.map_or(1.0, |change| change.factor(time_s));
        let compliance = 1.0 / self.rod_stiffness_n_per_m;
        let spring_share = factor * spring.stiffness_n_per_m * compliance;
        let target_m = free_m - (factor - 1.0) * spring.preload_n * compliance;
        let mut displacement_m = target_m / (1.0 + spring_share);
        if let Some(stop) = self.stop.filter(|stop| displacement_m > stop.position_m) {
            let share = stop.contact_stiffness_n_per_m * compliance;
            displacement_m = (target_m + share * stop.position_m) / (1.0 + spring_share + share);
        }
        Pull {
            displacement_m,
            surplus_n: (free_m - displacement_m) * self.rod_stiffness_n_per_m,
        }
    }
}

impl SpringChange {
    /// Force over that before; smooth, so that no step of the integration must end in it.
    fn factor(&self, time_s: f64) -> f64 {
        let s = ((time_s - self.at_s) / self.over_s).clamp(0.0, 1.0);
        1.0 + (self.ratio - 1.0) * s * s * (3.0 - 2.0 * s)
    }

    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("at_s", self.at_s, 0.0..=1e6)?;
        within("over_s", self.over_s, 0.1..=1e6)?;
        within("ratio", self.ratio, 0.2..=2.0)
    }
}

impl BiasSpring {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("stiffness_n_per_m", self.stiffness_n_per_m, 0.0..=1e7)?;
        within("preload_n", self.preload_n, 0.0..=1e5)
    }
}

impl StressCoupling {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within(
            "clausius_clapeyron_pa_per_k",
            self.clausius_clapeyron_pa_per_k,
            1e6..=5e7,
        )
    }

    /// Rise of the temperatures of transformation, K.
    pub(crate) fn shift_k(&self, rod: &Rod, surplus_n: f64) -> f64 {
        surplus_n / (rod.section_m2() * self.clausius_clapeyron_pa_per_k)
    }
}

impl EndStop {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("position_m", self.position_m, -1.0..=1.0)?;
        within(
            "contact_stiffness_n_per_m",
            self.contact_stiffness_n_per_m,
            0.0..=1e9,
        )
    }
}

impl MountSlip {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("holding_force_n", self.holding_force_n, 0.0..=1e6)?;
        within("mobility_m_per_n_s", self.mobility_m_per_n_s, 0.0..=1.0)
    }

    /// Speed of slipping, m/s.
    pub(crate) fn rate_m_per_s(&self, force_n: f64) -> f64 {
        self.mobility_m_per_n_s * (force_n - self.holding_force_n).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Below and at the stop, before and after the change: the forces balance, and the rod gives way to them.
    #[test]
    fn forces_balance() {
        let load = Load {
            spring: Some(BiasSpring {
                stiffness_n_per_m: 8e3,
                preload_n: 40.0,
            }),
            change: Some(SpringChange {
                at_s: 10.0,
                over_s: 4.0,
                ratio: 0.7,
            }),
            stop: Some(EndStop {
                position_m: 3e-3,
                contact_stiffness_n_per_m: 1e6,
            }),
            rod_stiffness_n_per_m: 2e5,
        };
        for (time_s, factor) in [(9.0, 1.0), (12.0, 0.85), (20.0, 0.7)] {
            for free_m in [-1e-4, 1e-3, 5e-3] {
                let pull = load.balance(free_m, time_s);
                let x = pull.displacement_m;
                let force_n = factor * (40.0 + 8e3 * x) + 1e6 * (x - 3e-3_f64).max(0.0);
                assert!((pull.surplus_n - (force_n - 40.0)).abs() < 1e-9);
                assert!((x - (free_m - pull.surplus_n / 2e5)).abs() < 1e-15);
            }
        }
    }
}
