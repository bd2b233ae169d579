//! The verdict of `sma diagnose`, to be read aloud.

use std::fmt::Write;

use identify::Validated;
use missing_physics::{
    Candidate, Diagnosis, EffectBlock, Finding, NoiseClass, Remainder, RuleId, Stage, Verdict,
};

use super::number::{behind, percent, significant, spoken, spoken_percent};
use super::{repeated, runs};

/// Distance to a bound, as a share of the range, at which a value stands on it.
const NEAR_BOUND: f64 = 1e-6;

/// The verdict, how well it holds, and what it does not say: a few lines.
#[must_use]
pub fn verdict(diagnosis: &Diagnosis) -> String {
    let (said, errors) = (said(diagnosis), errors(diagnosis));
    // What the unseen recordings do not bear out is not said without that.
    let [first, third] = if fails_unseen(diagnosis) {
        [errors, said]
    } else {
        [said, errors]
    };
    let parts = [
        first,
        at_bounds(diagnosis),
        third,
        noise(diagnosis),
        diagnosis
            .repeats
            .as_ref()
            .and_then(repeated::said)
            .unwrap_or_default(),
        runs::said(diagnosis).unwrap_or_default(),
        diagnosis
            .remainder
            .as_ref()
            .map_or(String::new(), |left| remains(left, &unit(diagnosis))),
        diagnosis
            .next_experiment
            .as_ref()
            .map_or(String::new(), |next| {
                format!("Next: {}", full_stop(&next.sentence))
            }),
    ];
    parts
        .iter()
        .filter(|part| !part.is_empty())
        .map(|part| format!("{part}\n"))
        .collect()
}

/// The first sentences.
fn said(diagnosis: &Diagnosis) -> String {
    let findings: Vec<String> = diagnosis.findings.iter().map(found).collect();
    let findings = findings.join("\n");
    match diagnosis.verdict {
        Verdict::NotConverged => "NOT CONVERGED: the plain model is not fitted, and nothing can be said of what it leaves out. \
             Try another --seed, or start from an earlier model (--from-model)."
            .to_owned(),
        Verdict::Adequate => {
            let unit = unit(diagnosis);
            let unseen = Validated::rmse_of_all(&diagnosis.baseline.validated).map_or(
                "; not yet tested on unseen data (--validate)".to_owned(),
                |rmse| format!(", and what it has not seen to {}{unit}", spoken(rmse)),
            );
            let at_most = diagnosis.audit.map_or(String::new(), |audit| {
                format!(
                    " At most {} of what is left, by variance, could still be physics.",
                    percent(audit.share_at_most.max(0.01))
                )
            });
            format!(
                "Nothing is missing that these recordings could show: the plain model meets them to {}{unit}{unseen}.{at_most}",
                spoken(diagnosis.baseline.fit.train_rmse),
            )
        }
        Verdict::Explained | Verdict::Ambiguous => findings,
        // What it is follows.
        Verdict::ExplainedInPart if diagnosis.remainder.is_some() => findings,
        Verdict::ExplainedInPart => match passed(diagnosis, RuleId::Slow) {
            Some(times) => format!(
                "{findings}\nWhat is left is {} times the noise between neighboring samples, and follows nothing that the model \
                 knows: it does not come back from run to run. Record the surroundings, and the rest position before and after.",
                spoken(times)
            ),
            None => format!("{findings}\nSomething else is left."),
        },
        Verdict::Unexplained if fails(diagnosis, RuleId::Describes) => {
            let predicted = statistic(diagnosis, RuleId::Describes).unwrap_or(0.0);
            format!(
                "The model does not describe this recording: of what the output does it predicts {}, on stretches that it has not \
                 seen. Do drive and output belong together?",
                percent(predicted.max(0.0))
            )
        }
        Verdict::Unexplained if fails(diagnosis, RuleId::Remainder) && is_disturbed(diagnosis) => {
            "What is left is a disturbance that does not follow the drive, and is no noise of a sensor either: it grows and shrinks \
             with the state of the rod, or repeats itself, or wanders slowly, or slips. Record the surroundings, and the rest position before and \
             after."
                .to_owned()
        }
        Verdict::Unexplained => {
            let closest: Vec<&str> = diagnosis.suspects.iter().map(|one| one.effect.info().name).collect();
            let closest = match closest.as_slice() {
                [] => "None of it even helps.".to_owned(),
                [one] => format!("Closest: {one}, which is no finding."),
                several => format!("Closest: {}, which are no findings.", listed(several, "and")),
            };
            format!("Something is missing, and nothing in the catalogue accounts for it. {closest}")
        }
    }
}

/// Statistic of a rule when it was first asked; `None` if it was not asked.
fn statistic(diagnosis: &Diagnosis, id: RuleId) -> Option<f64> {
    let mut traces = diagnosis.traces.iter();
    traces
        .find(|trace| trace.rule.id == id)
        .map(|trace| trace.value)
}

