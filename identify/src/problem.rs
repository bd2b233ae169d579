//! The sum of squares of several recordings together, gain and offsets solved for.

use pso::Bound;
use rayon::prelude::*;
use recording::Recording;
use wiener::{Block, widest_vectors};

use crate::factor::Triangle;
use crate::least_squares::{Linearized, SumOfSquares};
use crate::{Enters, ForwardModel, IdentifyError, ParameterState, ParameterVector};

/// Points simulated together by one thread: the lanes of a full chunk.
const BATCH: usize = 32;

/// Step of a central difference as a share of the coordinate's range: its cube root of rounding.
const DIFFERENCE: f64 = 1e-6;

/// Gain and offsets that fit best at one point, and what is left.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Solved {
    pub(crate) gain: f64,
    /// One a recording.
    pub(crate) offsets: Vec<f64>,
    pub(crate) sum_of_squares: f64,
}

/// Moments of the shape f and the output y of one recording; y from its mean.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    f: f64,
    ff: f64,
    fy: f64,
}

#[derive(Debug)]
pub(crate) struct Problem<'a, M> {
    model: &'a M,
    recordings: &'a [Recording],
    vector: ParameterVector,
    bounds: Vec<Bound>,
    /// Mean of each output.
    means: Vec<f64>,
    /// Σ (y - mean)² of each.
    spreads: Vec<f64>,
    gain: ParameterState,
    offset: ParameterState,
}

impl<'a, M: ForwardModel> Problem<'a, M> {
    pub(crate) fn new(model: &'a M, recordings: &'a [Recording]) -> Result<Self, IdentifyError> {
        let vector = ParameterVector::new(model.parameters(), recordings.len());
        if vector.is_empty() {
            return Err(IdentifyError::NothingFree);
        }
        // A central difference takes two lanes a coordinate beside the point itself.
        let most = (BATCH - 1) / 2;
        let found = vector.acting_on(0).count();
        if found > most {
            return Err(IdentifyError::TooManyParameters { found, most });
        }
        let state = |enters, absent| {
            let info = model.parameters().iter().find(|info| info.enters == enters);
            info.map_or(ParameterState::Fixed(absent), |info| info.state)
        };
        let means: Vec<f64> = recordings
            .iter()
            .map(|recording| recording.output().iter().sum::<f64>() / recording.len() as f64)
            .collect();
        let spreads = recordings
            .iter()
            .zip(&means)
            .map(|(recording, mean)| recording.output().iter().map(|y| (y - mean).powi(2)).sum())
            .collect();
        Ok(Self {
            model,
            recordings,
            bounds: vector.bounds(),
            vector,
            means,
            spreads,
            gain: state(Enters::Gain, 1.0),
            offset: state(Enters::Offset, 0.0),
        })
    }

    pub(crate) fn vector(&self) -> &ParameterVector {
        &self.vector
    }

    pub(crate) fn bounds(&self) -> &[Bound] {
        &self.bounds
    }

    pub(crate) fn n_samples(&self) -> usize {
        self.recordings.iter().map(Recording::len).sum()
    }

    /// Σ (y - mean)² over all recordings, each about its own mean.
    pub(crate) fn spread(&self) -> f64 {
        self.spreads.iter().sum()
    }

    /// Sum of squares of one recording at a point with its gain and offsets.
    pub(crate) fn sum_of_squares_of(
        &self,
        r: usize,
        point: &[f64],
        solved: &Solved,
    ) -> Result<f64, IdentifyError> {
        let recording = &self.recordings[r];
        let mut sum = 0.0;
        self.model
            .simulate(&[self.vector.values(point, r)], recording, &mut |block| {
                let shapes = block.displacement.iter().step_by(block.stride);
                for (f, y) in shapes.zip(&recording.output()[block.first_sample..]) {
                    sum += (y - solved.gain * f - solved.offsets[r]).powi(2);
                }
            })?;
        Ok(sum)
    }

