//! Tests of static recordings for effects that the plain loop leaves out.

use std::fmt;
use std::ops::ControlFlow;

use recording::Recording;
use wiener::hysteresis::Rule;

use crate::resistance_change::resistance_change;
use crate::{
    Bounds, Fit, FitConfig, FitProgress, ForwardModel, IdentifyError, LoopModel, ParameterVector,
    Rod, fit,
};

/// The effects of which static recordings can tell.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticEffects {
    /// `stress-coupling`: the loop's center rises with the stress.
    pub stress_coupling: Result<StaticEffect, NotTestable>,
    /// `phase-dependent-resistance`: the resistance changes with the transformed fraction.
    pub phase_dependent_resistance: Result<StaticEffect, NotTestable>,
    /// `functional-fatigue`: loop, stroke and rest drift with the number of cycles.
    pub functional_fatigue: Result<StaticEffect, NotTestable>,
}

/// One of them, tested.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticEffect {
    /// Its id.
    pub effect: &'static str,
    /// Estimates. The first are the sizes of the effect, which are 0 if it is absent.
    pub estimates: Vec<Estimate>,
    /// How many of them are sizes.
    pub n_sizes: usize,
    /// How well the same is met where that size is 0.
    pub without: StaticScore,
    /// How well it is met with the effect.
    pub with: StaticScore,
}

/// A number and how far it can be trusted.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Name, with its unit where it has a fixed one.
    pub name: &'static str,
    /// Value, in `unit`.
    pub value: f64,
    /// 95 % interval; `None` if the data do not fix it.
    pub interval: Option<Bounds>,
    /// Unit; "1" for a pure number.
    pub unit: String,
}

/// How well training recordings are met.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticScore {
    /// Root mean square of recording - model, in `unit`; of a resistance weighed by the square of the current.
    pub rmse: f64,
    /// Unit of `rmse`.
    pub unit: String,
    /// Schwarz's criterion, as [`Fit::bic`]: the lower the better, on the same recordings. Of a resistance under the
    /// autocorrelation that is left with the effect.
    pub bic: f64,
    /// True if the fit converged.
    pub converged: bool,
}

/// Why recordings say nothing of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum NotTestable {
    /// A recording has no stress.
    NoStress,
    /// Mean stresses of the recordings lie no further apart than the stress moves within them.
    OneStress {
        /// Lowest and highest mean, MPa.
        means_mpa: [f64; 2],
        /// Standard deviation within the recordings, MPa.
        within_mpa: f64,
    },
    /// No recording has a resistance.
    NoResistance,
    /// No recording goes through two cycles.
    OneCycle,
    /// Recordings differ in their stress: what the cycles do is not told from what the stress does.
    SeveralStresses,
    /// No current flows, or the transformed fraction never changes while it does.
    NoChange,
}

impl fmt::Display for NotTestable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoStress => f.write_str("not every recording has a stress"),
            Self::OneStress {
                means_mpa: [lowest, highest],
                within_mpa,
            } => write!(
                f,
                "the mean stresses, {lowest:.3} to {highest:.3} MPa, differ by no more than the stress moves \
                 within a recording, {within_mpa:.3} MPa"
            ),
            Self::NoResistance => f.write_str("no recording has a resistance"),
            Self::OneCycle => f.write_str("no recording goes through two cycles"),
            Self::SeveralStresses => f.write_str(
                "the recordings differ in their stress; give those of one stress by themselves",
            ),
            Self::NoChange => f.write_str("no current flows, or nothing transforms while it does"),
        }
    }
}

/// Tests the effects of which static recordings can tell, by fits to the training recordings.
///
/// ```text
/// stress-coupling              y = gain (1 + g (σ - σ_ref)) ξ(T - k (σ - σ_ref)) + offset,   without: k = 0
/// phase-dependent-resistance   R = R_0 (1 + ρ ξ),                                            without: ρ = 0
/// functional-fatigue           y = gain ((1 - b s) ξ(T - a s) + c s) + offset,                  without: a, b, c = 0
/// ```
///
/// The fraction under the resistance is that of the fitted loop: with the stress coupling, where that is tested
/// and has the lower criterion. `progress` is told of each start of each fit, of which there are one or two.
///
/// # Errors
///
/// As [`LoopModel::new`] and [`fit`].
pub fn static_effects(
    rod: &Rod,
    rule: Rule,
    training: &[Recording],
    config: &FitConfig,
    progress: &mut dyn FnMut(&FitProgress) -> ControlFlow<()>,
) -> Result<StaticEffects, IdentifyError> {
    let plain = LoopModel::new(rod, rule, training)?;
    let (stress_coupling, model, fitted, fatigue) = match differing_stresses(training) {
        Err(why) => {
            let fitted = fit(&plain, training, config, progress)?;
            let fatigue = fatigue(&plain, &fitted, training, config)?;
            (Err(why), plain, fitted, fatigue)
        }
        Ok(()) => {
            let coupled = plain.with_stress_coupling(training)?;
            let level = coupled.clone().without_shift();
            let without = fit(&level, training, config, progress)?;
            let with = fit(&coupled, training, config, progress)?;
            let effect = coupling(&without, &with);
            if with.bic < without.bic {
                (Ok(effect), coupled, with, Err(NotTestable::SeveralStresses))
            } else {
                (
                    Ok(effect),
                    level,
                    without,
                    Err(NotTestable::SeveralStresses),
                )
            }
        }
    };
    Ok(StaticEffects {
        stress_coupling,
        phase_dependent_resistance: resistance_change(&model, &fitted, training)?,
        functional_fatigue: fatigue,
    })
}

