//! The sum of squares of several recordings together, gain and offsets solved for.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use pso::Bound;
use recording::Recording;
use wiener::Block;

use crate::dense::Matrix;
use crate::difference::{Batch, Difference, Sides};
use crate::factor::Triangle;
use crate::least_squares::{Linearized, SumOfSquares};
use crate::moments::{BATCH, Moments, Solved, Weighed, solve_linear};
use crate::prior::{Prior, PriorRow, prior_rows};
use crate::quantities::one_unit;
use crate::tasks::try_in_parallel;
use crate::{Enters, ForwardModel, IdentifyError, ParameterState, ParameterVector, Scope};

/// ```text
/// S(θ) = Σ w (y - gain f - offset)² + w_T Σ (T - T_recorded)²,   gain and offsets the best for θ
/// ```
///
/// and the prior of θ, as [`Prior`] counts it.
#[derive(Debug)]
pub(crate) struct Problem<'a> {
    model: &'a dyn ForwardModel,
    recordings: Vec<Weighed<'a>>,
    vector: ParameterVector,
    bounds: Vec<Bound>,
    gain: ParameterState,
    offset: ParameterState,
    /// w_T, (output unit/K)²; 0 leaves recorded temperatures out.
    temperature_weight: f64,
    /// Priors of the coordinates.
    prior_rows: Vec<PriorRow>,
    /// How they count.
    prior: Prior,
    /// Points simulated so far.
    simulations: AtomicU64,
    /// Points solved last, kept because a search asks again for the best of its trials.
    latest: Mutex<Vec<(Vec<f64>, Solved)>>,
}

/// Residuals of one recording.
#[derive(Debug)]
pub(crate) struct Residuals {
    /// Recording - model, of the output.
    pub(crate) values: Vec<f64>,
    /// Recording - model, of the temperature, K; empty where none is recorded.
    pub(crate) temperatures_k: Vec<f64>,
    /// Highest temperature of the model, °C.
    pub(crate) peak_temperature_degc: f64,
}

/// One residual and its derivatives, unweighted.
#[derive(Debug)]
pub(crate) struct Row<'a> {
    pub(crate) channel: Channel,
    pub(crate) sample: usize,
    /// Derivatives with respect to the linear parameters, then the coordinates.
    derivatives: &'a [f64],
    /// Model - recording.
    pub(crate) residual: f64,
}

/// Difference quotients by a coordinate of a further batch, sample by sample.
#[derive(Debug)]
struct Quotients {
    coordinate: usize,
    /// Of the output at a gain of 1.
    output: Vec<f64>,
    /// Of the temperature, K; empty where none counts.
    temperature: Vec<f64>,
}

/// Measured quantity of a residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Channel {
    Output,
    Temperature,
}

impl Row<'_> {
    pub(crate) fn derivative(&self, column: usize) -> f64 {
        self.derivatives[column]
    }
}

impl<'a> Problem<'a> {
    pub(crate) fn new(
        model: &'a dyn ForwardModel,
        recordings: &'a [Recording],
    ) -> Result<Self, IdentifyError> {
        let vector = ParameterVector::new(model.parameters(), recordings.len());
        one_unit(recordings)?;
        let gain = linear_state(model, Enters::Gain, Scope::Shared, 1.0)?;
        let offset = linear_state(model, Enters::Offset, Scope::PerRecording, 0.0)?;
        Ok(Self {
            model,
            recordings: recordings
                .iter()
                .map(|recording| Weighed::new(recording, None))
                .collect(),
            bounds: vector.bounds(),
            vector,
            gain,
            offset,
            temperature_weight: 0.0,
            prior_rows: Vec::new(),
            prior: Prior::Nothing,
            simulations: AtomicU64::new(0),
            latest: Mutex::default(),
        })
    }

    /// Says how the priors of parameters count.
    pub(crate) fn set_prior(&mut self, prior: Prior) {
        self.prior = prior;
        self.prior_rows = match prior {
            Prior::Nothing => Vec::new(),
            _ => prior_rows(&self.vector),
        };
    }