/// Statistic of a rule when it first passed; `None` if it never did.
fn passed(diagnosis: &Diagnosis, id: RuleId) -> Option<f64> {
    let mut traces = diagnosis.traces.iter();
    traces
        .find(|trace| trace.rule.id == id && trace.passed)
        .map(|trace| trace.value)
}

/// True if a rule was asked and did not pass.
fn fails(diagnosis: &Diagnosis, id: RuleId) -> bool {
    let mut traces = diagnosis.traces.iter();
    traces.any(|trace| trace.rule.id == id && !trace.passed)
}

/// True if the residual is a disturbance: nothing predicts it, yet it is no noise.
fn is_disturbed(diagnosis: &Diagnosis) -> bool {
    let odd = [RuleId::Disturbed, RuleId::Tone, RuleId::Slow, RuleId::Slip];
    odd.iter().any(|&id| passed(diagnosis, id).is_some())
}

/// A finding, under all its names.
fn found(finding: &Finding) -> String {
    if finding.could_also_be.is_empty() {
        return full_stop(&finding.sentence);
    }
    let effects = std::iter::once(&finding.effect).chain(&finding.could_also_be);
    let names: Vec<&str> = effects.map(|effect| effect.info().name).collect();
    format!(
        "{} is missing; these recordings cannot tell which. If it is {}: {}",
        capitalized(&listed(&names, "or")),
        names[0],
        full_stop(what(finding))
    )
}

/// Description of an effect, without the claim that it is missing.
#[must_use]
pub fn what(finding: &Finding) -> &str {
    let sentence = finding.sentence.as_str();
    sentence.split_once(": ").map_or(sentence, |(_, what)| what)
}

/// True if the findings do not reduce the error on the unseen recordings.
fn fails_unseen(diagnosis: &Diagnosis) -> bool {
    let before = Validated::rmse_of_all(&diagnosis.baseline.validated);
    let extended = diagnosis.extended.as_ref();
    let after = extended.and_then(|one| Validated::rmse_of_all(&one.stage.validated));
    before
        .zip(after)
        .is_some_and(|(before, after)| after >= before)
}

/// Which sizes would be larger still if they could: a sign that another effect is meant.
fn at_bounds(diagnosis: &Diagnosis) -> String {
    let estimates = diagnosis.findings.iter().flat_map(|finding| {
        let infos = finding.effect.info().parameters.iter();
        infos.zip(&finding.parameters)
    });
    let on_bound: Vec<&str> = estimates
        .filter(|(info, estimate)| {
            let near = NEAR_BOUND * (info.bounds[1] - info.bounds[0]);
            let is_whole = info.name.ends_with("_share") && info.bounds[1] >= 1.0;
            let is_on = |bound: f64| bound != 0.0 && (estimate.value - bound).abs() <= near;
            !is_whole && info.bounds.into_iter().any(is_on)
        })
        .map(|(info, _)| info.name)
        .collect();
    if on_bound.is_empty() {
        return String::new();
    }
    format!(
        "DOUBTFUL, on a bound of what is possible: {}. The data pull further: something else may be meant.",
        listed(&on_bound, "and")
    )
}

/// How much smaller the error got, where that was tested.
fn errors(diagnosis: &Diagnosis) -> String {
    let (Some(extended), Some(explained)) = (&diagnosis.extended, diagnosis.explained) else {
        return String::new();
    };
    let unit = unit(diagnosis);
    let share = |share: f64, interval: Option<[f64; 2]>| {
        let said = spoken_percent(share);
        // A floor that is only a lower bound makes the share one, too.
        let is_least = diagnosis.noise_floor.upper.is_none() && said != spoken_percent(1.0);
        let at_least = if is_least { "at least " } else { "" };
        let ends = interval.map(|ends| ends.map(spoken_percent));
        let ends = ends.filter(|ends| ends.iter().any(|end| *end != said));
        let ends = ends.map_or(String::new(), |[lower, upper]| {
            format!(" ({lower} to {upper})")
        });
        format!("{at_least}{said}{ends} of what could be explained is")
    };
    let unseen = &diagnosis.baseline.validated;
    let pair = (
        Validated::rmse_of_all(unseen),
        Validated::rmse_of_all(&extended.stage.validated),
    );
    let (Some(before), Some(after)) = pair else {
        let mut text = format!(
            "Error on the training recordings {}{unit}. Not yet tested on unseen data (--validate)",
            change(
                diagnosis.baseline.fit.train_rmse,
                extended.stage.fit.train_rmse
            )
        );
        if let Some(held_out) = explained.train {
            let _ = write!(text, "; held out in parts, {}", share(held_out, None));
        }
        return text + ".";
    };
    let error = if diagnosis.verdict == Verdict::Unexplained {
        "With what is closest, error"
    } else {
        "Error"
    };
    let recordings = if unseen.len() == 1 {
        "recording"
    } else {
        "recordings"
    };
    let change = format!("{}{unit}", change(before, after));
    if fails_unseen(diagnosis) {
        return format!(
            "{error} on the unseen {recordings} {change}: it does not fall. What follows fits the training recordings only."
        );
    }
    let Some(validate) = explained.validate else {
        return format!(
            "{error} on the unseen {recordings} {change}; the plain model's error is the noise's there, and tests nothing."
        );
    };
    let said = share(validate, explained.validate_interval);
    let doubt = match explained.validate_interval {
        Some([lower, _]) if lower <= 0.0 => " What was not seen does not bear this out.",
        _ => "",
    };
    let predicted = predicted(diagnosis, &extended.stage, after, &unit);
    format!("{error} on the unseen {recordings} {change}; {said}.{doubt}{predicted}")
}

