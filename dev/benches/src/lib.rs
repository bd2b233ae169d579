//! Benches and published tables
