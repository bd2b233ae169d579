//! Differences by the coordinates, taken in the lanes beside the points themselves.

use pso::Bound;

use crate::moments::BATCH;

/// Step of a difference as a share of the coordinate's range: near the cube root of rounding, which is best for a
/// central one. One-sided ones are then off by the size of the step, and a search ends nowhere else for that.
const DIFFERENCE: f64 = 1e-6;

/// Sides on which a difference looks.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Sides {
    Both,
    /// Half of the points, good enough to search by.
    One,
}

/// Points that are simulated together, and differences around one of them.
#[derive(Debug)]
pub(crate) struct Batch {
    pub(crate) points: Vec<Vec<f64>>,
    pub(crate) around: usize,
    pub(crate) differences: Vec<Difference>,
    /// Differences by the coordinates for which there were no lanes left, around the same point.
    pub(crate) further: Option<Box<Batch>>,
}

impl Batch {
    /// Some points and what differences by the acting coordinates take around one of them. At a bound they are
    /// one-sided, between equal bounds there is none. Central ones are so for as many coordinates of a batch, from its first, as it has
    /// lanes for. Coordinates beyond the lanes go to `further`, around the same point.
    pub(crate) fn new(
        acting: &[usize],
        bounds: &[Bound],
        points: &[Vec<f64>],
        around: usize,
        sides: Sides,
    ) -> Self {
        let lanes = BATCH.saturating_sub(points.len());
        let (acting, others) = acting.split_at(acting.len().min(lanes));
        let further = (!others.is_empty()).then(|| {
            let center = std::slice::from_ref(&points[around]);
            Box::new(Self::new(others, bounds, center, 0, sides))
        });
        let center = &points[around];
        let mut points = points.to_vec();
        let mut differences = Vec::new();
        let mut to_spare = BATCH.saturating_sub(points.len() + acting.len());
        for &j in acting {
            let bound = &bounds[j];
            let range = bound.upper - bound.lower;
            let steps = match sides {
                Sides::Both if to_spare > 0 => {
                    to_spare -= 1;
                    [-DIFFERENCE, DIFFERENCE]
                }
                _ if center[j] + DIFFERENCE * range <= bound.upper => [0.0, DIFFERENCE],
                _ => [-DIFFERENCE, 0.0],
            };
            let mut ends = [center[j]; 2];
            let mut lanes = [around; 2];
            for side in 0..2 {
                if steps[side] != 0.0 {
                    ends[side] = (center[j] + steps[side] * range).clamp(bound.lower, bound.upper);
                    lanes[side] = points.len();
                    let mut moved = center.clone();
                    moved[j] = ends[side];
                    points.push(moved);
                }
            }
            let distance = ends[1] - ends[0];
            differences.push(Difference {
                coordinate: j,
                lanes,
                per_distance: if distance > 0.0 { 1.0 / distance } else { 0.0 },
            });
        }
        Self {
            points,
            around,
            differences,
            further,
        }
    }

    /// Points of this batch and of its further ones.
    pub(crate) fn n_points(&self) -> usize {
        let further = self.further.as_deref().map_or(0, Self::n_points);
        self.points.len() + further
    }
}

/// A difference by one coordinate.
#[derive(Debug)]
pub(crate) struct Difference {
    pub(crate) coordinate: usize,
    /// Points at its lower and its upper end.
    lanes: [usize; 2],
    /// 1 over the distance of these.
    per_distance: f64,
}

impl Difference {
    #[inline(always)]
    pub(crate) fn quotient(&self, row: &[f64]) -> f64 {
        (row[self.lanes[1]] - row[self.lanes[0]]) * self.per_distance
    }
}
