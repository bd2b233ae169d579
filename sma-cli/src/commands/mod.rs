//! One file a subcommand.

pub(crate) mod identify;
pub(crate) mod inspect;
pub(crate) mod simulate;
pub(crate) mod tune;
