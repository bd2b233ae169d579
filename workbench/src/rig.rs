//! An identified rig as something to be controlled.

use identify::{RigModel, SavedEffects, SavedModel, Scope};
use missing_physics::RestoredModel;
use pid_tune::Variation;
use recording::Quantity;
use sma_effects::{EffectId, Member, PhysicsError, Turned};
use wiener::hysteresis::Rule;
use wiener::{Drive, Fleet, Input, Lanes, NARROW, Start, Wiener, WienerError, WienerParams};

use crate::WorkbenchError;

/// Largest drive over that of the training from which a prediction is called a guess.
pub const BEYOND: f64 = 1.02;

/// By how much a parameter is varied to see what depends on it.
const VARIATION: f64 = 0.2;

/// Time constants after which a rod with effects counts as hot, and samples in each.
const HOT_AFTER: [usize; 2] = [40, 20];

/// A rig whose output rises with heat: one whose output falls is turned over, and its set points with it.
#[derive(Debug, Clone)]
pub struct Rig {
    /// Model that its plants share.
    pub fleet: Turned,
    /// The rod at rest; its signs are not turned.
    pub member: Member,
    /// The baseline part, its signs turned.
    pub params: WienerParams,
    /// Ids of the effects beyond it that count here.
    pub effects: Vec<String>,
    /// How the drive heats the rod.
    pub drive: Drive,
    /// Which reversals it remembers.
    pub rule: Rule,
    /// Temperature of the surroundings, °C.
    pub ambient_degc: f64,
    /// The largest drive, in the unit of the drive.
    pub drive_max: f64,
    /// Largest drive of the training recordings.
    pub largest_drive: f64,
    /// True if the model was identified to a minimum.
    pub converged: bool,
    /// Unit of the output.
    pub output_unit: String,
    /// Unit of the drive.
    pub drive_unit: String,
    /// The highest temperature that the rig stands, °C.
    temperature_max_degc: f64,
}

/// Why a model cannot be controlled as asked.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// The model is a static loop.
    #[error(
        "{file}: a static loop has no time constant; to be controlled a rig needs a recording with time"
    )]
    Static {
        /// File of the model.
        file: String,
    },
    /// The model is a heat balance.
    #[error(
        "{file}: the output is the temperature: only an actuator that moves is controlled; identify it from a recording of what it does"
    )]
    Thermal {
        /// File of the model.
        file: String,
    },
    /// The model is of two rods.
    #[error(
        "{file}: two rods with two drives: a controller is tuned for one; identify that one from a recording with the other cold"
    )]
    Antagonist {
        /// File of the model.
        file: String,
    },
    /// The largest drive is not known.
    #[error(
        "{file}: limits.drive_max is missing: the controller needs it; give it there or as --drive-max; the recordings went to {largest}"
    )]
    DriveMax {
        /// File of the model.
        file: String,
        /// Largest drive of the recordings.
        largest: f64,
    },
    /// The largest drive is no positive number.
    #[error("--drive-max {value}: must be finite and > 0")]
    DriveMaxValue {
        /// Rejected value.
        value: f64,
    },
    /// A duty above 1.
    #[error("drive_max = {value}: a duty is at most 1; the recordings went to {largest}")]
    Duty {
        /// Rejected value.
        value: f64,
        /// Largest drive of the recordings.
        largest: f64,
    },
    /// No drive within the limits holds the set point.
    #[error(
        "set point {value} {unit}: beyond what the rig reaches, {lower} to {upper} {unit} with a drive of at most {drive_max} {drive_unit}"
    )]
    SetPoint {
        /// The set point.
        value: f64,
        /// The lowest that is held.
        lower: String,
        /// The highest.
        upper: String,
        /// Unit of the output.
        unit: String,
        /// The largest drive.
        drive_max: f64,
        /// Unit of the drive.
        drive_unit: String,
    },
    /// The temperature of the surroundings is not known.
    #[error("{file}: ambient_degc is missing; give it in [surroundings]")]
    Ambient {
        /// File of the model.
        file: String,
    },
    /// Something else is not known.
    #[error("{what} is missing: {why}")]
    Missing {
        /// The missing quantity.
        what: &'static str,
        /// Why it is needed.
        why: &'static str,
    },
    /// A number is out of its range.
    #[error("{name} = {value}: {accepted}")]
    Value {
        /// Its name.
        name: &'static str,
        /// The number.
        value: f64,
        /// Accepted range.
        accepted: &'static str,
    },
}

