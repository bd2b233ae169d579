#![doc = include_str!("../README.md")]

mod error;
mod model_entries;
pub mod model_file;
mod recording_table;
pub mod rod_file;
mod source;
mod supply_keys;

pub use error::RigFileError;
