//! The verdict of a diagnosis, in a sentence or two that begin with its class.

use identify::Validated;
use missing_physics::{Diagnosis, Finding, RuleId, Rung, Stage, Verdict};
use sma_effects::Belongs;

use super::traces::{failed, passed, value};
use crate::report::number::{behind, percent, significant, spoken};
use crate::report::words::{listed, recordings};

/// Class of the verdict in capitals, and what it says: the heading of text and page.
#[must_use]
pub fn headline(diagnosis: &Diagnosis) -> String {
    let class = diagnosis.verdict.id().replace('_', " ").to_uppercase();
    format!("{class}: {}", said(diagnosis))
}

/// A second question where the model does not describe the recordings, but a drift reduces the error.
fn or_changed(diagnosis: &Diagnosis) -> &'static str {
    let is_drift = |one: &Finding| one.effect.info().belongs_to == Belongs::Recording;
    match diagnosis.suspects.iter().any(is_drift) {
        true => ", or did something change during the recording, a fan for example",
        false => "",
    }
}

fn said(diagnosis: &Diagnosis) -> String {
    match diagnosis.verdict {
        Verdict::NotConverged => {
            "no two starts of the baseline model end at one minimum, and nothing can be said of what it leaves out. Try \
             another --seed, or start from an earlier model (--from-model)."
                .to_owned()
        }
        Verdict::Adequate => format!(
            "nothing is missing that these recordings could show. {}",
            error(diagnosis)
        ),
        Verdict::Explained | Verdict::Ambiguous | Verdict::ExplainedInPart => {
            format!("{} {}", missing(&diagnosis.findings), change(diagnosis))
        }
        Verdict::Unexplained if failed(diagnosis, RuleId::Describes).is_some() => format!(
            "the model does not describe this recording. Of what the output does it predicts {} on stretches that it has not seen; \
             {} are required. Do drive and output belong together{}?",
            percent(value(diagnosis, RuleId::Describes).unwrap_or(0.0).max(0.0)),
            percent(RuleId::Describes.rule().threshold),
            or_changed(diagnosis),
        ),
        Verdict::Unexplained if fails_unseen_alone(diagnosis) => format!(
            "the baseline model does not hold on the unseen {}, and the training does not show why. {} Add {} to the training.",
            recordings(diagnosis.baseline.validated.len()),
            error(diagnosis),
            if diagnosis.baseline.validated.len() == 1 {
                "that recording"
            } else {
                "one of those"
            }
        ),
        Verdict::Unexplained
            if failed(diagnosis, RuleId::Remainder).is_some()
                && failed(diagnosis, RuleId::UnseenShare).is_none()
                && !disturbances(diagnosis).is_empty() =>
        {
            format!(
                "the error is a disturbance that neither the drive nor the noise of a sensor makes: it {}. {} Record the \
                 surroundings, and the rest position before and after.",
                listed(&disturbances(diagnosis), "and"),
                error(diagnosis)
            )
        }
        Verdict::Unexplained => format!(
            "something is missing, and no effect of the catalogue accounts for it. {}",
            error(diagnosis)
        ),
    }
}

/// True if nothing is left in training, and the baseline model misses the unseen recordings by more than its parameters are uncertain.
fn fails_unseen_alone(diagnosis: &Diagnosis) -> bool {
    let shares = diagnosis.explained;
    let is_of_names = shares.is_some_and(|shares| shares.by_findings.is_some());
    !is_of_names && failed(diagnosis, RuleId::UnseenShare).is_some()
}

/// Signs of a disturbance that are seen in the error.
fn disturbances(diagnosis: &Diagnosis) -> Vec<&'static str> {
    [
        (
            RuleId::Disturbed,
            "grows and shrinks with the state of the rod",
        ),
        (RuleId::Tone, "has a tone"),
        (RuleId::Slow, "wanders slowly"),
        (RuleId::Slip, "slips as a mount does"),
    ]
    .into_iter()
    .filter_map(|(id, does)| passed(diagnosis, id).map(|_| does))
    .collect()
}

