//! A model to first order: what its parameters could still do, and the traces of effects that it does not have.

use identify::{ForwardModel, IdentifyError, ParameterVector};

use crate::model::case::{Case, Node};
use crate::model::projection::{dot, norm};
use crate::{Candidate, Role, Sign, Smoothness};

/// Step of a central difference, as a share of the coordinate's range.
const DIFFERENCE: f64 = 1e-6;

/// Sizes of secants, as shares of the typical size: what a small one leaves beside the baseline may be nothing where a
/// large one shows, and what a large one leaves may be only what bends where the baseline hides most of the trace.
const SECANTS: [f64; 2] = [LARGEST_SECANT, 0.02];

/// The largest: the only one of effects with corners, and of those whose partner is varied.
pub(crate) const LARGEST_SECANT: f64 = 0.25;

/// Trace of a typical size, relative to the residual, below which it is rounding: a recording without inner
/// reversals shows nothing of their memory.
const SMALLEST_TRACE: f64 = 1e-6;

/// Distance from a bound, relative to the range, at which a coordinate stands on it.
const AT_BOUND: f64 = 1e-9;

/// Trace of one size of an effect, per unit of it.
#[derive(Debug, Clone)]
pub(crate) struct Trace {
    pub(crate) effect: Candidate,
    /// Value of the partner, where there is one.
    pub(crate) partner: Option<f64>,
    /// Size of the secant, as a share of the typical size.
    pub(crate) share: f64,
    /// True if the size may only be positive.
    pub(crate) one_sided: bool,
    pub(crate) secant: Vec<f64>,
}

impl Trace {
    /// True if another size is tested together with this one.
    pub(crate) fn is_tested_with(&self, other: &Self) -> bool {
        self.effect == other.effect
            && self.partner == other.partner
            && self.share.to_bits() == other.share.to_bits()
    }
}

/// Derivative of a model's output by one of its coordinates, or by an offset.
#[derive(Debug, Clone)]
pub(crate) struct Sensitivity {
    /// The coordinate; `None` for an offset.
    pub(crate) coordinate: Option<usize>,
    pub(crate) column: Vec<f64>,
    /// True if the coordinate stands on a bound and the residual pushes it against that bound.
    pub(crate) held: bool,
}

/// Derivatives of a node by all its free parameters.
pub(crate) fn sensitivities(
    case: &Case<'_>,
    node: &Node,
) -> Result<Vec<Sensitivity>, IdentifyError> {
    derivatives(case, &node.model, &node.coordinates, &node.residual)
}

/// Derivatives of any model of a case by all its free parameters, at coordinates where it leaves a residual.
pub(crate) fn derivatives(
    case: &Case<'_>,
    model: &dyn ForwardModel,
    coordinates: &[f64],
    residual: &[f64],
) -> Result<Vec<Sensitivity>, IdentifyError> {
    let n_recordings = case.training.len();
    let vector = ParameterVector::new(model.parameters(), n_recordings);
    let bounds = vector.bounds();
    let ends: Vec<[f64; 2]> = coordinates
        .iter()
        .zip(&bounds)
        .map(|(at, bound)| {
            let step = DIFFERENCE * (bound.upper - bound.lower);
            [-step, step].map(|step| (at + step).clamp(bound.lower, bound.upper))
        })
        .collect();
    // In a recording nothing moves but by what acts on it: as many of them in each.
    let shown = case.layout.shown(model, case.training, |r| {
        let ends = vector
            .acting_on(r)
            .flat_map(|j| ends[j].map(|end| (j, end)));
        let moved = ends.map(|(j, end)| {
            let mut moved = coordinates.to_vec();
            moved[j] = end;
            vector.values(&moved, r)
        });
        moved.collect()
    })?;
    let mut columns = vec![vec![0.0; case.layout.len()]; ends.len()];
    for segment in &case.layout.segments {
        let range = segment.range.clone();
        for (k, j) in vector.acting_on(segment.recording).enumerate() {
            let [below, above] = [2 * k, 2 * k + 1].map(|end| &shown[end][range.clone()]);
            let apart = difference(above, below, ends[j][1] - ends[j][0]);
            columns[j][range.clone()].copy_from_slice(&apart);
        }
    }
    let mut sensitivities: Vec<Sensitivity> = columns
        .into_iter()
        .enumerate()
        .map(|(j, column)| {
            let margin = AT_BOUND * (bounds[j].upper - bounds[j].lower);
            let pull = dot(&column, residual);
            let at = coordinates[j];
            let held = (at <= bounds[j].lower + margin && pull <= 0.0)
                || (at >= bounds[j].upper - margin && pull >= 0.0);
            Sensitivity {
                coordinate: Some(j),
                column,
                held,
            }
        })
        .collect();
    for r in 0..n_recordings {
        let mut column = vec![0.0; case.layout.len()];
        column[case.layout.segments[r].range.clone()].fill(1.0);
        sensitivities.push(Sensitivity {
            coordinate: None,
            column,
            held: false,
        });
    }
    Ok(sensitivities)
}