    /// Solves for gain and offsets at each point. Results stand in the order of the points, whatever
    /// the number of threads.
    pub(crate) fn solve(&self, points: &[Vec<f64>]) -> Result<Vec<Solved>, IdentifyError> {
        let tasks: Vec<(usize, &[Vec<f64>])> = points
            .chunks(BATCH)
            .flat_map(|batch| (0..self.recordings.len()).map(move |r| (r, batch)))
            .collect();
        let moments = tasks
            .par_iter()
            .map(|&(r, batch)| self.moments(r, batch))
            .collect::<Result<Vec<_>, _>>()?;
        let n_recordings = self.recordings.len();
        Ok((0..points.len())
            .map(|p| {
                let of_point: Vec<Moments> = (0..n_recordings)
                    .map(|r| moments[p / BATCH * n_recordings + r][p % BATCH])
                    .collect();
                self.solve_linear(&of_point)
            })
            .collect())
    }

    fn moments(&self, r: usize, batch: &[Vec<f64>]) -> Result<Vec<Moments>, IdentifyError> {
        let recording = &self.recordings[r];
        let values: Vec<Vec<f64>> = batch
            .iter()
            .map(|point| self.vector.values(point, r))
            .collect();
        let mean = self.means[r];
        let mut moments = [Moments::default(); BATCH];
        self.model.simulate(&values, recording, &mut |block| {
            let output = &recording.output()[block.first_sample..];
            let lanes = &mut moments[block.first_member..];
            widest_vectors(
                #[inline(always)]
                || add_moments(lanes, &block, output, mean),
            );
        })?;
        Ok(moments[..batch.len()].to_vec())
    }

    /// min Σ (y - gain f - offset)² over gain and offsets, in closed form.
    fn solve_linear(&self, moments: &[Moments]) -> Solved {
        // Sums over all recordings of products of f and y, each from its mean where the offset is
        // free, from the fixed offset otherwise.
        let (mut ff, mut fy, mut yy) = (0.0, 0.0, 0.0);
        for (r, m) in moments.iter().enumerate() {
            let n = self.recordings[r].len() as f64;
            match self.offset {
                ParameterState::Free => {
                    ff += m.ff - m.f * m.f / n;
                    fy += m.fy;
                    yy += self.spreads[r];
                }
                ParameterState::Fixed(offset) => {
                    let shift = self.means[r] - offset;
                    ff += m.ff;
                    fy += m.fy + shift * m.f;
                    yy += self.spreads[r] + n * shift * shift;
                }
            }
        }
        let gain = match self.gain {
            ParameterState::Fixed(gain) => gain,
            // A shape that never moves explains nothing.
            ParameterState::Free if ff > 0.0 => fy / ff,
            ParameterState::Free => 0.0,
        };
        let offsets = moments
            .iter()
            .enumerate()
            .map(|(r, m)| match self.offset {
                ParameterState::Free => {
                    self.means[r] - gain * m.f / self.recordings[r].len() as f64
                }
                ParameterState::Fixed(offset) => offset,
            })
            .collect();
        Solved {
            gain,
            offsets,
            sum_of_squares: (yy - 2.0 * gain * fy + gain * gain * ff).max(0.0),
        }
    }

    /// Adds the rows of one recording to the factor of [linear columns | Jacobian | residual].
    fn add_rows(
        &self,
        triangle: &mut Triangle,
        point: &[f64],
        solved: &Solved,
        r: usize,
    ) -> Result<(), IdentifyError> {
        let recording = &self.recordings[r];
        let acting: Vec<usize> = self.vector.acting_on(r).collect();
        let mut batch = vec![point.to_vec()];
        let mut distances = Vec::with_capacity(acting.len());
        for &j in &acting {
            let bound = &self.bounds[j];
            let step = DIFFERENCE * (bound.upper - bound.lower);
            let ends = [-step, step].map(|step| (point[j] + step).clamp(bound.lower, bound.upper));
            distances.push(ends[1] - ends[0]);
            batch.extend(ends.map(|end| {
                let mut moved = point.to_vec();
                moved[j] = end;
                moved
            }));
        }
        let values: Vec<Vec<f64>> = batch
            .iter()
            .map(|point| self.vector.values(point, r))
            .collect();
        let columns = self.columns(r);
        let mut derivative = vec![0.0; self.vector.len()];
        self.model.simulate(&values, recording, &mut |block| {
            for (row, shapes) in block.displacement.chunks_exact(block.stride).enumerate() {
                let y = recording.output()[block.first_sample + row];
                for (k, &j) in acting.iter().enumerate() {
                    derivative[j] =
                        solved.gain * (shapes[2 + 2 * k] - shapes[1 + 2 * k]) / distances[k];
                }
                let residual = solved.gain * shapes[0] + solved.offsets[r] - y;
                triangle.push(|column| columns.value(column, shapes[0], &derivative, residual));
            }
        })
    }

