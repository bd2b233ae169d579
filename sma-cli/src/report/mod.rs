//! What the commands say: text for people, JSON for programs.

pub(crate) mod identified;
pub(crate) mod inspected;
mod number;
