use std::path::Path;
use std::time::Instant;

use identify::{Fit, Prior};
use missing_physics::{
    CandidateSet, Diagnosis, Entry, ExtendedModel, Finding, LoopFamily, Run, Status,
};
use rand::Rng;
use sma_effects::{EffectBlock, EffectSet, Setting};
use truth_plant::{Draw, DriveProfile, Shape};

use crate::aliases::{aliases, effects_of, stand_ins};
use crate::case::{Case, Recorded};
use crate::case_line::{CaseLine, Next, Revealed};
use crate::competitors::compete;
use crate::folder::Folder;
use crate::oracle::{Eye, Left};
use crate::verdict::{Opened, Verdict};
use crate::{Family, Oracle, TrialError, runs};

/// Millimeters of a meter.
const MM_PER_M: f64 = 1e3;

/// A case that was run, and how long its diagnosis took.
#[derive(Debug, Clone, PartialEq)]
pub struct Ran {
    /// Result of the case.
    pub line: CaseLine,
    /// Wall time of the diagnosis, s.
    pub diagnosis_s: f64,
}

/// Writes the files of a case into a folder, diagnoses them, asks others if they are wanted, and compares with the
/// answer.
///
/// # Errors
///
/// [`TrialError`] with the case.
pub fn run_case(case: &Case, folder: &Path, asks_others: bool) -> Result<Ran, TrialError> {
    let id = case.id;
    let recorded = case.record()?;
    let folder = Folder::write(folder, case, &recorded)?;
    let files = Opened::read(&folder)?;
    let begun = Instant::now();
    let whole = files.diagnosed(EffectSet::all())?;
    let diagnosis_s = begun.elapsed().as_secs_f64();
    let (struck, diagnosis) = match id.family {
        Family::Deleted => struck(case, &files, whole)?,
        _ => (Vec::new(), whole),
    };
    let verdict = Verdict::from(&diagnosis);
    // They would have the truth in their catalogue.
    let asks_others = asks_others && id.family != Family::Deleted;
    let competitors = asks_others
        .then(|| compete(id, &files, &diagnosis))
        .transpose()?;
    let opened = Judge {
        case,
        recorded: &recorded,
        folder: &folder,
        files: &files,
        diagnosis: &diagnosis,
    }
    .open()?;
    Ok(Ran {
        line: CaseLine {
            case: id,
            files: folder.digest()?,
            seal: None,
            struck,
            verdict,
            competitors,
            opened,
        },
        diagnosis_s,
    })
}

/// The diagnosis without the truth and its aliases.
fn struck(
    case: &Case,
    files: &Opened,
    whole: Diagnosis,
) -> Result<(Vec<String>, Diagnosis), TrialError> {
    let mut struck: Vec<String> = Vec::new();
    for effect in case
        .answer()
        .concealed
        .iter()
        .filter_map(|one| one.effect.as_ref())
    {
        let others = aliases(case.id, files, &whole.baseline.fit, effect)?;
        let named = stand_ins(&whole, effect);
        for id in std::iter::once(effect).chain(&others).chain(&named) {
            if !struck.contains(id) {
                struck.push(id.clone());
            }
        }
    }
    let left = effects_of(&struck).fold(EffectSet::all(), EffectSet::without);
    let diagnosis = files.diagnosed(left)?;
    Ok((struck, diagnosis))
}

/// Who knows the answer.
struct Judge<'a> {
    case: &'a Case,
    recorded: &'a Recorded,
    folder: &'a Folder,
    files: &'a Opened,
    diagnosis: &'a Diagnosis,
}

