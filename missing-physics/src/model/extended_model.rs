//! The Wiener model with some of the catalogue's effects, as a model to be fitted.

use identify::{
    Bounds, Enters, Fit, ForwardModel, IdentifyError, Ordinary, ParameterInfo, ParameterState,
    SECOND_POPULATION_PARAMETERS, SHAPE_PARAMETERS, Scale, Scope, StateOfRun, WienerModel,
    in_states, parameters_of_family,
};
use recording::Recording;
use wiener::Block;
use wiener::hysteresis::SecondPopulation;

use crate::{
    Belongs, Candidate, CandidateSet, EffectValues, Extended, FamilyShape, LoopFamily, Member,
    Setting,
};

/// Factor by which a gain may leave that of the baseline, either way.
const GAIN_FACTOR: f64 = 4.0;

/// A rig's baseline and the effects that may have a size.
///
/// Parameters: those of the baseline, in their order, then what the loop's family has beside them, then those of each
/// effect in the order of the catalogue. The gain is searched: effects behind it are in the unit of the output, so that it cannot be
/// solved for. Offsets still are.
#[derive(Debug, Clone)]
pub struct ExtendedModel {
    base: WienerModel,
    setting: Setting,
    active: CandidateSet,
    /// Effect and number of the parameter, for each parameter after the baseline's.
    slots: Vec<(Candidate, usize)>,
    parameters: Vec<ParameterInfo>,
}

impl ExtendedModel {
    /// The model around a fitted baseline with some candidates; of a loop of another family the shape is free, and a second population
    /// of relays is not. `setting` says what is common to all its plants,
    /// but for these, drive, rule and run length, which the baseline and each recording have.
    #[must_use]
    pub fn new(
        base: &WienerModel,
        fit: &Fit,
        setting: Setting,
        active: impl Into<CandidateSet>,
    ) -> Self {
        let active = active.into();
        let mut parameters = base.parameters().to_vec();
        let gain = parameters
            .iter()
            .position(|info| info.enters == Enters::Gain)
            .unwrap_or(0);
        let fitted = fit.parameters[gain].values[0];
        let ends = [fitted / GAIN_FACTOR, fitted * GAIN_FACTOR];
        parameters[gain] = ParameterInfo {
            enters: Enters::Nonlinear,
            bounds: Bounds {
                lower: ends[0].min(ends[1]),
                upper: ends[0].max(ends[1]),
            },
            ..parameters[gain].clone()
        };
        parameters.extend(parameters_of_family(setting.loop_family));
        let mut slots = Vec::new();
        for effect in active.iter() {
            for (k, parameter) in effect.info().parameters.iter().enumerate() {
                let [lower, upper] = parameter.bounds;
                let bounds = Bounds { lower, upper };
                let is_told = !parameter.needs_thermometer || fit.temperature_rmse_k.is_some();
                let scope = scope_of(effect);
                // A drift is a curve through its knots.
                let ordinary = (scope == Scope::PerRecording).then_some(Ordinary {
                    deviation: parameter.typical.abs(),
                    from_previous: k > 0,
                });
                parameters.push(ParameterInfo {
                    admissible: bounds,
                    scope,
                    ordinary,
                    state: if is_told {
                        ParameterState::Free
                    } else {
                        ParameterState::Fixed(parameter.neutral())
                    },
                    ..ParameterInfo::searched(
                        parameter.name,
                        setting.unit_of(parameter),
                        Scale::Linear,
                        bounds,
                    )
                });
                slots.push((effect, k));
            }
        }
        let model = Self {
            setting: Setting {
                drive: base.drive(),
                rule: base.rule(),
                active: active.effects(),
                hypotheses: active.hypotheses(),
                ..setting
            },
            active,
            base: base.clone(),
            slots,
            parameters,
        };
        model.with_loop_freedom(LoopFreedom::Shape)
    }

    /// The model with so much free of a loop of another family; the rest stays as the family's formulas have it.
    pub(crate) fn with_loop_freedom(mut self, freedom: LoopFreedom) -> Self {
        for info in &mut self.parameters {
            let least = LoopFreedom::of(info.name);
            if least > freedom {
                info.state = ParameterState::Fixed(0.0);
            } else if least > LoopFreedom::Formula {
                info.state = ParameterState::Free;
            }
        }
        self
    }

    /// The model with a parameter of its loop held at a value; itself if it has none of that name.
    pub(crate) fn holding(mut self, name: &str, value: f64) -> Self {
        let named = self.parameters.iter_mut().filter(|info| info.name == name);
        named.for_each(|info| info.state = ParameterState::Fixed(value));
        self
    }

    /// How much is free of its loop.
    pub(crate) fn loop_freedom(&self) -> LoopFreedom {
        let free = self.parameters.iter();
        let free = free.filter(|info| info.state == ParameterState::Free);
        let least = free.map(|info| LoopFreedom::of(info.name));
        least.max().unwrap_or(LoopFreedom::Formula)
    }

