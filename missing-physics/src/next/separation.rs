//! How far apart two models lie in an experiment, once each has been refitted to all that is known then.

use identify::{ForwardModel, IdentifyError, ParameterVector};
use recording::Recording;

use crate::model::case::{Case, Node};
use crate::model::elsewhere::{is_drift, without_drifts};
use crate::model::projection::{Span, dot, norm};
use crate::model::series::{Channel, Layout, Noise};
use crate::model::tangent::sensitivities;
use crate::noise::whiten::Whitener;

/// Step of a central difference, as a share of the coordinate's range.
const DIFFERENCE: f64 = 1e-6;

/// Recordings that an experiment would yield.
#[derive(Debug)]
pub(crate) struct Experiment<'a> {
    pub(crate) recordings: &'a [Recording],
    pub(crate) layout: Layout,
    whitener: Whitener,
    /// True if a recorded temperature counts up to a factor only.
    scale_is_open: bool,
}

/// A rival and what the training says of its parameters.
#[derive(Debug)]
pub(crate) struct Known<'a> {
    node: &'a Node,
    /// For each shared coordinate, what moving it by one costs the training: a column of a triangular matrix,
    /// with what is of each recording alone taken out.
    told: Vec<Vec<f64>>,
}

/// A rival in an experiment.
#[derive(Debug)]
pub(crate) struct Foreseen {
    /// Whitened series: without drifts, and where the rival has some with those of the training as well.
    shown: Vec<Vec<f64>>,
    /// Span of the changes that its parameters can make there; its first rows hold the costs of these changes elsewhere.
    span: Span,
    /// Number of those first rows.
    n_costs: usize,
}

/// Distance of a pair.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Separation {
    /// Standard deviations.
    pub(crate) distance: f64,
    /// Where in the experiment's series it lies: squares that add up to the square of the distance, but for
    /// what the costs elsewhere make of it.
    pub(crate) squares: Vec<f64>,
}

impl<'a> Experiment<'a> {
    pub(crate) fn new(case: &Case<'_>, recordings: &'a [Recording], noise: &Noise) -> Self {
        Self::of(
            case,
            recordings,
            Layout::of(recordings, case.layout.per_k),
            noise,
        )
    }

    /// An experiment in which temperatures of the rod are recorded as well, with their noise.
    pub(crate) fn with_temperature(
        case: &Case<'_>,
        recordings: &'a [Recording],
        noise: &Noise,
    ) -> Self {
        let mut layout = Layout::of(recordings, 1.0);
        layout.segments.retain(|one| one.channel == Channel::Output);
        let mut segments = layout.segments.clone();
        for one in &mut segments {
            let start = layout.len();
            one.range = start..start + one.range.len();
            one.channel = Channel::Temperature;
            layout.segments.push(one.clone());
        }
        Self::of(case, recordings, layout, noise)
    }

    fn of(case: &Case<'_>, recordings: &'a [Recording], layout: Layout, noise: &Noise) -> Self {
        Self {
            whitener: Whitener::new(&layout, noise),
            scale_is_open: !case.base.knows_temperature(),
            recordings,
            layout,
        }
    }
}

impl<'a> Known<'a> {
    pub(crate) fn of(
        case: &Case<'_>,
        node: &'a Node,
        noise: &Noise,
    ) -> Result<Self, IdentifyError> {
        let whitener = Whitener::new(&case.layout, noise);
        let n_shared = n_shared(node);
        let (mut shared, mut own) = (Vec::new(), Vec::new());
        for one in sensitivities(case, node)? {
            let column = whitener.whiten(&one.column);
            match one.coordinate {
                Some(j) if j < n_shared && drift_scale(node, j).is_none() => shared.push(column),
                _ => own.push(column),
            }
        }
        let own = Span::of(&own);
        let shared: Vec<Vec<f64>> = shared.iter().map(|column| own.outside(column)).collect();
        let basis = Span::of(&shared);
        let told = shared
            .iter()
            .map(|column| basis.basis().iter().map(|one| dot(one, column)).collect())
            .collect();
        Ok(Self { node, told })
    }

