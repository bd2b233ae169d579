use crate::Hysteresis;
use crate::error::{TruthError, within};
use crate::reversals::{Recall, Reversals, Turn};
use std::f64::consts::{FRAC_PI_2, PI};

/// Proximity below which a point counts as lying on the limiting curve, K.
const SMALLEST_PROXIMITY_K: f64 = 1e-9;

/// Limiting-loop proximity in the fraction itself.
///
/// ```text
/// F(T, δ) = ½ + atan((T - T_mid - δ T_c)/h_δ)/π              [Sadeghi, eq. 4]
/// T_L(ξ, δ) = T_mid + δ T_c + h_δ tan(π (ξ - ½))             [Sadeghi, eq. 6]
/// ξ = F(T + T_pr P(x), δ),  T_pr = T_L(ξ_r, δ) - T_r,  x = |T - T_r|/|T_pr|
/// P(x) = 1 - sin ζx for ζx < π/2, else 0                     [Sadeghi, eq. 12]
/// ```
///
/// The magnitudes in x count where curves of different spreads cross: a branch that starts beyond its limiting curve
/// comes back to it. With nested memory the branch's rise in fraction is scaled so that it ends in its return point; the fraction may then
/// leave the limiting loop a little, never its branch's two ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct L2pLoop {
    /// Middle of the loop T_mid, °C; -50 to 200.
    pub loop_center_degc: f64,
    /// Half of the loop's width T_c, K; 0.1 to 60.
    pub loop_half_width_k: f64,
    /// Spread h_0, K; 0.1 to 60. The geometric mean of both branches.
    pub loop_spread_k: f64,
    /// Shape ζ of the proximity function; above 0, to 1. At least 0.01.
    pub zeta: f64,
    /// Spread of the cooling branch over that of the heating branch; 0.2 to 5.
    pub cooling_over_heating_spread: f64,
    /// True if all reversals count, by Madelung's rules; false if only the last one does, as in the paper.
    pub nested: bool,
}

impl Default for L2pLoop {
    /// A loop of a thin wire, on its own.
    fn default() -> Self {
        Self {
            loop_center_degc: 58.0,
            loop_half_width_k: 8.0,
            loop_spread_k: 3.0,
            zeta: 0.85,
            cooling_over_heating_spread: 1.0,
            nested: false,
        }
    }
}

impl L2pLoop {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        within("loop_center_degc", self.loop_center_degc, -50.0..=200.0)?;
        within("loop_half_width_k", self.loop_half_width_k, 0.1..=60.0)?;
        within("loop_spread_k", self.loop_spread_k, 0.1..=60.0)?;
        within("zeta", self.zeta, 0.01..=1.0)?;
        within(
            "cooling_over_heating_spread",
            self.cooling_over_heating_spread,
            0.2..=5.0,
        )
    }

    /// The operator.
    ///
    /// # Errors
    ///
    /// [`TruthError::OutOfRange`] naming the parameter.
    pub fn operator(&self) -> Result<L2p, TruthError> {
        self.check()?;
        let root = self.cooling_over_heating_spread.sqrt();
        Ok(L2p {
            parameters: *self,
            heating_spread_k: self.loop_spread_k / root,
            cooling_spread_k: self.loop_spread_k * root,
        })
    }
}

/// Limiting-loop proximity, ready to use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct L2p {
    parameters: L2pLoop,
    heating_spread_k: f64,
    cooling_spread_k: f64,
}

/// Memory of limiting-loop proximity.
#[derive(Debug, Clone, PartialEq)]
pub struct L2pMemory {
    reversals: Reversals,
    branch: Course,
}

impl L2pMemory {
    /// How many reversals are remembered.
    #[must_use]
    pub fn depth(&self) -> usize {
        self.reversals.depth()
    }
}

/// The course of a branch from its start.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Course {
    rising: bool,
    start: Option<Turn>,
    /// T_pr; 0 on the limiting curve.
    proximity_k: f64,
    /// Factor of the rise in fraction.
    scale: f64,
}

impl L2p {
    /// Middle and spread of a limiting curve.
    fn curve(&self, rising: bool) -> (f64, f64) {
        let p = &self.parameters;
        if rising {
            (
                p.loop_center_degc + p.loop_half_width_k,
                self.heating_spread_k,
            )
        } else {
            (
                p.loop_center_degc - p.loop_half_width_k,
                self.cooling_spread_k,
            )
        }
    }

    /// F.
    fn limiting(&self, rising: bool, temperature_degc: f64) -> f64 {
        let (middle_degc, spread_k) = self.curve(rising);
        0.5 + ((temperature_degc - middle_degc) / spread_k).atan() / PI
    }

    fn course(&self, reversals: &Reversals, recall: &Recall) -> Course {
        let rising = recall.rising;
        let limiting = Course {
            rising,
            start: None,
            proximity_k: 0.0,
            scale: 1.0,
        };
        let Some(start) = reversals.start(recall) else {
            return limiting;
        };
        let (middle_degc, spread_k) = self.curve(rising);
        let on_curve_degc = middle_degc + spread_k * (PI * (start.fraction - 0.5)).tan();
        let natural = Course {
            start: Some(start),
            proximity_k: on_curve_degc - start.temperature_degc,
            ..limiting
        };
        let Some(target) = reversals.target(recall) else {
            return natural;
        };
        let reached = self.on(&natural, target.temperature_degc) - start.fraction;
        let scale = (target.fraction - start.fraction) / reached;
        Course {
            // Over the shortest loops the quotient is all rounding.
            scale: if scale.is_finite() && scale > 0.0 {
                scale
            } else {
                1.0
            },
            ..natural
        }
    }

    fn on(&self, course: &Course, temperature_degc: f64) -> f64 {
        let rising = course.rising;
        let Some(start) = course.start else {
            return self.limiting(rising, temperature_degc);
        };
        let proximity_k = course.proximity_k;
        let natural = if proximity_k.abs() > SMALLEST_PROXIMITY_K {
            let travel_k = (temperature_degc - start.temperature_degc).abs();
            let angle = self.parameters.zeta * travel_k / proximity_k.abs();
            let left = if angle < FRAC_PI_2 {
                1.0 - angle.sin()
            } else {
                0.0
            };
            self.limiting(rising, temperature_degc + proximity_k * left)
        } else {
            self.limiting(rising, temperature_degc)
        };
        start.fraction + course.scale * (natural - start.fraction)
    }
}

impl Hysteresis for L2p {
    type Memory = L2pMemory;

    fn rest(&self, temperature_degc: f64) -> L2pMemory {
        let furthest = Turn {
            temperature_degc,
            fraction: self.limiting(false, temperature_degc),
        };
        let reversals = Reversals::fallen_to(furthest, self.parameters.nested);
        let branch = self.course(&reversals, &reversals.present());
        L2pMemory { reversals, branch }
    }

    fn fraction(&self, memory: &L2pMemory, temperature_degc: f64) -> f64 {
        let recall = memory.reversals.recall(temperature_degc);
        if recall == memory.reversals.present() {
            return self.on(&memory.branch, temperature_degc);
        }
        self.on(&self.course(&memory.reversals, &recall), temperature_degc)
    }

    fn commit(&self, memory: &mut L2pMemory, temperature_degc: f64) -> f64 {
        let recall = memory.reversals.recall(temperature_degc);
        if recall != memory.reversals.present() {
            memory.branch = self.course(&memory.reversals, &recall);
        }
        let fraction = self.on(&memory.branch, temperature_degc);
        let end = Turn {
            temperature_degc,
            fraction,
        };
        memory.reversals.follow(&recall, end);
        fraction
    }
}
