//! The polynomials against a table of high-precision values.

use fixtures::tables::{self, Row};
use sma_hysteresis::{atan, sin_quarter};

/// Largest absolute error allowed.
const ALLOWED: f64 = 2e-15;

fn worst(rows: &[Row], function: impl Fn(f64) -> f64) -> f64 {
    rows.iter()
        .map(|row| row.error(function(row.argument)).abs())
        .fold(0.0, f64::max)
}

#[test]
fn sin_agrees_with_the_table_on_its_quarter() {
    let rows: Vec<Row> = tables::sin()
        .unwrap()
        .into_iter()
        .filter(|row| (0.0..=std::f64::consts::FRAC_PI_2).contains(&row.argument))
        .collect();
    assert!(rows.len() > 900, "{} rows", rows.len());
    let error = worst(&rows, sin_quarter);
    assert!(error <= ALLOWED, "{error:e} over {} rows", rows.len());
}

#[test]
fn atan_agrees_with_the_table_everywhere() {
    let rows = tables::atan().unwrap();
    assert!(rows.len() > 3000, "{} rows", rows.len());
    let error = worst(&rows, atan);
    assert!(error <= ALLOWED, "{error:e} over {} rows", rows.len());
}

#[test]
fn atan_of_what_is_no_number() {
    assert!(atan(f64::NAN).is_nan());
    let quarter = std::f64::consts::FRAC_PI_2;
    assert!((atan(f64::INFINITY) - quarter).abs() <= ALLOWED);
    assert!((atan(f64::NEG_INFINITY) + quarter).abs() <= ALLOWED);
    assert!(sin_quarter(f64::NAN).is_nan());
}
