//! What the cases of a study come to, as Markdown tables.

use std::fmt::Write;

use blind_trial::Proportion;

use crate::{CaseLine, Outcome, Study};

/// Score from which on an effect counts as visible, standard deviations.
const VISIBLE_T: f64 = 5.0;

/// Probability from which on a name is stated with confidence.
const CONFIDENT: f64 = 0.8;

/// Effects that belong to their recording: they are not carried to another one.
const DRIFTS: [&str; 2] = ["ambient-drift", "sensor-drift"];

/// The table of a study; its intervals are exact 95 % intervals of a probability.
#[must_use]
pub fn summary(study: Study, lines: &[&CaseLine]) -> String {
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = writeln!(text, "{}: {} cases\n", study.id(), lines.len());
    let table = match study {
        Study::CleanWhite | Study::CleanAr1 => clean(lines),
        Study::Single => single(lines) + "\n" + &held_out(lines) + "\n" + &by_effect(lines),
        Study::Removed => removed(lines),
        Study::CoverageLatentHeat | Study::CoverageBacklash | Study::CoverageAmbientDrift => {
            coverage(lines)
        }
    };
    text + &table
}

fn clean(lines: &[&CaseLine]) -> String {
    let with_finding = Proportion::of(lines, |line| !line.diagnosis.findings.is_empty());
    let [lower, upper] = with_finding.interval().map(|end| 200.0 * end);
    let mut rows = vec![
        vec!["with a finding".to_owned(), with_finding.to_string()],
        vec![
            "the same, per 200".to_owned(),
            format!(
                "{:.1} ({lower:.1} to {upper:.1})",
                200.0 * with_finding.share()
            ),
        ],
        vec![
            "with suspects only".to_owned(),
            Proportion::of(lines, |line| {
                line.diagnosis.findings.is_empty() && !line.diagnosis.suspects.is_empty()
            })
            .to_string(),
        ],
    ];
    for (verdict, n) in verdicts(lines.iter().map(|line| &line.diagnosis)) {
        rows.push(vec![format!("verdict {verdict}"), n.to_string()]);
    }
    table(&["clean recordings", "number"], &rows)
}

fn verdicts<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> Vec<(&'a str, usize)> {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for outcome in outcomes {
        match counts
            .iter_mut()
            .find(|(known, _)| *known == outcome.verdict)
        {
            Some((_, n)) => *n += 1,
            None => counts.push((&outcome.verdict, 1)),
        }
    }
    counts.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(b.0)));
    counts
}

/// How well a concealed effect was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Hit {
    Named,
    InSet,
    Missed,
}

const HITS: [Hit; 3] = [Hit::Named, Hit::InSet, Hit::Missed];

fn effect_of(line: &CaseLine) -> &str {
    line.truth.as_ref().map_or("", |truth| &truth.effect)
}

fn hit(line: &CaseLine) -> Hit {
    if line.diagnosis.names(effect_of(line)) {
        Hit::Named
    } else if line.is_found() {
        Hit::InSet
    } else {
        Hit::Missed
    }
}

/// Whether the concealed effect helps, and its name is not licensed.
fn is_suspect(line: &CaseLine) -> bool {
    let mut suspects = line.diagnosis.suspects.iter();
    suspects.any(|suspect| suspect == effect_of(line))
}

fn is_visible(line: &CaseLine) -> bool {
    line.diagnosis.t.is_some_and(|t| t.abs() >= VISIBLE_T)
}

/// Findings that neither are the concealed effect nor could be.
fn has_other_names(line: &CaseLine) -> bool {
    let truth = [effect_of(line).to_owned()];
    let mut findings = line.diagnosis.findings.iter();
    findings.any(|finding| !finding.meets(&truth))
}