/// Tests functional fatigue, by a fit that starts from the one without it, fading or not.
fn fatigue(
    plain: &LoopModel,
    without: &Fit,
    training: &[Recording],
    config: &FitConfig,
) -> Result<Result<StaticEffect, NotTestable>, IdentifyError> {
    /// Rates to start from, 1/cycle.
    const FADINGS: [f64; 3] = [0.0, 0.05, 0.5];
    let Some(model) = plain.clone().with_fatigue(training) else {
        return Ok(Err(NotTestable::OneCycle));
    };
    let vector = ParameterVector::new(model.parameters(), training.len());
    let last = model.parameters().len() - 1;
    let from = FADINGS.map(|fading| {
        vector.coordinates(|parameter, r| {
            if parameter == last {
                return Some(fading);
            }
            let values = &without.parameters.get(parameter)?.values;
            values.get(r).or(values.first()).copied()
        })
    });
    let config = FitConfig {
        from: from.to_vec(),
        starts: 0,
        ended: Vec::new(),
        ..config.clone()
    };
    let with = fit(
        &model,
        training,
        &config,
        &mut |_| ControlFlow::Continue(()),
    )?;
    let mut estimates = estimates(&with, &LoopModel::FATIGUE);
    estimates.extend(model.fatigue_cycles().map(|cycles| Estimate {
        name: "cycles",
        value: cycles,
        interval: None,
        unit: "1".to_owned(),
    }));
    Ok(Ok(StaticEffect {
        effect: "functional-fatigue",
        n_sizes: LoopModel::FATIGUE.len() - 1,
        estimates,
        without: score(without),
        with: score(&with),
    }))
}

fn score(fit: &Fit) -> StaticScore {
    StaticScore {
        rmse: fit.train_rmse,
        unit: fit.output_unit.clone(),
        bic: fit.bic,
        converged: fit.converged(),
    }
}

fn estimates(fit: &Fit, names: &[&'static str]) -> Vec<Estimate> {
    let found = names.iter().filter_map(|name| fit.parameter(name));
    found
        .map(|parameter| Estimate {
            name: parameter.info.name,
            value: parameter.values[0],
            interval: parameter.intervals[0],
            unit: parameter.info.unit.clone(),
        })
        .collect()
}

/// Requires more than one load: a stress that only moves with the stroke looks like another loop.
fn differing_stresses(training: &[Recording]) -> Result<(), NotTestable> {
    let mut means_mpa = [f64::INFINITY, f64::NEG_INFINITY];
    let (mut squares, mut n) = (0.0, 0.0);
    for recording in training {
        let stress_pa = recording.stress_pa().ok_or(NotTestable::NoStress)?;
        let n_own = stress_pa.len() as f64;
        let mean_pa = stress_pa.iter().map(|pa| pa / n_own).sum::<f64>();
        let mean_mpa = mean_pa / 1e6;
        means_mpa = [means_mpa[0].min(mean_mpa), means_mpa[1].max(mean_mpa)];
        squares += stress_pa
            .iter()
            .map(|pa| (pa / 1e6 - mean_mpa).powi(2))
            .sum::<f64>();
        n += n_own;
    }
    let within_mpa = (squares / n).sqrt();
    if means_mpa[1] - means_mpa[0] > within_mpa {
        Ok(())
    } else {
        Err(NotTestable::OneStress {
            means_mpa,
            within_mpa,
        })
    }
}

fn coupling(without: &Fit, with: &Fit) -> StaticEffect {
    let mut estimates = estimates(with, &LoopModel::STRESS_EFFECTS);
    let shift = estimates[0].clone();
    // Around 0 a shift has no reciprocal that an interval could hold.
    let excludes_zero = |bounds: &Bounds| bounds.lower > 0.0 || bounds.upper < 0.0;
    estimates.push(Estimate {
        name: "stress_coupling_mpa_per_k",
        value: 1.0 / shift.value,
        interval: shift.interval.filter(excludes_zero).map(|k| Bounds {
            lower: 1.0 / k.upper,
            upper: 1.0 / k.lower,
        }),
        unit: "MPa/K".to_owned(),
    });
    StaticEffect {
        effect: "stress-coupling",
        n_sizes: 1,
        estimates,
        without: score(without),
        with: score(with),
    }
}

impl Estimate {
    /// True if the interval excludes 0.
    #[must_use]
    pub fn excludes_zero(&self) -> bool {
        self.interval
            .is_some_and(|bounds| bounds.lower > 0.0 || bounds.upper < 0.0)
    }
}

impl StaticEffect {
    /// True if the effect is found: Schwarz's criterion prefers it, and the interval of a size excludes 0.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.with.bic < self.without.bic && self.sizes().iter().any(Estimate::excludes_zero)
    }

    /// Its sizes.
    #[must_use]
    pub fn sizes(&self) -> &[Estimate] {
        &self.estimates[..self.n_sizes]
    }

    /// The estimate of a name.
    #[must_use]
    pub fn estimate(&self, name: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|estimate| estimate.name == name)
    }
}
