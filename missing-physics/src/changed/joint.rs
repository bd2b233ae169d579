//! All runs of a rig with one model, to first order.

use std::ops::Range;

use identify::{ForwardModel, IdentifyError, ParameterVector, PriorRow, prior_rows};
use recording::Recording;

use crate::changed::discrepancy::{Discrepancy, Filter, Sampled};
use crate::changed::partial_loops::{Turn, is_known, turns};
use crate::changed::system::{Adjusted, System};
use crate::changed::version::Version;
use crate::model::case::Case;
use crate::model::series::Channel;
use crate::model::tangent::{Sensitivity, derivatives};

/// The runs: where each stands, when it was sampled, how fast it moved, where it turned back.
#[derive(Debug, Clone)]
pub(crate) struct Runs {
    sampled: Vec<Sampled>,
    turns: Vec<Vec<Turn>>,
    ranges: Vec<Range<usize>>,
}

/// A model of all runs somewhere, and what its parameters could still do there.
#[derive(Debug, Clone)]
pub(crate) struct Joint {
    pub(crate) version: Version,
    pub(crate) coordinates: Vec<f64>,
    pub(crate) residual: Vec<f64>,
    pub(crate) sensitivities: Vec<Sensitivity>,
    rows: Vec<PriorRow>,
    vector: ParameterVector,
}

/// Steps of a search, and what one must gain to go on, nats.
const STEPS: usize = 20;
const LEAST: f64 = 0.1;

/// Damping of the first step (Levenberg and Marquardt), what it is multiplied by after one that helped, and dampings of a step.
const FIRST_DAMPING: f64 = 1e-2;
const EASED: f64 = 0.1;
const TRIES: usize = 7;

impl Runs {
    /// `residual` is what a model of them leaves.
    pub(crate) fn of(case: &Case<'_>, residual: &[f64]) -> Self {
        let outputs = case.layout.of_channel(Channel::Output);
        let ranges: Vec<_> = outputs.map(|one| one.range.clone()).collect();
        let pairs = case.recorded().iter().zip(residual);
        let shown: Vec<f64> = pairs
            .map(|(recorded, residual)| recorded - residual)
            .collect();
        let runs = case.training.iter().zip(&ranges);
        let mut sampled: Vec<Sampled> = runs
            .map(|(recording, range)| Sampled {
                time_s: recording.time_s().to_vec(),
                rate: rates(recording, &shown[range.clone()]),
                is_compared: vec![true; range.len()],
            })
            .collect();
        let ends = [f64::min, f64::max].map(|of| shown.iter().copied().reduce(of).unwrap_or(0.0));
        let turns = ranges
            .iter()
            .map(|range| turns(&shown[range.clone()], ends));
        let turns = turns.collect();
        let all = || sampled.iter().flat_map(|one| &one.rate);
        let square = all().map(|rate| rate * rate).sum::<f64>() / all().count() as f64;
        let per = 1.0 / square.sqrt().max(f64::MIN_POSITIVE);
        for one in &mut sampled {
            one.rate.iter_mut().for_each(|rate| *rate *= per);
        }
        Self {
            sampled,
            turns,
            ranges,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.ranges.len()
    }

    /// These runs, of which some are compared with the others only in loops that those have as well.
    pub(crate) fn beside_others(&self, some: &[usize]) -> Self {
        let others = (0..self.len()).filter(|run| !some.contains(run));
        let others: Vec<Turn> = others.flat_map(|run| self.turns[run].clone()).collect();
        let mut beside = self.clone();
        for &run in some {
            beside.sampled[run].is_compared =
                is_known(&self.turns[run], &others, self.ranges[run].len());
        }
        beside
    }

    /// Samples of a run that are compared.
    pub(crate) fn n_compared(&self, run: usize) -> usize {
        let is_compared = self.sampled[run].is_compared.iter();
        is_compared.filter(|one| **one).count()
    }

    /// Share of the samples of some runs that are compared.
    pub(crate) fn share_compared(&self, some: &[usize]) -> f64 {
        let compared: usize = some.iter().map(|&run| self.n_compared(run)).sum();
        let all: usize = some.iter().map(|&run| self.ranges[run].len()).sum();
        compared as f64 / all as f64
    }

    /// Root mean square of a series in a run, about its own mean.
    pub(crate) fn rms_of(&self, run: usize, series: &[f64]) -> f64 {
        let own = &series[self.ranges[run].clone()];
        let mean = own.iter().sum::<f64>() / own.len() as f64;
        let squares = own.iter().map(|one| (one - mean).powi(2)).sum::<f64>();
        (squares / own.len() as f64).sqrt()
    }

    /// Root mean square of a series over all samples of all runs, about the mean of each run.
    pub(crate) fn rms(&self, series: &[f64]) -> f64 {
        let of_runs = 0..self.len();
        let squares = |run: usize| self.ranges[run].len() as f64 * self.rms_of(run, series).powi(2);
        let n: usize = self.ranges.iter().map(ExactSizeIterator::len).sum();
        (of_runs.map(squares).sum::<f64>() / n as f64).sqrt()
    }

    /// Standard deviation of a discrepancy in a run: time, s, and deviation, in the unit of the output.
    pub(crate) fn deviations(&self, run: usize, discrepancy: &Discrepancy) -> Vec<[f64; 2]> {
        let own = &self.sampled[run];
        let pairs = own.time_s.iter().zip(&own.rate);
        pairs
            .map(|(&time_s, &rate)| [time_s, discrepancy.deviation(rate)])
            .collect()
    }

    pub(crate) fn filters(
        &self,
        runs: &[usize],
        discrepancy: &Discrepancy,
    ) -> Vec<(usize, Filter)> {
        runs.iter()
            .map(|&run| (run, Filter::of(discrepancy, &self.sampled[run])))
            .collect()
    }

    /// A series over some of the runs, made white.
    pub(crate) fn white(&self, filters: &[(usize, Filter)], series: &[f64]) -> Vec<f64> {
        let mut white = Vec::new();
        for (run, filter) in filters {
            let start = white.len();
            white.extend_from_slice(&series[self.ranges[*run].clone()]);
            filter.whiten(&mut white[start..]);
        }
        white
    }

    /// A series with nothing but what it has in some runs.
    pub(crate) fn only_in(&self, runs: &[usize], series: &[f64]) -> Vec<f64> {
        let mut only = vec![0.0; series.len()];
        for &run in runs {
            let range = self.ranges[run].clone();
            only[range.clone()].copy_from_slice(&series[range]);
        }
        only
    }
}

impl Joint {
    pub(crate) fn at(
        case: &Case<'_>,
        version: Version,
        coordinates: Vec<f64>,
    ) -> Result<Self, IdentifyError> {
        let residual = residual(case, &version, &coordinates)?;
        let vector = ParameterVector::new(version.parameters(), case.training.len());
        Ok(Self {
            sensitivities: derivatives(case, &version, &coordinates, &residual)?,
            rows: prior_rows(&vector),
            vector,
            version,
            coordinates,
            residual,
        })
    }

