use pid_tune::{Pid, PidGains, PidParams};
use sma_effects::{EffectId, EffectSet, ExtendedPlant, Member, Setting};
use wiener::hysteresis::LoopFamily;

use crate::ExportError;
use crate::constants::LONGEST_SAMPLES;

/// A model that leaves the program.
#[derive(Debug, Clone)]
pub struct Exported {
    /// Drive, rule of memory, active effects.
    pub setting: Setting,
    /// Parameters, values of the effects, and the start of the first training recording; the start's temperature is above
    /// the surroundings, K.
    pub member: Member,
    /// Sample time, s; > 0.
    pub dt_s: f64,
    /// Magnitude beyond which the drive acts no further, in its unit.
    pub drive_limit: Option<f64>,
    /// Its controller.
    pub controller: Option<Controller>,
    /// Texts about it.
    pub labels: Labels,
}

/// A controller that leaves with its model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    /// All of it but the gains; its sample time is that of the model.
    pub params: PidParams,
    /// The gains.
    pub gains: PidGains,
    /// True if the output falls as the drive rises: signs of set point and measurement are changed.
    pub is_turned: bool,
}

/// Texts about a model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Labels {
    /// File of the model.
    pub model_file: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// Version of the program.
    pub version: String,
    /// The call.
    pub command: String,
    /// Unit of the drive: "A", "V", "W" or "duty".
    pub drive_unit: String,
    /// Unit of the output.
    pub output_unit: String,
    /// Temperature of the surroundings that the model states, °C.
    pub ambient_degc: Option<f64>,
    /// The recording whose offset and start the model has.
    pub recording: String,
    /// Parts of the model that are not exported.
    pub left_out: Vec<String>,
}

/// Effects that are a formula, without a search.
const FORMULAS: [EffectId; 13] = [
    EffectId::SupplyLimit,
    EffectId::SupplyLag,
    EffectId::DeadTime,
    EffectId::ReturnPointMemory,
    EffectId::LoopShape,
    EffectId::LoopAsymmetry,
    EffectId::RPhase,
    EffectId::ThermalExpansion,
    EffectId::EndStop,
    EffectId::Backlash,
    EffectId::OutputLag,
    EffectId::SensorNonlinearity,
    EffectId::ThermocoupleLag,
];

impl Exported {
    /// Effects that leave as source code.
    #[must_use]
    pub fn formulas() -> EffectSet {
        FORMULAS.into_iter().collect()
    }

    /// Checks that all of the model can leave as source code.
    ///
    /// # Errors
    ///
    /// [`ExportError`] naming what cannot.
    pub fn checked(&self) -> Result<(), ExportError> {
        if !(self.dt_s > 0.0 && self.dt_s.is_finite()) {
            return Err(ExportError::SampleTime { value: self.dt_s });
        }
        let setting = &self.setting;
        if setting.loop_family != LoopFamily::Proximity {
            return Err(ExportError::Family {
                family: setting.loop_family.id(),
                expected: LoopFamily::Proximity.id(),
            });
        }
        if !setting.hypotheses.is_empty() {
            return Err(ExportError::Hypotheses);
        }
        let known = Self::formulas();
        if let Some(effect) = setting.active.iter().find(|&one| !known.contains(one)) {
            return Err(ExportError::Effect {
                effect: effect.id(),
                known: FORMULAS.map(EffectId::id).join(", "),
            });
        }
        ExtendedPlant::new(setting, &self.member.params, &self.member.effects)?;
        let delay_s = self.member.effects.dead_time.dead_time_s;
        let longest_s = LONGEST_SAMPLES as f64 * self.dt_s;
        if setting.active.contains(EffectId::DeadTime) && delay_s > longest_s {
            return Err(ExportError::DeadTime {
                delay_s,
                longest: LONGEST_SAMPLES,
                longest_s,
            });
        }
        if let Some(controller) = &self.controller {
            Pid::new(controller.params, &[controller.gains])?;
        }
        Ok(())
    }
}
