//! A fitted baseline to first order: its residual, what its parameters could still do, and the traces of
//! effects that it does not have.

use identify::{Enters, Fit, ForwardModel, IdentifyError, ParameterVector, Scope, WienerModel};
use recording::Recording;

use crate::info::Sign;
use crate::projection::norm;
use crate::scores::{Candidate, Tangent};
use crate::{EffectId, EffectSet, ExtendedModel, Role, Setting};

/// Step of a central difference, as a share of the coordinate's range.
const DIFFERENCE: f64 = 1e-6;

/// Size of a secant, as a share of the typical size: small enough to be nearly a tangent, large enough for
/// effects with corners.
const SECANT: f64 = 0.25;

/// Trace of a typical size, relative to the residual, below which it is rounding: a recording without inner
/// reversals shows nothing of their memory.
const SMALLEST_TRACE: f64 = 1e-6;

/// What a candidate trace is of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Origin {
    pub(crate) effect: EffectId,
    /// Number of the size among the effect's parameters.
    pub(crate) parameter: usize,
    /// Value of the partner, where there is one.
    pub(crate) partner: Option<f64>,
}

/// Linearizes a fit; the candidates stand in the order of their origins.
pub(crate) fn tangent(
    base: &WienerModel,
    fit: &Fit,
    setting: Setting,
    effects: &[EffectId],
    training: &[Recording],
) -> Result<(Tangent, Vec<Origin>), IdentifyError> {
    let points: Vec<Vec<f64>> = (0..training.len()).map(|r| fit.point(r)).collect();
    let at_fit = traces(base, training, |r| vec![points[r].clone()])?.remove(0);
    let recorded: Vec<f64> = training
        .iter()
        .flat_map(Recording::output)
        .copied()
        .collect();
    let residual = difference(&recorded, &at_fit, 1.0);
    let mut origins: Vec<Origin> = Vec::new();
    let mut candidates: Vec<Candidate> = Vec::new();
    for &effect in effects {
        let (found, traces) = secants(base, fit, setting, effect, training, &at_fit)?;
        origins.extend(found);
        candidates.extend(traces);
    }
    for (origin, candidate) in origins.iter().zip(&mut candidates) {
        let typical = origin.effect.info().parameters[origin.parameter].typical;
        if typical * norm(&candidate.secant) < SMALLEST_TRACE * norm(&residual) {
            candidate.secant.fill(0.0);
        }
    }
    let tangent = Tangent {
        fitted: fitted_columns(base, fit, training, &at_fit)?,
        residual,
        candidates,
    };
    Ok((tangent, origins))
}

/// Derivatives with respect to all free parameters of the baseline.
fn fitted_columns(
    base: &WienerModel,
    fit: &Fit,
    training: &[Recording],
    at_fit: &[f64],
) -> Result<Vec<Vec<f64>>, IdentifyError> {
    let vector = ParameterVector::new(base.parameters(), training.len());
    let coordinates = fit.coordinates(&vector);
    let mut columns = Vec::new();
    for (j, bound) in vector.bounds().iter().enumerate() {
        let step = DIFFERENCE * (bound.upper - bound.lower);
        let ends = [-step, step].map(|step| {
            let mut moved = coordinates.clone();
            moved[j] = (coordinates[j] + step).clamp(bound.lower, bound.upper);
            moved
        });
        let moved = traces(base, training, |r| {
            ends.iter()
                .map(|end| with_readout(base, fit, vector.values(end, r), r))
                .collect()
        })?;
        columns.push(difference(&moved[1], &moved[0], ends[1][j] - ends[0][j]));
    }
    // Gain and offsets enter as factor and sum.
    let mut start = 0;
    let mut shape = at_fit.to_vec();
    for (r, recording) in training.iter().enumerate() {
        let own = start..start + recording.len();
        start = own.end;
        for (info, value) in base.parameters().iter().zip(fit.point(r)) {
            if info.enters == Enters::Offset {
                shape[own.clone()].iter_mut().for_each(|y| *y -= value);
                let mut column = vec![0.0; at_fit.len()];
                column[own.clone()].fill(1.0);
                columns.push(column);
            }
        }
    }
    columns.push(shape);
    Ok(columns)
}