    /// Where the linear parameters stand in a row of recording `r`.
    fn columns(&self, r: usize) -> Columns {
        let gains = usize::from(self.gain == ParameterState::Free);
        let offsets = match self.offset {
            ParameterState::Free => self.recordings.len(),
            ParameterState::Fixed(_) => 0,
        };
        Columns {
            gains,
            linear: gains + offsets,
            own_offset: gains + r,
            coordinates: self.vector.len(),
        }
    }
}

struct Columns {
    gains: usize,
    linear: usize,
    own_offset: usize,
    coordinates: usize,
}

impl Columns {
    fn value(&self, column: usize, shape: f64, derivative: &[f64], residual: f64) -> f64 {
        if column < self.gains {
            shape
        } else if column < self.linear {
            f64::from(u8::from(column == self.own_offset))
        } else if column < self.linear + self.coordinates {
            derivative[column - self.linear]
        } else {
            residual
        }
    }
}

impl<M: ForwardModel> SumOfSquares for Problem<'_, M> {
    /// With the linear parameters' columns first, what stands below them in the triangular factor is
    /// the Jacobian of the problem *without* them: variable projection (Golub1973 in REFERENCES.md, in
    /// Kaufman's form) without projecting anything.
    fn linearize(&self, point: &[f64]) -> Result<Linearized, IdentifyError> {
        let mut solved = self.solve(&[point.to_vec()])?;
        let Some(solved) = solved.pop() else {
            unreachable!("one point gives one solution");
        };
        let Columns {
            linear,
            coordinates,
            ..
        } = self.columns(0);
        let triangles = (0..self.recordings.len())
            .into_par_iter()
            .map(|r| {
                let mut triangle = Triangle::new(linear + coordinates + 1);
                self.add_rows(&mut triangle, point, &solved, r)?;
                Ok(triangle.r())
            })
            .collect::<Result<Vec<_>, IdentifyError>>()?;
        let mut whole = Triangle::new(linear + coordinates + 1);
        for part in &triangles {
            for row in 0..part.nrows() {
                whole.push(|column| part[(row, column)]);
            }
        }
        let r = whole.r();
        Ok(Linearized {
            jacobian: r
                .get(linear..linear + coordinates, linear..linear + coordinates)
                .to_owned(),
            residual: (linear..linear + coordinates)
                .map(|row| r[(row, linear + coordinates)])
                .collect(),
            sum_of_squares: solved.sum_of_squares,
        })
    }

    /// The moments' products cancel to some 1e-16 of the spread; a hundred times that is safe.
    fn rounding(&self) -> f64 {
        1e-14 * self.spread()
    }

    fn sums(&self, points: &[Vec<f64>]) -> Result<Vec<f64>, IdentifyError> {
        Ok(self
            .solve(points)?
            .into_iter()
            .map(|solved| solved.sum_of_squares)
            .collect())
    }
}

#[inline(always)]
fn add_moments(moments: &mut [Moments], block: &Block<'_>, output: &[f64], mean: f64) {
    let mut sums = [[0.0; BATCH]; 3];
    for (shapes, y) in block.displacement.chunks_exact(block.stride).zip(output) {
        let y = y - mean;
        for (l, &f) in shapes.iter().enumerate().take(BATCH) {
            sums[0][l] += f;
            sums[1][l] += f * f;
            sums[2][l] += f * y;
        }
    }
    for l in 0..block.members {
        moments[l].f += sums[0][l];
        moments[l].ff += sums[1][l];
        moments[l].fy += sums[2][l];
    }
}
