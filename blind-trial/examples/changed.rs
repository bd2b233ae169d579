//! Concealed changes of drawn rigs, each after runs of the rig as it should be in ever other states:
//! `cargo run --release -p blind-trial --example changed OUT N`; see the README.

use std::error::Error;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::PathBuf;

use blind_trial::Journal;
use blind_trial::changed::{Answered, ChangedRig, said};
use missing_physics::Reference;

/// Seed of the published table.
const SEED: u64 = 8_215_079;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(out), Some(n)) = (arguments.next(), arguments.next()) else {
        writeln!(
            io::stdout(),
            "changed OUT N: where to write, and how many rigs"
        )?;
        return Ok(());
    };
    let mut journal: Journal<Answered> = Journal::open(&PathBuf::from(out))?;
    for number in 0..n.parse()? {
        // Nothing has changed, then something.
        let numbers = [2 * number, 2 * number + 1];
        if numbers.iter().all(|&number| journal.contains(number)) {
            continue;
        }
        let rig = ChangedRig::drawn(SEED, number);
        let [reference, unchanged] = rig.recorded(false)?;
        let [_, changed] = rig.recorded(true)?;
        let (base, config) = rig.model(&reference)?;
        let go_on = &mut |_| ControlFlow::Continue(());
        let healthy = Reference::of(&base, &reference, &config, go_on)?;
        let of = rig.to_string();
        let answers = [
            (&unchanged, None),
            (&changed, Some((rig.effect().to_owned(), rig.size()))),
        ];
        for ((today, put_on), number) in answers.into_iter().zip(numbers) {
            if !journal.contains(number) {
                let change = healthy.changed(today)?;
                journal.append(Answered::new(number, of.clone(), put_on, &change))?;
            }
        }
    }
    // A closed pipe is not a fault of the study.
    let _ = io::stdout().write_all(said(journal.lines()).as_bytes());
    Ok(())
}
