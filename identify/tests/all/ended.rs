//! A fit that goes on from starts that an interrupted one has made.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

#[allow(dead_code, reason = "the other tests use the rest")]
use crate::common;

use std::ops::ControlFlow;

use common::{ROD, recording, rod, triangles};
use identify::{EndedStart, Fit, FitConfig, WienerModel, fit};
use wiener::hysteresis::Rule;

/// The fit, and where its starts ended; interrupted after so many.
fn fitted(ended: Vec<EndedStart>, seed: u64, interrupted: Option<u64>) -> (Fit, Vec<EndedStart>) {
    let training = [recording("a.csv", triangles(600, 4.2), 0.5)];
    let model = WienerModel::new(&rod(ROD), Rule::LastReversal, &training).unwrap();
    let config = FitConfig {
        starts: 6,
        seed,
        ended,
        ..FitConfig::default()
    };
    let mut made = Vec::new();
    let fit = fit(&model, &training, &config, &mut |so_far| {
        made.push(so_far.ended.clone());
        if interrupted == Some(so_far.starts) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    });
    (fit.unwrap(), made)
}

#[test]
fn it_ends_as_one_that_was_not_interrupted() {
    let (whole, _) = fitted(Vec::new(), 1, None);
    let (part, ended) = fitted(Vec::new(), 1, Some(2));
    assert_eq!((part.starts, ended.len()), (2, 2));
    let (resumed, _) = fitted(ended, 1, None);
    assert_eq!(resumed, whole);
}

#[test]
fn what_has_ended_is_not_made_again() {
    let (_, mut ended) = fitted(Vec::new(), 1, None);
    // Starts that were made again would not end where these pretend to have.
    let text = toml::to_string(&ended[0]).unwrap();
    let marked = text.replace("rejected_costs = 0", "rejected_costs = 12345");
    assert_ne!(marked, text);
    ended[0] = toml::from_str(&marked).unwrap();
    let (resumed, _) = fitted(ended.clone(), 1, None);
    assert_eq!(resumed.rejected_costs, 12345);
    let (other_seed, _) = fitted(ended, 2, None);
    assert_eq!(other_seed.rejected_costs, 0);
}
