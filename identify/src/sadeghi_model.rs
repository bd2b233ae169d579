//! The paper's own choice of unknowns.

use recording::Recording;
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::HeatBalanceParams;
use wiener::{Block, WienerParams};

use crate::cascade::{Cascade, StartAbove, ambient_degc};
use crate::wiener_model::zeta;
use crate::{
    AntagonistModel, Bounds, ForwardModel, IdentifyError, ParameterInfo, Rod, Scale, ThermalModel,
};

/// Smallest resistance and conductance: the bound of zero that is printed is no rod.
const SMALLEST: f64 = 1e-3;

/// The Wiener model with the unknowns and bounds of Sadeghi, section 4, for comparison with the paper.
///
/// ```text
/// R 0…2 Ω/m,  hA 0…3 W/(m K),  T_r -10…0 K,  h_0 0.1…2 K,  T_c 0.1…2 K
/// ```
///
/// The heat capacity of the rod file is taken as it is; T_r is the temperature of the cold start relative to
/// the middle of the loop. Such bounds hold for no real rod: resistance and temperatures share a factor
/// that the displacement does not show, and it settles wherever the bounds leave room. Only the mean squared
/// error can be compared. ζ, for which the paper prints neither value nor bounds, is searched too; gain and
/// offset are solved for.
#[derive(Debug, Clone)]
pub struct SadeghiModel {
    cascade: Cascade,
    heat_capacity_j_per_m_k: f64,
    ambient_degc: f64,
    parameters: Vec<ParameterInfo>,
}

// Order of the parameters in a point.
const RESISTANCE: usize = 0;
const CONDUCTANCE: usize = 1;
const COLD_START: usize = 2;
const SPREAD: usize = 3;
const HALF_WIDTH: usize = 4;
const ZETA: usize = 5;
const GAIN: usize = 6;
const OFFSET: usize = 7;

impl SadeghiModel {
    /// The model of a rig.
    ///
    /// # Errors
    ///
    /// [`IdentifyError`] for a missing ambient temperature, supply or heat capacity, an output that is a temperature, and what `[model]` says
    /// of parameters that do not exist or of values that cannot be.
    pub fn new(rod: &Rod, rule: Rule, training: &[Recording]) -> Result<Self, IdentifyError> {
        let first = training.first().ok_or(IdentifyError::NoRecordings)?;
        if AntagonistModel::is_for(training) {
            return Err(IdentifyError::TwoRods {
                recording: first.name().to_owned(),
            });
        }
        if ThermalModel::is_for(first.output_unit()) {
            return Err(IdentifyError::OnlyTemperature {
                recording: first.name().to_owned(),
            });
        }
        let mut model = Self::template(rod, rule, training)?;
        model.parameters = parameters(first.output_unit());
        rod.apply_model(&mut model.parameters)?;
        Ok(model)
    }

    /// The model before anything is known of recordings; see
    /// [`WienerModel::template`](crate::WienerModel).
    pub(crate) fn template(
        rod: &Rod,
        rule: Rule,
        training: &[Recording],
    ) -> Result<Self, IdentifyError> {
        let Some(heat_capacity_j_per_m_k) = rod.heat_capacity_j_per_m_k() else {
            return Err(IdentifyError::Missing {
                file: rod.file.clone(),
                key: "rod.diameter_mm, density_kg_per_m3 or specific_heat_j_per_kg_k",
                why: "the paper's bounds of R and hA mean nothing without the heat capacity",
            });
        };
        Ok(Self {
            cascade: Cascade::new(rod, rule)?,
            heat_capacity_j_per_m_k,
            ambient_degc: ambient_degc(rod, training)?,
            parameters: parameters("1"),
        })
    }

    pub(crate) fn parameters_mut(&mut self) -> &mut [ParameterInfo] {
        &mut self.parameters
    }

    /// The model's parameters for one point.
    #[must_use]
    pub fn wiener_params(&self, point: &[f64]) -> WienerParams {
        WienerParams {
            heat: HeatBalanceParams {
                heat_capacity_j_per_m_k: self.heat_capacity_j_per_m_k,
                conductance_w_per_m_k: point[CONDUCTANCE],
                resistance_ohm_per_m: point[RESISTANCE],
            },
            limiting_loop: LoopParams {
                loop_center_degc: self.ambient_degc - point[COLD_START],
                loop_half_width_k: point[HALF_WIDTH],
                loop_spread_k: point[SPREAD],
                ..LoopParams::default()
            },
            zeta: point[ZETA],
            gain: point[GAIN],
            offset: point[OFFSET],
        }
    }
}

impl ForwardModel for SadeghiModel {
    fn parameters(&self) -> &[ParameterInfo] {
        &self.parameters
    }

    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        self.cascade.simulate(points, recording, visit, |point| {
            (self.wiener_params(point), StartAbove::REST)
        })
    }
}

/// As printed, but for [`SMALLEST`]; searched on a linear scale, as by the paper.
fn parameters(output_unit: &str) -> Vec<ParameterInfo> {
    let searched = |name, unit, lower, upper| {
        ParameterInfo::searched(name, unit, Scale::Linear, Bounds { lower, upper })
    };
    let positive = |info: ParameterInfo| ParameterInfo {
        admissible: Bounds {
            lower: 1e-12,
            upper: 1e12,
        },
        ..info
    };
    vec![
        positive(searched("resistance_ohm_per_m", "Ω/m", SMALLEST, 2.0)),
        positive(searched("conductance_w_per_m_k", "W/(m K)", SMALLEST, 3.0)),
        searched("cold_start_k", "K", -10.0, 0.0),
        positive(searched("loop_spread_k", "K", 0.1, 2.0)),
        positive(searched("loop_half_width_k", "K", 0.1, 2.0)),
        zeta(),
        ParameterInfo::gain(output_unit),
        ParameterInfo::offset(output_unit),
    ]
}
