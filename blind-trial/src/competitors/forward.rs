//! Forward selection by Schwarz's criterion.

use identify::{
    Fit, ForwardModel, IdentifyError, LeastSquaresConfig, ParameterVector, RefineConfig, Refined,
    Validated, refine, validate_at,
};
use missing_physics::{Candidate, ExtendedModel, ScreenConfig, screen};
use rayon::prelude::*;
use recording::Recording;
use serde::{Deserialize, Serialize};
use sma_effects::{EffectId, EffectSet, Role, Setting, Sign};

use crate::verdict::Opened;

/// Most effects that are taken.
const MOST_EFFECTS: usize = 4;

/// Iterations of a refit that is only to be compared with others, and until a refit has its end.
const ITERATIONS: [usize; 2] = [8, 60];

/// Sizes from which a refit may start, as shares of the typical one; the negative ones where a size may be negative.
const STARTS: [f64; 4] = [1.0, 0.25, -0.25, -1.0];

/// Effects that are added one by one, the best first, as long as that lowers Schwarz's criterion for independent errors.
///
/// ```text
/// n ln(MSE) + n_T ln(MSE_T) + k ln(n + n_T)        [Schwarz 1978]
/// ```
///
/// n, n_T are the samples of output and recorded temperature, k the free parameters, offsets counted
/// (doi:10.1214/aos/1176344136). This is the common practice with grey-box models: neighbors in the residual count as
/// independent, and nothing controls how often an effect is taken that is not there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Forward {
    /// Ids of the effects in the order in which they were taken; at most four.
    pub effects: Vec<String>,
    /// Error of the model with them on the unseen recording, mm; `None` without one.
    pub unseen_mm: Option<f64>,
}

pub(super) fn forward(files: &Opened, plain: &Fit) -> Result<Forward, IdentifyError> {
    let bench = Bench::new(files, plain);
    let left = bench.computable()?;
    let mut best = bench.plain()?;
    let mut order = Vec::new();
    while order.len() < MOST_EFFECTS {
        let Some((effect, next)) = bench.next(&best, left) else {
            break;
        };
        order.push(effect);
        best = next;
    }
    Ok(Forward {
        effects: order.iter().map(|effect| effect.id().to_owned()).collect(),
        unseen_mm: best.unseen_mm(&files.unseen)?,
    })
}

/// Files and plain fit that all models are fitted to.
#[derive(Debug)]
struct Bench<'a> {
    files: &'a Opened,
    plain: &'a Fit,
    /// Samples of the output and of the temperature.
    n: [usize; 2],
}

/// A model with effects, refitted.
#[derive(Debug)]
struct Fitted {
    effects: EffectSet,
    model: ExtendedModel,
    refined: Refined,
    bic: f64,
}

impl<'a> Bench<'a> {
    fn new(files: &'a Opened, plain: &'a Fit) -> Self {
        let n = |of: fn(&Recording) -> usize| files.training.iter().map(of).sum();
        let temperatures =
            |recording: &Recording| recording.temperature_degc().map_or(0, <[_]>::len);
        Self {
            files,
            plain,
            n: [n(Recording::len), n(temperatures)],
        }
    }

    /// Effects of the catalogue of which all is known that they need.
    fn computable(&self) -> Result<EffectSet, IdentifyError> {
        let config = &self.files.config;
        let screening = screen(
            &self.files.base,
            self.plain,
            &self.files.training,
            &ScreenConfig {
                setting: config.setting,
                seed: config.seed,
            },
        )?;
        let unknown = screening.unknown.iter();
        Ok(unknown
            .filter_map(|(candidate, _)| Candidate::effect(*candidate))
            .fold(config.catalogue, EffectSet::without))
    }

    /// The baseline model, its gain searched as that of the others is.
    fn plain(&self) -> Result<Fitted, IdentifyError> {
        let model = self.model(EffectSet::EMPTY);
        let vector = ParameterVector::new(model.parameters(), self.files.training.len());
        let start = self.plain.coordinates(&vector);
        let weight = match self.plain.temperature_rmse_k {
            Some(rmse_k) if rmse_k > 0.0 => (self.plain.train_rmse / rmse_k).powi(2),
            _ => 0.0,
        };
        self.fitted(EffectSet::EMPTY, &[start], weight, ITERATIONS[1])
    }

    /// The effect that lowers the criterion most, and the model with it at the end of its search; `None` if none lowers it.
    fn next(&self, parent: &Fitted, catalogue: EffectSet) -> Option<(EffectId, Fitted)> {
        let wanted: Vec<EffectId> = catalogue
            .iter()
            .filter(|&effect| !parent.effects.contains(effect))
            .collect();
        let tried: Vec<Option<Fitted>> = wanted
            .par_iter()
            .map(|&effect| self.tried(parent, effect).ok())
            .collect();
        let pairs = wanted.into_iter().zip(tried);
        let (effect, best) = pairs
            .filter_map(|(effect, fitted)| Some((effect, fitted?)))
            .min_by(|(_, a), (_, b)| a.bic.total_cmp(&b.bic))
            .filter(|(_, best)| best.bic < parent.bic)?;
        let start = std::slice::from_ref(&best.refined.coordinates);
        let weight = self.temperature_weight(&best.refined);
        let ended = self.fitted(best.effects, start, weight, ITERATIONS[1]);
        let ended = ended.ok().filter(|ended| ended.bic < best.bic);
        Some((effect, ended.unwrap_or(best)))
    }