/// The values of a point with gain and offset as fitted.
fn with_readout(base: &WienerModel, fit: &Fit, mut values: Vec<f64>, r: usize) -> Vec<f64> {
    for (k, info) in base.parameters().iter().enumerate() {
        if info.enters != Enters::Nonlinear {
            let own = match info.scope {
                Scope::Shared => 0,
                Scope::PerRecording => r,
            };
            values[k] = fit.parameters[k].values[own];
        }
    }
    values
}

/// Secants of an effect: one for each of its sizes and each value of its partner.
fn secants(
    base: &WienerModel,
    fit: &Fit,
    setting: Setting,
    effect: EffectId,
    training: &[Recording],
    at_fit: &[f64],
) -> Result<(Vec<Origin>, Vec<Candidate>), IdentifyError> {
    let parameters = effect.info().parameters;
    let grid = parameters
        .iter()
        .find_map(|parameter| match parameter.role {
            Role::Partner { grid } => Some(grid),
            Role::Size => None,
        });
    let partners: Vec<Option<f64>> = match grid {
        Some(grid) => grid.iter().copied().map(Some).collect(),
        None => vec![None],
    };
    let mut origins = Vec::new();
    let mut sizes = Vec::new();
    for (parameter, info) in parameters.iter().enumerate() {
        if info.role == Role::Size {
            for &partner in &partners {
                sizes.push(SECANT * info.typical);
                origins.push(Origin {
                    effect,
                    parameter,
                    partner,
                });
            }
        }
    }
    let model = ExtendedModel::new(
        base,
        fit,
        Setting {
            active: EffectSet::of(effect),
            ..setting
        },
    );
    let shown = traces(&model, training, |r| {
        origins
            .iter()
            .zip(&sizes)
            .map(|(origin, &size)| {
                let mut point = fit.point(r);
                point.extend(parameters.iter().enumerate().map(|(k, info)| {
                    match (info.role, origin.partner) {
                        (Role::Size, _) if k == origin.parameter => size,
                        (Role::Partner { .. }, Some(partner)) => partner,
                        _ => info.neutral(),
                    }
                }));
                point
            })
            .collect()
    })?;
    let candidates = shown
        .iter()
        .zip(origins.iter().zip(&sizes))
        .map(|(shown, (origin, &size))| Candidate {
            secant: difference(shown, at_fit, size),
            one_sided: parameters[origin.parameter].sign() == Sign::NonNegative,
        })
        .collect();
    Ok((origins, candidates))
}

/// Outputs over all recordings, one after the other, at the points that `points` gives for each: a series a
/// point.
fn traces<M: ForwardModel>(
    model: &M,
    training: &[Recording],
    points: impl Fn(usize) -> Vec<Vec<f64>>,
) -> Result<Vec<Vec<f64>>, IdentifyError> {
    /// Points that a model takes at once.
    const BATCH: usize = 32;
    let mut traces: Vec<Vec<f64>> = Vec::new();
    for (r, recording) in training.iter().enumerate() {
        let points = points(r);
        traces.resize_with(points.len(), Vec::new);
        for (batch, traces) in points.chunks(BATCH).zip(traces.chunks_mut(BATCH)) {
            model.simulate(batch, recording, &mut |block| {
                for row in block.displacement.chunks_exact(block.stride) {
                    for (trace, &y) in traces.iter_mut().zip(row) {
                        trace.push(y);
                    }
                }
            })?;
        }
    }
    Ok(traces)
}

/// (a - b)/distance; nothing where there is no distance.
fn difference(a: &[f64], b: &[f64], distance: f64) -> Vec<f64> {
    let per = if distance == 0.0 { 0.0 } else { 1.0 / distance };
    a.iter().zip(b).map(|(a, b)| (a - b) * per).collect()
}
