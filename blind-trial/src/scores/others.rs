use super::figure::{Figure, median};
use super::view::DRIFTS;
use crate::{CaseLine, Competitors, Family, Proportion};

/// The diagnosis beside other methods, on the files that all of them saw.
#[derive(Debug, Clone, PartialEq)]
pub struct Others {
    /// The diagnosis first.
    pub methods: Vec<Method>,
}

/// A method.
#[derive(Debug, Clone, PartialEq)]
pub struct Method {
    /// Its name.
    pub name: &'static str,
    /// Share of clean files with white or autoregressive noise in which it finds something.
    pub false_alarms: Proportion,
    /// Share of files with a visible effect in which it finds something.
    pub alarms: Proportion,
    /// Share of the same in which the name that it gives first is right; `None` if it gives none.
    pub named: Option<Proportion>,
    /// Share of the explainable error of the unseen recording that it explains, by the true noise: the median over
    /// visible effects that are carried to another recording; `None` if it predicts nothing.
    pub explained: Option<Figure>,
}

/// Result of a method in a case.
struct Said<'a> {
    finds: bool,
    /// Its first name; `None` if it gives none to anything.
    named: Option<Option<&'a str>>,
    unseen_mm: Option<Option<f64>>,
}

impl Others {
    pub(super) fn of(lines: &[CaseLine]) -> Self {
        let asked: Vec<(&CaseLine, &Competitors)> = lines
            .iter()
            .filter_map(|line| Some((line, line.competitors.as_ref()?)))
            .collect();
        if asked.is_empty() {
            return Self {
                methods: Vec::new(),
            };
        }
        let method = |name, said: for<'a> fn(&'a CaseLine, &'a Competitors) -> Said<'a>| {
            Method::of(name, &asked, said)
        };
        Self {
            methods: vec![
                method("this diagnosis", |line, _| Said {
                    finds: !line.verdict.findings.is_empty(),
                    named: Some(line.top()),
                    unseen_mm: Some(line.verdict.extended.unwrap_or(line.verdict.plain).unseen),
                }),
                method("whiteness of the residual", |_, others| Said {
                    finds: others.whiteness.is_not_white,
                    named: None,
                    unseen_mm: None,
                }),
                method("cross-correlation with the drive", |_, others| Said {
                    finds: others.whiteness.depends_on_drive,
                    named: None,
                    unseen_mm: None,
                }),
                method("forward selection by BIC", |_, others| Said {
                    finds: !others.forward.effects.is_empty(),
                    named: Some(others.forward.effects.first().map(String::as_str)),
                    unseen_mm: Some(others.forward.unseen_mm),
                }),
                method("black box of the residual", |line, others| Said {
                    finds: others.black_box_unseen_mm != line.verdict.plain.unseen,
                    named: None,
                    unseen_mm: Some(others.black_box_unseen_mm),
                }),
            ],
        }
    }
}

impl Method {
    fn of(
        name: &'static str,
        asked: &[(&CaseLine, &Competitors)],
        said: for<'a> fn(&'a CaseLine, &'a Competitors) -> Said<'a>,
    ) -> Self {
        let among = |is_one: &dyn Fn(&CaseLine) -> bool| -> Vec<(&CaseLine, Said<'_>)> {
            let ones = asked.iter().filter(|(line, _)| is_one(line));
            ones.map(|(line, others)| (*line, said(line, others)))
                .collect()
        };
        let clean = among(&|line| matches!(line.case.family, Family::CleanWhite | Family::CleanAr));
        let seen = among(&|line| line.case.family == Family::Single && line.is_visible());
        let gives_names = seen.iter().any(|(_, said)| said.named.is_some());
        let is_right =
            |(line, said): &&(&CaseLine, Said<'_>)| said.named.flatten() == Some(line.truth());
        let explained: Option<Vec<f64>> = seen
            .iter()
            .filter(|(line, _)| !DRIFTS.contains(&line.truth()))
            .map(|(line, said)| explained(line, said.unseen_mm?))
            .collect();
        Self {
            name,
            false_alarms: Proportion::of(&clean, |(_, said)| said.finds),
            alarms: Proportion::of(&seen, |(_, said)| said.finds),
            named: gives_names.then(|| Proportion::of(&seen, is_right)),
            explained: explained.map(|shares| median(shares, "")),
        }
    }
}

/// Share of the explainable error of the unseen recording; 0 where the baseline model leaves only noise.
fn explained(line: &CaseLine, unseen_mm: Option<f64>) -> Option<f64> {
    let plain = line.verdict.plain.unseen?.powi(2);
    let explainable = plain - line.opened.noise_mm.powi(2);
    let gained = plain - unseen_mm?.powi(2);
    Some(if explainable > 0.0 {
        gained / explainable
    } else {
        0.0
    })
}
