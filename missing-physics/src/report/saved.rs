//! Models with effects as files, and what is made of them again.

use identify::{
    Bounds, ForwardModel, IdentifyError, NamedEffect, ParameterInfo, ParameterState, RigModel,
    SINCE_REVERSAL, SavedEffects, SavedModel, Scale, StateOfRun, WienerModel, in_states,
};
use recording::{Quantity, Recording};
use wiener::{Block, Start};

use crate::model::elsewhere::{drifts_dropped, is_drift};
use crate::model::extended_model::{scope_of, values_of_family};
use crate::{
    EffectId, EffectSet, Extended, ExtendedPlant, ExtendedStage, Member, Need, PhysicsError,
    Setting, setting_of_rod,
};

/// The effects of a chosen model as its file has them; `setting` is that of the diagnosis.
///
/// # Errors
///
/// [`PhysicsError::UnknownEffect`] for a hypothesis of one's own: its equation has no place in the file.
pub fn saved_effects(
    stage: &ExtendedStage,
    setting: &Setting,
) -> Result<SavedEffects, PhysicsError> {
    let known = stage
        .effects
        .iter()
        .map(|effect| Ok(EffectId::parse(effect.id())?.id().to_owned()));
    Ok(SavedEffects {
        ids: known.collect::<Result<_, PhysicsError>>()?,
        loop_family: stage.model.loop_family(),
        sub_steps: setting.sub_steps,
        newton_iterations: setting.newton_iterations,
    })
}

/// The parameters of an effect of the catalogue that a model file names, for who reads the file.
///
/// # Errors
///
/// A text that says what would be accepted in its place: the effect is not in the catalogue, or needs what the file does not
/// say of the rig.
pub fn known_effects(named: &NamedEffect<'_>) -> Result<Vec<ParameterInfo>, String> {
    let Ok(effect) = EffectId::parse(named.id) else {
        let known = EffectId::ALL.map(EffectId::id).join(" ");
        return Err(format!("no such effect; known are {known}"));
    };
    let setting = setting_of_rod(named.rod, named.output_unit);
    for need in effect.info().needs {
        let (is_given, needed) = match need {
            Need::MassPerMeter => (
                setting.mass_kg_per_m.is_some(),
                "diameter_mm and density_kg_per_m3 in [rod]",
            ),
            Need::SurfacePerMeter => (setting.surface_m2_per_m.is_some(), "diameter_mm in [rod]"),
            // The others matter to those who look for effects.
            _ => continue,
        };
        if !is_given {
            return Err(format!("needs {needed}"));
        }
    }
    let info = |one: &crate::EffectParameter| {
        let [lower, upper] = one.bounds;
        let bounds = Bounds { lower, upper };
        ParameterInfo {
            admissible: bounds,
            scope: scope_of(effect.into()),
            ..ParameterInfo::searched(one.name, setting.unit_of(one), Scale::Linear, bounds)
        }
    };
    Ok(effect.info().parameters.iter().map(info).collect())
}

/// A saved model that runs again, with its effects where it has any.
///
/// Drifts are those of the recordings that they were fitted to, and are left out: see [`RestoredModel::point`].
#[derive(Debug, Clone)]
pub struct RestoredModel<'a> {
    saved: &'a SavedModel,
    parameters: Vec<ParameterInfo>,
    /// The cascade that has effects.
    base: Option<&'a WienerModel>,
    /// Effect and number of the parameter, for each parameter after those of the baseline part.
    slots: Vec<(EffectId, usize)>,
    fleet: Extended,
}

impl<'a> RestoredModel<'a> {
    /// Takes a model that was read with [`known_effects`].
    ///
    /// # Errors
    ///
    /// [`IdentifyError::Model`] for sub-steps, iterations or values of effects that the plant refuses.
    pub fn new(saved: &'a SavedModel) -> Result<Self, IdentifyError> {
        let rod = &saved.rod;
        let mut restored = Self {
            parameters: saved
                .parameters
                .iter()
                .map(|one| one.info.clone())
                .collect(),
            base: None,
            slots: Vec::new(),
            fleet: Extended {
                setting: setting_of_rod(rod, &saved.output_unit),
            },
            saved,
        };
        let setting = &mut restored.fleet.setting;
        setting.rule = saved.rule;
        setting.largest_drive = Some(saved.largest_drive()).filter(|largest| *largest > 0.0);
        let has_cascade = !matches!(
            &saved.model,
            RigModel::Loop(_) | RigModel::Thermal(_) | RigModel::Antagonist(_)
        );
        if has_cascade && rod.drive_kind != Quantity::Temperature {
            setting.drive = rod.drive()?;
        }
        let (RigModel::Wiener(base), Some(effects)) = (&saved.model, &saved.effects) else {
            return Ok(restored);
        };
        let ids = effects.ids.iter().map(|id| EffectId::parse(id));
        let ids = ids.collect::<Result<Vec<_>, _>>().map_err(refused)?;
        setting.loop_family = effects.loop_family;
        setting.sub_steps = effects.sub_steps;
        setting.newton_iterations = effects.newton_iterations;
        let carried = ids
            .iter()
            .copied()
            .filter(|&effect| !is_drift(effect.into()));
        setting.active = carried.collect::<EffectSet>();
        restored.base = Some(base);
        restored.slots = ids
            .iter()
            .flat_map(|&effect| (0..effect.info().parameters.len()).map(move |k| (effect, k)))
            .collect();
        let first = restored.n_plain();
        for (info, &(effect, _)) in restored.parameters[first..].iter_mut().zip(&restored.slots) {
            if is_drift(effect.into()) {
                // It is left out, and is nothing that another recording could tell.
                info.state = ParameterState::Fixed(0.0);
            }
        }
        let at_rest = Start::rest(rod.ambient_degc.unwrap_or_default());
        if let Some(Member {
            params, effects, ..
        }) = restored.member(&saved.point(0), at_rest)
        {
            ExtendedPlant::new(&restored.fleet.setting, &params, &effects).map_err(refused)?;
        }
        Ok(restored)
    }