/// The visible cases, and the others.
fn by_visibility<'a>(lines: &[&'a CaseLine]) -> [(String, Vec<&'a CaseLine>); 2] {
    let (visible, others) = lines.iter().partition(|line| is_visible(line));
    [
        (format!("t >= {VISIBLE_T}"), visible),
        ("below".to_owned(), others),
    ]
}

fn single(lines: &[&CaseLine]) -> String {
    let rows: Vec<_> = by_visibility(lines)
        .into_iter()
        .map(|(name, lines)| {
            let count = |wanted| Proportion::of(&lines, |line| hit(line) == wanted).to_string();
            let mut row = vec![name];
            row.extend(HITS.map(count));
            row.push(Proportion::of(&lines, |line| is_suspect(line)).to_string());
            row.push(Proportion::of(&lines, |line| has_other_names(line)).to_string());
            row
        })
        .collect();
    let head = [
        "score",
        "named",
        "in the stated set",
        "not found",
        "of these a suspect",
        "another name stated",
    ];
    table(&head, &rows)
}

fn held_out(lines: &[&CaseLine]) -> String {
    let (drifts, others): (Vec<&CaseLine>, Vec<&CaseLine>) = lines
        .iter()
        .partition(|line| DRIFTS.contains(&effect_of(line)));
    let mut rows = Vec::new();
    for (name, lines) in by_visibility(&others) {
        let errors = lines.iter().map(|line| line.diagnosis.errors().unseen);
        let (n, [_, median, max]) = spread(errors.flatten());
        let what = format!("unseen error over the noise, {name}");
        rows.push(vec![what, n, format!("median {median}, max {max}")]);
    }
    for (name, lines) in by_visibility(&drifts) {
        let shares = lines.iter().map(|line| line.diagnosis.explained?.train);
        let (n, [min, median, _]) = spread(shares.flatten());
        let what = format!("drifts: share explained in the training's folds, {name}");
        rows.push(vec![what, n, format!("median {median}, min {min}")]);
    }
    table(&["held out", "cases", "value"], &rows)
}

fn by_effect(lines: &[&CaseLine]) -> String {
    let mut effects: Vec<&str> = lines.iter().map(|line| effect_of(line)).collect();
    effects.sort_unstable();
    effects.dedup();
    let rows: Vec<_> = effects
        .into_iter()
        .map(|effect| {
            let own: Vec<&CaseLine> = lines
                .iter()
                .copied()
                .filter(|line| effect_of(line) == effect)
                .collect();
            let counts = by_visibility(&own).map(|(_, lines)| {
                HITS.map(|wanted| {
                    let hits = lines.iter().filter(|line| hit(line) == wanted);
                    hits.count().to_string()
                })
                .join(" / ")
            });
            [vec![effect.to_owned()], counts.to_vec()].concat()
        })
        .collect();
    let visible = format!("t >= {VISIBLE_T}: named / in set / not found");
    table(&["effect", &visible, "below"], &rows)
}

/// What became of a concealed effect that is not in the catalogue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Substitute {
    Alias,
    Wrong { is_confident: bool },
    Unexplained,
    Other,
}

fn substitute(step: &Outcome, aliases: &[String]) -> Substitute {
    let wrong = || {
        step.findings
            .iter()
            .filter(|finding| !finding.meets(aliases))
    };
    if wrong().next().is_some() {
        Substitute::Wrong {
            is_confident: wrong().any(|finding| finding.probability > CONFIDENT),
        }
    } else if !step.findings.is_empty() {
        Substitute::Alias
    } else if step.verdict == "unexplained" {
        Substitute::Unexplained
    } else {
        Substitute::Other
    }
}

/// What became of the truth in a line's first step, or in its last.
fn substitutes(lines: &[&CaseLine], is_last: bool) -> Vec<Substitute> {
    let of = |line: &&CaseLine| {
        let step = if is_last {
            line.steps.last()
        } else {
            line.steps.first()
        }?;
        // The last step has struck the most: the truth and then all aliases.
        let aliases = &line.steps.last()?.removed[1..];
        Some(substitute(&step.diagnosis, aliases))
    };
    lines.iter().filter_map(of).collect()
}

fn removed(lines: &[&CaseLine]) -> String {
    let is_shown = |line: &&CaseLine| !line.diagnosis.findings.is_empty();
    let shown: Vec<&CaseLine> = lines.iter().copied().filter(is_shown).collect();
    let rows: Vec<_> = [("the truth", false), ("the truth and its aliases", true)]
        .map(|(name, is_last)| {
            let all = substitutes(&shown, is_last);
            let count =
                |is: &dyn Fn(&Substitute) -> bool| Proportion::of(&all, |one| is(one)).to_string();
            vec![
                name.to_owned(),
                count(&|one| *one == Substitute::Alias),
                count(&|one| matches!(one, Substitute::Wrong { .. })),
                count(&|one| *one == Substitute::Wrong { is_confident: true }),
                count(&|one| *one == Substitute::Unexplained),
                count(&|one| *one == Substitute::Other),
            ]
        })
        .into();
    let head = [
        "struck",
        "alias named",
        "wrong name",
        &format!("the same with P > {CONFIDENT}"),
        "unexplained",
        "nothing missed",
    ];
    let n_hidden = lines.len() - shown.len();
    table(&head, &rows)
        + &format!(
            "\nNot counted: {n_hidden} cases in which the whole catalogue finds nothing.\n\n"
        )
        + &table(
            &["truth, struck alone", "wrong names"],
            &wrong_names(&shown),
        )
}

/// The cases whose first step has a wrong name, with the wrong names.
fn wrong_names(lines: &[&CaseLine]) -> Vec<Vec<String>> {
    let of = |line: &&CaseLine| {
        let aliases = &line.steps.last()?.removed[1..];
        let findings = line.steps.first()?.diagnosis.findings.iter();
        let wrong: Vec<String> = findings
            .filter(|finding| !finding.meets(aliases))
            .map(|finding| format!("{} (P = {:.2})", finding.effect, finding.probability))
            .collect();
        let case = format!("{} (case {})", effect_of(line), line.case);
        (!wrong.is_empty()).then(|| vec![case, wrong.join(", ")])
    };
    lines.iter().filter_map(of).collect()
}