    /// Curves of its loop's branches.
    #[must_use]
    pub fn loop_family(&self) -> LoopFamily {
        self.setting.loop_family
    }

    /// The effects that may have a size.
    #[must_use]
    pub fn active(&self) -> CandidateSet {
        self.active
    }

    /// Index of the first parameter of an effect; `None` if it is not active.
    #[must_use]
    pub fn first_parameter(&self, effect: impl Into<Candidate>) -> Option<usize> {
        let effect = effect.into();
        let slot = self
            .slots
            .iter()
            .position(|&(active, _)| active == effect)?;
        Some(self.n_plain() + slot)
    }

    /// The effect and the number of its parameter that a parameter of this model is; `None` for the baseline's.
    pub(crate) fn slot(&self, parameter: usize) -> Option<(Candidate, usize)> {
        self.slots
            .get(parameter.checked_sub(self.n_plain())?)
            .copied()
    }

    /// Number of the parameters before those of the effects.
    pub(crate) fn n_plain(&self) -> usize {
        self.parameters.len() - self.slots.len()
    }

    fn member(&self, point: &[f64], first_ambient_degc: f64, state: StateOfRun) -> Member {
        let (base, extra) = point.split_at(self.n_plain());
        let mut effects = values_of_family(self.loop_family(), base);
        for (own, hypothesis) in effects.own.iter_mut().zip(self.setting.hypotheses) {
            *own = hypothesis.values(0.0);
        }
        for (&(candidate, index), &value) in self.slots.iter().zip(extra) {
            match candidate {
                Candidate::Effect(effect) => {
                    if let Some(slot) = effects.slot(effect, index) {
                        *slot = value;
                    }
                }
                Candidate::Own(number, _) => effects.own[number][index] = value,
            }
        }
        Member {
            params: state.of(self.base.wiener_params(base)),
            start: self.base.start(base, first_ambient_degc),
            effects,
        }
    }
}

/// Parameters that are free of a loop of another family than the paper's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum LoopFreedom {
    /// The parameters of its formula.
    Formula,
    /// The shape of its branches as well.
    Shape,
    /// A second population of relays as well.
    TwoPopulations,
}

impl LoopFreedom {
    /// The least with which a parameter is free.
    fn of(parameter: &str) -> Self {
        if SECOND_POPULATION_PARAMETERS.contains(&parameter) {
            Self::TwoPopulations
        } else if SHAPE_PARAMETERS.contains(&parameter) {
            Self::Shape
        } else {
            Self::Formula
        }
    }
}

/// No effects, and what the loop's family has of the last of the parameters before theirs.
pub(crate) fn values_of_family(family: LoopFamily, plain: &[f64]) -> EffectValues {
    let family = match (family, plain) {
        (
            LoopFamily::Relays,
            &[
                ..,
                skew,
                bend,
                third,
                tails,
                share,
                shift,
                log_half_width,
                log_spread,
                zeta_difference,
            ],
        ) => FamilyShape {
            bends: [skew, bend, third],
            tails,
            onset: 0.0,
            second: SecondPopulation {
                share,
                shift,
                log_half_width,
                log_spread,
                zeta_difference,
            },
        },
        (LoopFamily::Kinetics, &[.., skew, bend, third, onset]) => FamilyShape {
            bends: [skew, bend, third],
            onset,
            ..FamilyShape::default()
        },
        _ => FamilyShape::default(),
    };
    EffectValues {
        family,
        ..EffectValues::default()
    }
}

/// Scope of an effect's parameters: each recording has its own values, or all recordings share them.
pub(crate) fn scope_of(effect: Candidate) -> Scope {
    match effect.info().belongs_to {
        Belongs::Recording => Scope::PerRecording,
        Belongs::Rig | Belongs::History => Scope::Shared,
    }
}

impl ForwardModel for ExtendedModel {
    fn parameters(&self) -> &[ParameterInfo] {
        &self.parameters
    }

    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        let profile = self.base.profile(recording)?;
        let states: Vec<StateOfRun> = points
            .iter()
            .map(|point| self.base.state_of_run(point, recording))
            .collect();
        let members: Vec<Member> = points
            .iter()
            .zip(&states)
            .map(|(point, &state)| self.member(point, profile.first_ambient_degc(), state))
            .collect();
        let mut visit = in_states(states, visit);
        let time_s = recording.time_s();
        let fleet = Extended {
            setting: Setting {
                run_length_s: Some(time_s[time_s.len() - 1] - time_s[0]),
                ..self.setting
            },
        };
        // Compiled once, in the crate of the effects.
        fleet
            .run(&members, &profile, &mut visit)
            .map_err(|error| IdentifyError::Model(Box::new(error)))
    }
}