impl Judge<'_> {
    fn open(&self) -> Result<Revealed, TrialError> {
        let answer = self.case.answer();
        let noise = self.case.truth.displacement_noise;
        let mut revealed = Revealed {
            salt: None,
            answer: answer.clone(),
            noise_mm: noise.map_or(0.0, |noise| MM_PER_M * noise.deviation),
            has_scale: self.case.known.has_scale(),
            oracles: Vec::new(),
            aliases: Vec::new(),
            said: Vec::new(),
            sizes: self.case.sizes.clone(),
            excluded_above: Vec::new(),
            spans: None,
            next: None,
        };
        let fit = &self.diagnosis.baseline.fit;
        let mut left = Vec::new();
        for without in &self.case.without {
            left.push(self.left(without)?);
        }
        revealed.oracles = left.iter().map(|left| left.oracle).collect::<Vec<Oracle>>();
        for concealed in &answer.concealed {
            let effect = concealed.effect.as_deref();
            revealed.aliases.push(match effect {
                Some(effect) => aliases(self.case.id, self.files, fit, effect)?,
                None => Vec::new(),
            });
            revealed
                .said
                .push(effect.and_then(|effect| Some(self.entry(effect)?.status.id().to_owned())));
            revealed
                .excluded_above
                .push(effect.and_then(|effect| self.excluded_above(effect)));
        }
        if let [only] = &left[..] {
            revealed.spans = self.spans(only);
        }
        let is_ambiguous = self
            .diagnosis
            .findings
            .iter()
            .any(|finding| !finding.could_also_be.is_empty());
        let run = self.diagnosis.next_experiment.as_ref();
        if let Some(run) = run
            .and_then(|next| next.run.as_ref())
            .filter(|_| is_ambiguous)
        {
            revealed.next = Some(Next {
                recommended: self.resolved(&runs::Run::whole("recommended", recommended(run)))?,
                random: self.resolved(&runs::Run::whole("random", self.random(run)))?,
            });
        }
        Ok(revealed)
    }

    /// Trace that an effect leaves beside the baseline model, and its score beside the model that is open, too.
    fn left(&self, without: &truth_plant::TruthPlant) -> Result<Left, TrialError> {
        let training = self.case.runs.training.iter();
        let quiet = training
            .map(|run| self.case.run(without, run))
            .collect::<Result<Vec<_>, _>>()?;
        let eye = |model, fit, prior| Eye {
            model,
            fit,
            prior,
            training: &self.files.training,
            truth: &self.case.truth,
        };
        let seen = |eye: Eye<'_>| {
            let left = eye.left(&self.recorded.training, &quiet);
            left.map_err(TrialError::diagnosis(self.case.id))
        };
        let fit = &self.diagnosis.baseline.fit;
        let mut left = seen(eye(&self.files.base, fit, Prior::Nothing))?;
        let (open, fit) = self.open_model();
        let prior = Prior::Profiled(fit.noise.n_effective.max(1.0));
        left.oracle.t_open = Some(seen(eye(&open, fit, prior))?.oracle.t);
        Ok(left)
    }

    /// The model without an effect that a diagnosis must leave open, and the fit nearest to it: with the level and the start of runs, and,
    /// where the rig's loop is not the paper's, with the loop that was found.
    fn open_model(&self) -> (ExtendedModel, &Fit) {
        let found = self.diagnosis.extended.as_ref();
        let found = found.filter(|_| self.case.id.has_other_loop());
        let loop_family = found.map_or(LoopFamily::Proximity, |one| one.model.loop_family());
        let fit = found.map_or(&self.diagnosis.baseline.fit, |one| &one.stage.fit);
        let base = self.files.base.with_unknowns(&self.files.training);
        let setting = Setting {
            loop_family,
            ..self.files.config.setting
        };
        let open = ExtendedModel::new(&base, fit, setting, CandidateSet::EMPTY);
        (open, fit)
    }

    /// Entry of an effect in the catalogue of the diagnosis.
    fn entry(&self, effect: &str) -> Option<&Entry> {
        let mut entries = self.diagnosis.catalogue.iter();
        entries.find(|entry| entry.effect.id() == effect)
    }

    /// Above which size it is excluded, in the unit of its size.
    fn excluded_above(&self, effect: &str) -> Option<f64> {
        match self.entry(effect)?.status {
            Status::Excluded { upper } => Some(upper),
            _ => None,
        }
    }

    /// Share of the squares of what is left in the blamed spans, and their share of the time; `None` without spans.
    fn spans(&self, left: &Left) -> Option<[f64; 2]> {
        let (mut own, mut all, mut n_inside, mut n) = (0.0, 0.0, 0, 0);
        for (recording, left_mm) in self.files.training.iter().zip(&left.output_mm) {
            let spans = self.diagnosis.mismatch.spans.iter();
            let spans = spans.filter(|span| span.recording == recording.name());
            let ends_s: Vec<_> = spans.map(|span| span.start_s..=span.end_s).collect();
            for (time_s, mm) in recording.time_s().iter().zip(left_mm) {
                let is_inside = ends_s.iter().any(|span| span.contains(time_s));
                all += mm * mm;
                n += 1;
                if is_inside {
                    own += mm * mm;
                    n_inside += 1;
                }
            }
        }
        (n_inside > 0 && all > 0.0).then(|| [own / all, f64::from(n_inside) / f64::from(n)])
    }

    /// True if one more run leaves the truth named, and alone. If the loop is of another family, a name in the
    /// transformation is neither right nor wrong.
    fn resolved(&self, run: &runs::Run) -> Result<bool, TrialError> {
        let traces = self.case.run(&self.case.truth, run)?;
        self.folder.add_next(self.case, &traces, run)?;
        let diagnosis = Opened::with_next(self.folder)?.diagnosed(EffectSet::all())?;
        let concealed = &self.case.answer().concealed;
        let is_truth = |finding: &Finding| {
            let mut truths = concealed.iter().filter_map(|one| one.effect.as_deref());
            truths.any(|truth| truth == finding.effect.id())
        };
        let mut findings = diagnosis.findings.iter();
        let is_resolved = findings.all(|finding| {
            let is_of_the_loop = finding.effect.info().block == EffectBlock::Transformation;
            let is_right = is_truth(finding) && finding.could_also_be.is_empty();
            is_right || (is_of_the_loop && self.case.id.has_other_loop())
        });
        Ok(is_resolved && diagnosis.findings.iter().any(is_truth))
    }

    /// A run as long as the one that was recommended.
    fn random(&self, run: &Run) -> DriveProfile {
        let chance = self.case.chance();
        let shape = Shape::ALL[chance.of("random run").random_range(0..Shape::ALL.len())];
        let draw = Draw::new(chance.seed("random run"));
        DriveProfile {
            drive: draw.drive(shape, &self.case.truth, run.drive.len()).drive,
            dt_s: run.dt_s,
        }
    }
}

fn recommended(run: &Run) -> DriveProfile {
    DriveProfile {
        drive: run.drive.clone(),
        dt_s: run.dt_s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CaseId;

    #[test]
    fn who_leaves_more_open_sees_no_more_of_an_effect() {
        // Of either plant one of few samples.
        for number in [4, 13] {
            let case = Case::drawn("a seed", CaseId::lab(Family::Single, number));
            let folder = tempfile::tempdir().unwrap();
            let recorded = case.record().unwrap();
            let folder = Folder::write(folder.path(), &case, &recorded).unwrap();
            let files = Opened::read(&folder).unwrap();
            // Whatever is found, the baseline model is fitted.
            let diagnosis = files.diagnosed(EffectSet::EMPTY).unwrap();
            let judge = Judge {
                case: &case,
                recorded: &recorded,
                folder: &folder,
                files: &files,
                diagnosis: &diagnosis,
            };
            let oracles = judge.open().unwrap().oracles;
            let [oracle] = &oracles[..] else {
                panic!("{oracles:?}");
            };
            let t_open = oracle.t_open.unwrap();
            assert!(
                t_open > 0.0 && t_open <= 1.01 * oracle.t,
                "{number} {oracle:?}"
            );
        }
    }
}