fn coverage(lines: &[&CaseLine]) -> String {
    let estimates: Vec<_> = lines
        .iter()
        .filter_map(|line| line.diagnosis.interval.as_ref())
        .collect();
    let within: Vec<_> = estimates
        .iter()
        .filter_map(|one| Some((one.ci95?, one.truth)))
        .collect();
    let contain = Proportion::of(&within, |([lower, upper], truth)| {
        (*lower..=*upper).contains(truth)
    });
    let ratios = estimates.iter().map(|one| one.value / one.truth);
    let (_, [min, median, max]) = spread(ratios);
    let rows = [
        [
            "95 % intervals with the truth".to_owned(),
            contain.to_string(),
        ],
        [
            "cases without an interval".to_owned(),
            (lines.len() - within.len()).to_string(),
        ],
        [
            "estimate over truth".to_owned(),
            format!("median {median}, {min} to {max}"),
        ],
        [
            "cases with the effect named".to_owned(),
            Proportion::of(lines, |line| hit(line) == Hit::Named).to_string(),
        ],
    ]
    .map(Vec::from);
    table(&["first size", "number"], &rows)
}

/// Number of values, and the least, the median and the largest of them.
fn spread(values: impl Iterator<Item = f64>) -> (String, [String; 3]) {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let at = |k: usize| values.get(k).copied();
    let median = at(n / 2).zip(at(n.saturating_sub(1) / 2));
    let median = median.map(|(upper, lower)| 0.5 * (upper + lower));
    let shown = [at(0), median, values.last().copied()]
        .map(|value| value.map_or("none".to_owned(), |value| format!("{value:.3}")));
    (n.to_string(), shown)
}

fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let mut text = format!("| {} |\n|{}\n", head.join(" | "), "---|".repeat(head.len()));
    for row in rows {
        let _ = writeln!(text, "| {} |", row.join(" | "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Errors, Named, Step, Truth};

    fn outcome(verdict: &str, findings: &[(&str, &[&str])]) -> Outcome {
        Outcome {
            verdict: verdict.to_owned(),
            t: Some(9.0),
            findings: findings
                .iter()
                .map(|(effect, others)| Named {
                    effect: (*effect).to_owned(),
                    could_also_be: others.iter().map(|&other| other.to_owned()).collect(),
                    probability: 0.9,
                })
                .collect(),
            suspects: Vec::new(),
            baseline: Errors {
                train: 3.0,
                unseen: Some(4.0),
            },
            extended: None,
            explained: None,
            interval: None,
            simulations: 1,
        }
    }

    fn line(study: Study, diagnosis: Outcome) -> CaseLine {
        CaseLine {
            study,
            case: 0,
            seed: 0,
            truth: Some(Truth {
                effect: "backlash".to_owned(),
                multiple: 1.0,
                sizes: vec![0.015],
            }),
            diagnosis,
            steps: Vec::new(),
        }
    }

    #[test]
    fn a_truth_in_the_set_of_another_name_is_found() {
        let of = |findings: &[(&str, &[&str])]| {
            hit(&line(Study::Single, outcome("explained", findings)))
        };
        assert_eq!(of(&[("backlash", &[])]), Hit::Named);
        assert_eq!(of(&[("output-lag", &["backlash"])]), Hit::InSet);
        assert_eq!(of(&[("output-lag", &["dead-time"])]), Hit::Missed);
    }

    #[test]
    fn a_name_is_wrong_if_neither_it_nor_its_set_is_an_alias() {
        let aliases = ["output-lag".to_owned()];
        let of = |verdict: &str, findings: &[(&str, &[&str])]| {
            substitute(&outcome(verdict, findings), &aliases)
        };
        assert_eq!(of("explained", &[("output-lag", &[])]), Substitute::Alias);
        assert_eq!(
            of("explained", &[("dead-time", &["output-lag"])]),
            Substitute::Alias
        );
        assert_eq!(
            of("explained", &[("output-lag", &[]), ("radiation", &[])]),
            Substitute::Wrong { is_confident: true }
        );
        assert_eq!(of("unexplained", &[]), Substitute::Unexplained);
        assert_eq!(of("adequate", &[]), Substitute::Other);
    }

    #[test]
    fn tables_count_every_case_once() {
        let named = line(Study::Single, outcome("explained", &[("backlash", &[])]));
        let missed = line(Study::Single, outcome("unexplained", &[]));
        let text = summary(Study::Single, &[&named, &missed]);
        assert!(
            text.contains("| t >= 5 | 1 of 2, 50.0 % (1.3 to 98.7) | 0 of 2"),
            "{text}"
        );
        assert!(
            text.contains("| backlash | 1 / 0 / 1 | 0 / 0 / 0 |"),
            "{text}"
        );
        assert!(text.contains("| 2 | median 4.000, max 4.000 |"), "{text}");

        let mut struck = line(Study::Removed, outcome("explained", &[("backlash", &[])]));
        struck.steps.push(Step {
            removed: vec!["backlash".to_owned()],
            diagnosis: outcome("unexplained", &[]),
        });
        let text = summary(Study::Removed, &[&struck]);
        let row = "| the truth | 0 of 1, 0.0 % (0.0 to 97.5) | 0 of 1, 0.0 % (0.0 to 97.5) |";
        assert!(text.contains(row), "{text}");
    }
}
