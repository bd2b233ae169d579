//! What the benches and the programs of this package share: the jobs that they time.

mod job;

pub use job::{Job, JobError, N_COORDINATES, ROD_TOML};