impl Rig {
    /// The rig of a model, at rest.
    ///
    /// # Errors
    ///
    /// [`RigError`] for what the model does not tell; what the drive of its rod file lacks.
    pub fn of(
        saved: &SavedModel,
        model: &RestoredModel<'_>,
        drive_max: Option<f64>,
    ) -> Result<Self, WorkbenchError> {
        let rod = &saved.rod;
        let file = || rod.file.clone();
        match &saved.model {
            RigModel::Thermal(_) => return Err(RigError::Thermal { file: file() }.into()),
            RigModel::Antagonist(_) => return Err(RigError::Antagonist { file: file() }.into()),
            RigModel::Wiener(_) | RigModel::Sadeghi(_) | RigModel::Loop(_) => {}
        }
        // That the temperature is known is checked last.
        let at_rest = Start::rest(rod.ambient_degc.unwrap_or_default());
        let Some(member) = model.member(&model.point(), at_rest) else {
            return Err(RigError::Static { file: file() }.into());
        };
        let drive_max = match drive_max {
            Some(value) if value > 0.0 && value.is_finite() => value,
            Some(value) => return Err(RigError::DriveMaxValue { value }.into()),
            // A supply that saturates is a limit as well.
            None => match rod.limits.drive_max.or(rod.supply.limit) {
                Some(value) => value,
                None => {
                    let largest = saved.largest_drive();
                    let file = file();
                    return Err(RigError::DriveMax { file, largest }.into());
                }
            },
        };
        let drive_max = rod.supply.limited(drive_max);
        if rod.drive_kind == Quantity::Duty && drive_max > 1.0 {
            let largest = saved.largest_drive();
            let value = drive_max;
            return Err(RigError::Duty { value, largest }.into());
        }
        let Some(ambient_degc) = rod.ambient_degc else {
            return Err(RigError::Ambient { file: file() }.into());
        };
        let sign = if member.params.gain < 0.0 { -1.0 } else { 1.0 };
        let drifts: Vec<&str> = model.drifts().map(EffectId::id).collect();
        let beyond = saved
            .effects
            .as_ref()
            .map_or_else(Vec::new, SavedEffects::names);
        Ok(Self {
            fleet: Turned {
                fleet: model.fleet(),
                sign,
            },
            member,
            params: turned(member.params, sign),
            effects: beyond
                .into_iter()
                .filter(|id| !drifts.contains(id))
                .map(str::to_owned)
                .collect(),
            drive: rod.drive()?,
            rule: saved.rule,
            ambient_degc,
            drive_max,
            largest_drive: saved.largest_drive(),
            converged: saved.scores.converged,
            output_unit: saved.output_unit.to_owned(),
            drive_unit: match rod.drive_kind {
                Quantity::Duty => "duty".to_owned(),
                other => other.unit().to_owned(),
            },
            temperature_max_degc: match rod.limits.temperature_max_degc {
                Some(limit) if saved.model.knows_temperature() => limit,
                _ => f64::INFINITY,
            },
        })
    }

    /// True if the output falls with heat, so that signs are turned.
    #[must_use]
    pub fn is_turned(&self) -> bool {
        self.fleet.sign < 0.0
    }

    /// An output of the sensor as the controller sees it, and back.
    #[must_use]
    pub fn signed(&self, output: f64) -> f64 {
        self.fleet.sign * output
    }

    /// How far the output can go.
    #[must_use]
    pub fn stroke(&self) -> f64 {
        self.params.gain
    }

    /// The rig at rest; all lanes are alike.
    fn at_rest(&self) -> Result<Box<dyn Lanes<NARROW> + Send>, PhysicsError> {
        self.fleet.narrow(&[self.member; NARROW])
    }