    /// Values of all parameters for another recording, with the offset of the first training recording: of a
    /// drift of the surroundings it has the mean, as a loop that lies lower, and of that of the sensor nothing.
    #[must_use]
    pub fn point(&self) -> Vec<f64> {
        self.without_drifts(&self.saved.point(0))
    }

    /// Drifts in the model, which are left out.
    pub fn drifts(&self) -> impl Iterator<Item = EffectId> {
        let first = self.slots.iter().filter(|(_, index)| *index == 0);
        first
            .map(|&(effect, _)| effect)
            .filter(|&effect| is_drift(effect.into()))
    }

    /// The plants of points: what the members have in common.
    #[must_use]
    pub fn fleet(&self) -> Extended {
        self.fleet
    }

    /// The plant of a point, as [`SavedModel::parameters`] orders it, from a start; `None` for a static loop and for a heat balance alone.
    #[must_use]
    pub fn member(&self, point: &[f64], start: Start) -> Option<Member> {
        let point = self.without_drifts(point);
        let (plain, extra) = point.split_at(self.n_plain());
        let mut effects = values_of_family(self.fleet.setting.loop_family, plain);
        for (&(effect, index), &value) in self.slots.iter().zip(extra) {
            if let Some(slot) = effects.slot(effect, index) {
                *slot = value;
            }
        }
        Some(Member {
            params: self.saved.model.wiener_params(&point)?,
            effects,
            start,
        })
    }

    /// The plant that leaves the program: with the offset of the first training recording and the start of it, whose
    /// temperature is above the surroundings, K; `None` for a model without a cascade.
    #[must_use]
    pub fn first_member(&self) -> Option<Member> {
        let point = self.point();
        let value = |name: &str| {
            let place = self.parameters.iter().position(|info| info.name == name);
            place.map(|place| point[place])
        };
        let start = Start {
            temperature_degc: value("start_rise_k").unwrap_or(0.0),
            share: value("start_share").unwrap_or(1.0),
            since_reversal_k: value(SINCE_REVERSAL).unwrap_or(0.0),
        };
        self.member(&point, start)
    }

    fn n_plain(&self) -> usize {
        self.parameters.len() - self.slots.len()
    }

    fn without_drifts(&self, point: &[f64]) -> Vec<f64> {
        drifts_dropped(&self.parameters, point, |drift| {
            let slot = self.slots.iter().position(|&(effect, _)| effect == drift)?;
            Some(self.n_plain() + slot)
        })
    }
}

impl ForwardModel for RestoredModel<'_> {
    fn parameters(&self) -> &[ParameterInfo] {
        &self.parameters
    }

    fn simulate(
        &self,
        points: &[Vec<f64>],
        recording: &Recording,
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        let Some(base) = self.base else {
            return self.saved.model.simulate(points, recording, visit);
        };
        let profile = base.profile(recording)?;
        let states: Vec<StateOfRun> = points
            .iter()
            .map(|point| base.state_of_run(point, recording))
            .collect();
        let members: Vec<Member> = points
            .iter()
            .zip(&states)
            .filter_map(|(point, state)| {
                let start = base.start(point, profile.first_ambient_degc());
                let member = self.member(point, start)?;
                Some(Member {
                    params: state.of(member.params),
                    ..member
                })
            })
            .collect();
        let mut visit = in_states(states, visit);
        self.fleet
            .run(&members, &profile, &mut visit)
            .map_err(refused)
    }
}

fn refused(error: PhysicsError) -> IdentifyError {
    IdentifyError::Model(Box::new(error))
}
