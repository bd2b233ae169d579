//! The main quantities by kind of recording and by plant.

use super::calibration::Calibration;
use super::figure::{Figure, Score, mean};
use super::table::{beside_all_that_is_open, beyond_names, false_alarms, share};
use crate::{CaseLine, Family};

/// Quantities of every kind of recording and of every plant that there is, without targets; those without a case are
/// left out. Nothing where all rigs are of one plant and recorded as the guide asks.
pub(super) fn groups(lines: &[CaseLine]) -> Vec<Score> {
    let recordings = by(lines, CaseLine::recording);
    let plants = by(lines, CaseLine::plant);
    let all = recordings.into_iter().chain(plants);
    all.flat_map(|(name, of_group)| quantities(&name, &of_group))
        .collect()
}

/// Lines by what they have in common, in the order of their names.
fn by<'a>(
    lines: &'a [CaseLine],
    key: impl Fn(&'a CaseLine) -> Option<&'a str>,
) -> Vec<(String, Vec<&'a CaseLine>)> {
    let mut names: Vec<&str> = lines.iter().filter_map(&key).collect();
    names.sort_unstable();
    names.dedup();
    let of = |name: &str| {
        lines
            .iter()
            .filter(|line| key(line) == Some(name))
            .collect()
    };
    names
        .into_iter()
        .map(|name| (name.to_owned(), of(name)))
        .collect()
}

fn quantities(name: &str, lines: &[&CaseLine]) -> Vec<Score> {
    let of = |family: Family| -> Vec<&CaseLine> {
        let all = lines.iter().copied();
        all.filter(|line| line.case.family == family).collect()
    };
    let seen = |family: Family| -> Vec<&CaseLine> {
        let all = of(family).into_iter();
        all.filter(|line| line.is_visible()).collect()
    };
    let singles = seen(Family::Single);
    let unknown = [seen(Family::Outside), seen(Family::Deleted)].concat();
    let sizes: Vec<f64> = singles
        .iter()
        .map(|line| line.stated().len() as f64)
        .collect();
    let sizes: Vec<f64> = sizes.into_iter().filter(|&size| size > 0.0).collect();
    let calibration = Calibration::of(lines.iter().copied());
    let number = |quantity: &str, figure: Figure| Score {
        quantity: quantity.to_owned(),
        figure,
        target: None,
    };
    let mut scores = vec![
        share(
            "true effect in the stated set",
            &singles,
            CaseLine::states_all,
            None,
        ),
        number("mean size of the set", mean(&sizes)),
        share(
            "both effects of a pair in the sets",
            &seen(Family::Pair),
            CaseLine::states_all,
            None,
        ),
        share(
            "outside or deleted: unexplained",
            &unknown,
            CaseLine::is_unexplained,
            None,
        ),
        share(
            "any case: confident wrong name",
            lines,
            CaseLine::is_wrong_and_sure,
            None,
        ),
    ];
    scores.extend(beside_all_that_is_open(&seen));
    scores.extend(false_alarms(&of));
    scores.extend(beyond_names(lines));
    scores.push(number(
        "calibration error of stated probabilities",
        Figure::Number {
            value: calibration.error(),
            n: calibration.n(),
            unit: "",
        },
    ));
    scores.retain(|score| score.figure.value().is_some());
    for score in &mut scores {
        score.quantity = format!("{name}: {}", score.quantity);
        score.target = None;
    }
    scores
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some lines of the first published table, as if they had been recorded in two ways.
    fn lines() -> Vec<CaseLine> {
        let published = include_str!("../../results/cases.jsonl");
        let some = published.lines().step_by(7);
        let mut lines: Vec<CaseLine> = some
            .map(|line| serde_json::from_str(line).unwrap())
            .collect();
        for (k, line) in lines.iter_mut().enumerate() {
            let recording = if k % 2 == 0 { "guide" } else { "chatter" };
            line.opened.answer.recording = Some(recording.to_owned());
            line.opened.answer.plant = Some("volumes".to_owned());
        }
        lines
    }

    fn figure(scores: &[Score], quantity: &str) -> f64 {
        let mut scores = scores.iter().filter(|score| score.quantity == quantity);
        scores.next().unwrap().figure.value().unwrap()
    }

    #[test]
    fn nothing_is_grouped_where_all_is_recorded_as_the_guide_asks() {
        let mut lines = lines();
        for line in &mut lines {
            line.opened.answer.recording = None;
            line.opened.answer.plant = None;
        }
        assert!(groups(&lines).is_empty());
    }

    #[test]
    fn every_kind_of_recording_and_every_plant_has_its_quantities() {
        let scores = groups(&lines());
        for name in ["guide", "chatter", "volumes"] {
            let share = figure(&scores, &format!("{name}: true effect in the stated set"));
            assert!(share > 0.8, "{name}: {share}");
            let alarms = figure(&scores, &format!("{name}: false alarm, white"));
            assert!(alarms < 0.2, "{name}: {alarms}");
        }
        assert!(scores.iter().all(|score| score.target.is_none()));
    }

    #[test]
    fn effects_are_counted_that_show_beside_what_is_open_where_that_was_asked() {
        let quantity = "guide: visible beside what is open: true effect in the stated set";
        let of = |lines: &[CaseLine]| {
            groups(lines)
                .into_iter()
                .find(|one| one.quantity == quantity)
        };
        let mut lines = lines();
        assert!(of(&lines).is_none());
        // One of them misses, and does not show beside what is open.
        let mut of_guide = lines.iter_mut().filter(|line| {
            let is_single = line.case.family == Family::Single && line.is_visible();
            is_single && line.recording() == Some("guide") && line.states_all()
        });
        let missed = of_guide.next().unwrap();
        missed.verdict.findings.clear();
        let missed = missed.case;
        for line in &mut lines {
            let is_hidden = line.case == missed;
            for oracle in &mut line.opened.oracles {
                oracle.t_open = Some(if is_hidden { 1.0 } else { oracle.t });
            }
        }
        let share = |lines: &[CaseLine]| of(lines).unwrap().figure.value().unwrap();
        let without = share(&lines);
        for oracle in lines.iter_mut().flat_map(|line| &mut line.opened.oracles) {
            oracle.t_open = Some(oracle.t);
        }
        assert!(without > share(&lines));
    }

    #[test]
    fn a_misfit_that_is_called_adequate_and_an_effect_that_is_excluded_are_counted() {
        let mut lines = lines();
        lines.retain(|line| line.case.family == Family::Single && line.is_visible());
        let n = lines.len() as f64;
        for line in &mut lines {
            line.opened.noise_mm = 0.1 * line.verdict.plain.train;
            line.verdict.verdict = "unexplained".to_owned();
            line.opened.sizes = vec![Some(2.0)];
            line.opened.excluded_above = vec![None];
        }
        lines[0].verdict.verdict = "adequate".to_owned();
        lines[1].opened.excluded_above = vec![Some(2.0)];
        lines[2].opened.excluded_above = vec![Some(2.1)];
        let all: Vec<&CaseLine> = lines.iter().collect();
        for score in beyond_names(&all) {
            let share = score.figure.value().unwrap();
            assert!((share - 1.0 / n).abs() < 1e-12, "{}", score.quantity);
        }
    }
}
