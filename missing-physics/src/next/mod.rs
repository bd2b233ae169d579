//! The run that tells explanations apart.

pub(crate) mod advice;
pub(crate) mod bench;
pub(crate) mod drives;
pub(crate) mod experiment;
pub(crate) mod rivals;
pub(crate) mod run;
pub(crate) mod separation;