/// "Latent heat, and dead time or supply lag, are missing from the baseline model."
fn missing(findings: &[Finding]) -> String {
    let is_sure = findings.iter().all(|one| one.could_also_be.is_empty());
    let names: Vec<String> = findings.iter().map(|one| names(one, findings)).collect();
    let verb = if names.len() == 1 { "is" } else { "are" };
    let cannot_tell = if is_sure {
        ""
    } else {
        "; these recordings cannot tell which"
    };
    format!(
        "{} {verb} missing from the baseline model{cannot_tell}.",
        listed(&names, "and")
    )
}

/// Name of one of the findings, or names: "latent heat", "either dead time or supply lag".
pub(super) fn names(finding: &Finding, all: &[Finding]) -> String {
    let others = names_of_others(finding, all);
    let names: Vec<&str> = std::iter::once(finding.effect.info().name)
        .chain(others)
        .collect();
    match names.as_slice() {
        [one] => (*one).to_owned(),
        [_, _] => format!("either {}", listed(&names, "or")),
        several => format!("one of {}", listed(several, "or")),
    }
}

/// Names of what one of the findings could also be.
pub(super) fn names_of_others(finding: &Finding, all: &[Finding]) -> Vec<&'static str> {
    let has_loop = all.iter().any(|one| one.effect.info().names_loop_families);
    let others = finding.could_also_be.iter().map(|other| {
        let info = other.info();
        // Another loop is there in any case.
        if info.names_loop_families && has_loop {
            "a finer form of that loop"
        } else {
            info.name
        }
    });
    others.collect()
}

/// The model with findings and suspects; the baseline model where there are neither.
pub(super) fn last(diagnosis: &Diagnosis) -> &Stage {
    let extended = diagnosis.extended.as_ref();
    extended.map_or(&diagnosis.baseline, |one| &one.stage)
}

/// Unit of the output behind a number: nothing where it has none.
#[must_use]
pub fn unit(diagnosis: &Diagnosis) -> String {
    behind(&diagnosis.baseline.fit.output_unit)
}

/// An error beside the noise: "5.6 times the noise".
fn beside_noise(diagnosis: &Diagnosis, error: f64) -> String {
    let floor = diagnosis.noise_floor;
    if floor.upper.unwrap_or(floor.lower) <= 0.0 {
        return "where no noise shows".to_owned();
    }
    match floor.upper {
        Some(upper) if error <= upper => "as much as the noise".to_owned(),
        Some(upper) => format!("{} times the noise", spoken(error / upper)),
        None => format!("at most {} times the noise", spoken(error / floor.lower)),
    }
}

/// Error of the baseline model.
fn error(diagnosis: &Diagnosis) -> String {
    let (stage, unit) = (&diagnosis.baseline, unit(diagnosis));
    let trained = stage.fit.train_rmse;
    let of_output = match Validated::rmse_of_all(&stage.validated) {
        Some(unseen) => format!(
            "The error of the baseline model is {}{unit} RMS in training and {}{unit} on the unseen {}, {}.",
            spoken(trained),
            spoken(unseen),
            recordings(stage.validated.len()),
            beside_noise(diagnosis, unseen)
        ),
        None => format!(
            "The error of the baseline model is {}{unit} RMS, {}; not yet tested on unseen recordings (--validate).",
            spoken(trained),
            beside_noise(diagnosis, trained)
        ),
    };
    of_output + &of_drive(diagnosis) + &of_temperature([stage, stage])
}

/// Error that noise of the drive may have left, a sentence to follow another; nothing where no drive was smoothed.
fn of_drive(diagnosis: &Diagnosis) -> String {
    let of_drive = diagnosis.noise_floor.of_drive;
    if of_drive <= 0.0 {
        return String::new();
    }
    let size = spoken(of_drive) + &unit(diagnosis);
    format!(" Noise of the drive, though it was smoothed, may make up to {size} in training.")
}

/// Error of a model on the recorded temperatures, beside that of another where it differs: a sentence to follow another, where temperatures
/// were recorded.
fn of_temperature([before, after]: [&Stage; 2]) -> String {
    let [before, after] = [before, after].map(|stage| stage.fit.temperature_rmse_k.map(spoken));
    let Some(after) = after else {
        return String::new();
    };
    let before = before.filter(|before| *before != after);
    let before = before.map_or(String::new(), |before| format!(", before to {before} K"));
    format!(" The recorded temperature is met to {after} K RMS{before}.")
}

