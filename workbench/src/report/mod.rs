//! Reports of the commands: text for people, JSON for programs.

pub mod changed;
pub mod diagnosed;
pub mod fleet;
pub mod identified;
pub mod inspected;
pub mod label;
pub mod number;
pub mod plot;
pub mod repeated;
pub mod series;
pub mod static_diagnosed;
pub mod table;
pub mod trial;
pub mod tuned;
pub mod words;
