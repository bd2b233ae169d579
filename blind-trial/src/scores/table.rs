//! The table of a trial.

use super::calibration::Calibration;
use super::figure::{Figure, Score, Target, mean, median};
use super::groups::groups;
use super::view::DRIFTS;
use crate::{CaseLine, Family, Proportion};

/// All quantities of a trial, those without a case included. Where a denominator needs an effect that is visible, its
/// oracle score is at least 5; that nothing was said is a miss.
#[must_use]
pub fn table(lines: &[CaseLine], calibration: &Calibration, times_alone_s: &[f64]) -> Vec<Score> {
    let of = |family: Family| -> Vec<&CaseLine> {
        lines
            .iter()
            .filter(|line| line.case.family == family)
            .collect()
    };
    let seen = |family: Family| -> Vec<&CaseLine> {
        of(family)
            .into_iter()
            .filter(|line| line.is_visible())
            .collect()
    };
    let mut scores = false_alarms(&of);
    scores.extend(singles(&seen(Family::Single)));
    scores.push(share(
        "1/f, coarse steps, outliers: true effect in the stated set",
        &seen(Family::HardNoise),
        CaseLine::states_all,
        None,
    ));
    scores.push(share(
        "both effects of a pair in the sets",
        &seen(Family::Pair),
        CaseLine::states_all,
        Some(Target::AtLeast(0.8)),
    ));
    scores.extend(unknown(&seen(Family::Outside), &seen(Family::Deleted)));
    scores.extend(beside_all_that_is_open(&seen));
    scores.push(share(
        "other hysteresis: true effect in the stated set",
        &seen(Family::OtherLoop),
        CaseLine::states_all,
        Some(Target::AtLeast(0.75)),
    ));
    scores.push(share(
        "other hysteresis alone: nothing named outside the transformation",
        &of(Family::OtherLoopClean),
        |line| !line.is_wrong(),
        Some(Target::AtLeast(0.9)),
    ));
    scores.push(Score {
        quantity: "calibration error of stated probabilities".to_owned(),
        figure: Figure::Number {
            value: calibration.error(),
            n: calibration.n(),
            unit: "",
        },
        target: Some(Target::AtMost(0.05)),
    });
    let all: Vec<&CaseLine> = lines.iter().collect();
    scores.extend(beyond_names(&all));
    scores.extend(next_runs(lines));
    scores.push(Score {
        quantity: "median time of a diagnosis".to_owned(),
        figure: median(times_alone_s.to_vec(), "s"),
        target: Some(Target::AtMost(2.0)),
    });
    scores.extend(groups(lines));
    scores
}

/// Shares of effects that are visible beside unknowns of single runs and another loop, too; nothing of trials that did not ask.
pub(super) fn beside_all_that_is_open<'a>(
    seen: &impl Fn(Family) -> Vec<&'a CaseLine>,
) -> Vec<Score> {
    let still_seen = |families: &[Family]| -> Vec<&'a CaseLine> {
        let all = families.iter().flat_map(|&family| seen(family));
        all.filter(|line| line.is_visible_beside_all_that_is_open())
            .collect()
    };
    let mut scores = vec![
        share(
            "visible beside what is open: true effect in the stated set",
            &still_seen(&[Family::Single]),
            CaseLine::states_all,
            None,
        ),
        share(
            "visible beside what is open: both effects of a pair in the sets",
            &still_seen(&[Family::Pair]),
            CaseLine::states_all,
            None,
        ),
        share(
            "visible beside what is open: outside or deleted: unexplained",
            &still_seen(&[Family::Outside, Family::Deleted]),
            CaseLine::is_unexplained,
            None,
        ),
    ];
    scores.retain(|score| score.figure.value().is_some());
    scores
}

/// Scores of statements beside the names.
pub(super) fn beyond_names(lines: &[&CaseLine]) -> Vec<Score> {
    let misfits: Vec<&CaseLine> = lines
        .iter()
        .copied()
        .filter(|line| line.misfits())
        .collect();
    let exclusions: Vec<bool> = lines.iter().flat_map(|line| line.exclusions()).collect();
    vec![
        share(
            "misfit of 5 times the noise or more: called adequate",
            &misfits,
            CaseLine::is_adequate,
            None,
        ),
        Score {
            quantity: "visible effect of known size: excluded at that size or below".to_owned(),
            figure: Figure::Share(Proportion::of(&exclusions, |is_excluded| **is_excluded)),
            target: None,
        },
    ]
}

pub(super) fn share(
    quantity: &str,
    lines: &[&CaseLine],
    is_hit: impl Fn(&CaseLine) -> bool,
    target: Option<Target>,
) -> Score {
    Score {
        quantity: quantity.to_owned(),
        figure: Figure::Share(Proportion::of(lines, |line| is_hit(line))),
        target,
    }
}

pub(super) fn false_alarms<'a>(of: &impl Fn(Family) -> Vec<&'a CaseLine>) -> Vec<Score> {
    let noises = [
        (
            Family::CleanWhite,
            "white",
            Target::AtMostSurely(0.05, 0.08),
        ),
        (Family::CleanAr, "AR", Target::AtMostSurely(0.05, 0.08)),
        (Family::CleanOneOverF, "1/f", Target::AtMost(0.08)),
        (Family::CleanQuantized, "coarse steps", Target::AtMost(0.08)),
        (Family::CleanOutliers, "outliers", Target::AtMost(0.08)),
    ];
    noises
        .into_iter()
        .map(|(family, noise, target)| {
            share(
                &format!("false alarm, {noise}"),
                &of(family),
                CaseLine::is_wrong,
                Some(target),
            )
        })
        .collect()
}

