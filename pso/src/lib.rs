#![doc = include_str!("../README.md")]

#[cfg(feature = "serde")]
mod bits;
mod bound;
mod boundary;
mod checkpoint;
mod config;
mod error;
mod minimize;
mod run;
mod start;
mod stop;
mod swarm;
pub mod test_functions;
mod topology;
mod uniform;
mod weights;

pub use bound::Bound;
pub use boundary::Boundary;
pub use checkpoint::Checkpoint;
pub use config::SwarmConfig;
pub use error::SwarmError;
pub use minimize::minimize;
#[cfg(feature = "rayon")]
pub use minimize::minimize_parallel;
pub use run::{Best, Progress, Report};
pub use start::Start;
pub use stop::{Stall, Stop, Termination};
pub use swarm::Swarm;
pub use topology::Topology;
pub use weights::{ConstrictionParams, Inertia, Weights};