    /// The model of a parent with one effect more, from whichever start leaves least.
    fn tried(&self, parent: &Fitted, effect: EffectId) -> Result<Fitted, IdentifyError> {
        let effects = parent.effects.with(effect);
        let weight = self.temperature_weight(&parent.refined);
        let starts = self.starts(parent, effect);
        let nearest = self.fitted(effects, &starts, weight, 0)?;
        let start = std::slice::from_ref(&nearest.refined.coordinates);
        self.fitted(effects, start, weight, ITERATIONS[0])
    }

    /// Coordinates with the parent's values and one effect more: sizes around the typical ones, partners at theirs.
    fn starts(&self, parent: &Fitted, effect: EffectId) -> Vec<Vec<f64>> {
        let model = self.model(parent.effects.with(effect));
        let vector = ParameterVector::new(model.parameters(), self.files.training.len());
        let n_plain = self.files.base.parameters().len();
        let own = effect.info().parameters;
        let is_two_sided = own
            .iter()
            .any(|one| one.sign() == Sign::Either && one.role == Role::Size);
        let start = |share: f64| {
            vector.coordinates(|parameter, r| {
                let point = &parent.refined.points[r];
                if parameter < n_plain {
                    return Some(point[parameter]);
                }
                let (other, index) = slot(&model, parameter)?;
                if other != effect {
                    return Some(point[parent.model.first_parameter(other)? + index]);
                }
                let info = &own[index];
                Some(match (info.role, info.sign()) {
                    (Role::Partner { .. }, _) => info.typical,
                    (Role::Size, Sign::Either) => share * info.typical,
                    (Role::Size, Sign::NonNegative) => share.abs() * info.typical,
                })
            })
        };
        let shares = STARTS
            .into_iter()
            .filter(|&share| share > 0.0 || is_two_sided);
        shares.map(start).collect()
    }

    fn model(&self, effects: EffectSet) -> ExtendedModel {
        let Opened {
            base,
            config,
            training,
            ..
        } = self.files;
        let drives = training.iter().map(Recording::largest_drive);
        let setting = Setting {
            largest_drive: Some(drives.fold(0.0, f64::max)).filter(|largest| *largest > 0.0),
            ..config.setting
        };
        ExtendedModel::new(base, self.plain, setting, effects)
    }

    fn fitted(
        &self,
        effects: EffectSet,
        starts: &[Vec<f64>],
        temperature_weight: f64,
        iterations: usize,
    ) -> Result<Fitted, IdentifyError> {
        let config = RefineConfig {
            least_squares: LeastSquaresConfig {
                iterations,
                relative_offset: 1e-3,
                ..LeastSquaresConfig::default()
            },
            temperature_weight,
            ..RefineConfig::default()
        };
        let model = self.model(effects);
        let training = &self.files.training;
        let refined = refine(&model, training, starts, &config)?;
        let n_free = refined.coordinates.len() + training.len();
        let n: usize = self.n.iter().sum();
        Ok(Fitted {
            bic: refined.deviance + n_free as f64 * (n as f64).ln(),
            effects,
            model,
            refined,
        })
    }

    /// Weight by which both channels count as well as a model meets them, (mm/K)²; 0 without temperatures.
    fn temperature_weight(&self, refined: &Refined) -> f64 {
        let [n, n_temperatures] = self.n.map(|n| n as f64);
        if n_temperatures > 0.0 {
            let of_temperature = refined.deviance - n * refined.mean_square.ln();
            refined.mean_square / (of_temperature / n_temperatures).exp()
        } else {
            0.0
        }
    }
}

impl Fitted {
    fn unseen_mm(&self, unseen: &[Recording]) -> Result<Option<f64>, IdentifyError> {
        let validated = unseen
            .iter()
            .map(|recording| validate_at(&self.model, &self.refined.points[0], recording))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Validated::rmse_of_all(&validated))
    }
}

/// The effect and the number of its parameter that a parameter of a model is; `None` for the baseline model's.
fn slot(model: &ExtendedModel, parameter: usize) -> Option<(EffectId, usize)> {
    model.active().effects().iter().find_map(|effect| {
        let index = parameter.checked_sub(model.first_parameter(effect)?)?;
        (index < effect.info().parameters.len()).then_some((effect, index))
    })
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::opened;
    use super::*;
    use crate::Family;

    #[test]
    fn latent_heat_is_taken_first() {
        let (files, plain) = opened(Family::Single, 7);
        let forward = forward(&files, &plain.fit).unwrap();
        assert_eq!(forward.effects[0], "latent-heat", "{forward:?}");
        assert!(forward.unseen_mm < plain.validated.first().map(|one| one.rmse));
    }
}
