//! An identified rig as something to be controlled.

use identify::{RigModel, SavedModel, Scope};
use pid_tune::Variation;
use recording::Quantity;
use wiener::hysteresis::Rule;
use wiener::{Drive, Ensemble, Member, Plant, Start, Wiener, WienerError, WienerParams};

/// Largest drive over that of the training from which a prediction is called a guess.
pub(crate) const BEYOND: f64 = 1.02;

/// By how much a parameter is varied to see what depends on it.
const VARIATION: f64 = 0.2;

/// A rig whose output rises with heat: one whose output falls is turned over, and its set points with it.
#[derive(Debug, Clone)]
pub(crate) struct Rig {
    pub(crate) params: WienerParams,
    pub(crate) drive: Drive,
    pub(crate) rule: Rule,
    pub(crate) ambient_degc: f64,
    pub(crate) drive_max: f64,
    /// Largest drive of the training recordings.
    pub(crate) largest_drive: f64,
    /// Whether the model was identified to a minimum.
    pub(crate) converged: bool,
    pub(crate) output_unit: String,
    pub(crate) drive_unit: String,
    /// -1 if the output falls with heat.
    sign: f64,
    /// The highest temperature that the rig stands, °C.
    temperature_max_degc: f64,
}

/// Why a model cannot be controlled as asked.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RigError {
    #[error(
        "{file}: a static loop has no time constant; to be controlled a rig needs a recording with time"
    )]
    Static { file: String },
    #[error(
        "{file}: limits.drive_max is missing: the controller needs it; give it there or as --drive-max; the recordings went to {largest}"
    )]
    DriveMax { file: String, largest: f64 },
    #[error("--drive-max {value}: must be finite and > 0")]
    DriveMaxValue { value: f64 },
    #[error("drive_max = {value}: a duty is at most 1; the recordings went to {largest}")]
    Duty { value: f64, largest: f64 },
    #[error(
        "set point {value} {unit}: beyond what the rig reaches, {lower} to {upper} {unit} with a drive of at most {drive_max} {drive_unit}"
    )]
    SetPoint {
        value: f64,
        lower: String,
        upper: String,
        unit: String,
        drive_max: f64,
        drive_unit: String,
    },
    #[error("{file}: ambient_degc is missing; give it in [surroundings]")]
    Ambient { file: String },
    #[error("{what} is missing: {why}")]
    Missing {
        what: &'static str,
        why: &'static str,
    },
    #[error("{name} = {value}: {accepted}")]
    Value {
        name: &'static str,
        value: f64,
        accepted: &'static str,
    },
}

impl Rig {
    pub(crate) fn of(saved: &SavedModel, drive_max: Option<f64>) -> Result<Self, anyhow::Error> {
        let rod = saved.rod();
        let file = || rod.file().to_owned();
        let Some(params) = saved.wiener_params() else {
            return Err(RigError::Static { file: file() }.into());
        };
        let drive_max = match drive_max {
            Some(value) if value > 0.0 && value.is_finite() => value,
            Some(value) => return Err(RigError::DriveMaxValue { value }.into()),
            None => match rod.limits.drive_max {
                Some(value) => value,
                None => {
                    let largest = saved.largest_drive();
                    let file = file();
                    return Err(RigError::DriveMax { file, largest }.into());
                }
            },
        };
        if rod.drive_kind == Quantity::Duty && drive_max > 1.0 {
            let largest = saved.largest_drive();
            let value = drive_max;
            return Err(RigError::Duty { value, largest }.into());
        }
        let Some(ambient_degc) = rod.ambient_degc else {
            return Err(RigError::Ambient { file: file() }.into());
        };
        let sign = if params.gain < 0.0 { -1.0 } else { 1.0 };
        Ok(Self {
            params: turned(params, sign),
            drive: rod.drive()?,
            rule: saved.rule(),
            ambient_degc,
            drive_max,
            largest_drive: saved.largest_drive(),
            converged: saved.scores().converged,
            output_unit: saved.output_unit().to_owned(),
            drive_unit: match rod.drive_kind {
                Quantity::Duty => "duty".to_owned(),
                other => other.unit().to_owned(),
            },
            sign,
            temperature_max_degc: match rod.limits.temperature_max_degc {
                Some(limit) if saved.model().knows_temperature() => limit,
                _ => f64::INFINITY,
            },
        })
    }

    /// Whether the output falls with heat, so that signs are turned.
    pub(crate) fn is_turned(&self) -> bool {
        self.sign < 0.0
    }

    /// An output of the sensor as the controller sees it, and back.
    pub(crate) fn signed(&self, output: f64) -> f64 {
        self.sign * output
    }

    /// How far the output can go.
    pub(crate) fn stroke(&self) -> f64 {
        self.params.gain
    }

    pub(crate) fn ensemble(&self) -> Ensemble {
        Ensemble {
            drive: self.drive,
            rule: self.rule,
        }
    }

    /// The rod at rest.
    pub(crate) fn member(&self) -> Member {
        self.member_of(self.params)
    }

    fn member_of(&self, params: WienerParams) -> Member {
        Member {
            params,
            start: Start::rest(self.ambient_degc),
        }
    }

    pub(crate) fn plant(&self) -> Result<Wiener, WienerError> {
        Wiener::new(self.drive, self.rule, &[self.params])
    }

    /// The rig with its sensor's zero moved so that it reads this at rest.
    pub(crate) fn resting_at(&self, output: f64) -> Result<Self, WienerError> {
        let mut moved = self.clone();
        moved.params.offset += self.signed(output) - self.rest_output()?;
        Ok(moved)
    }

    /// Output of the cold rod, as the controller sees it.
    pub(crate) fn rest_output(&self) -> Result<f64, WienerError> {
        let plant = self.plant()?;
        Ok(plant.output(&plant.rest(self.ambient_degc)).displacement[0])
    }

    /// Output that the largest drive holds in the end, heated from rest.
    fn hot_output(&self) -> Result<f64, WienerError> {
        let plant = self.plant()?;
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

    /// Refuses a set point that no drive within the limits holds.
    pub(crate) fn check_set_point(&self, output: f64) -> Result<(), anyhow::Error> {
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
    pub(crate) fn draws(&self, saved: &SavedModel, n: usize, seed: u64) -> Vec<Member> {
        let points = saved.draws(n, seed).points;
        points
            .iter()
            .filter_map(|point| self.member_at(saved.model(), point))
            .collect()
    }

    /// The rod with one parameter less and more by a fifth; the loop's center by that of its height above
    /// ambient.
    pub(crate) fn variations<'m>(&self, saved: &'m SavedModel) -> Vec<Variation<'m, Member>> {
        let estimate = saved.point(0);
        let shared = saved.parameters().iter().enumerate();
        shared
            .filter(|(_, parameter)| parameter.info.scope == Scope::Shared)
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
                    self.member_at(saved.model(), &point)
                };
                Some(Variation {
                    name,
                    minus: varied(1.0 - VARIATION)?,
                    plus: varied(1.0 + VARIATION)?,
                })
            })
            .collect()
    }

    fn member_at(&self, model: &RigModel, point: &[f64]) -> Option<Member> {
        let params = model.wiener_params(point)?;
        Some(self.member_of(turned(params, self.sign)))
    }
}

fn turned(params: WienerParams, sign: f64) -> WienerParams {
    WienerParams {
        gain: sign * params.gain,
        offset: sign * params.offset,
        ..params
    }
}
