//! Errors before and after, and what is left of them.

use std::fmt::Write;

use comfy_table::{Cell, Table};
use identify::Validated;
use missing_physics::{Diagnosis, Finding, NoiseClass, Remainder, RuleId, Verdict};

use super::headline::{chance_of_rest, from_to, last, unit, with_findings_alone};
use super::traces::{failed, passed};
use crate::report::number::{significant, spoken, spoken_percent};
use crate::report::table::{right, table};
use crate::report::words::{block_name, named, recordings};

/// Predicted error of unseen recordings over the calibrated one, from which it is said.
const WORSE_PREDICTED: f64 = 1.2;

/// Errors from the baseline model down to the noise.
pub(super) fn ladder(diagnosis: &Diagnosis) -> Table {
    let is_tested = diagnosis
        .ladder
        .iter()
        .any(|rung| rung.unseen_rmse.is_some());
    let first = match unit(diagnosis).trim() {
        "" => "RMS error".to_owned(),
        unit => format!("RMS error, {unit}"),
    };
    let mut header = vec![first.as_str(), "training"];
    if is_tested {
        header.extend(["unseen, predicted", "unseen, calibrated"]);
    }
    let n_columns = header.len();
    let mut table = table(header);
    for rung in &diagnosis.ladder {
        let is_suspect = |one: &Finding| rung.added.contains(&one.effect);
        let name = match named(&rung.added, "and") {
            name if name.is_empty() => "baseline model".to_owned(),
            name if diagnosis.suspects.iter().any(is_suspect) => format!("+ {name} (suspected)"),
            name => format!("+ {name}"),
        };
        let shown = |error: Option<f64>| right(error.map_or("-".to_owned(), significant));
        let cells = [
            Cell::new(name),
            right(significant(rung.train_rmse)),
            shown(rung.predicted_rmse),
            shown(rung.unseen_rmse),
        ];
        table.add_row(cells.into_iter().take(n_columns));
    }
    let floor = diagnosis.noise_floor;
    let size = match floor.upper {
        Some(upper) if significant(upper) == significant(floor.lower) => significant(upper),
        Some(upper) => format!("{} … {}", significant(floor.lower), significant(upper)),
        None => format!("≥ {}", significant(floor.lower)),
    };
    let class = floor.class.id().replace('_', " ");
    table.add_row([format!("noise level ({class}): {size}")]);
    table
}

/// Instructions for reading [`ladder`].
pub(super) fn how_to_read_ladder(diagnosis: &Diagnosis) -> &'static str {
    let mut rungs = diagnosis.ladder.iter();
    if rungs.any(|rung| rung.unseen_rmse.is_some()) {
        "Each line adds to those above; an error may rise before it falls further. Predicted: only the offset at rest is taken from the \
         unseen recording. Calibrated: its surroundings, and a drift where the model has one, are fitted as well, on stretches that \
         are not scored."
    } else {
        "Each line adds to those above."
    }
}

/// Share of the explainable error that is explained, and where it was tested.
pub(super) fn explained(diagnosis: &Diagnosis) -> Option<String> {
    // What only suspects explain is explained by no finding.
    let extended = diagnosis
        .extended
        .as_ref()
        .filter(|_| !diagnosis.findings.is_empty())?;
    let explained = diagnosis.explained?;
    let (share, interval, place) = match (explained.validate, explained.train) {
        (Some(share), _) => {
            let n_unseen = diagnosis.baseline.validated.len();
            let place = format!("on the unseen {}", recordings(n_unseen));
            (share, explained.validate_interval, place)
        }
        (None, Some(share)) if diagnosis.baseline.validated.is_empty() => (
            share,
            None,
            "on stretches of the training that were held out".to_owned(),
        ),
        (None, _) if !diagnosis.baseline.validated.is_empty() => {
            return Some(
                "The unseen recordings test nothing: the baseline model's error there is that of the noise."
                    .to_owned(),
            );
        }
        (None, _) => return None,
    };
    let shown = spoken_percent(share);
    let amount = match shown == spoken_percent(1.0) {
        true => "All".to_owned(),
        false if share <= 0.0 => "Nothing".to_owned(),
        false => shown.clone(),
    };
    let ends = interval.map(|ends| ends.map(spoken_percent));
    let ends = ends.filter(|ends| ends.iter().any(|end| *end != shown));
    let ends = ends.map_or(String::new(), |[lower, upper]| {
        format!(" (95 % interval: {lower} to {upper})")
    });
    let suspects = match diagnosis.suspects.len() {
        0 => "",
        1 => "the suspect",
        _ => "the suspects",
    };
    let by_findings = explained
        .by_findings
        .filter(|own| spoken_percent(*own) != shown);
    let mut text = match by_findings {
        Some(own) => format!(
            "The findings explain {} of the explainable error {place}, and with {suspects} {shown}{ends}.",
            spoken_percent(own)
        ),
        None if suspects.is_empty() => {
            format!("{amount} of the explainable error{ends} is explained {place}.")
        }
        None => format!(
            "{amount} of the explainable error{ends} is explained {place}, {suspects} included."
        ),
    };
    if matches!(interval, Some([lower, _]) if lower <= 0.0) {
        text += " What was not seen does not bear the findings out.";
    }
    let after = match with_findings_alone(diagnosis) {
        Some(rung) => (rung.predicted_rmse, rung.unseen_rmse),
        None => (
            extended.stage.predicted_rmse,
            Validated::rmse_of_all(&extended.stage.validated),
        ),
    };
    if let (Some(before), (Some(after), Some(calibrated))) =
        (diagnosis.baseline.predicted_rmse, after)
        && after > WORSE_PREDICTED * calibrated
    {
        let _ = write!(
            text,
            " Predicted instead of calibrated, the error goes {}{}: expect that of the next run.",
            from_to(before, after),
            unit(diagnosis)
        );
    }
    Some(text)
}

