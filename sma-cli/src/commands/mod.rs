//! One file a subcommand.

use crate::outcome::Outcome;

pub(crate) mod batch;
pub(crate) mod batch_unit;
pub(crate) mod demo;
pub(crate) mod diagnose;
pub(crate) mod export;
pub(crate) mod identify;
pub(crate) mod init;
pub(crate) mod inspect;
mod pictures;
pub(crate) mod shell;
pub(crate) mod simulate;
mod since;
pub(crate) mod trial;
pub(crate) mod tune;
mod used;

/// Runs a command on so many threads, 0 for all; its result does not depend on them.
fn on_threads(
    threads: u16,
    command: impl FnOnce() -> anyhow::Result<Outcome> + Send,
) -> anyhow::Result<Outcome> {
    // A browser gives the program the one thread that it is called on.
    if cfg!(target_family = "wasm") {
        return command();
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(usize::from(threads))
        .build()?;
    pool.install(command)
}