/// Errors of a model: in training, and calibrated on unseen recordings, where there are any.
type Errors = (f64, Option<f64>);

/// Change of the error by the findings, then by what is suspected.
fn change(diagnosis: &Diagnosis) -> String {
    let of = |stage: &Stage| {
        let unseen = Validated::rmse_of_all(&stage.validated);
        (stage.fit.train_rmse, unseen)
    };
    let before = of(&diagnosis.baseline);
    let last_stage = last(diagnosis);
    let last = of(last_stage);
    let alone = with_findings_alone(diagnosis).map(|rung| (rung.train_rmse, rung.unseen_rmse));
    let n_unseen = diagnosis.baseline.validated.len();
    let with = match (diagnosis.findings.len(), alone) {
        (_, None) if !diagnosis.suspects.is_empty() => "With findings and suspects",
        (1, _) => "With it",
        _ => "With them",
    };
    let place = match before.1 {
        Some(_) => format!("unseen {}", recordings(n_unseen)),
        None => format!(
            "training {}",
            recordings(diagnosis.baseline.fit.recordings.len())
        ),
    };
    let error = |errors: Errors| errors.1.unwrap_or(errors.0);
    let [first, after] = [before, alone.unwrap_or(last)].map(error);
    let unit = unit(diagnosis);
    let falls = if after < first {
        format!(
            "falls {}{unit} RMS, {}",
            from_to(first, after),
            beside_noise(diagnosis, after)
        )
    } else {
        format!(
            "does not fall: it goes {}{unit} RMS, and the findings hold for the training recordings only",
            from_to(first, after)
        )
    };
    let suspects = alone.map_or(String::new(), |_| {
        let several = if diagnosis.suspects.len() == 1 {
            "the suspect"
        } else {
            "the suspects"
        };
        format!(
            "; with {several} below to {}{unit}, {}",
            spoken(error(last)),
            beside_noise(diagnosis, error(last))
        )
    });
    let untested = match before.1 {
        Some(_) => "",
        None => "; not yet tested on unseen recordings (--validate)",
    };
    let of_temperature = of_temperature([&diagnosis.baseline, last_stage]);
    format!("{with} the error on the {place} {falls}{suspects}{untested}.{of_temperature}")
}

/// The model with all findings and no suspect, if it stands on the ladder beside one with suspects.
pub(super) fn with_findings_alone(diagnosis: &Diagnosis) -> Option<&Rung> {
    let is_suspect = |rung: &Rung| {
        let mut suspects = diagnosis.suspects.iter();
        suspects.any(|one| rung.added.contains(&one.effect))
    };
    let first = diagnosis.ladder.iter().position(is_suspect)?;
    let before = &diagnosis.ladder[..first];
    let has = |finding: &Finding| {
        before
            .iter()
            .any(|rung| rung.added.contains(&finding.effect))
    };
    before.last().filter(|_| diagnosis.findings.iter().all(has))
}

/// Error over the noise from which on the rest is worth a word.
const MORE_THAN_NOISE: f64 = 1.5;

/// Share of draws in which chance predicts the rest of the error as well as a curve of drive and state; `None` where the rest is hardly
/// more than noise, or follows them.
pub(super) fn chance_of_rest(diagnosis: &Diagnosis) -> Option<f64> {
    let is_named = matches!(
        diagnosis.verdict,
        Verdict::Explained | Verdict::Ambiguous | Verdict::ExplainedInPart
    );
    let upper = diagnosis.noise_floor.upper?;
    let is_more = last(diagnosis).fit.train_rmse > MORE_THAN_NOISE * upper;
    failed(diagnosis, RuleId::Predicted)
        .filter(|_| is_named && is_more && diagnosis.remainder.is_none())
}

/// From one error to another, with the digits that tell them apart.
pub(super) fn from_to(before: f64, after: f64) -> String {
    let shown: fn(f64) -> String = if spoken(before) == spoken(after) {
        significant
    } else {
        spoken
    };
    format!("from {} to {}", shown(before), shown(after))
}