    /// A version without a change, at points of each run.
    pub(crate) fn unchanged(
        case: &Case<'_>,
        version: Version,
        points: &[Vec<f64>],
    ) -> Result<Self, IdentifyError> {
        let vector = ParameterVector::new(version.parameters(), points.len());
        let start = vector.coordinates(|parameter, run| Some(points[run][parameter]));
        Self::at(case, version, start)
    }

    /// From here to where some of the runs are met best.
    pub(crate) fn settled(
        mut self,
        case: &Case<'_>,
        runs: &Runs,
        which: &[usize],
        discrepancy: &Discrepancy,
    ) -> Result<Self, IdentifyError> {
        let filters = runs.filters(which, discrepancy);
        let mut cost = self.cost(runs, &filters, &self.coordinates, &self.residual);
        let bounds = self.vector.bounds();
        let mut damping = FIRST_DAMPING;
        for _ in 0..STEPS {
            let system = self.system(runs, which, discrepancy);
            let mut found = None;
            for _ in 0..TRIES {
                let mut moved = self.coordinates.clone();
                for (coordinate, by) in system.step(damping) {
                    let bound = &bounds[coordinate];
                    moved[coordinate] = (moved[coordinate] + by).clamp(bound.lower, bound.upper);
                }
                let left = residual(case, &self.version, &moved)?;
                let there = self.cost(runs, &filters, &moved, &left);
                if there < cost {
                    found = Some((moved, there));
                    damping *= EASED;
                    break;
                }
                damping /= EASED;
            }
            let Some((moved, there)) = found else {
                break;
            };
            let gain = 0.5 * (cost - there);
            cost = there;
            self = Self::at(case, self.version, moved)?;
            if gain < LEAST {
                break;
            }
        }
        Ok(self)
    }

    /// Squares of what is left beside offsets, and of priors.
    fn cost(
        &self,
        runs: &Runs,
        filters: &[(usize, Filter)],
        coordinates: &[f64],
        residual: &[f64],
    ) -> f64 {
        let offsets = self
            .sensitivities
            .iter()
            .filter(|one| one.coordinate.is_none());
        let white: Vec<Vec<f64>> = offsets
            .map(|one| runs.white(filters, &one.column))
            .filter(|white| white.iter().any(|value| value.abs() > 0.0))
            .collect();
        let adjusted = Adjusted {
            coordinates: vec![None; white.len()],
            weak: vec![0.0; white.len()],
            columns: white,
            ..Adjusted::default()
        };
        let own = runs.white(filters, residual);
        let squares = System::new(Vec::new(), adjusted, own).squares();
        let acts = |row: &&PriorRow| {
            filters.iter().any(|(run, _)| {
                self.vector
                    .acting_on(*run)
                    .any(|one| row.derivative(one).abs() > 0.0)
            })
        };
        let rows = self.rows.iter().filter(acts);
        squares + rows.map(|row| row.value(coordinates).powi(2)).sum::<f64>()
    }

