//! Regimes that hold more of the error than their share of the samples.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::order::falling;

use crate::Cell;
use crate::locate::located::Located;
use crate::locate::regimes::Regime;
use crate::model::projection::Span;
use crate::model::series::{Channel, Layout, Noise};

/// Draws of noise: a probability of 5 % has a standard error of 1.5 %.
const DRAWS: usize = 200;

/// Largest probability that noise concentrates as much, for a cell to be shown.
const LARGEST_P: f64 = 0.05;

/// Most cells.
const MOST_CELLS: usize = 6;

/// Samples in common, as a share of those in either, above which two regimes are the same.
const SAME: f64 = 0.8;

/// Samples before the first that are drawn, so that the noise is stationary.
const BURN_IN: usize = 500;

/// The regimes with more error than noise would put there, the most telling first.
pub(crate) fn cells(located: &Located<'_>, regimes: &[Regime]) -> Vec<Cell> {
    let n_outputs = located.case.layout.n_outputs();
    let residual = &located.node.residual[..n_outputs];
    let excess = excesses(residual, regimes);
    let drawn: Vec<Vec<f64>> = surrogates(located)
        .iter()
        .map(|noise| excesses(&noise[..n_outputs], regimes))
        .collect();
    let deviations: Vec<f64> = (0..regimes.len())
        .map(|c| {
            let squares: f64 = drawn.iter().map(|excess| excess[c] * excess[c]).sum();
            (squares / DRAWS as f64).sqrt()
        })
        .collect();
    let in_deviations = |excess: &[f64], c: usize| {
        let quotient = excess[c] / deviations[c];
        if quotient.is_nan() { 0.0 } else { quotient }
    };
    let largest: Vec<f64> = drawn
        .iter()
        .map(|excess| {
            (0..regimes.len())
                .map(|c| in_deviations(excess, c))
                .fold(f64::NEG_INFINITY, f64::max)
        })
        .collect();
    let explainable = located.explainable();
    let judged = regimes.iter().enumerate().map(|(c, regime)| {
        let own = in_deviations(&excess, c);
        let as_large = largest.iter().filter(|largest| **largest >= own).count();
        let cell = Cell {
            at: regime.at.clone(),
            share: explainable_in(residual, &regime.members, located.floor) / explainable,
            occupancy: regime.n_members as f64 / n_outputs as f64,
            p_value: (1 + as_large) as f64 / (1 + DRAWS) as f64,
        };
        (cell, regime)
    });
    let mut found: Vec<(Cell, &Regime)> = judged
        .filter(|(cell, _)| cell.share > cell.occupancy && cell.p_value <= LARGEST_P)
        .collect();
    falling(&mut found, |(one, _)| information(one));
    distinct(found)
}

/// Information of a cell on the place of the error, nats: its part of the divergence from an even spread.
fn information(cell: &Cell) -> f64 {
    cell.share * (cell.share / cell.occupancy).ln()
}

/// The first cells, without any that is nearly the same set of samples as one before it.
fn distinct(found: Vec<(Cell, &Regime)>) -> Vec<Cell> {
    let mut kept: Vec<(Cell, &Regime)> = Vec::new();
    for (cell, regime) in found {
        let is_new = kept.iter().all(|(_, other)| overlap(regime, other) <= SAME);
        if is_new && kept.len() < MOST_CELLS {
            kept.push((cell, regime));
        }
    }
    kept.into_iter().map(|(cell, _)| cell).collect()
}

/// Samples in both regimes, as a share of those in either.
fn overlap(one: &Regime, other: &Regime) -> f64 {
    let pairs = || one.members.iter().zip(&other.members);
    let both = pairs().filter(|(a, b)| **a && **b).count();
    let either = pairs().filter(|(a, b)| **a || **b).count();
    both as f64 / either.max(1) as f64
}

/// Mean square in each regime less that of all samples.
fn excesses(residual: &[f64], regimes: &[Regime]) -> Vec<f64> {
    let squares: Vec<f64> = residual.iter().map(|value| value * value).collect();
    let whole = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    regimes
        .iter()
        .map(|regime| {
            let own = squares.iter().zip(&regime.members);
            let sum: f64 = own
                .filter(|(_, member)| **member)
                .map(|(square, _)| square)
                .sum();
            sum / regime.n_members.max(1) as f64 - whole
        })
        .collect()
}

/// Sum of the squares above the floor's.
fn explainable_in(residual: &[f64], members: &[bool], floor: f64) -> f64 {
    let own = residual.iter().zip(members).filter(|(_, member)| **member);
    own.map(|(value, _)| value * value - floor * floor).sum()
}

/// Noise at the floor, with the memory of the residual, as a refitted model would leave it.
fn surrogates(located: &Located<'_>) -> Vec<Vec<f64>> {
    let columns = located.fitted();
    let span = Span::of(columns);
    let mut rng = ChaCha8Rng::seed_from_u64(located.seed);
    let layout = &located.case.layout;
    (0..DRAWS)
        .map(|_| {
            let noise = draw(layout, &located.node.noise, located.floor, &mut rng);
            span.outside(&noise)
        })
        .collect()
}

/// Autoregressive noise; that of the output with the standard deviation `floor`.
fn draw(layout: &Layout, noise: &Noise, floor: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let mut series = Vec::with_capacity(layout.len());
    for segment in &layout.segments {
        let own = noise.of(segment.channel);
        let variance = match segment.channel {
            Channel::Output => floor * floor,
            Channel::Temperature => own.variance,
        };
        let ratio = own.innovation_variance / own.variance;
        let deviation = (variance * if ratio.is_finite() { ratio } else { 1.0 }).sqrt();
        let mut drawn: Vec<f64> = Vec::with_capacity(BURN_IN + segment.range.len());
        for _ in 0..BURN_IN + segment.range.len() {
            let past = drawn.iter().rev();
            let recalled: f64 = own
                .coefficients
                .iter()
                .zip(past)
                .map(|(a, past)| a * past)
                .sum();
            let innovation: f64 = StandardNormal.sample(rng);
            drawn.push(recalled + deviation * innovation);
        }
        series.extend_from_slice(&drawn[BURN_IN..]);
    }
    series
}
