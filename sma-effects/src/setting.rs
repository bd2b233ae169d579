use wiener::Drive;
use wiener::hysteresis::{LoopFamily, Rule};

use crate::hypothesis::MOST_HYPOTHESES;
use crate::{EffectParameter, EffectSet, Hypothesis, PhysicsError, SizePrior};

/// Most sub-steps of a sample.
const MOST_SUB_STEPS: usize = 64;
/// Most Newton iterations: far more than a converging search needs.
const MOST_ITERATIONS: usize = 50;

/// Setting common to all plants of one kind. An unknown quantity is left out, and effects that need it
/// are refused.
///
/// The number of sub-steps and the largest number of iterations are fixed, and are equal for the baseline
/// and every candidate. A difference between two outputs is therefore physics, not integration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setting {
    /// Meaning of the drive.
    pub drive: Drive,
    /// Memory of the hysteresis in the baseline; relays remember all reversals.
    pub rule: Rule,
    /// Curves of its branches.
    pub loop_family: LoopFamily,
    /// The effects that may have a size.
    pub active: EffectSet,
    /// Hypotheses of one's own, all of which may have a size; at most 4. They act in this order.
    pub hypotheses: &'static [Hypothesis],
    /// Mass per meter of rod, kg/m; > 0. [`RodParams::mass_kg_per_m`](wiener::thermal::RodParams::mass_kg_per_m).
    pub mass_kg_per_m: Option<f64>,
    /// Surface per meter of rod, m²/m; > 0.
    pub surface_m2_per_m: Option<f64>,
    /// Length of the rod times its lever, in the unit of the displacement; > 0. Where it is not known, an expansion counts
    /// for a strain of 4 %: see [`Setting::unit_of`].
    pub length_output: Option<f64>,
    /// Length of the run over which drifts are spread, s; > 0.
    pub run_length_s: Option<f64>,
    /// Largest magnitude of the drive in the recordings that decide, in its unit; > 0. Limits of the supply are shares of it.
    pub largest_drive: Option<f64>,
    /// Share of the resistance between the supply's terminals that is that of leads, 0 to 1, the rod cold. It counts where the
    /// rod's resistance changes under a voltage or a duty; the drive itself has it in its length.
    pub lead_share: f64,
    /// Time on the clock of the drifts at which the recording starts, s; ≥ 0.
    pub start_s: f64,
    /// Temperature at which the rod has its length, °C. It moves only the offset. 20 °C by default,
    /// the reference temperature of ISO 1.
    pub reference_degc: f64,
    /// Parts into which every sample is divided; 1 to 64.
    pub sub_steps: usize,
    /// Newton iterations of each sub-step, at most; 1 to 50. Fewer are made where they leave nothing.
    pub newton_iterations: usize,
}

impl Default for Setting {
    fn default() -> Self {
        Self {
            drive: Drive::Current,
            rule: Rule::LastReversal,
            loop_family: LoopFamily::Proximity,
            active: EffectSet::EMPTY,
            hypotheses: &[],
            mass_kg_per_m: None,
            surface_m2_per_m: None,
            length_output: None,
            run_length_s: None,
            largest_drive: None,
            lead_share: 0.0,
            start_s: 0.0,
            reference_degc: 20.0,
            sub_steps: 1,
            newton_iterations: 3,
        }
    }
}

impl Setting {
    /// Unit of a parameter of an effect.
    #[must_use]
    pub fn unit_of(&self, parameter: &EffectParameter) -> &'static str {
        let without_length = parameter
            .unit_without_length
            .filter(|_| self.length_output.is_none());
        without_length.unwrap_or(parameter.unit)
    }

    /// Prior of the value of a parameter, in the unit of [`Setting::unit_of`]. Without a length its literature range counts
    /// less: the strain of 4 % stands for 2 to 8 %.
    #[must_use]
    pub fn prior_of(&self, parameter: &EffectParameter) -> SizePrior {
        SizePrior::of(parameter, self.unit_of(parameter) == parameter.unit)
    }

    /// Checks everything but the drive, which the baseline checks.
    pub(crate) fn checked(&self) -> Result<(), PhysicsError> {
        for (name, value, unit) in [
            ("mass_kg_per_m", self.mass_kg_per_m, "kg/m"),
            ("surface_m2_per_m", self.surface_m2_per_m, "m²/m"),
            ("length_output", self.length_output, "(output unit)"),
            ("run_length_s", self.run_length_s, "s"),
            ("largest_drive", self.largest_drive, "(drive unit)"),
        ] {
            match value {
                Some(value) if !(value > 0.0 && value.is_finite()) => {
                    return Err(PhysicsError::NotPositive { name, value, unit });
                }
                _ => {}
            }
        }
        if !(0.0..=1.0).contains(&self.lead_share) {
            return Err(PhysicsError::Share {
                name: "lead_share",
                value: self.lead_share,
            });
        }
        if !(self.start_s >= 0.0 && self.start_s.is_finite()) {
            return Err(PhysicsError::Negative {
                name: "start_s",
                value: self.start_s,
                unit: "s",
            });
        }
        if !self.reference_degc.is_finite() {
            return Err(PhysicsError::NotFinite {
                name: "reference_degc",
                value: self.reference_degc,
            });
        }
        if self.hypotheses.len() > MOST_HYPOTHESES {
            return Err(PhysicsError::TooManyHypotheses {
                count: self.hypotheses.len(),
                largest: MOST_HYPOTHESES,
            });
        }
        for (name, value, largest) in [
            ("sub_steps", self.sub_steps, MOST_SUB_STEPS),
            ("newton_iterations", self.newton_iterations, MOST_ITERATIONS),
        ] {
            if !(1..=largest).contains(&value) {
                return Err(PhysicsError::Count {
                    name,
                    value,
                    largest,
                });
            }
        }
        Ok(())
    }
}