    /// Least-squares system of some of the runs: their residual, and everything that laws and states could do to it.
    pub(crate) fn system(&self, runs: &Runs, which: &[usize], discrepancy: &Discrepancy) -> System {
        let filters = runs.filters(which, discrepancy);
        let bounds = self.vector.bounds();
        let acts = |coordinate: usize| {
            which
                .iter()
                .any(|&run| self.vector.acting_on(run).any(|one| one == coordinate))
        };
        let mut adjusted = Adjusted::default();
        let mut of_rows: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.rows.len()];
        for one in &self.sensitivities {
            let white = match one.coordinate {
                Some(coordinate) if !acts(coordinate) => continue,
                _ => runs.white(&filters, &one.column),
            };
            let weak = match one.coordinate {
                Some(coordinate) => {
                    let bound = &bounds[coordinate];
                    let weak = 1.0 / (bound.upper - bound.lower);
                    let mut precise = weak;
                    for (row, of_row) in self.rows.iter().zip(&mut of_rows) {
                        let derivative = row.derivative(coordinate);
                        if derivative.abs() > 0.0 {
                            of_row.push((adjusted.columns.len(), derivative));
                            precise = precise.max(derivative);
                        }
                    }
                    adjusted.ln_prior += precise.ln();
                    weak
                }
                None if white.iter().all(|value| value.abs() <= 0.0) => continue,
                None => 0.0,
            };
            adjusted.weak.push(weak);
            adjusted.coordinates.push(one.coordinate);
            adjusted.columns.push(white);
        }
        let values = self.rows.iter().map(|row| -row.value(&self.coordinates));
        let priors = of_rows.into_iter().zip(values);
        adjusted.priors = priors.filter(|(of_row, _)| !of_row.is_empty()).collect();
        let residual = runs.white(&filters, &self.residual);
        System::new(filters, adjusted, residual)
    }

    /// Logarithm of the density of some of the runs, but for a constant, what may be adjusted integrated out.
    pub(crate) fn nats(&self, runs: &Runs, which: &[usize], discrepancy: &Discrepancy) -> f64 {
        let system = self.system(runs, which, discrepancy);
        // Not what a step might still gain: a search that stands still is worth what it has found.
        system.nats(self.cost(runs, &system.filters, &self.coordinates, &self.residual))
    }

    /// Coordinates of another version where these parameters are, as far as it has them; what it has beside is at nothing.
    pub(crate) fn in_version(&self, version: &Version, n_runs: usize) -> Vec<f64> {
        let vector = ParameterVector::new(version.parameters(), n_runs);
        let points = self.points(n_runs);
        let (own, other) = (self.version.model(), version.model());
        vector.coordinates(|parameter, run| match other.slot(parameter) {
            None if parameter < other.n_plain() => Some(points[run][parameter]),
            // A change of a law.
            None => Some(0.0),
            Some((effect, k)) => {
                let first = own.first_parameter(effect);
                Some(
                    first.map_or(effect.info().parameters[k].neutral(), |first| {
                        points[run][first + k]
                    }),
                )
            }
        })
    }

    /// Values of all parameters in each run.
    pub(crate) fn points(&self, n_runs: usize) -> Vec<Vec<f64>> {
        (0..n_runs).map(|run| self.point(run)).collect()
    }

    /// Values of all parameters in a run.
    pub(crate) fn point(&self, run: usize) -> Vec<f64> {
        self.vector.values(&self.coordinates, run)
    }

    /// The coordinate of a shared parameter.
    pub(crate) fn coordinate_of(&self, parameter: usize) -> Option<usize> {
        self.vector.coordinate_of(parameter, 0)
    }
}

/// Residual that a version leaves of all outputs at coordinates.
pub(crate) fn residual(
    case: &Case<'_>,
    version: &Version,
    coordinates: &[f64],
) -> Result<Vec<f64>, IdentifyError> {
    let vector = ParameterVector::new(version.parameters(), case.training.len());
    let shown = case.layout.shown(version, case.training, |r| {
        vec![vector.values(coordinates, r)]
    })?;
    let pairs = case.recorded().iter().zip(&shown[0]);
    Ok(pairs.map(|(recorded, shown)| recorded - shown).collect())
}

/// |dy/dt|, between the neighbors of each sample.
fn rates(recording: &Recording, shown: &[f64]) -> Vec<f64> {
    let time_s = recording.time_s();
    let last = shown.len() - 1;
    let rate = |k: usize| {
        let [from, to] = [k.saturating_sub(1), (k + 1).min(last)];
        let dt_s = time_s[to] - time_s[from];
        if dt_s > 0.0 {
            ((shown[to] - shown[from]) / dt_s).abs()
        } else {
            0.0
        }
    };
    (0..shown.len()).map(rate).collect()
}
