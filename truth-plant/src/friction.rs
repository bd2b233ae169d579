use crate::error::{TruthError, in_order, within};

/// Friction of the guide that carries the sensor, driven through an elastic coupling.
///
/// ```text
/// dF/dx = σ_0 (1 - (F/F_c) sign(dx))        P. R. Dahl, 1968
/// y = x - F/k
/// ```
///
/// x is the rod's end, y the guide. Over a straight path the force is an exponential, so that the element knows no
/// step size. After a reversal the guide lags by up to 2 F_c/k, and gets there over F_c/σ_0: no play has its corners.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// Coulomb force F_c, N; 0 to 1e4. Typical: 1 % of the stroke times k.
    pub coulomb_force_n: f64,
    /// Stiffness of the coupling k, N/m; 1 to 1e9.
    pub coupling_stiffness_n_per_m: f64,
    /// Stiffness of the bristles σ_0, N/m; at least 1, below half of k, or the guide would run backward.
    pub bristle_stiffness_n_per_m: f64,
}

impl Friction {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("coulomb_force_n", self.coulomb_force_n, 0.0..=1e4)?;
        within(
            "coupling_stiffness_n_per_m",
            self.coupling_stiffness_n_per_m,
            1.0..=1e9,
        )?;
        within(
            "bristle_stiffness_n_per_m",
            self.bristle_stiffness_n_per_m,
            1.0..=1e9,
        )?;
        in_order(
            ("bristle_stiffness_n_per_m", self.bristle_stiffness_n_per_m),
            (
                "half of coupling_stiffness_n_per_m",
                0.5 * self.coupling_stiffness_n_per_m,
            ),
        )
    }

    /// Force after a movement by `travel_m`.
    pub(crate) fn force_n(&self, force_n: f64, travel_m: f64) -> f64 {
        if self.coulomb_force_n > 0.0 {
            let end_n = self.coulomb_force_n.copysign(travel_m);
            let share = self.bristle_stiffness_n_per_m * travel_m.abs() / self.coulomb_force_n;
            end_n + (force_n - end_n) * (-share).exp()
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_way_ends_in_the_coulomb_force_and_pieces_make_the_whole() {
        let friction = Friction {
            coulomb_force_n: 2.0,
            coupling_stiffness_n_per_m: 1e4,
            bristle_stiffness_n_per_m: 4e3,
        };
        let far_n = friction.force_n(0.0, 0.1);
        assert!((far_n - 2.0).abs() < 1e-12);
        // From there back, a small way and in ten pieces: dF/dx = 2 σ_0 at first.
        let whole_n = friction.force_n(far_n, -1e-5);
        let mut pieces_n = far_n;
        for _ in 0..10 {
            pieces_n = friction.force_n(pieces_n, -1e-6);
        }
        assert!((whole_n - pieces_n).abs() < 1e-12);
        assert!(((far_n - whole_n) / (2.0 * 4e3 * 1e-5) - 1.0).abs() < 0.02);
    }
}