/// The noise, where it limits what may be said.
pub(super) fn noise(diagnosis: &Diagnosis) -> Option<String> {
    let floor = diagnosis.noise_floor;
    let unit = unit(diagnosis);
    let size = match floor.upper {
        Some(upper) if spoken(upper) == spoken(floor.lower) => format!("{}{unit}", spoken(upper)),
        Some(upper) => format!("{} to {}{unit}", spoken(floor.lower), spoken(upper)),
        None => format!(
            "at least {}{unit}; more of the error may be noise",
            spoken(floor.lower)
        ),
    };
    match floor.class {
        NoiseClass::White | NoiseClass::Colored => None,
        NoiseClass::OneOverF => Some(format!(
            "Noise level: {size}. It grows toward low frequencies without end, as a slow drift does: repeat cycles to tell them apart."
        )),
        NoiseClass::Quantized => Some(format!(
            "Noise level: {size}. The converter's step exceeds it: a finer range of the sensor would show more."
        )),
    }
}

/// True if the findings explain enough of the explainable error of the unseen recordings, however much is left there.
fn findings_hold_elsewhere(diagnosis: &Diagnosis) -> bool {
    let shares = diagnosis.explained.and_then(|shares| shares.by_findings);
    shares.is_some_and(|share| RuleId::UnseenShare.rule().passes(share))
}

/// Rest of the error after the findings, in words; `None` if nothing is to be said of it.
pub(super) fn rest(diagnosis: &Diagnosis) -> Option<String> {
    if let Some(left) = &diagnosis.remainder {
        return Some(remainder(left, &unit(diagnosis)));
    }
    match diagnosis.verdict {
        Verdict::ExplainedInPart => Some(match passed(diagnosis, RuleId::Slow) {
            Some(times) => format!(
                "Left: a slow wander, {} times the noise between neighboring samples, in which no dependence on drive or state was found. Record \
                 the surroundings, and the rest position before and after.",
                spoken(times)
            ),
            None => match failed(diagnosis, RuleId::UnseenShare) {
                Some(made) if findings_hold_elsewhere(diagnosis) => format!(
                    "Left: the unseen recordings are missed by far more than the training. Noise as there and the uncertainty of the parameters make {} \
                     of that error (needs ≥ {}).",
                    spoken_percent(made),
                    spoken_percent(RuleId::UnseenShare.rule().threshold)
                ),
                Some(share) => format!(
                    "Left: the findings explain {} of the explainable error of the unseen recordings (needs ≥ {}).",
                    spoken_percent(share),
                    spoken_percent(RuleId::UnseenShare.rule().threshold)
                ),
                None => "Left: more than noise.".to_owned(),
            },
        }),
        Verdict::Explained | Verdict::Ambiguous => {
            let chance = chance_of_rest(diagnosis)?;
            Some(format!(
                "Left: {}{} RMS in training, of unknown cause. No dependence on drive or state was found in it: chance predicts it as well as a free curve \
                 in {} of draws (needs ≤ {}).",
                spoken(last(diagnosis).fit.train_rmse),
                unit(diagnosis),
                spoken_percent(chance),
                spoken_percent(RuleId::Predicted.rule().threshold)
            ))
        }
        Verdict::Adequate => diagnosis.audit.map(|audit| {
            format!(
                "At most {} of the variance that is left could still be physics.",
                spoken_percent(audit.share_at_most.max(0.01))
            )
        }),
        Verdict::Unexplained | Verdict::NotConverged => None,
    }
}

fn remainder(left: &Remainder, unit: &str) -> String {
    let mut text = format!(
        "Left: {}{unit} RMS beyond the noise on stretches that were left out, {} of the error above the noise",
        spoken(left.rms),
        spoken_percent(left.share)
    );
    if let Some((block, probability)) = left.mismatch.block {
        let _ = write!(
            text,
            ". It arises most likely in the {} ({})",
            block_name(block),
            spoken_percent(probability)
        );
    }
    if let Some(cell) = left.mismatch.cells.first() {
        let _ = write!(
            text,
            ". {} of it lies in one regime: {}",
            spoken_percent(cell.share),
            cell.at
        );
    }
    text + "."
}
