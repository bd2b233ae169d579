//! How far a rig repeats: what recordings of the same drive differ by, without a model.

mod apart;
mod floor;
mod pairs;

pub use apart::{Apart, Difference};
pub use floor::{Part, RepeatFloor, RepeatedDrive, repeat_floor};
