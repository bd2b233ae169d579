//! The polynomials against a table of high-precision values.

use fixtures::tables::{self, Row};
use sma_hysteresis::{atan, expm1, inverse_fourth_root, inverse_sqrt, ln, sin_quarter};

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

#[test]
fn ln_and_expm1_agree_with_the_library() {
    for k in -4000..4000 {
        let x = libm::exp(f64::from(k) * 0.01);
        let error = (ln(x) - libm::log(x)).abs();
        assert!(
            error <= 4e-16 * libm::log(x).abs().max(1e-300),
            "{x} {error}"
        );
    }
    for k in -40_000..40_000 {
        let y = f64::from(k) * 5e-4;
        let error = (expm1(y) - libm::expm1(y)).abs();
        assert!(
            error <= 4e-16 * libm::expm1(y).abs().max(1.0),
            "{y} {error}"
        );
    }
    for y in [1e-3, 1e-9, 1e-15, -1e-12] {
        let error = (expm1(y) - libm::expm1(y)).abs();
        assert!(error <= 4e-16 * y.abs(), "{y} {error}");
    }
    assert_eq!(expm1(0.0).to_bits(), 0);
    assert_eq!(ln(1.0).abs().to_bits(), 0);
}

#[test]
fn inverse_roots_agree_with_the_hardware() {
    for k in -60_000..60_000 {
        let x = libm::exp(f64::from(k) * 0.0115);
        for (found, root) in [
            (inverse_sqrt(x), x.sqrt()),
            (inverse_fourth_root(x), x.sqrt().sqrt()),
        ] {
            let error = (found * root - 1.0).abs();
            assert!(error <= 5e-16, "{x:e} {error:e}");
        }
    }
    assert!(inverse_sqrt(0.0).is_finite());
    assert!(inverse_sqrt(f64::NAN).is_nan());
    assert!(inverse_fourth_root(f64::NAN).is_nan());
}