    /// The priors of the coordinates, and the variance of each such row where the residual is that of a solution.
    pub(crate) fn prior_rows(&self, solved: &Solved) -> (&[PriorRow], f64) {
        (&self.prior_rows, self.prior.variance(self.squares(solved)))
    }

    /// P at a point.
    pub(crate) fn of_prior(&self, point: &[f64]) -> f64 {
        let rows = self.prior_rows.iter();
        rows.map(|row| row.value(point).powi(2)).sum()
    }

    /// Weighs the samples of each recording anew.
    pub(crate) fn weigh_samples(&mut self, weights: Vec<Vec<f64>>) {
        self.latest = Mutex::default();
        for (weighed, weights) in self.recordings.iter_mut().zip(weights) {
            *weighed = Weighed::new(weighed.recording, Some(weights));
        }
    }

    /// Weighs recorded temperatures against the output, (output unit/K)².
    pub(crate) fn weigh_temperature(&mut self, weight: f64) {
        self.temperature_weight = weight;
    }

    /// Copy of the problem with a count and a memory of its own.
    pub(crate) fn apart(&self) -> Self {
        Self {
            model: self.model,
            recordings: self.recordings.clone(),
            vector: self.vector.clone(),
            bounds: self.bounds.clone(),
            prior_rows: self.prior_rows.clone(),
            simulations: AtomicU64::new(0),
            latest: Mutex::default(),
            ..*self
        }
    }

