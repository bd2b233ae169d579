//! The model that a rod file asks for.

use recording::{Quantity, Recording};
use serde::{Deserialize, Serialize};
use wiener::hysteresis::Rule;
use wiener::{Block, WienerParams};

use crate::{
    AntagonistModel, Fit, ForwardModel, IdentifyError, LoopModel, ParameterInfo, Rod, SadeghiModel,
    ThermalModel, WienerModel,
};

/// The baseline model of a rig.
#[derive(Debug, Clone)]
pub enum RigModel {
    /// A rod heated by its drive.
    Wiener(WienerModel),
    /// A rod heated by its drive, with the unknowns of the paper.
    Sadeghi(SadeghiModel),
    /// Static data: the loop alone.
    Loop(LoopModel),
    /// The output is the temperature: the heat balance alone.
    Thermal(ThermalModel),
    /// Two rods that pull against one another, each with its drive.
    Antagonist(AntagonistModel),
}

/// Kind of a baseline model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ModelKind {
    /// [`RigModel::Wiener`].
    Wiener,
    /// [`RigModel::Sadeghi`].
    Sadeghi,
    /// [`RigModel::Loop`].
    StaticLoop,
    /// [`RigModel::Thermal`].
    Thermal,
    /// [`RigModel::Antagonist`].
    Antagonist,
}

/// Properties that a model is made of before anything is known of its parameters.
#[derive(Debug, Clone, Copy)]
pub struct ModelTemplate<'a> {
    /// Kind of the model.
    pub kind: ModelKind,
    /// Known properties of the rig.
    pub rod: &'a Rod,
    /// Rule of its memory.
    pub rule: Rule,
    /// True if the rise of temperature is assumed, not known: see [`RigModel::knows_temperature`].
    pub rise_is_assumed: bool,
    /// Name of the recording whose surroundings are those of the rig.
    pub reference: Option<&'a str>,
    /// Unit of the output.
    pub output_unit: &'a str,
    /// Unit of the drive.
    pub drive_unit: &'a str,
}