/// Sizes of an effect's secants in screening, as shares of the typical size.
pub(crate) fn secants_of(case: &Case<'_>, effect: Candidate) -> &'static [f64] {
    let is_smooth = effect.info().smoothness == Smoothness::Smooth;
    if is_smooth && case.screened_partner(effect).is_none() {
        &SECANTS
    } else {
        &SECANTS[..1]
    }
}

/// Traces of an effect that a node does not have, as secants at shares of the typical size: one for each of its
/// sizes, each share, and each value of its partner or only one.
pub(crate) fn traces(
    case: &Case<'_>,
    node: &Node,
    effect: Candidate,
    shares: &[f64],
    partner: Option<f64>,
) -> Result<Vec<Trace>, IdentifyError> {
    let parameters = effect.info().parameters;
    let partners: Vec<Option<f64>> = match case.screened_partner(effect) {
        Some((_, grid)) if partner.is_none() => grid.iter().copied().map(Some).collect(),
        _ => vec![partner],
    };
    // Sizes of one test stand together.
    let sizes = |at| {
        let sizes = (0..parameters.len()).filter(|&k| parameters[k].role == Role::Size);
        sizes.map(move |k| (k, at))
    };
    let wanted: Vec<(usize, (Option<f64>, f64))> = partners
        .iter()
        .flat_map(|&partner| shares.iter().map(move |&share| (partner, share)))
        .flat_map(sizes)
        .collect();
    let model = case.model(node.effects.with(effect));
    let vector = ParameterVector::new(model.parameters(), case.training.len());
    // The point itself first: with the effect at zero the model has the node's bits.
    let mut starts = vec![case.moved(node, &model, |_, _| None)];
    starts.extend(wanted.iter().map(|&(size, (partner, share))| {
        case.moved(node, &model, |other, k| {
            if other != effect {
                None
            } else if k == size {
                Some(share * parameters[k].typical)
            } else {
                of_partner(effect, k, partner)
            }
        })
    }));
    let shown = case.layout.shown(&model, case.training, |r| {
        starts.iter().map(|start| vector.values(start, r)).collect()
    })?;
    let residual = norm(&node.residual);
    Ok(wanted
        .iter()
        .zip(&shown[1..])
        .map(|(&(parameter, (partner, share)), moved)| {
            let typical = parameters[parameter].typical;
            let mut secant = difference(moved, &shown[0], share * typical);
            if typical * norm(&secant) < SMALLEST_TRACE * residual {
                secant.fill(0.0);
            }
            Trace {
                effect,
                partner,
                share,
                one_sided: parameters[parameter].sign() == Sign::NonNegative,
                secant,
            }
        })
        .collect())
}

/// The value of an effect's parameter, if it is the partner that screening varies.
pub(crate) fn of_partner(effect: Candidate, parameter: usize, value: Option<f64>) -> Option<f64> {
    let (screened, _) = effect.info().screened_partner()?;
    value.filter(|_| screened == parameter)
}

/// (a - b)/distance; nothing where there is no distance.
fn difference(a: &[f64], b: &[f64], distance: f64) -> Vec<f64> {
    let per = if distance == 0.0 { 0.0 } else { 1.0 / distance };
    a.iter().zip(b).map(|(a, b)| (a - b) * per).collect()
}
