//! Terms that each block of the cascade could lack, as they would show in the output.

pub(crate) mod elementary_terms;
pub(crate) mod local_terms;
pub(crate) mod ridge;
pub(crate) mod scene;
