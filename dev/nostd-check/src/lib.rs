//! Proof that the model crates build without std and alloc
