//! Diagnoses a measured wire with effects put on its recordings, and says which of them were found beyond what is found
//! without: `cargo run --release -p blind-trial --example injected OUT`; see the README.

use std::collections::BTreeMap;
use std::error::Error;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::PathBuf;

use blind_trial::injected::{Injected, stroke};
use blind_trial::{Journal, Line, Named, TrialError, Verdict};
use fixtures::bologna;
use identify::{Rod, WienerModel};
use missing_physics::{DiagnoseConfig, diagnose, setting_of_rod};
use recording::{Recording, read_csv};
use serde::{Deserialize, Serialize};
use wiener::hysteresis::Rule;

/// Where results stand, from the workspace's root.
const RESULTS: &str = "blind-trial/results/injected.jsonl";

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

fn main() -> Result<(), Box<dyn Error>> {
    let Some(out) = std::env::args().nth(1) else {
        let usage =
            format!("injected OUT: where to write, {RESULTS} for one; it takes half an hour");
        writeln!(io::stdout(), "{usage}")?;
        return Ok(());
    };
    let Some(folder) = fixtures::shared::path(bologna::FOLDER) else {
        return Ok(());
    };
    let rod = Rod::parse("rod.toml", bologna::ROD)?;
    let read = |name: &str| read_csv(folder.join(name), &rod.read_options());
    let names = bologna::TRAINING.into_iter().chain([bologna::UNSEEN]);
    let recorded = names.map(read).collect::<Result<Vec<_>, _>>()?;
    let stroke = stroke(&recorded);
    let mut journal = Journal::open(&PathBuf::from(out))?;
    let injections = std::iter::once(None).chain(Injected::all().into_iter().map(Some));
    for (number, injected) in injections.enumerate() {
        if journal.contains(number) {
            continue;
        }
        let on = |one: &Recording| {
            injected.map_or_else(|| Ok(one.clone()), |injected| injected.on(one, stroke))
        };
        let recordings = recorded.iter().map(on);
        let recordings = recordings.collect::<Result<Vec<Recording>, TrialError>>()?;
        let (training, unseen) = recordings.split_at(recordings.len() - 1);
        let base = WienerModel::new(&rod, Rule::LastReversal, training)?;
        let config = DiagnoseConfig {
            setting: setting_of_rod(&rod, "mm"),
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
    // A closed pipe is not a fault of the study.
    let _ = io::stdout().write_all(said(&lines).as_bytes());
    Ok(())
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