fn singles(lines: &[&CaseLine]) -> Vec<Score> {
    let sizes: Vec<f64> = lines
        .iter()
        .map(|line| line.stated().len() as f64)
        .filter(|&size| size > 0.0)
        .collect();
    let carried = lines.iter().filter(|line| !DRIFTS.contains(&line.truth()));
    let explained = carried.map(|line| line.verdict.explained.unwrap_or(0.0));
    let estimates: Vec<(f64, Option<bool>)> =
        lines.iter().filter_map(|line| estimate(line)).collect();
    let intervals: Vec<bool> = estimates.iter().filter_map(|(_, covers)| *covers).collect();
    let spans: Vec<[f64; 2]> = lines.iter().filter_map(|line| line.opened.spans).collect();
    let number = |quantity: &str, figure: Figure, target: Option<Target>| Score {
        quantity: quantity.to_owned(),
        figure,
        target,
    };
    vec![
        share(
            "true effect in the stated set",
            lines,
            CaseLine::states_all,
            Some(Target::AtLeast(0.95)),
        ),
        number(
            "mean size of the set",
            mean(&sizes),
            Some(Target::AtMost(1.6)),
        ),
        share(
            "top-1",
            lines,
            |line| line.top() == Some(line.truth()),
            Some(Target::AtLeast(0.8)),
        ),
        share(
            "right cluster of aliases",
            lines,
            CaseLine::is_near,
            Some(Target::AtLeast(0.92)),
        ),
        number(
            "held-out explained fraction, median (without drifts, which stay with their recording)",
            median(explained.collect(), ""),
            Some(Target::AtLeast(0.95)),
        ),
        share(
            "block located",
            lines,
            CaseLine::locates,
            Some(Target::AtLeast(0.9)),
        ),
        number(
            "share of the effect's squares in the blamed spans over their share of the time, median",
            median(spans.iter().map(|[share, time]| share / time).collect(), ""),
            None,
        ),
        number(
            "error of the named size, median",
            median(estimates.iter().map(|(error, _)| *error).collect(), ""),
            None,
        ),
        Score {
            quantity: "95 % intervals of the named size that hold the truth".to_owned(),
            figure: Figure::Share(Proportion::of(&intervals, |covers| **covers)),
            target: None,
        },
    ]
}

/// Relative error of a named size whose parameter means the same in truth and catalogue, and whether its interval
/// holds the truth.
fn estimate(line: &CaseLine) -> Option<(f64, Option<bool>)> {
    let known = line.opened.answer.concealed.first()?.parameter.as_ref()?;
    if !line.opened.has_scale {
        return None;
    }
    let findings = &line.verdict.findings;
    let finding = findings
        .iter()
        .find(|finding| finding.effect == line.truth())?;
    let parameters = &finding.parameters;
    let own = parameters.iter().find(|own| own.name == known.name)?;
    let covers = own
        .ci95
        .map(|[lower, upper]| (lower..=upper).contains(&known.value));
    Some(((own.value / known.value - 1.0).abs(), covers))
}

fn unknown(outside: &[&CaseLine], deleted: &[&CaseLine]) -> Vec<Score> {
    let both = [outside, deleted].concat();
    let mut scores = Vec::new();
    for (of, lines, is_target) in [
        ("outside the catalogue or deleted", &both[..], true),
        ("  outside", outside, false),
        ("  deleted with aliases", deleted, false),
    ] {
        let target = |target: Target| is_target.then_some(target);
        scores.push(share(
            &format!("{of}: unexplained"),
            lines,
            CaseLine::is_unexplained,
            target(Target::AtLeast(0.85)),
        ));
        scores.push(share(
            &format!("{of}: confident wrong name"),
            lines,
            CaseLine::is_wrong_and_sure,
            target(Target::AtMost(0.03)),
        ));
        // Another loop is there, too, and its name is right.
        scores.push(share(
            &format!("{of}: unexplained, or in part by another loop"),
            lines,
            |line| line.is_unexplained() || line.is_in_part_by_another_loop(),
            None,
        ));
    }
    scores
}

fn next_runs(lines: &[CaseLine]) -> Vec<Score> {
    let runs: Vec<_> = lines.iter().filter_map(|line| line.opened.next).collect();
    let recommended = Proportion::of(&runs, |next| next.recommended);
    let random = Proportion::of(&runs, |next| next.random);
    let failures = |of: Proportion| (of.n - of.hits) as f64;
    vec![
        Score {
            quantity: "ambiguous sets that the recommended run resolves".to_owned(),
            figure: Figure::Share(recommended),
            target: Some(Target::AtLeast(0.8)),
        },
        Score {
            quantity: "its failures over those of a random run".to_owned(),
            figure: Figure::Number {
                value: failures(recommended) / failures(random),
                n: random.n - random.hits,
                unit: "",
            },
            target: Some(Target::AtMost(0.5)),
        },
    ]
}
