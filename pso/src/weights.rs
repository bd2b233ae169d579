use crate::SwarmError;
use crate::error::{not_negative, positive};

/// Weight w of the last velocity in the next one, move by move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Inertia {
    /// Constant in every move; finite, >= 0.
    Constant(f64),
    /// Falls (or rises) along a line [`Shi1998`](crate#references).
    ///
    /// ```text
    /// w_k = first + (last − first) min(k, iterations) / iterations,   k = 0, 1, … (moves)
    /// ```
    LinearlyDecreasing {
        /// Weight of the first move; finite, >= 0.
        first: f64,
        /// Weight from move `iterations` (counted from 0) on; finite, >= 0.
        last: f64,
        /// Moves from `first` to `last`; >= 1.
        iterations: u64,
    },
    /// Falls geometrically: `w_k = first · factor^k`, as a running product.
    Damped {
        /// Weight of the first move; finite, >= 0.
        first: f64,
        /// Factor on the weight after each move; in (0, 1].
        factor: f64,
    },
}

impl Inertia {
    /// Weight of move `k` (from 0); `damping` is the running product of the factors before it.
    pub(crate) fn at(self, k: u64, damping: f64) -> f64 {
        match self {
            Self::Constant(weight) => weight,
            Self::LinearlyDecreasing {
                first,
                last,
                iterations,
            } => first + (last - first) * (k.min(iterations) as f64 / iterations as f64),
            Self::Damped { first, .. } => first * damping,
        }
    }

    /// Factor of one move in the running product.
    pub(crate) fn factor(self) -> f64 {
        match self {
            Self::Damped { factor, .. } => factor,
            Self::Constant(_) | Self::LinearlyDecreasing { .. } => 1.0,
        }
    }

    fn check(self) -> Result<(), SwarmError> {
        match self {
            Self::Constant(weight) => not_negative("weights.inertia", weight).map(|_| ()),
            Self::LinearlyDecreasing {
                first,
                last,
                iterations,
            } => {
                not_negative("weights.inertia.first", first)?;
                not_negative("weights.inertia.last", last)?;
                if iterations == 0 {
                    return Err(SwarmError::ZeroCount {
                        name: "weights.inertia.iterations",
                    });
                }
                Ok(())
            }
            Self::Damped { first, factor } => {
                not_negative("weights.inertia.first", first)?;
                if factor > 0.0 && factor <= 1.0 {
                    Ok(())
                } else {
                    let name = "weights.inertia.factor";
                    Err(SwarmError::NotAFraction {
                        name,
                        value: factor,
                    })
                }
            }
        }
    }

    /// Both ends of the weights that a run passes through.
    fn ends(self) -> [f64; 2] {
        match self {
            Self::Constant(weight) => [weight, weight],
            Self::LinearlyDecreasing { first, last, .. } => [first, last],
            Self::Damped { first, factor } => [first, if factor < 1.0 { 0.0 } else { first }],
        }
    }
}

/// The three weights of a velocity.
///
/// ```text
/// v ← w v + c1 r1 (own best − x) + c2 r2 (informer's best − x)
/// x ← x + v
/// ```
///
/// w inertia, c1 cognitive, c2 social; r1, r2 uniform in [0, 1), drawn anew for every coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Weight w of the last velocity.
    pub inertia: Inertia,
    /// Weight c1 of the pull to the particle's own best point; finite, >= 0.
    pub cognitive: f64,
    /// Weight c2 of the pull to the best point among its informers; finite, >= 0.
    pub social: f64,
}

/// Arguments of [`Weights::constriction`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstrictionParams {
    /// φ1, before constriction; finite, > 0.
    pub phi_cognitive: f64,
    /// φ2, before constriction; finite, > 0; φ1 + φ2 > 4.
    pub phi_social: f64,
}

impl Weights {
    /// Constriction coefficient [`Clerc2002`](crate#references), with κ = 1.
    ///
    /// ```text
    /// χ = 2 / |2 − φ − √(φ² − 4φ)|,   φ = φ1 + φ2
    /// w = χ,   c1 = χ φ1,   c2 = χ φ2
    /// ```
    ///
    /// # Errors
    ///
    /// A φ that is not positive and finite, and a sum that is not above 4.
    pub fn constriction(params: ConstrictionParams) -> Result<Self, SwarmError> {
        let cognitive = positive("phi_cognitive", params.phi_cognitive)?;
        let social = positive("phi_social", params.phi_social)?;
        let phi = cognitive + social;
        if !(phi > 4.0 && phi.is_finite()) {
            return Err(SwarmError::ConstrictionSum { sum: phi });
        }
        // √(φ² − 4φ) as √φ √(φ − 4), which cannot overflow; 2 − φ − √ is negative for φ > 4.
        let chi = 2.0 / (phi - 2.0 + phi.sqrt() * (phi - 4.0).sqrt());
        Ok(Self {
            inertia: Inertia::Constant(chi),
            cognitive: chi * cognitive,
            social: chi * social,
        })
    }

