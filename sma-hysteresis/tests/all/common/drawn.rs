//! Materials and paths that laws are tried on.

use proptest::prelude::*;
use sma_hysteresis::Rule;

pub(crate) fn any_rule() -> impl Strategy<Value = Rule> {
    prop_oneof![Just(Rule::LastReversal), Just(Rule::Nested)]
}

/// Half width, spread, ζ.
pub(crate) fn any_shape() -> impl Strategy<Value = (f64, f64, f64)> {
    (0.5..20.0, 0.5..20.0, prop_oneof![0.05..1.0, Just(1.0)])
}

pub(crate) fn any_path() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-50.0..50.0, 2..40)
}
