//! Published functions with known minima, for tests and tables.
//!
//! All have the minimum 0, at the origin or, for Rosenbrock, at (1, …, 1). Domains are those of
//! [`Bratton2007`](crate#references). Thresholds of success are those of
//! [`Trelea2003`](crate#references), set for 30 dimensions and mild in 10; he has none for Ackley,
//! which takes that of the sphere.

use crate::Bound;
use std::f64::consts::{E, TAU};

/// A cost of any number of dimensions with its usual domain.
#[derive(Debug, Clone, Copy)]
pub struct TestFunction {
    /// Name in tables.
    pub name: &'static str,
    /// The cost of a point.
    pub cost: fn(&[f64]) -> f64,
    /// Domain of each coordinate.
    pub domain: Bound,
    /// A run that ends below this cost counts as a success.
    pub threshold: f64,
    /// Coordinate of the minimum, equal in every dimension.
    pub minimizer: f64,
}

impl TestFunction {
    /// The domain in so many dimensions.
    #[must_use]
    pub fn bounds(&self, n_dimensions: usize) -> Vec<Bound> {
        vec![self.domain; n_dimensions]
    }
}

/// All of them.
pub const PUBLISHED: [TestFunction; 5] = [
    TestFunction {
        name: "sphere",
        cost: sphere,
        domain: Bound {
            lower: -100.0,
            upper: 100.0,
        },
        threshold: 0.01,
        minimizer: 0.0,
    },
    TestFunction {
        name: "Rosenbrock",
        cost: rosenbrock,
        domain: Bound {
            lower: -30.0,
            upper: 30.0,
        },
        threshold: 100.0,
        minimizer: 1.0,
    },
    TestFunction {
        name: "Rastrigin",
        cost: rastrigin,
        domain: Bound {
            lower: -5.12,
            upper: 5.12,
        },
        threshold: 100.0,
        minimizer: 0.0,
    },
    TestFunction {
        name: "Ackley",
        cost: ackley,
        domain: Bound {
            lower: -32.0,
            upper: 32.0,
        },
        threshold: 0.01,
        minimizer: 0.0,
    },
    TestFunction {
        name: "Griewank",
        cost: griewank,
        domain: Bound {
            lower: -600.0,
            upper: 600.0,
        },
        threshold: 0.1,
        minimizer: 0.0,
    },
];

/// `Σ x_i²`: one basin.
#[must_use]
pub fn sphere(point: &[f64]) -> f64 {
    point.iter().map(|x| x * x).sum()
}

/// `Σ 100 (x_{i+1} − x_i²)² + (1 − x_i)²`: a curved valley, nearly flat along its floor.
#[must_use]
pub fn rosenbrock(point: &[f64]) -> f64 {
    point
        .windows(2)
        .map(|pair| 100.0 * (pair[1] - pair[0] * pair[0]).powi(2) + (1.0 - pair[0]).powi(2))
        .sum()
}

/// `Σ x_i² − 10 cos(2π x_i) + 10`: a local minimum at nearly every integer point.
#[must_use]
pub fn rastrigin(point: &[f64]) -> f64 {
    point
        .iter()
        .map(|x| x * x - 10.0 * (TAU * x).cos() + 10.0)
        .sum()
}

/// `−20 exp(−0.2 √(Σ x_i²/n)) − exp(Σ cos(2π x_i)/n) + 20 + e`: ripples around a funnel.
///
/// In floating point the minimum is 4.4e-16.
#[must_use]
pub fn ackley(point: &[f64]) -> f64 {
    let n = point.len() as f64;
    let cosines: f64 = point.iter().map(|x| (TAU * x).cos()).sum();
    -20.0 * (-0.2 * (sphere(point) / n).sqrt()).exp() - (cosines / n).exp() + 20.0 + E
}

/// `Σ x_i²/4000 − Π cos(x_i/√i) + 1`, i from 1: ripples on a bowl.
#[must_use]
pub fn griewank(point: &[f64]) -> f64 {
    let product: f64 = point
        .iter()
        .enumerate()
        .map(|(i, x)| (x / (i as f64 + 1.0).sqrt()).cos())
        .product();
    sphere(point) / 4000.0 - product + 1.0
}
