//! What the commands say: text for people, JSON for programs.

pub(crate) mod diagnosed;
pub(crate) mod diagnosed_json;
pub(crate) mod identified;
pub(crate) mod inspected;
pub(crate) mod label;
pub(crate) mod number;
pub(crate) mod plot;
pub(crate) mod static_diagnosed;
pub(crate) mod table;
pub(crate) mod trial;
pub(crate) mod tuned;
pub(crate) mod verdict;
