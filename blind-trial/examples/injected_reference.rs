//! Puts effects on some runs of a measured wire, and asks what has changed since the others, as they are:
//! `cargo run --release -p blind-trial --example injected_reference OUT`; see the README.

use std::error::Error;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::PathBuf;

use blind_trial::changed::{Answered, said};
use blind_trial::injected::{Injected, stroke};
use blind_trial::{Journal, TrialError};
use fixtures::bologna;
use identify::{Rod, WienerModel};
use missing_physics::{DiagnoseConfig, Reference, setting_of_rod};
use recording::{Recording, read_csv};
use wiener::hysteresis::Rule;

/// Most runs of today, of four.
const MOST: u32 = 2;

fn main() -> Result<(), Box<dyn Error>> {
    let Some(out) = std::env::args().nth(1) else {
        writeln!(io::stdout(), "injected_reference OUT: where to write")?;
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
    let mut journal: Journal<Answered> = Journal::open(&PathBuf::from(out))?;
    let put_on: Vec<Option<Injected>> = std::iter::once(None)
        .chain(Injected::all().into_iter().map(Some))
        .collect();
    // A bit a run: those of today.
    let splits = 1..(1_u32 << recorded.len()) - 1;
    let splits = splits.filter(|today| today.count_ones() <= MOST);
    for (split, today) in splits.enumerate() {
        let number = |k: usize| (split * put_on.len() + k) as u64;
        if (0..put_on.len()).all(|k| journal.contains(number(k))) {
            continue;
        }
        let of = |is_today: bool| -> Vec<&Recording> {
            let runs = recorded.iter().enumerate();
            let own = runs.filter(|(k, _)| (today >> k & 1 == 1) == is_today);
            own.map(|(_, run)| run).collect()
        };
        let reference: Vec<Recording> = of(false).into_iter().cloned().collect();
        let base = WienerModel::new(&rod, Rule::LastReversal, &reference)?;
        let config = DiagnoseConfig {
            setting: setting_of_rod(&rod, "mm"),
            ..DiagnoseConfig::default()
        };
        let go_on = &mut |_| ControlFlow::Continue(());
        let healthy = Reference::of(&base, &reference, &config, go_on)?;
        let names: Vec<String> = of(true).iter().map(|run| file_name(run)).collect();
        for (k, injected) in put_on.iter().enumerate() {
            if journal.contains(number(k)) {
                continue;
            }
            let on = |run: &&Recording| match injected {
                Some(injected) => injected.on(run, stroke),
                None => Ok((*run).clone()),
            };
            let today = of(true);
            let today = today
                .iter()
                .map(on)
                .collect::<Result<Vec<_>, TrialError>>()?;
            let change = healthy.changed(&today)?;
            let changed = injected.map(|one| (one.effect.effect().id().to_owned(), one.size));
            journal.append(Answered::new(number(k), names.join(", "), changed, &change))?;
        }
    }
    // A closed pipe is not a fault of the study.
    let _ = io::stdout().write_all(said(journal.lines()).as_bytes());
    Ok(())
}

fn file_name(run: &Recording) -> String {
    let path = PathBuf::from(run.name());
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}
