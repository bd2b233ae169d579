use std::collections::BTreeSet;

use identify::{Fit, WienerModel};
use missing_physics::{Diagnosis, ScreenConfig, screen};
use sma_effects::EffectId;

use crate::CaseId;
use crate::TrialError;
use crate::verdict::Opened;

/// Effects that act alike on the displacement under slow drives, whatever the rig: losses that grow faster than the
/// temperature, delays, and slow shifts of the loop against the drive.
pub(crate) const ALIKE: [&[&str]; 3] = [
    &["radiation", "natural-convection"],
    &["supply-lag", "dead-time", "output-lag"],
    &["ambient-drift", "functional-fatigue"],
];

/// Effects that cannot be told from one in this recording, without it: the like ones above, and those whose traces,
/// freed of what refitting the baseline model hides, have a cosine above 0.9 with its own.
pub(crate) fn aliases(
    case: CaseId,
    files: &Opened,
    fit: &Fit,
    effect: &str,
) -> Result<Vec<String>, TrialError> {
    let mut all: BTreeSet<String> = ALIKE
        .iter()
        .filter(|group| group.contains(&effect))
        .flat_map(|group| group.iter().map(|&id| id.to_owned()))
        .collect();
    all.extend(alike_here(case, files, fit, effect)?);
    all.remove(effect);
    Ok(all.into_iter().collect())
}

fn alike_here(
    case: CaseId,
    files: &Opened,
    fit: &Fit,
    effect: &str,
) -> Result<Vec<String>, TrialError> {
    let base: &WienerModel = &files.base;
    let config = ScreenConfig {
        setting: files.config.setting,
        seed: files.config.seed,
    };
    let screening =
        screen(base, fit, &files.training, &config).map_err(TrialError::diagnosis(case))?;
    let own = screening
        .effects
        .iter()
        .find(|one| one.effect.id() == effect);
    let alike = own.into_iter().flat_map(|own| &own.alike);
    Ok(alike.map(|other| other.id().to_owned()).collect())
}

/// Effects that the whole catalogue names together with an effect, or in its place.
pub(crate) fn stand_ins(diagnosis: &Diagnosis, effect: &str) -> Vec<String> {
    let sets = diagnosis.findings.iter().map(|finding| {
        let set = std::iter::once(&finding.effect).chain(&finding.could_also_be);
        set.map(|one| one.id().to_owned()).collect()
    });
    let (with, without): (Vec<Vec<String>>, Vec<Vec<String>>) =
        sets.partition(|set: &Vec<String>| set.iter().any(|id| id == effect));
    let mut all = if with.is_empty() { without } else { with }.concat();
    all.retain(|id| id != effect);
    all
}

/// The effects of some ids.
pub(crate) fn effects_of<'a>(
    ids: impl IntoIterator<Item = &'a String>,
) -> impl Iterator<Item = EffectId> {
    ids.into_iter().filter_map(|id| EffectId::parse(id).ok())
}
