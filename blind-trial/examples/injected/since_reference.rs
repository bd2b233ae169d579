//! The wire with an effect on some of its recordings, compared with the others.

use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

use blind_trial::changed::{Answered, said};
use blind_trial::injected::Injected;
use blind_trial::{Journal, TrialError};
use identify::WienerModel;
use missing_physics::{DiagnoseConfig, Reference, setting_of_rod};
use recording::Recording;
use wiener::hysteresis::Rule;

use crate::Wire;

/// Most runs of today, of four.
const MOST: u32 = 2;

/// Asks what has changed, of every way to part the runs; says how often that was right.
pub(crate) fn study(wire: &Wire, out: &Path) -> Result<String, Box<dyn Error>> {
    let mut journal: Journal<Answered> = Journal::open(out)?;
    let put_on: Vec<Option<Injected>> = std::iter::once(None)
        .chain(Injected::all().into_iter().map(Some))
        .collect();
    // A bit a run: those of today.
    let splits = 1..(1_u32 << wire.recorded.len()) - 1;
    let splits = splits.filter(|today| today.count_ones() <= MOST);
    for (split, today) in splits.enumerate() {
        let number = |k: usize| (split * put_on.len() + k) as u64;
        if (0..put_on.len()).all(|k| journal.contains(number(k))) {
            continue;
        }
        let of = |is_today: bool| -> Vec<&Recording> {
            let runs = wire.recorded.iter().enumerate();
            let own = runs.filter(|(k, _)| (today >> k & 1 == 1) == is_today);
            own.map(|(_, run)| run).collect()
        };
        let reference: Vec<Recording> = of(false).into_iter().cloned().collect();
        let base = WienerModel::new(&wire.rod, Rule::LastReversal, &reference)?;
        let config = DiagnoseConfig {
            setting: setting_of_rod(&wire.rod, "mm"),
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
                Some(injected) => injected.on(run, wire.stroke),
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
    Ok(said(journal.lines()))
}

fn file_name(run: &Recording) -> String {
    let path = Path::new(run.name());
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}
