//! A fit that goes on from starts that an interrupted one has made.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

#[allow(dead_code, reason = "the other tests use the rest")]
use crate::common;

use std::ops::ControlFlow;

use common::{ROD, recording, rod, triangles};
use identify::{EndedStart, Fit, FitConfig, LeastSquaresConfig, WienerModel, fit};
use wiener::hysteresis::Rule;

/// The fit, and where its starts ended; interrupted after so many.
fn fitted(ended: Vec<EndedStart>, seed: u64, interrupted: Option<u64>) -> (Fit, Vec<EndedStart>) {
    fitted_to(600, ended, seed, interrupted)
}

/// A fit to a recording with so many samples.
fn fitted_to(
    n_samples: usize,
    ended: Vec<EndedStart>,
    seed: u64,
    interrupted: Option<u64>,
) -> (Fit, Vec<EndedStart>) {
    let training = [recording("a.csv", triangles(n_samples, 4.2), 0.5)];
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

/// Many enough that basins are found on fewer.
const MANY: usize = 2_400;

#[test]
fn a_basin_is_searched_on_all_samples_once() {
    let (whole, ended) = fitted_to(MANY, Vec::new(), 1, None);
    assert_eq!([whole.agreeing_starts, whole.starts], [6, 6]);
    let [first, others @ ..] = &ended[..] else {
        unreachable!("six starts were made");
    };
    // The first start found it, and searched. Swarms differ, and so does what they took; ends do not.
    for other in others {
        let [first, other] = [first, other].map(|one| toml::Value::try_from(one).unwrap());
        assert_eq!(other["minimum"], first["minimum"]);
        assert_ne!(other["basin"]["point"], first["basin"]["point"]);
        assert!(other["simulations"].as_integer() < first["simulations"].as_integer());
    }
}

#[test]
fn who_found_a_basin_first_is_kept_when_a_fit_is_interrupted() {
    let (whole, _) = fitted_to(MANY, Vec::new(), 1, None);
    for made in [1, 2, 5] {
        let (part, ended) = fitted_to(MANY, Vec::new(), 1, Some(made));
        assert_eq!(part.starts, made);
        let (resumed, _) = fitted_to(MANY, ended, 1, None);
        assert_eq!(resumed, whole);
    }
}

/// A start with other values of some keys.
fn edited(one: &EndedStart, edits: &[(&str, &str)]) -> EndedStart {
    let text = toml::to_string(one).unwrap();
    let lines = text.lines().map(|line| {
        let key = line.split(" = ").next().unwrap();
        let edit = edits.iter().find(|(other, _)| *other == key);
        edit.map_or(format!("{line}\n"), |(key, value)| {
            format!("{key} = {value}\n")
        })
    });
    let edited: String = lines.collect();
    assert_ne!(edited, text);
    toml::from_str(&edited).unwrap()
}

#[test]
fn what_has_ended_is_not_made_again() {
    let (_, mut ended) = fitted(Vec::new(), 1, None);
    // Starts that were made again would not end where these pretend to have.
    ended[0] = edited(&ended[0], &[("rejected_costs", "12345")]);
    let (resumed, _) = fitted(ended.clone(), 1, None);
    assert_eq!(resumed.rejected_costs, 12345);
    let (other_seed, _) = fitted(ended, 2, None);
    assert_eq!(other_seed.rejected_costs, 0);
}

#[test]
fn of_two_searches_with_one_seed_each_finds_its_own_starts() {
    let (_, mut own) = fitted(Vec::new(), 1, None);
    // As of a search on fewer samples, which comes first: the cost of its points is another one here.
    let others = own.iter().map(|one| {
        let costs = [("sum_of_squares", "1e9"), ("rejected_costs", "12345")];
        edited(one, &costs)
    });
    let others: Vec<EndedStart> = others.collect();
    own[0] = edited(&own[0], &[("rejected_costs", "7")]);
    let (resumed, _) = fitted([others, own].concat(), 1, None);
    assert_eq!(resumed.rejected_costs, 7);
}

#[test]
fn eight_starts_that_all_agree_are_enough_where_that_is_asked() {
    let training = [recording("a.csv", triangles(600, 4.2), 0.5)];
    let model = WienerModel::new(&rod(ROD), Rule::LastReversal, &training).unwrap();
    let made = |config| {
        let asked = FitConfig {
            starts: 10,
            ..config
        };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        let fit = fit(&model, &training, &asked, go_on).unwrap();
        [fit.agreeing_starts, fit.starts]
    };
    let until_agreed = FitConfig {
        until_agreed: true,
        ..FitConfig::default()
    };
    assert_eq!(made(FitConfig::default()), [10, 10]);
    assert_eq!(made(until_agreed.clone()), [8, 8]);
    // Of swarms without a search after them the ends differ.
    let rough = LeastSquaresConfig {
        iterations: 0,
        ..LeastSquaresConfig::default()
    };
    let [agreeing, starts] = made(FitConfig {
        least_squares: rough,
        ..until_agreed
    });
    assert!(agreeing < 8 && starts == 10, "{agreeing}");
}