    /// The problem of one recording alone with another model, whose samples weigh as they do here, and its priors as they do where the
    /// residual of all is that of a solution.
    pub(crate) fn of_one<'b>(
        &self,
        model: &'b dyn ForwardModel,
        r: usize,
        solved: &Solved,
    ) -> Result<Problem<'b>, IdentifyError>
    where
        'a: 'b,
    {
        let weighed = self.recordings[r].clone();
        let recording = std::slice::from_ref(weighed.recording);
        let mut alone = Problem {
            recordings: vec![weighed],
            temperature_weight: self.temperature_weight,
            ..Problem::new(model, recording)?
        };
        alone.set_prior(match self.prior {
            Prior::Nothing => Prior::Nothing,
            prior => Prior::Variance(prior.variance(self.squares(solved))),
        });
        Ok(alone)
    }

    pub(crate) fn model(&self) -> &'a dyn ForwardModel {
        self.model
    }

    /// Counts points that were simulated.
    pub(crate) fn count(&self, simulations: u64) {
        self.simulations.fetch_add(simulations, Ordering::Relaxed);
    }

    /// Points simulated so far, each over all recordings.
    pub(crate) fn simulations(&self) -> u64 {
        self.simulations.load(Ordering::Relaxed)
    }

    pub(crate) fn vector(&self) -> &ParameterVector {
        &self.vector
    }

    pub(crate) fn bounds(&self) -> &[Bound] {
        &self.bounds
    }

    /// The middle of the bounds: where to start when nothing is known.
    pub(crate) fn middle(&self) -> Vec<f64> {
        self.bounds
            .iter()
            .map(|bound| f64::midpoint(bound.lower, bound.upper))
            .collect()
    }

    pub(crate) fn recordings(&self) -> impl Iterator<Item = &'a Recording> {
        self.recordings.iter().map(|weighed| weighed.recording)
    }

    pub(crate) fn n_recordings(&self) -> usize {
        self.recordings.len()
    }

    /// Number of output samples.
    pub(crate) fn n_samples(&self) -> usize {
        self.recordings
            .iter()
            .map(|weighed| weighed.recording.len())
            .sum()
    }

    /// Number of recorded temperatures.
    pub(crate) fn n_temperatures(&self) -> usize {
        let of =
            |weighed: &Weighed<'_>| weighed.recording.temperature_degc().map_or(0, <[f64]>::len);
        self.recordings.iter().map(of).sum()
    }

    /// Σ w (y - mean)² over all recordings, each about its own mean.
    pub(crate) fn spread(&self) -> f64 {
        self.recordings.iter().map(Weighed::spread).sum()
    }

    /// Weight of a residual in the sum of squares.
    pub(crate) fn weight(&self, r: usize, row: &Row<'_>) -> f64 {
        match row.channel {
            Channel::Output => self.recordings[r].weight(row.sample),
            Channel::Temperature => self.temperature_weight,
        }
    }

    /// Number of columns that stand for gain and offsets, before those of the coordinates.
    pub(crate) fn n_linear(&self) -> usize {
        let offsets = match self.offset {
            ParameterState::Free => self.recordings.len(),
            ParameterState::Fixed(_) => 0,
        };
        self.n_gains() + offsets
    }

    /// 1 if the gain is free, else 0.
    pub(crate) fn n_gains(&self) -> usize {
        usize::from(self.gain == ParameterState::Free)
    }

    /// Column of the Jacobian of a parameter in a recording; `None` if it is not free.
    pub(crate) fn column_of(&self, parameter: usize, r: usize) -> Option<usize> {
        let info = &self.vector.infos()[parameter];
        match (info.enters, info.state) {
            (_, ParameterState::Fixed(_)) => None,
            (Enters::Gain, ParameterState::Free) => Some(0),
            (Enters::Offset, ParameterState::Free) => Some(self.n_gains() + r),
            (Enters::Nonlinear, ParameterState::Free) => {
                let coordinate = self.vector.coordinate_of(parameter, r)?;
                Some(self.n_linear() + coordinate)
            }
        }
    }

    /// Values of all parameters in a recording, gain and offset included.
    pub(crate) fn values(&self, point: &[f64], solved: &Solved, r: usize) -> Vec<f64> {
        let mut values = self.vector.values(point, r);
        for (value, info) in values.iter_mut().zip(self.vector.infos()) {
            match info.enters {
                Enters::Nonlinear => {}
                Enters::Gain => *value = solved.gain,
                Enters::Offset => *value = solved.offsets[r],
            }
        }
        values
    }

    /// Recording - model at every sample of each recording's output, and the model's highest temperature.
    pub(crate) fn residuals(
        &self,
        point: &[f64],
        solved: &Solved,
    ) -> Result<Vec<Residuals>, IdentifyError> {
        (0..self.recordings.len())
            .map(|r| {
                let recording = self.recordings[r].recording;
                let mut values = Vec::with_capacity(recording.len());
                let recorded = recording.temperature_degc().unwrap_or(&[]);
                let mut temperatures_k = Vec::with_capacity(recorded.len());
                let mut peak_temperature_degc = f64::NEG_INFINITY;
                self.simulate(r, &[point.to_vec()], &mut |block| {
                    let shapes = block.displacement.iter().step_by(block.stride);
                    for (f, y) in shapes.zip(&recording.output()[block.first_sample..]) {
                        values.push(y - solved.gain * f - solved.offsets[r]);
                    }
                    let shown = block.temperature_degc.iter().step_by(block.stride);
                    peak_temperature_degc =
                        shown.clone().copied().fold(peak_temperature_degc, f64::max);
                    let recorded = recorded.iter().skip(block.first_sample);
                    temperatures_k.extend(
                        shown
                            .zip(recorded)
                            .map(|(shown, recorded)| recorded - shown),
                    );
                })?;
                Ok(Residuals {
                    values,
                    temperatures_k,
                    peak_temperature_degc,
                })
            })
            .collect()
    }

    /// Lowest and highest temperature of the model over all recordings at each point, °C.
    pub(crate) fn reached_degc(&self, points: &[Vec<f64>]) -> Result<Vec<[f64; 2]>, IdentifyError> {
        self.count(points.len() as u64);
        let mut reached = vec![[f64::INFINITY, f64::NEG_INFINITY]; points.len()];
        for (batch, reached) in points.chunks(BATCH).zip(reached.chunks_mut(BATCH)) {
            for r in 0..self.recordings.len() {
                self.simulate(r, batch, &mut |block| {
                    for row in block.temperature_degc.chunks_exact(block.stride) {
                        for ([lowest, highest], degc) in reached.iter_mut().zip(row) {
                            (*lowest, *highest) = (lowest.min(*degc), highest.max(*degc));
                        }
                    }
                })?;
            }
        }
        Ok(reached)
    }

    /// See [`ForwardModel::branches_degc`].
    pub(crate) fn branches_degc(&self, point: &[f64]) -> Option<[f64; 2]> {
        self.model.branches_degc(&self.vector.values(point, 0))
    }

    /// Simulates a recording at points, by their coordinates, and holds the model to its promise: every block
    /// shows all points, and the blocks together all samples in their order.
    fn simulate(
        &self,
        r: usize,
        points: &[Vec<f64>],
        visit: &mut dyn FnMut(Block<'_>),
    ) -> Result<(), IdentifyError> {
        let recording = self.recordings[r].recording;
        let values = |point: &Vec<f64>| self.vector.values(point, r);
        let points: Vec<Vec<f64>> = points.iter().map(values).collect();
        let mut shown = 0;
        let mut complete = true;
        self.model.simulate(&points, recording, &mut |block| {
            let rows = block.displacement.len() / block.stride.max(1);
            let fits = block.first_member == 0
                && (points.len()..=BATCH).contains(&block.stride)
                && block.members == points.len()
                && block.first_sample == shown
                && shown + rows <= recording.len()
                && block.temperature_degc.len() == block.displacement.len();
            complete &= fits;
            shown += rows;
            if complete {
                visit(block);
            }
        })?;
        if complete && shown == recording.len() {
            Ok(())
        } else {
            Err(IdentifyError::IncompleteBlocks {
                recording: recording.name().to_owned(),
                shown,
                expected: recording.len(),
            })
        }
    }

    /// Solves for gain and offsets at one point.
    pub(crate) fn solve_one(&self, point: &[f64]) -> Result<Solved, IdentifyError> {
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner);
        let known = latest.iter().find(|(solved, _)| solved == point);
        if let Some((_, solved)) = known {
            return Ok(solved.clone());
        }
        drop(latest);
        let Some(solved) = self.solve(&[point.to_vec()])?.pop() else {
            unreachable!("one point gives one solution");
        };
        Ok(solved)
    }

    /// Solves for gain and offsets at each point, and remembers them.
    pub(crate) fn solve(&self, points: &[Vec<f64>]) -> Result<Vec<Solved>, IdentifyError> {
        let solved = self.solve_once(points)?;
        self.remember(points, solved.clone());
        Ok(solved)
    }

    /// Solves for gain and offsets at each point. Results stand in the order of the points, whatever
    /// the number of threads.
    fn solve_once(&self, points: &[Vec<f64>]) -> Result<Vec<Solved>, IdentifyError> {
        self.count(points.len() as u64);
        let tasks: Vec<(usize, &[Vec<f64>])> = points
            .chunks(BATCH)
            .flat_map(|batch| (0..self.recordings.len()).map(move |r| (r, batch)))
            .collect();
        let moments = try_in_parallel(&tasks, |&(r, batch)| self.moments(r, batch))?;
        let n_recordings = self.recordings.len();
        Ok(self.solved(points, |p, r| {
            moments[p / BATCH * n_recordings + r][p % BATCH]
        }))
    }

    /// Gain and offsets at each point, from the moments of each point and recording.
    fn solved(
        &self,
        points: &[Vec<f64>],
        moments: impl Fn(usize, usize) -> Moments,
    ) -> Vec<Solved> {
        (0..points.len())
            .map(|p| {
                let of_point: Vec<Moments> =
                    (0..self.recordings.len()).map(|r| moments(p, r)).collect();
                solve_linear(&self.recordings, &of_point, self.gain, self.offset)
            })
            .collect()
    }

    fn remember(&self, points: &[Vec<f64>], solved: Vec<Solved>) {
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner) =
            points.iter().cloned().zip(solved).collect();
    }

    fn moments(&self, r: usize, batch: &[Vec<f64>]) -> Result<[Moments; BATCH], IdentifyError> {
        let weighed = &self.recordings[r];
        let mut moments = [Moments::default(); BATCH];
        self.simulate(r, batch, &mut |block| weighed.add(&mut moments, &block))?;
        Ok(moments)
    }

    /// Squares of the residuals.
    fn squares(&self, solved: &Solved) -> f64 {
        solved.output + self.temperature_weight * solved.temperature
    }

    fn sum_of_squares(&self, solved: &Solved, point: &[f64]) -> f64 {
        self.prior.sum(self.squares(solved), self.of_prior(point))
    }

    /// Shows the residuals of one recording with their derivatives, by central differences: sample
    /// after sample, the output before the temperature.
    pub(crate) fn rows(
        &self,
        r: usize,
        point: &[f64],
        solved: &Solved,
        visit: &mut dyn FnMut(&Row<'_>),
    ) -> Result<(), IdentifyError> {
        let batch = self.batch(r, &[point.to_vec()], 0, Sides::Both);
        self.simulate_around(r, &batch, solved, &mut |_| (), visit)
    }

    /// Simulates a recording at points, and shows its residuals and their derivatives at one of them.
    fn simulate_around(
        &self,
        r: usize,
        batch: &Batch,
        solved: &Solved,
        visit: &mut dyn FnMut(&Block<'_>),
        visit_row: &mut dyn FnMut(&Row<'_>),
    ) -> Result<(), IdentifyError> {
        let recording = self.recordings[r].recording;
        let around = batch.around;
        let (gains, linear) = (self.n_gains(), self.n_linear());
        let temperatures = self.temperatures_degc(r);
        let mut derivatives = vec![0.0; linear + self.vector.len()];
        let further = self.quotients(r, batch.further.as_deref())?;
        self.simulate(r, &batch.points, &mut |block| {
            visit(&block);
            let shapes = block.displacement.chunks_exact(block.stride);
            let shown = block.temperature_degc.chunks_exact(block.stride);
            for (row, (shapes, shown)) in shapes.zip(shown).enumerate() {
                let sample = block.first_sample + row;
                derivatives[..gains].fill(shapes[around]);
                if linear > gains {
                    derivatives[gains + r] = 1.0;
                }
                for difference in &batch.differences {
                    derivatives[linear + difference.coordinate] =
                        solved.gain * difference.quotient(shapes);
                }
                for known in &further {
                    derivatives[linear + known.coordinate] = solved.gain * known.output[sample];
                }
                let fitted = solved.gain * shapes[around] + solved.offsets[r];
                visit_row(&Row {
                    channel: Channel::Output,
                    sample,
                    derivatives: &derivatives,
                    residual: fitted - recording.output()[sample],
                });
                let Some(temperatures) = temperatures else {
                    continue;
                };
                derivatives[..linear].fill(0.0);
                for difference in &batch.differences {
                    derivatives[linear + difference.coordinate] = difference.quotient(shown);
                }
                for known in &further {
                    derivatives[linear + known.coordinate] = known.temperature[sample];
                }
                visit_row(&Row {
                    channel: Channel::Temperature,
                    sample,
                    derivatives: &derivatives,
                    residual: shown[around] - temperatures[sample],
                });
            }
        })
    }

    /// Difference quotients of a recording by the coordinates of a batch and of its further ones; none without one.
    fn quotients(&self, r: usize, batch: Option<&Batch>) -> Result<Vec<Quotients>, IdentifyError> {
        let Some(batch) = batch else {
            return Ok(Vec::new());
        };
        let mut all = self.quotients(r, batch.further.as_deref())?;
        let has_temperatures = self.temperatures_degc(r).is_some();
        let n_samples = self.recordings[r].recording.len();
        let of_difference = |difference: &Difference| Quotients {
            coordinate: difference.coordinate,
            output: Vec::with_capacity(n_samples),
            temperature: Vec::new(),
        };
        let mut own: Vec<Quotients> = batch.differences.iter().map(of_difference).collect();
        self.simulate(r, &batch.points, &mut |block| {
            let shapes = block.displacement.chunks_exact(block.stride);
            let shown = block.temperature_degc.chunks_exact(block.stride);
            for (shapes, shown) in shapes.zip(shown) {
                for (difference, known) in batch.differences.iter().zip(&mut own) {
                    known.output.push(difference.quotient(shapes));
                    if has_temperatures {
                        known.temperature.push(difference.quotient(shown));
                    }
                }
            }
        })?;
        all.append(&mut own);
        Ok(all)
    }

    /// Temperatures of a recording that count, °C.
    fn temperatures_degc(&self, r: usize) -> Option<&[f64]> {
        let recorded = self.recordings[r].recording.temperature_degc();
        recorded.filter(|_| self.temperature_weight > 0.0)
    }

    /// Some points, and others around one of them.
    fn batch(&self, r: usize, points: &[Vec<f64>], around: usize, sides: Sides) -> Batch {
        let acting: Vec<usize> = self.vector.acting_on(r).collect();
        Batch::new(&acting, &self.bounds, points, around, sides)
    }

    /// With the linear parameters' columns first, what stands below them in the triangular factor is
    /// the Jacobian of the problem *without* them: variable projection (Golub1973 in REFERENCES.md, in
    /// Kaufman's form) without projecting anything.
    fn linearized_by(
        &self,
        points: &[Vec<f64>],
        around: usize,
    ) -> Result<(Vec<f64>, Linearized), IdentifyError> {
        let batches: Vec<(usize, Batch)> = (0..self.recordings.len())
            .map(|r| (r, self.batch(r, points, around, Sides::One)))
            .collect();
        self.count(batches[0].1.n_points() as u64);
        let seen = try_in_parallel(&batches, |(r, batch)| self.seen(*r, batch))?;
        let solved = self.solved(points, |p, r| seen[r].moments[p]);
        let sums: Vec<f64> = solved
            .iter()
            .zip(points)
            .map(|(solved, point)| self.sum_of_squares(solved, point))
            .collect();
        let (linear, coordinates) = (self.n_linear(), self.vector.len());
        let last = linear + coordinates;
        let gain = match self.gain {
            ParameterState::Free => solved[around].gain,
            ParameterState::Fixed(_) => 1.0,
        };
        let mut whole = Triangle::new(last + 1);
        for seen in &seen {
            let [output, temperature] = &seen.triangles;
            let of = |triangle: &Matrix, row: usize, column: usize| {
                let places = seen.places[row].zip(seen.places[column]);
                places.map_or(0.0, |place| triangle[place])
            };
            for row in 0..=last {
                whole.push(|column| {
                    let is_derivative = (linear..last).contains(&column);
                    of(output, row, column) * if is_derivative { gain } else { 1.0 }
                });
                whole.push(|column| of(temperature, row, column));
            }
        }
        let (prior_rows, variance) = self.prior_rows(&solved[around]);
        let root = variance.sqrt();
        for row in prior_rows {
            let value = row.value(&points[around]);
            whole.push(|column| {
                let coordinate = column.checked_sub(linear);
                root * match coordinate {
                    _ if column == last => value,
                    Some(coordinate) => row.derivative(coordinate),
                    None => 0.0,
                }
            });
        }
        let r = whole.r();
        let linearized = Linearized {
            jacobian: r
                .view((linear, linear), (coordinates, coordinates))
                .into_owned(),
            residual: (linear..last).map(|row| r[(row, last)]).collect(),
            sum_of_squares: sums[around],
        };
        self.remember(points, solved);
        Ok((sums, linearized))
    }

    /// Contribution of one recording: moments at the points, derivatives around one of them.
    fn seen(&self, r: usize, batch: &Batch) -> Result<Seen, IdentifyError> {
        let weighed = &self.recordings[r];
        let mut moments = [Moments::default(); BATCH];
        // What belongs to another recording does nothing here.
        let (gains, linear) = (self.n_gains(), self.n_linear());
        let last = linear + self.vector.len();
        let own_offset = (linear > gains).then_some(gains + r);
        let acting = self.vector.acting_on(r).map(|j| linear + j);
        let kept: Vec<usize> = (0..gains)
            .chain(own_offset)
            .chain(acting)
            .chain([last])
            .collect();
        let mut places = vec![None; last + 1];
        for (place, &column) in kept.iter().enumerate() {
            places[column] = Some(place);
        }
        let mut triangles = [Triangle::new(kept.len()), Triangle::new(kept.len())];
        // Gain and offsets are known after the run only. A residual with others differs by what the columns of the
        // free ones take away, and derivatives of the output by the gain.
        let solved = Solved {
            gain: match self.gain {
                ParameterState::Free => 1.0,
                ParameterState::Fixed(gain) => gain,
            },
            offsets: vec![
                match self.offset {
                    ParameterState::Free => weighed.mean(),
                    ParameterState::Fixed(offset) => offset,
                };
                self.recordings.len()
            ],
            output: 0.0,
            temperature: 0.0,
        };
        self.simulate_around(
            r,
            batch,
            &solved,
            &mut |block| weighed.add(&mut moments, block),
            &mut |row| {
                let root = self.weight(r, row).sqrt();
                triangles[row.channel as usize].push(|place| {
                    root * match kept[place] {
                        column if column == last => row.residual,
                        column => row.derivative(column),
                    }
                });
            },
        )?;
        let triangles = triangles.map(Triangle::r);
        Ok(Seen {
            moments,
            triangles,
            places,
        })
    }
}

/// Contribution of one recording: moments at the points, derivatives around one of them.
#[derive(Debug)]
struct Seen {
    moments: [Moments; BATCH],
    /// Triangular factors of the weighted rows of output and temperature: linear parameters, coordinates, residual, but for those
    /// that belong to other recordings.
    triangles: [Matrix; 2],
    /// Places in these of all columns.
    places: Vec<Option<usize>>,
}

impl SumOfSquares for Problem<'_> {
    fn linearized(
        &self,
        points: &[Vec<f64>],
        around: usize,
    ) -> Result<(Vec<f64>, Linearized), IdentifyError> {
        if points.len() > 1 && points.len() + self.vector.acting_on(0).count() > BATCH {
            let sums = self.sums(points)?;
            return Ok((sums, self.linearize(&points[around])?));
        }
        self.linearized_by(points, around)
    }

    fn n_derivatives(&self) -> usize {
        let acting = (0..self.recordings.len()).map(|r| self.vector.acting_on(r).count());
        acting.max().unwrap_or(0)
    }

    /// The moments' products cancel to some 1e-16 of the spread; a hundred times that is safe.
    fn rounding(&self) -> f64 {
        1e-14 * self.spread()
    }

    fn sums(&self, points: &[Vec<f64>]) -> Result<Vec<f64>, IdentifyError> {
        // Of a swarm's points none is asked for again.
        Ok(self
            .solve_once(points)?
            .iter()
            .zip(points)
            .map(|(solved, point)| self.sum_of_squares(solved, point))
            .collect())
    }
}

/// How the one parameter that enters as `enters` is known; absent, it is fixed.
fn linear_state(
    model: &dyn ForwardModel,
    enters: Enters,
    scope: Scope,
    absent: f64,
) -> Result<ParameterState, IdentifyError> {
    let mut found = model
        .parameters()
        .iter()
        .filter(|info| info.enters == enters);
    let Some(info) = found.next() else {
        return Ok(ParameterState::Fixed(absent));
    };
    let is_free = info.state == ParameterState::Free;
    if found.next().is_some() || (is_free && info.scope != scope) {
        return Err(IdentifyError::NotSolvable { name: info.name });
    }
    Ok(info.state)
}
