//! Made-up rigs: the plain model with some of the catalogue's effects and noise, as recordings.

mod made;

pub use made::{Made, MadeUp, NoiseKind, made_up};