    pub(crate) fn node(&self) -> &'a Node {
        self.node
    }

    /// Values of all parameters in the recordings of an experiment: those of the training in the order of
    /// the training's recordings, those of the first in any other.
    fn points(&self, is_repetition: bool, n_recordings: usize) -> Vec<Vec<f64>> {
        let points = &self.node.points;
        (0..n_recordings)
            .map(|r| points[if is_repetition { r } else { 0 }].clone())
            .collect()
    }

    /// The rival in an experiment; in a repetition of the training, each recording has its own past.
    pub(crate) fn in_experiment(
        &self,
        experiment: &Experiment<'_>,
        is_repetition: bool,
    ) -> Result<Foreseen, IdentifyError> {
        let model = &self.node.model;
        let n_recordings = experiment.recordings.len();
        let vector = ParameterVector::new(model.parameters(), n_recordings);
        let with_drifts = self.points(is_repetition, n_recordings);
        let without: Vec<Vec<f64>> = with_drifts
            .iter()
            .map(|point| without_drifts(model, point))
            .collect();
        let at = vector.coordinates(|parameter, r| Some(without[r][parameter]));
        let bounds = vector.bounds();
        let mut lanes = vec![at.clone()];
        let mut distances = Vec::new();
        for (j, bound) in bounds.iter().enumerate() {
            let step = DIFFERENCE * (bound.upper - bound.lower);
            let ends = [-step, step].map(|step| (at[j] + step).clamp(bound.lower, bound.upper));
            distances.push(ends[1] - ends[0]);
            lanes.extend(ends.map(|end| {
                let mut moved = at.clone();
                moved[j] = end;
                moved
            }));
        }
        let has_drifts = model.active().iter().any(is_drift);
        if has_drifts {
            lanes.push(vector.coordinates(|parameter, r| Some(with_drifts[r][parameter])));
        }
        let mut white = experiment.layout.shown(model, experiment.recordings, |r| {
            lanes.iter().map(|lane| vector.values(lane, r)).collect()
        })?;
        let raw = white[0].clone();
        for series in &mut white {
            *series = experiment.whitener.whiten(series);
        }
        let columns: Vec<Vec<f64>> = distances
            .iter()
            .enumerate()
            .map(|(j, distance)| {
                let per = if *distance > 0.0 { 1.0 / distance } else { 0.0 };
                let pair = white[2 * j + 2].iter().zip(&white[2 * j + 1]);
                pair.map(|(above, below)| per * (above - below)).collect()
            })
            .collect();
        let with_drifts = has_drifts.then(|| white.pop()).flatten();
        let mut shown = vec![white.swap_remove(0)];
        shown.extend(with_drifts);
        let ranges: Vec<f64> = bounds
            .iter()
            .map(|bound| bound.upper - bound.lower)
            .collect();
        let (span, n_costs) = self.span(&columns, &ranges, experiment, &raw);
        Ok(Foreseen {
            shown,
            span,
            n_costs,
        })
    }

    /// The columns below what moving their parameters costs elsewhere: on the training, and against what is
    /// known of them before any recording; and what is free in the experiment.
    fn span(
        &self,
        columns: &[Vec<f64>],
        ranges: &[f64],
        experiment: &Experiment<'_>,
        raw: &[f64],
    ) -> (Span, usize) {
        let n_told = self.told.first().map_or(0, Vec::len);
        let n_costs = n_told + columns.len();
        let n_shared = n_shared(self.node);
        let mut span = Span::default();
        let mut told = self.told.iter();
        for (j, column) in columns.iter().enumerate() {
            let drift = (j < n_shared).then(|| drift_scale(self.node, j)).flatten();
            let mut stacked = vec![0.0; n_costs];
            if let (true, None) = (j < n_shared, drift) {
                let told = told.next().map_or(&[][..], Vec::as_slice);
                stacked[..told.len()].copy_from_slice(told);
            }
            stacked[n_told + j] = 1.0 / drift.unwrap_or(ranges[j]);
            stacked.extend(column);
            span.widen(&stacked);
        }
        for one in &experiment.layout.segments {
            // Each sensor has its zero.
            let mut free = vec![0.0; raw.len()];
            free[one.range.clone()].fill(1.0);
            let mut all = vec![free.clone()];
            if one.channel == Channel::Temperature && experiment.scale_is_open {
                free[one.range.clone()].copy_from_slice(&raw[one.range.clone()]);
                all.push(free);
            }
            for free in all {
                let mut stacked = vec![0.0; n_costs];
                stacked.extend(experiment.whitener.whiten(&free));
                span.widen(&stacked);
            }
        }
        (span, n_costs)
    }
}

/// How far an experiment in which `truth` holds would lie from all that `rival` can do.
///
/// ```text
/// d² = min over δ of |W (y_truth - y_rival - J δ)|² + |R δ|² + |P δ|²
/// ```
///
/// J are the rival's sensitivities there, R those on the training, P what is known before any recording:
/// the expected difference of twice the log-likelihoods on old and new data together (DIAGNOSIS 2.11). Drifts of
/// the truth may come back or not, whichever is harder to tell.
pub(crate) fn separation(truth: &Foreseen, rival: &Foreseen) -> Separation {
    let mut least: Option<Separation> = None;
    for true_series in &truth.shown {
        for series in &rival.shown {
            let mut stacked = vec![0.0; rival.n_costs];
            stacked.extend(true_series.iter().zip(series).map(|(a, b)| a - b));
            let outside = rival.span.outside(&stacked);
            let distance = norm(&outside);
            if least.as_ref().is_none_or(|least| distance < least.distance) {
                let squares = outside[rival.n_costs..].iter().map(|value| value * value);
                least = Some(Separation {
                    distance,
                    squares: squares.collect(),
                });
            }
        }
    }
    let Some(least) = least else {
        unreachable!("a rival shows at least one series");
    };
    least
}

/// The pair that is hardest to tell apart.
pub(crate) fn least_separation(rivals: &[Foreseen]) -> Option<Separation> {
    let pairs = (0..rivals.len())
        .flat_map(|j| (0..rivals.len()).map(move |k| (j, k)))
        .filter(|(j, k)| j != k);
    pairs
        .map(|(j, k)| separation(&rivals[j], &rivals[k]))
        .min_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// Coordinates that all recordings share; they come first.
fn n_shared(node: &Node) -> usize {
    ParameterVector::new(node.model.parameters(), 0).len()
}

/// Of the knots of a drift, how large they usually are; `None` for other coordinates.
fn drift_scale(node: &Node, coordinate: usize) -> Option<f64> {
    let vector = ParameterVector::new(node.model.parameters(), 1);
    let parameter = vector.parameter(coordinate);
    let (effect, index) = node.model.slot(parameter)?;
    if !is_drift(effect) {
        return None;
    }
    let found = node.values(effect).unwrap_or(&[]);
    let mean_square = found.iter().map(|value| value * value).sum::<f64>() / found.len() as f64;
    Some(
        effect.info().parameters[index]
            .typical
            .max(mean_square.sqrt()),
    )
}
