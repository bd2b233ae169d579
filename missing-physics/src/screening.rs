//! Which effects could explain what a fitted baseline leaves, before anything is refitted.

use identify::{Fit, IdentifyError, WienerModel};
use recording::Recording;

use crate::scores::scores;
use crate::tangent::tangent;
use crate::whiten::Whitener;
use crate::{EffectId, Need, Setting};

/// Standard normal quantiles of the power with which a size counts as detectable: 95 %.
const POWER: f64 = 1.645;

/// Settings of a screening.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenConfig {
    /// What all extended plants have in common.
    pub setting: Setting,
    /// Seed of the null distribution.
    pub seed: u64,
}

/// What screening says of one effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Screened {
    /// The effect.
    pub effect: EffectId,
    /// Score in standard deviations, whitened by the residuals' own memory: that of its best size and
    /// partner. It hides large effects, whose trace is part of that memory.
    pub whitened: f64,
    /// The same of the series as they are, with the variance of correlated residuals.
    pub plain: f64,
    /// Size to first order, in the unit of its parameter.
    pub size: f64,
    /// Smallest size that this recording would show in 95 % of cases.
    pub minimum_detectable: f64,
    /// Share of its trace's square that refitting the baseline hides.
    pub absorbed: f64,
    /// Value of its partner at which it scores best.
    pub partner: Option<f64>,
}

/// Scores of all effects that can be computed for a rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Screening {
    /// In the order of the catalogue.
    pub effects: Vec<Screened>,
    /// Effects that need what is not known of the rig, and what that is.
    pub unknown: Vec<(EffectId, Need)>,
    /// Whitened score that noise alone exceeds in 5 % of files, the number of effects counted.
    pub critical: f64,
}

/// Screens the catalogue at a fitted baseline.
///
/// Each effect's secant at a quarter of its typical size is freed of what the baseline's own parameters could
/// do, and compared with what is left of the recording (score test, DIAGNOSIS 2.5). Nothing is refitted: a
/// score is a reason to refit, never a name.
///
/// # Errors
///
/// What the models refuse.
pub fn screen(
    base: &WienerModel,
    fit: &Fit,
    training: &[Recording],
    config: &ScreenConfig,
) -> Result<Screening, IdentifyError> {
    let mut unknown = Vec::new();
    let mut effects = Vec::new();
    for effect in EffectId::ALL {
        match missing(effect, base, &config.setting, training) {
            Some(need) => unknown.push((effect, need)),
            None => effects.push(effect),
        }
    }
    let (tangent, origins) = tangent(base, fit, config.setting, &effects, training)?;
    let lengths: Vec<usize> = training.iter().map(Recording::len).collect();
    let whitener = Whitener::new(&fit.noise.coefficients, &lengths);
    let deviation = fit.noise.innovation_variance.sqrt();
    let found = scores(&tangent, &whitener, deviation, config.seed);
    let screened = effects.iter().filter_map(|&effect| {
        let own = (0..origins.len()).filter(|&k| origins[k].effect == effect);
        // One that may only be positive counts for nothing if it would have to be negative.
        let size = |k: usize| {
            let score = found.scores[k].plain;
            if tangent.candidates[k].one_sided {
                score
            } else {
                score.abs()
            }
        };
        let best = own.max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
        let score = found.scores[best];
        Some(Screened {
            effect,
            whitened: score.whitened,
            plain: score.plain,
            size: score.size,
            minimum_detectable: (found.critical + POWER) * score.error,
            absorbed: score.absorbed,
            partner: origins[best].partner,
        })
    });
    Ok(Screening {
        effects: screened.collect(),
        unknown,
        critical: found.critical,
    })
}

/// What an effect needs and is not known.
fn missing(
    effect: EffectId,
    base: &WienerModel,
    setting: &Setting,
    training: &[Recording],
) -> Option<Need> {
    let electrical = !matches!(base.drive(), wiener::Drive::Power { .. });
    let thermometer = training
        .iter()
        .any(|recording| recording.temperature_degc().is_some());
    effect.info().needs.iter().copied().find(|need| match need {
        Need::MassPerMeter => setting.mass_kg_per_m.is_none(),
        Need::SurfacePerMeter => setting.surface_m2_per_m.is_none(),
        Need::Length => setting.length_output.is_none(),
        Need::ElectricalDrive => !electrical,
        Need::TemperatureChannel => !thermometer,
        // Each recording has its length, and without a load the loop shifts all the same.
        Need::RunLength | Need::Load => false,
        Need::AbsoluteTemperature => !base.knows_temperature(),
    })
}
