use identify::{IdentifyError, WienerModel};
use missing_physics::{
    DiagnoseConfig, Diagnosis, EffectId, EffectSet, ScreenConfig, diagnose, diagnose_from, screen,
    setting_of_rod,
};
use std::ops::ControlFlow;
use wiener::hysteresis::Rule;

use crate::case_line::ids;
use crate::study::sizes;
use crate::{CaseId, CaseLine, Made, MadeUp, Outcome, Step, Study, StudyError, Truth, made_up};

/// Makes up the rig of a case and diagnoses it.
///
/// # Errors
///
/// [`StudyError::Case`] with what the diagnosis refuses.
pub fn run_case(case: CaseId) -> Result<CaseLine, StudyError> {
    line(case).map_err(|source| StudyError::Case {
        case,
        source: Box::new(source),
    })
}

fn line(CaseId { study, case }: CaseId) -> Result<CaseLine, IdentifyError> {
    let made = study.made(case);
    let concealed = study.concealed(case);
    let rig = made_up(&made);
    let base = WienerModel::new(&rig.rod, Rule::LastReversal, &rig.training)?;
    let config = DiagnoseConfig {
        setting: setting_of_rod(&rig.rod, "mm"),
        ..DiagnoseConfig::default()
    };
    let whole = diagnose(&base, &rig.training, &rig.unseen, &config, &mut |_| {
        ControlFlow::Continue(())
    })?;
    let truth = concealed.map(|(effect, _)| effect);
    let mut line = CaseLine {
        study,
        case,
        seed: made.seed,
        truth: concealed.map(|(effect, multiple)| Truth {
            effect: effect.id().to_owned(),
            multiple,
            sizes: sizes(effect, &made.values),
        }),
        diagnosis: Outcome::new(&whole, &made, truth, rig.noise_mm),
        steps: Vec::new(),
    };
    if let (Study::Removed, Some(truth)) = (study, truth) {
        let smaller = Smaller {
            rig: &rig,
            made: &made,
            base: &base,
            config: &config,
            whole: &whole,
        };
        line.steps = smaller.steps(truth)?;
    }
    Ok(line)
}

/// What diagnoses with a smaller catalogue share.
struct Smaller<'a> {
    rig: &'a MadeUp,
    made: &'a Made,
    base: &'a WienerModel,
    config: &'a DiagnoseConfig,
    whole: &'a Diagnosis,
}

impl Smaller<'_> {
    /// Without the truth, then without its aliases as well, one more a step.
    fn steps(&self, truth: EffectId) -> Result<Vec<Step>, IdentifyError> {
        let mut removed = Vec::new();
        let mut left = EffectSet::all();
        let mut steps = Vec::new();
        for effect in std::iter::once(truth).chain(self.aliases(truth)?) {
            left = left.without(effect);
            removed.push(effect);
            steps.push(Step {
                removed: ids(removed.iter().copied()),
                diagnosis: self.with(left)?,
            });
        }
        Ok(steps)
    }

    fn with(&self, catalogue: EffectSet) -> Result<Outcome, IdentifyError> {
        let config = DiagnoseConfig {
            catalogue,
            ..self.config.clone()
        };
        let diagnosis = diagnose_from(
            self.base,
            self.whole.baseline.fit.clone(),
            [&self.rig.training, &self.rig.unseen],
            &config,
            &mut |_| ControlFlow::Continue(()),
        )?;
        Ok(Outcome::new(&diagnosis, self.made, None, self.rig.noise_mm))
    }

    /// Effects that the whole catalogue cannot tell from the truth, or finds in its place, and those whose traces
    /// point the same way.
    fn aliases(&self, truth: EffectId) -> Result<Vec<EffectId>, IdentifyError> {
        let sets = self.whole.findings.iter().map(|finding| {
            let set = std::iter::once(&finding.effect).chain(&finding.could_also_be);
            set.filter_map(|candidate| candidate.effect())
                .collect::<Vec<_>>()
        });
        let (with, without): (Vec<_>, Vec<_>) = sets.partition(|set| set.contains(&truth));
        let config = ScreenConfig {
            setting: self.config.setting,
            seed: self.config.seed,
        };
        let plain = &self.whole.baseline.fit;
        let screening = screen(self.base, plain, &self.rig.training, &config)?;
        let own = screening.effects.iter().find(|one| one.effect == truth);
        let alike = own.into_iter().flat_map(|own| &own.alike);
        let mut aliases = Vec::new();
        for effect in if with.is_empty() { without } else { with }
            .concat()
            .into_iter()
            .chain(alike.filter_map(|candidate| candidate.effect()))
        {
            if effect != truth && !aliases.contains(&effect) {
                aliases.push(effect);
            }
        }
        Ok(aliases)
    }
}