impl RigModel {
    /// A model whose parameters have placeholders for units and bounds, to be set by [`RigModel::parameters_mut`].
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Missing`], [`IdentifyError::NoTemperature`] and [`IdentifyError::StaticDrive`]: the rig lacks what the
    /// kind needs.
    pub fn of_template(template: &ModelTemplate<'_>) -> Result<Self, IdentifyError> {
        let &ModelTemplate {
            kind,
            rod,
            rule,
            rise_is_assumed,
            reference,
            output_unit,
            drive_unit,
        } = template;
        Ok(match kind {
            ModelKind::Wiener => {
                let model = WienerModel::template(rod, rule, rise_is_assumed, &|_| Vec::new())?;
                Self::Wiener(model.with_reference(reference))
            }
            ModelKind::Antagonist => {
                let model = AntagonistModel::template(rod, rule, rise_is_assumed, reference)?;
                Self::Antagonist(model)
            }
            ModelKind::Sadeghi => Self::Sadeghi(SadeghiModel::template(rod, rule, &[])?),
            ModelKind::StaticLoop => Self::Loop(LoopModel::template(rule, drive_unit)),
            ModelKind::Thermal => Self::Thermal(ThermalModel::template(rod, output_unit)?),
        })
    }

    /// Kind of the model.
    #[must_use]
    pub fn kind(&self) -> ModelKind {
        match self {
            Self::Wiener(_) => ModelKind::Wiener,
            Self::Sadeghi(_) => ModelKind::Sadeghi,
            Self::Loop(_) => ModelKind::StaticLoop,
            Self::Thermal(_) => ModelKind::Thermal,
            Self::Antagonist(_) => ModelKind::Antagonist,
        }
    }

    /// The parameters, to be set from a file.
    pub fn parameters_mut(&mut self) -> &mut [ParameterInfo] {
        match self {
            Self::Wiener(model) => model.parameters_mut(),
            Self::Sadeghi(model) => model.parameters_mut(),
            Self::Loop(model) => model.parameters_mut(),
            Self::Thermal(model) => model.parameters_mut(),
            Self::Antagonist(model) => model.parameters_mut(),
        }
    }

    /// The model for what drives the rig and what was recorded of it: the cascade, two of them where there are two drives, for static
    /// data the loop alone, and where the output is the temperature the heat balance alone.
    ///
    /// # Errors
    ///
    /// As [`WienerModel::new`], [`LoopModel::new`] and [`ThermalModel::new`].
    pub fn new(rod: &Rod, rule: Rule, training: &[Recording]) -> Result<Self, IdentifyError> {
        Ok(match rod.drive_kind {
            Quantity::Temperature => Self::Loop(LoopModel::new(rod, rule, training)?),
            _ if training.first().is_some_and(shows_temperature) => {
                Self::Thermal(ThermalModel::new(rod, training)?)
            }
            _ if AntagonistModel::is_for(training) => {
                Self::Antagonist(AntagonistModel::new(rod, rule, training)?)
            }
            _ => Self::Wiener(WienerModel::new(rod, rule, training)?),
        })
    }

    /// See [`WienerModel::with_open_starts`]; the other models stay as they are.
    #[must_use]
    pub fn with_open_starts(self, training: &[Recording]) -> Self {
        match self {
            Self::Wiener(model) => Self::Wiener(model.with_open_starts(training)),
            Self::Antagonist(model) => Self::Antagonist(model.with_open_starts(training)),
            other => other,
        }
    }

    /// The parameters of the cascade at a point; `None` for a static loop, a heat balance and a pair of rods.
    #[must_use]
    pub fn wiener_params(&self, point: &[f64]) -> Option<WienerParams> {
        match self {
            Self::Wiener(model) => Some(model.wiener_params(point)),
            Self::Sadeghi(model) => Some(model.wiener_params(point)),
            Self::Loop(_) | Self::Thermal(_) | Self::Antagonist(_) => None,
        }
    }

    /// Opens the starts of validation recordings, too. For a heat balance see [`ThermalModel::with_starts_of`]; the
    /// other models stay as they are.
    #[must_use]
    pub fn seeing(self, unseen: &[Recording]) -> Self {
        match self {
            Self::Thermal(model) => Self::Thermal(model.with_starts_of(unseen)),
            other => other,
        }
    }

    /// The model with a sensor that lags, and coordinates to search it from, for a second fit: see
    /// [`ThermalModel::with_lag`]. `None` for models without a sensor lag.
    #[must_use]
    pub fn with_lag(&self, without: &Fit) -> Option<(Self, Vec<Vec<f64>>)> {
        match self {
            Self::Thermal(model) => {
                let (model, from) = model.with_lag(without)?;
                Some((Self::Thermal(model), from))
            }
            Self::Wiener(_) | Self::Sadeghi(_) | Self::Loop(_) | Self::Antagonist(_) => None,
        }
    }

    /// See [`ThermalModel::lag_shows`]; of the other models none does.
    #[must_use]
    pub fn lag_shows(&self, without: &Fit, with: &Fit) -> bool {
        matches!(self, Self::Thermal(model) if model.lag_shows(without, with))
    }

    /// See [`WienerModel::carry_specific_heat`]; the other models have no such range.
    pub fn carry_specific_heat(&self, fit: &mut Fit) -> bool {
        match self {
            Self::Wiener(model) => model.carry_specific_heat(fit),
            Self::Antagonist(model) => model.carry_specific_heat(fit),
            Self::Sadeghi(_) | Self::Loop(_) | Self::Thermal(_) => false,
        }
    }

    /// True if temperatures are in kelvins; see [`WienerModel::knows_temperature`].
    #[must_use]
    pub fn knows_temperature(&self) -> bool {
        match self {
            Self::Wiener(model) => model.knows_temperature(),
            Self::Antagonist(model) => model.knows_temperature(),
            Self::Sadeghi(_) => false,
            Self::Loop(_) | Self::Thermal(_) => true,
        }
    }
}

impl ForwardModel for RigModel {
    fn parameters(&self) -> &[ParameterInfo] {
        match self {
            Self::Wiener(model) => model.parameters(),
            Self::Sadeghi(model) => model.parameters(),
            Self::Loop(model) => model.parameters(),
            Self::Thermal(model) => model.parameters(),
            Self::Antagonist(model) => model.parameters(),
        }
    }

    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        match self {
            Self::Wiener(model) => model.simulate(points, recording, visit),
            Self::Sadeghi(model) => model.simulate(points, recording, visit),
            Self::Loop(model) => model.simulate(points, recording, visit),
            Self::Thermal(model) => model.simulate(points, recording, visit),
            Self::Antagonist(model) => model.simulate(points, recording, visit),
        }
    }

    fn branches_degc(&self, point: &[f64]) -> Option<[f64; 2]> {
        match self {
            Self::Wiener(model) => model.branches_degc(point),
            Self::Sadeghi(model) => model.branches_degc(point),
            Self::Loop(model) => model.branches_degc(point),
            Self::Antagonist(model) => model.branches_degc(point),
            Self::Thermal(_) => None,
        }
    }
}

fn shows_temperature(recording: &Recording) -> bool {
    ThermalModel::is_for(recording.output_unit())
}
