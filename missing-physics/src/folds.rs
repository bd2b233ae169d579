//! Error on parts of the training that a model has not seen, without fitting it again.

use std::ops::Range;

use faer::Mat;
use recording::{Recording, cycles};

use crate::case::{Case, Node};
use crate::projection::{Span, dot};
use crate::tangent::Sensitivity;

/// Fewest folds: below, whole cycles are cut into parts.
const FEWEST: usize = 8;

/// Most folds.
const MOST: usize = 16;

/// Share of a direction that only the samples left out determine, from which it stays as all samples have it:
/// the offset of a recording that is left out as a whole.
const DETERMINED: f64 = 0.99;

/// A part of the training that is left out in turn.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fold {
    /// Samples on which the error counts, as places in a series.
    pub(crate) scored: Range<usize>,
    /// Samples that are left out: these, and a gap on either side so that what is remembered does not leak.
    removed: Range<usize>,
}

/// Whole cycles of each recording, or equal parts of it where there are few.
pub(crate) fn folds(case: &Case<'_>, gap_s: f64) -> Vec<Fold> {
    let whole: Vec<Vec<Range<usize>>> = case.training.iter().map(cycle_ranges).collect();
    let n_cycles: usize = whole.iter().map(Vec::len).sum();
    let n_samples = case.layout.n_outputs();
    let mut folds = Vec::new();
    for (r, recording) in case.training.iter().enumerate() {
        let place = case.layout.segments[r].range.clone();
        let parts = if (FEWEST..=MOST).contains(&n_cycles) {
            whole[r].clone()
        } else {
            let share = FEWEST * recording.len();
            equal_parts(recording.len(), share.div_ceil(n_samples).max(2))
        };
        let gap = gap_samples(recording, gap_s);
        folds.extend(parts.into_iter().map(|part| {
            let scored = place.start + part.start..place.start + part.end;
            let removed = scored.start.saturating_sub(gap).max(place.start)
                ..(scored.end + gap).min(place.end);
            Fold { scored, removed }
        }));
    }
    folds
}

/// The cycles, with what comes before the first and after the last.
fn cycle_ranges(recording: &Recording) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = cycles(recording)
        .into_iter()
        .map(|cycle| cycle.samples)
        .collect();
    if let Some(first) = ranges.first_mut() {
        first.start = 0;
    }
    match ranges.last_mut() {
        Some(last) => last.end = recording.len(),
        None => ranges.push(0..recording.len()),
    }
    ranges
}

fn equal_parts(n_samples: usize, n_parts: usize) -> Vec<Range<usize>> {
    (0..n_parts)
        .map(|part| part * n_samples / n_parts..(part + 1) * n_samples / n_parts)
        .collect()
}

/// Not more than a quarter of a fold of the fewest.
fn gap_samples(recording: &Recording, gap_s: f64) -> usize {
    let time_s = recording.time_s();
    let dt_s = (time_s[time_s.len() - 1] - time_s[0]) / time_s.len() as f64;
    let most = recording.len() / (4 * FEWEST);
    if dt_s > 0.0 {
        ((gap_s / dt_s) as usize).min(most)
    } else {
        0
    }
}

/// Residual of each fold when its samples are left out of the fit, to first order: elsewhere as it is.
///
/// ```text
/// e_R + Q_R (I - Q_RᵀQ_R)⁻¹ Q_Rᵀ e_R,   Q the orthonormal basis of all sensitivities, R the samples left out
/// ```
///
/// Exact for a linear model (Allen's PRESS for whole blocks).
pub(crate) fn held_out(node: &Node, sensitivities: &[Sensitivity], folds: &[Fold]) -> Vec<f64> {
    let free = sensitivities.iter().filter(|one| !one.held);
    let span = Span::of(free.map(|one| &one.column));
    let mut held_out = node.residual.clone();
    for fold in folds {
        let rows: Vec<&[f64]> = span
            .basis()
            .iter()
            .map(|direction| &direction[fold.removed.clone()])
            .collect();
        let residual = &node.residual[fold.removed.clone()];
        let n = rows.len();
        let gram = Mat::from_fn(n, n, |i, j| dot(rows[i], rows[j]));
        let along: Vec<f64> = rows.iter().map(|row| dot(row, residual)).collect();
        let Ok(eigen) = gram.self_adjoint_eigen(faer::Side::Lower) else {
            continue;
        };
        let (vectors, values) = (eigen.U(), eigen.S().column_vector());
        let mut change = vec![0.0; n];
        for k in (0..n).filter(|&k| values[k] < DETERMINED) {
            let part: f64 = (0..n).map(|i| vectors[(i, k)] * along[i]).sum();
            for (i, change) in change.iter_mut().enumerate() {
                *change += vectors[(i, k)] * part / (1.0 - values[k]);
            }
        }
        let offset = fold.scored.start - fold.removed.start;
        for (k, place) in fold.scored.clone().enumerate() {
            let moved: f64 = rows
                .iter()
                .zip(&change)
                .map(|(row, change)| row[offset + k] * change)
                .sum();
            held_out[place] += moved;
        }
    }
    held_out
}

/// Error on one part that was left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HeldOut {
    /// Number of samples.
    pub(crate) n: f64,
    /// Sum of their squared errors.
    pub(crate) squares: f64,
}

impl HeldOut {
    pub(crate) fn of(residual: &[f64]) -> Self {
        Self {
            n: residual.len() as f64,
            squares: dot(residual, residual),
        }
    }
}

/// Mean square error over parts.
pub(crate) fn mean_square(parts: &[HeldOut]) -> f64 {
    let n: f64 = parts.iter().map(|part| part.n).sum();
    parts.iter().map(|part| part.squares).sum::<f64>() / n.max(1.0)
}
