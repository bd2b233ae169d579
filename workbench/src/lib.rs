#![doc = include_str!("../README.md")]

mod columns;
mod error;
pub mod figure;
mod first_rod;
pub mod fleet;
mod inputs;
pub mod kept;
mod known_to_a_range;
mod near_copy;
pub mod next_run;
pub mod page;
mod place;
mod recordings;
pub mod report;
mod rig;
pub mod sanity;
mod track;
mod tuning;

pub use columns::in_columns_of;
pub use error::WorkbenchError;
pub use first_rod::{FirstRod, first_rod};
pub use inputs::{hashed, sha256_of};
pub use known_to_a_range::{carry_resistivity, carry_specific_heat};
pub use place::Place;
pub use recordings::{
    as_fitted, as_simulated, each_once, gap_notes, in_its_window, input_notes, is_trained_on,
    read_all, read_perhaps_without_output,
};
pub use rig::{BEYOND, Rig, RigError};
pub use track::{Followed, Track, track};
pub use tuning::{
    Approaches, Bench, CHATTER, End, FILTER_SAMPLES, Kept, PAPER, Promise, Rest, Scheduled, Side,
    TriedSchedule, controller,
};