    /// Weights of the standard swarm of 2006 to 2011 [`Clerc2012`](crate#references):
    /// w = 1/(2 ln 2) = 0.7213, c1 = c2 = 1/2 + ln 2 = 1.1931.
    #[must_use]
    pub fn spso_2011() -> Self {
        let ln_2 = std::f64::consts::LN_2;
        Self {
            inertia: Inertia::Constant(0.5 / ln_2),
            cognitive: 0.5 + ln_2,
            social: 0.5 + ln_2,
        }
    }

    /// True if the *variance* of the positions settles in a swarm that finds nothing new, for every
    /// inertia of the run. If false, the velocity needs a limit.
    ///
    /// ```text
    /// 2 m (1 − w) − m² (1 − w)/(1 + w) − s² > 0,   m = (c1 + c2)/2,   s² = (c1² + c2²)/12
    /// for c1 = c2:   c1 + c2 < 24 (1 − w²)/(7 − 5w)                     [Poli2009]
    /// ```
    ///
    /// It implies the weaker condition on the mean, c1 + c2 < 4 (1 + w). The swarm without random
    /// numbers (r1 = r2 = 1) is stable for c1 + c2 < 2 (1 + w).
    ///
    /// ```
    /// use pso::{Inertia, Weights};
    /// assert!(Weights::spso_2011().is_order_2_stable());
    /// let unstable = Weights { inertia: Inertia::Constant(0.9), cognitive: 2.0, social: 2.0 };
    /// assert!(!unstable.is_order_2_stable());
    /// ```
    #[must_use]
    pub fn is_order_2_stable(&self) -> bool {
        // The limit on c1 + c2 rises and then falls with w in 0..1: the ends decide between them.
        self.inertia.ends().into_iter().all(|inertia| {
            let mean = 0.5 * (self.cognitive + self.social);
            // 12: a uniform number in 0..1 has the variance 1/12.
            let variance = (self.cognitive.powi(2) + self.social.powi(2)) / 12.0;
            let left = 1.0 - inertia;
            (0.0..1.0).contains(&inertia)
                && 2.0 * mean * left - mean.powi(2) * left / (1.0 + inertia) - variance > 0.0
        })
    }

    pub(crate) fn check(&self) -> Result<(), SwarmError> {
        self.inertia.check()?;
        not_negative("weights.cognitive", self.cognitive)?;
        not_negative("weights.social", self.social)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn constriction_gives_the_printed_coefficients() {
        // Clerc & Kennedy 2002 and the paper's PID setting print 0.7298 and 1.4962 (rounded).
        let params = ConstrictionParams {
            phi_cognitive: 2.05,
            phi_social: 2.05,
        };
        let weights = Weights::constriction(params).unwrap();
        assert_abs_diff_eq!(weights.inertia.at(0, 1.0), 0.7298, epsilon = 0.5e-4);
        assert_abs_diff_eq!(weights.cognitive, 1.4962, epsilon = 0.5e-4);
        assert_abs_diff_eq!(weights.social, 1.4962, epsilon = 0.5e-4);
    }

    #[test]
    fn spso_2011_gives_the_printed_coefficients() {
        let weights = Weights::spso_2011();
        assert_abs_diff_eq!(weights.inertia.at(0, 1.0), 0.7213, epsilon = 0.5e-4);
        assert_abs_diff_eq!(weights.cognitive, 1.1931, epsilon = 0.5e-4);
    }

    #[test]
    fn order_2_stability_agrees_with_the_printed_limit() {
        for inertia in [0.0, 0.2, 0.42, 0.5, 0.7298, 0.9, 0.99] {
            let limit = 24.0 * (1.0 - inertia * inertia) / (7.0 - 5.0 * inertia);
            for (share, stable) in [(0.999, true), (1.001, false)] {
                let half = 0.5 * limit * share;
                let weights = Weights {
                    inertia: Inertia::Constant(inertia),
                    cognitive: half,
                    social: half,
                };
                assert_eq!(
                    weights.is_order_2_stable(),
                    stable,
                    "w = {inertia}, share {share}"
                );
            }
        }
    }

    #[test]
    fn order_2_stability_refuses_nan_and_inertia_of_one() {
        for inertia in [f64::NAN, 1.0, -0.1] {
            let weights = Weights {
                inertia: Inertia::Constant(inertia),
                cognitive: 1.0,
                social: 1.0,
            };
            assert!(!weights.is_order_2_stable());
        }
    }

    #[test]
    fn schedules_follow_their_equations() {
        let line = Inertia::LinearlyDecreasing {
            first: 0.9,
            last: 0.4,
            iterations: 100,
        };
        assert_abs_diff_eq!(line.at(0, 1.0), 0.9);
        assert_abs_diff_eq!(line.at(50, 1.0), 0.65, epsilon = 1e-15);
        assert_abs_diff_eq!(line.at(100, 1.0), 0.4, epsilon = 1e-15);
        assert_abs_diff_eq!(line.at(u64::MAX, 1.0), 0.4, epsilon = 1e-15);
        let damped = Inertia::Damped {
            first: 0.8,
            factor: 0.99,
        };
        assert_abs_diff_eq!(damped.at(2, 0.99 * 0.99), 0.784_08, epsilon = 1e-15);
    }
}
