//! The wire with an effect on all of its recordings, diagnosed.

use std::collections::BTreeMap;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

use blind_trial::injected::Injected;
use blind_trial::{Journal, Line, Named, TrialError, Verdict};
use identify::WienerModel;
use missing_physics::{DiagnoseConfig, diagnose, setting_of_rod};
use recording::Recording;
use serde::{Deserialize, Serialize};
use wiener::hysteresis::Rule;

use crate::Wire;

/// One diagnosis.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Diagnosed {
    /// Its number: 0 is that of the recordings as they are.
    number: usize,
    injected: Option<Injected>,
    verdict: Verdict,
}

impl Line for Diagnosed {
    type Key = usize;

    fn key(&self) -> usize {
        self.number
    }
}

/// Diagnoses the wire as it is and with each effect; says what was found.
pub(crate) fn study(wire: &Wire, out: &Path) -> Result<String, Box<dyn Error>> {
    let mut journal = Journal::open(out)?;
    let injections = std::iter::once(None).chain(Injected::all().into_iter().map(Some));
    for (number, injected) in injections.enumerate() {
        if journal.contains(number) {
            continue;
        }
        let on = |one: &Recording| {
            injected.map_or_else(|| Ok(one.clone()), |injected| injected.on(one, wire.stroke))
        };
        let recordings = wire.recorded.iter().map(on);
        let recordings = recordings.collect::<Result<Vec<Recording>, TrialError>>()?;
        let (training, unseen) = recordings.split_at(recordings.len() - 1);
        let base = WienerModel::new(&wire.rod, Rule::LastReversal, training)?;
        let config = DiagnoseConfig {
            setting: setting_of_rod(&wire.rod, "mm"),
            ..DiagnoseConfig::default()
        };
        let diagnosis = diagnose(&base, training, unseen, &config, &mut |_| {
            ControlFlow::Continue(())
        })?;
        journal.append(Diagnosed {
            number,
            injected,
            verdict: Verdict::from(&diagnosis),
        })?;
    }
    let lines: BTreeMap<usize, &Diagnosed> =
        journal.lines().map(|line| (line.number, line)).collect();
    Ok(said(&lines))
}

/// A line a diagnosis: what was put on, what is said of it, and what else.
fn said(lines: &BTreeMap<usize, &Diagnosed>) -> String {
    let states = |line: &Diagnosed, id: &str| {
        let mut findings = line.verdict.findings.iter();
        findings.any(|one| one.set().any(|other| other == id))
    };
    let mut text = String::new();
    for line in lines.values() {
        let what = line
            .injected
            .map_or("as recorded".to_owned(), |one| one.to_string());
        let names: Vec<String> = line.verdict.findings.iter().map(name).collect();
        let own = line.injected.map(|one| one.effect.effect().id());
        let found = match own {
            None => "",
            Some(id) if states(line, id) && lines.get(&0).is_some_and(|bare| states(bare, id)) => {
                "as without it"
            }
            Some(id) if states(line, id) => "FOUND",
            Some(id) if line.verdict.suspects.iter().any(|other| other == id) => "suspected",
            Some(_) => "missed",
        };
        text += &format!(
            "{what}: {found} {}: {}; training {:.4} -> {:.4} mm\n",
            line.verdict.verdict,
            names.join(", "),
            line.verdict.plain.train,
            line.verdict
                .extended
                .map_or(line.verdict.plain.train, |one| one.train),
        );
    }
    text
}

fn name(named: &Named) -> String {
    let first = named.parameters.first();
    let size = first.map_or(String::new(), |one| format!(" {:.2e}", one.value));
    let others = if named.could_also_be.is_empty() {
        String::new()
    } else {
        format!(" (or {})", named.could_also_be.join(", "))
    };
    format!("{}{size}{others}", named.effect)
}