    /// The rig with its sensor's zero moved so that it reads this at rest.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn resting_at(&self, output: f64) -> Result<Self, PhysicsError> {
        let mut moved = self.clone();
        let higher = self.signed(output) - self.rest_output()?;
        moved.params.offset += higher;
        moved.member.params.offset += self.signed(higher);
        Ok(moved)
    }

    /// The rig of another rod, at rest where this one is, as the sensor reads it.
    ///
    /// # Errors
    ///
    /// [`PhysicsError`] naming what is refused.
    pub fn of_rod(&self, rod: Member) -> Result<Self, PhysicsError> {
        let other = Self {
            member: rod,
            params: turned(rod.params, self.fleet.sign),
            ..self.clone()
        };
        other.resting_at(self.signed(self.rest_output()?))
    }

    /// Output of the cold rod, as the controller sees it.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn rest_output(&self) -> Result<f64, PhysicsError> {
        Ok(self.at_rest()?.output().displacement[0])
    }

    /// Output that the largest drive holds in the end, heated from rest.
    fn hot_output(&self) -> Result<f64, WorkbenchError> {
        Ok(if self.effects.is_empty() {
            self.plain_hot_output()?
        } else {
            self.hot_output_with_effects()?
        })
    }

    fn plain_hot_output(&self) -> Result<f64, WienerError> {
        let plant = Wiener::new(self.drive, self.rule, &[self.params])?;
        let heat = plant.heat();
        let resistance = heat.resistance_ohm_per_m();
        let [power_w_per_m] = self.drive.power_w_per_m([self.drive_max], resistance);
        let rise_k = power_w_per_m * heat.lambda_k_per_a2()[0] / resistance[0];
        let hottest_degc = (self.ambient_degc + rise_k).min(self.temperature_max_degc);
        let mut memory = plant
            .hysteresis()
            .on_limiting_curve(wiener::hysteresis::Branch::Cooling, [self.ambient_degc]);
        let [fraction] = plant.hysteresis().commit(&mut memory, [hottest_degc]);
        Ok(self.params.gain * fraction + self.params.offset)
    }

    /// With effects no formula has it: the rod is heated until it stands, or is as hot as it may be.
    fn hot_output_with_effects(&self) -> Result<f64, PhysicsError> {
        let mut rod = self.at_rest()?;
        let [time_constants, samples] = HOT_AFTER;
        let dt_s = self.tau_s() / samples as f64;
        let input = Input {
            drive: [self.drive_max; NARROW],
            ambient_degc: self.ambient_degc,
        };
        let mut shown = rod.output();
        for _ in 0..time_constants * samples {
            rod.step(&input, dt_s);
            let next = rod.output();
            if next.temperature_degc[0] > self.temperature_max_degc {
                break;
            }
            shown = next;
        }
        Ok(shown.displacement[0])
    }

    /// Time constant of the baseline part, s.
    #[must_use]
    pub fn tau_s(&self) -> f64 {
        self.params.heat.heat_capacity_j_per_m_k / self.params.heat.conductance_w_per_m_k
    }

    /// Refuses a set point that no drive within the limits holds.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn check_set_point(&self, output: f64) -> Result<(), WorkbenchError> {
        if !output.is_finite() {
            return Err(RigError::Value {
                name: "set point",
                value: output,
                accepted: "must be finite",
            }
            .into());
        }
        let (cold, hot) = (self.rest_output()?, self.hot_output()?);
        if (cold..=hot).contains(&self.signed(output)) {
            return Ok(());
        }
        let mut ends = [self.signed(cold), self.signed(hot)];
        ends.sort_by(f64::total_cmp);
        let [lower, upper] = ends.map(|end| format!("{end:.4}"));
        Err(RigError::SetPoint {
            value: output,
            lower,
            upper,
            unit: self.output_unit.clone(),
            drive_max: self.drive_max,
            drive_unit: self.drive_unit.clone(),
        }
        .into())
    }

    /// Rods as likely as the identified one.
    #[must_use]
    pub fn draws(
        &self,
        saved: &SavedModel,
        model: &RestoredModel<'_>,
        n: usize,
        seed: u64,
    ) -> Vec<Member> {
        let points = saved.draws(n, seed).points;
        points
            .iter()
            .filter_map(|point| model.member(point, self.member.start))
            .collect()
    }

    /// The rig with one parameter less and more by a fifth; the loop's center by that of its height above
    /// ambient. Those of drifts are not varied.
    #[must_use]
    pub fn variations<'m>(
        &self,
        saved: &'m SavedModel,
        model: &RestoredModel<'_>,
    ) -> Vec<Variation<'m, Member>> {
        let estimate = model.point();
        let drifts: Vec<&str> = model
            .drifts()
            .flat_map(|drift| drift.info().parameters)
            .map(|parameter| parameter.name)
            .collect();
        let shared = saved.parameters.iter().enumerate();
        shared
            .filter(|(_, parameter)| parameter.info.scope == Scope::Shared)
            .filter(|(_, parameter)| !drifts.contains(&parameter.info.name))
            .filter_map(|(k, parameter)| {
                let name = parameter.info.name;
                let zero = if name == "loop_center_degc" {
                    self.ambient_degc
                } else {
                    0.0
                };
                let admissible = parameter.info.admissible;
                let varied = |factor: f64| {
                    let mut point = estimate.clone();
                    point[k] = (zero + factor * (estimate[k] - zero))
                        .clamp(admissible.lower, admissible.upper);
                    model.member(&point, self.member.start)
                };
                Some(Variation {
                    name,
                    minus: varied(1.0 - VARIATION)?,
                    plus: varied(1.0 + VARIATION)?,
                })
            })
            .collect()
    }
}

fn turned(params: WienerParams, sign: f64) -> WienerParams {
    WienerParams {
        gain: sign * params.gain,
        offset: sign * params.offset,
        ..params
    }
}
