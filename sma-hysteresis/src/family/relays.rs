//! Relays, Preisach's operator, by their distribution.

use super::{Along, Bends, SecondPopulation, Transforms, Way, of};
use crate::elementary::{expm1, inverse_fourth_root, inverse_sqrt};
use crate::limiting_loop::LimitingLoop;

/// Deviation of the relays' temperatures over h_0.
const DEVIATION: f64 = 1.5;
/// Logarithm of the odds ratio over ζ.
const LOG_ODDS: f64 = 5.0;
/// Share of the relays that switch by one temperature alone.
const LOOSE: f64 = 1e-3;

/// Relays of lanes side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Relays<const L: usize> {
    /// Odds ratio θ.
    odds: [f64; L],
    /// τ.
    tails: [f64; L],
    bends: Bends<L>,
    /// Where half of them have switched, K, and 1/deviation, 1/K, on heating and on cooling.
    middle_k: [[f64; L]; 2],
    per_k: [[f64; L]; 2],
}

impl<const L: usize> Relays<L> {
    pub(super) fn new(limits: &LimitingLoop<L>, zeta: [f64; L]) -> Self {
        let lanes = |sign: f64, what: &dyn Fn(usize, f64) -> f64| {
            core::array::from_fn(|lane| what(lane, sign))
        };
        let middle_k = |lane: usize, sign: f64| sign * limits.half_width_k(lane);
        let per_k = |lane: usize, sign: f64| {
            1.0 / (DEVIATION * limits.spread_k(lane) * limits.widening(lane, sign))
        };
        Self {
            odds: zeta.map(odds_of),
            tails: [0.0; L],
            bends: Bends::NONE,
            middle_k: [lanes(1.0, &middle_k), lanes(-1.0, &middle_k)],
            per_k: [lanes(1.0, &per_k), lanes(-1.0, &per_k)],
        }
    }

    pub(super) fn with_tails(self, tails: [f64; L]) -> Self {
        Self { tails, ..self }
    }

    pub(super) fn with_bends(self, bends: Bends<L>) -> Self {
        Self { bends, ..self }
    }

    /// A second population with the tails and bends of this one, the first.
    pub(super) fn beside(
        self,
        limits: &LimitingLoop<L>,
        zeta: [f64; L],
        second: &[SecondPopulation; L],
    ) -> Self {
        let middle_k = |lane: usize, sign: f64| {
            let SecondPopulation {
                shift,
                log_half_width,
                ..
            } = second[lane];
            shift * limits.spread_k(lane)
                + sign * limits.half_width_k(lane) * libm::exp(log_half_width)
        };
        let [heating, cooling] =
            [1.0, -1.0].map(|sign| core::array::from_fn(|lane| middle_k(lane, sign)));
        let per_k = self.per_k.map(|lanes| {
            core::array::from_fn(|lane| lanes[lane] * libm::exp(-second[lane].log_spread))
        });
        Self {
            odds: core::array::from_fn(|lane| odds_of(zeta[lane] + second[lane].zeta_difference)),
            middle_k: [heating, cooling],
            per_k,
            ..self
        }
    }

    /// Share of the relays that have switched at T̂ on the branch of a direction, and its slope, 1/K.
    ///
    /// The normal distribution, to 2·10⁻⁴, as a logistic one of a cubic, of what the tails leave of the distance.
    #[inline(always)]
    fn switched(&self, lane: usize, sign: f64, at_k: f64) -> Way {
        const LINEAR: f64 = 1.5976;
        const CUBIC: f64 = 0.070_56;
        /// Beyond, all are on one side.
        const FAR: f64 = 8.0;
        /// Where the heaviest tails leave twice that of the distance.
        const FAR_WITH_TAILS: f64 = 1e3;
        let per_k = of(&self.per_k, sign, lane);
        let x = (at_k - of(&self.middle_k, sign, lane)) * per_k;
        let x = if x > FAR_WITH_TAILS {
            FAR_WITH_TAILS
        } else {
            x
        };
        let x = if x < -FAR_WITH_TAILS {
            -FAR_WITH_TAILS
        } else {
            x
        };
        let tails = self.tails[lane];
        // x (1 + τ² x²)^(-1/4)
        let nearer = inverse_fourth_root(1.0 + tails * tails * x * x);
        let square = nearer * nearer;
        let nearer_slope = nearer * (0.5 + 0.5 * square * square);
        let x = x * nearer;
        let x = if x > FAR { FAR } else { x };
        let x = if x < -FAR { -FAR } else { x };
        let share = 1.0 / (2.0 + expm1(-x * (LINEAR + CUBIC * x * x)));
        let steepness = (LINEAR + 3.0 * CUBIC * x * x) * nearer_slope;
        let density = share * (1.0 - share) * steepness * per_k;
        let (share, slope) = self.bends.bent(lane, sign, share);
        (share, density * slope)
    }
}

impl<const L: usize> Transforms<L> for Relays<L> {
    #[inline(always)]
    fn along(&self, lane: usize, sign: f64, start_k: f64) -> Along {
        let (fixed, _) = self.switched(lane, -sign, start_k);
        let begins = Along {
            fixed,
            scale: 0.0,
            further: 0.0,
        };
        Along {
            scale: self.way(lane, sign, &begins, start_k).0 * sign,
            ..begins
        }
    }

    /// Heating from T_r: w = P(A ≤ T) - P(A ≤ T, B ≤ T_r); cooling: w = P(A ≤ T_r, B ≤ T), which falls.
    #[inline(always)]
    fn way(&self, lane: usize, sign: f64, along: &Along, temperature_k: f64) -> Way {
        let (share, density) = self.switched(lane, sign, temperature_k);
        let (joint, slope) = plackett(self.odds[lane], share, along.fixed);
        let (alone, both) = if sign < 0.0 {
            (LOOSE, 1.0 - LOOSE)
        } else {
            (1.0, LOOSE - 1.0)
        };
        (
            sign * ((alone * share + both * joint) - along.scale),
            density * (alone + both * slope),
        )
    }
}

/// Odds ratio θ of a ζ.
fn odds_of(zeta: f64) -> f64 {
    libm::exp(LOG_ODDS * zeta)
}

/// Plackett's copula C(u, v) of odds ratio θ, in a form that is exact for θ = 1, and ∂C/∂u.
///
/// ```text
/// C = 2θuv/(S + R),   S = 1 + (θ - 1)(u + v),   R² = S² - 4θ(θ - 1)uv
/// ```
#[inline(always)]
fn plackett(odds: f64, u: f64, v: f64) -> Way {
    let over = odds - 1.0;
    let sum = 1.0 + over * (u + v);
    let square = sum * sum - 4.0 * odds * over * u * v;
    let square = if square < 0.0 { 0.0 } else { square };
    let inverse = inverse_sqrt(square);
    let joint = 2.0 * odds * u * v / (sum + square * inverse);
    (joint, 0.5 + (odds * v - 0.5 * sum) * inverse)
}