/// Predicted error of unseen recordings over the calibrated one, from which it is said.
const WORSE_PREDICTED: f64 = 1.2;

/// The predicted errors of unseen recordings, where they are much larger.
fn predicted(diagnosis: &Diagnosis, extended: &Stage, calibrated: f64, unit: &str) -> String {
    let pair = diagnosis
        .baseline
        .predicted_rmse
        .zip(extended.predicted_rmse);
    let worse = pair.filter(|(_, after)| *after > WORSE_PREDICTED * calibrated);
    worse.map_or(String::new(), |(before, after)| {
        format!(
            " Predicted, with nothing of its own but its offset: {}{unit}.",
            change(before, after)
        )
    })
}

/// From one error to another, with the digits that tell them apart.
fn change(before: f64, after: f64) -> String {
    let shown: fn(f64) -> String = if spoken(before) == spoken(after) {
        significant
    } else {
        spoken
    };
    format!("{} → {}", shown(before), shown(after))
}

/// The noise, where it limits what may be said.
fn noise(diagnosis: &Diagnosis) -> String {
    let floor = diagnosis.noise_floor;
    if diagnosis.verdict == Verdict::NotConverged {
        return String::new();
    }
    let unit = unit(diagnosis);
    let size = match floor.upper {
        Some(upper) if spoken(upper) == spoken(floor.lower) => format!("{}{unit}", spoken(upper)),
        Some(upper) => format!("{} to {}{unit}", spoken(floor.lower), spoken(upper)),
        None => format!(
            "at least {}{unit}; more of the error may be noise",
            spoken(floor.lower)
        ),
    };
    let forbids = "tests then see effects where there are none, so that an effect is suspected, not named, unless \
                   cycles are repeated";
    match floor.class {
        NoiseClass::White | NoiseClass::Colored => format!("The noise is {size}."),
        NoiseClass::OneOverF => {
            format!("The noise is {size}. It grows toward low frequencies without end: {forbids}.")
        }
        NoiseClass::Quantized => {
            format!("The noise is {size}. The converter's step exceeds it: {forbids}.")
        }
    }
}

/// Remainder after the findings, in words.
fn remains(left: &Remainder, unit: &str) -> String {
    let place = match (left.mismatch.block, left.mismatch.cells.first()) {
        (Some((block, probability)), cell) => format!(
            ", most likely in the {} ({}){}",
            block_name(block),
            spoken_percent(probability),
            cell.map_or(String::new(), |cell| format!(", above all: {}", cell.at))
        ),
        (None, Some(cell)) => format!(", above all: {}", cell.at),
        (None, None) => String::new(),
    };
    format!(
        "What remains on the training recordings: {}{unit} beyond the noise, {} of what could be explained{place}.",
        spoken(left.rms),
        spoken_percent(left.share)
    )
}

/// A block in a sentence.
#[must_use]
pub fn block_name(block: EffectBlock) -> &'static str {
    match block {
        EffectBlock::Drive => "drive",
        EffectBlock::HeatBalance => "heat balance",
        EffectBlock::Transformation => "transformation",
        EffectBlock::Displacement => "displacement",
        EffectBlock::Sensor => "thermometer",
    }
}

/// Names of effects in a sentence.
#[must_use]
pub fn named(effects: &[Candidate], word: &str) -> String {
    let names: Vec<&str> = effects.iter().map(|effect| effect.info().name).collect();
    listed(&names, word)
}

/// Unit of the output behind a number: nothing where it has none.
#[must_use]
pub fn unit(diagnosis: &Diagnosis) -> String {
    behind(&diagnosis.baseline.fit.output_unit)
}

/// "a, b and c".
fn listed(names: &[&str], word: &str) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [first @ .., last] => format!("{} {word} {last}", first.join(", ")),
    }
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().to_string() + letters.as_str()
    })
}

fn full_stop(text: &str) -> String {
    text.trim_end_matches('.').to_owned() + "."
}
