//! What the commands say: text for people, JSON for programs.

pub(crate) mod identified;
pub(crate) mod inspected;
pub(crate) mod number;
pub(crate) mod plot;
pub(crate) mod tuned;
