use crate::SwarmError;

/// Largest accepted magnitude of a bound: far below `f64::MAX` (1.8e308), so that a range, or a
/// pull times a weight, does not overflow.
const LARGEST_BOUND: f64 = 1e300;

/// Range of one coordinate, both ends included.
///
/// Equal ends fix the coordinate: it never moves, and the random numbers of the others are the ones
/// they would have had if it had been free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bound {
    /// Smallest value; finite, at most 1e300 in magnitude.
    pub lower: f64,
    /// Largest value; finite, at most 1e300 in magnitude, >= `lower`.
    pub upper: f64,
}

impl Bound {
    /// Length of the range.
    pub(crate) fn range(self) -> f64 {
        self.upper - self.lower
    }

    /// The point a fraction 0..1 along the range; rounding does not carry it outside.
    #[must_use]
    pub fn at(self, fraction: f64) -> f64 {
        (self.lower + fraction * self.range()).clamp(self.lower, self.upper)
    }

    /// True if a value lies in the range; false for NaN.
    pub(crate) fn contains(self, value: f64) -> bool {
        value >= self.lower && value <= self.upper
    }
}

/// Checks the bounds of a search.
pub(crate) fn check(bounds: &[Bound]) -> Result<(), SwarmError> {
    if bounds.is_empty() {
        return Err(SwarmError::NoCoordinates);
    }
    for (coordinate, bound) in bounds.iter().enumerate() {
        for (side, value) in [("lower", bound.lower), ("upper", bound.upper)] {
            if value.abs() <= LARGEST_BOUND {
                continue;
            }
            let limit = LARGEST_BOUND;
            return Err(SwarmError::BoundNotFinite {
                coordinate,
                side,
                value,
                limit,
            });
        }
        if bound.lower > bound.upper {
            let Bound { lower, upper } = *bound;
            return Err(SwarmError::BoundsInverted {
                coordinate,
                lower,
                upper,
            });
        }
    }
    Ok(())
}
