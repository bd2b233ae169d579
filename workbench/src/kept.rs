//! Model that a diagnosis saves for later commands.

use identify::{Identification, Provenance, RigModel, Rod, SavedModel};
use missing_physics::{Diagnosis, Verdict, saved_effects};
use recording::Recording;
use sma_effects::Setting;
use wiener::hysteresis::Rule;

/// A diagnosis with its inputs and settings.
#[derive(Debug, Clone, Copy)]
pub struct Diagnosed<'a> {
    /// The rod file.
    pub rod: &'a Rod,
    /// The baseline model.
    pub plain: &'a RigModel,
    /// Which reversals the baseline model remembers.
    pub rule: Rule,
    /// Setting that all plants of the diagnosis share.
    pub setting: &'a Setting,
    /// Recordings that decided.
    pub training: &'a [Recording],
    /// Recordings that it was checked on.
    pub unseen: &'a [Recording],
    /// Result of the diagnosis.
    pub diagnosis: &'a Diagnosis,
}

/// The last model of the report, and what to say of it.
#[derive(Debug)]
pub struct Kept {
    /// `None` if it has hypotheses of one's own.
    pub model: Option<SavedModel>,
    /// Note on it, or on why there is none.
    pub note: String,
}

impl Kept {
    /// Takes the model with the effects that were found, or the plain one if there are none.
    #[must_use]
    pub fn of(diagnosed: &Diagnosed<'_>, made: Provenance) -> Self {
        let diagnosis = diagnosed.diagnosis;
        let (stage, effects) = match &diagnosis.extended {
            None => (&diagnosis.baseline, None),
            Some(extended) => match saved_effects(extended, diagnosed.setting) {
                Ok(effects) => (&extended.stage, Some(effects)),
                Err(_) => {
                    return Self {
                        model: None,
                        note: format!(
                            "no model is saved: it has {}, and hypotheses of your own have no place in a model \
                             file yet; leave them out to save the model without them",
                            extended.names().join(", ")
                        ),
                    };
                }
            },
        };
        let note = match &effects {
            None if diagnosis.verdict == Verdict::NotConverged => {
                "the baseline model is saved, NOT CONVERGED".to_owned()
            }
            None => "the baseline model is saved: no effect was found".to_owned(),
            Some(effects) => {
                let findings = diagnosis.findings.iter();
                let found: Vec<&str> = findings.map(|one| one.effect.id()).collect();
                note(&effects.names(), &found)
            }
        };
        let model = SavedModel::of(
            &Identification {
                rod: diagnosed.rod,
                model: diagnosed.plain,
                effects,
                rule: diagnosed.rule,
                fit: &stage.fit,
                training: diagnosed.training,
                unseen: diagnosed.unseen,
                validated: &stage.validated,
            },
            made,
        );
        Self {
            model: Some(model),
            note,
        }
    }
}

/// Which effects are saved, and which of them are no findings.
fn note(ids: &[&str], found: &[&str]) -> String {
    let suspects = ids.iter().copied().filter(|id| !found.contains(id));
    let suspects: Vec<&str> = suspects.collect();
    let mut note = format!("the model with {} is saved", ids.join(", "));
    if !suspects.is_empty() {
        note += &format!("; only suspected: {}", suspects.join(", "));
    }
    note
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_only_suspected_is_said() {
        let ids = ["latent-heat", "radiation"];
        assert_eq!(
            note(&ids, &["radiation", "latent-heat"]),
            "the model with latent-heat, radiation is saved"
        );
        assert_eq!(
            note(&ids, &["latent-heat"]),
            "the model with latent-heat, radiation is saved; only suspected: radiation"
        );
    }
}
