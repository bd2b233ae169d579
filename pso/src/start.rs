use crate::SwarmError;
use crate::bound::Bound;
use crate::uniform::{index, unit};
use rand::Rng;

/// Where the particles start.
///
/// Start velocities are those of the standard swarm of 2011 [`Clerc2012`](crate#references), then cut to
/// the velocity limit:
///
/// ```text
/// v = u − x,   u uniform in the range
/// ```
///
/// All positions are drawn before all velocities; `Uniform` and the velocities particle by particle,
/// the Latin hypercube coordinate by coordinate.
#[derive(Debug, Clone, PartialEq)]
pub enum Start {
    /// Every coordinate uniform in its range.
    Uniform,
    /// Latin hypercube [`McKay1979`](crate#references): each range is cut into as many strata as
    /// there are particles, and each stratum holds one particle.
    LatinHypercube,
    /// The first particles start at these points, for example at an earlier result; the others as in
    /// a `LatinHypercube` of the whole swarm.
    ///
    /// At most as many points as particles, each as long as the bounds and inside them. Velocities
    /// are drawn as for all particles, so that a given point is a start and not a resting place.
    Given(Vec<Vec<f64>>),
}

impl Start {
    pub(crate) fn check(&self, particles: usize, bounds: &[Bound]) -> Result<(), SwarmError> {
        let Self::Given(points) = self else {
            return Ok(());
        };
        if points.len() > particles {
            return Err(SwarmError::TooManyStarts {
                count: points.len(),
                particles,
            });
        }
        for (point, values) in points.iter().enumerate() {
            if values.len() != bounds.len() {
                let (length, coordinates) = (values.len(), bounds.len());
                return Err(SwarmError::StartLength {
                    point,
                    length,
                    coordinates,
                });
            }
            for (coordinate, (&value, bound)) in values.iter().zip(bounds).enumerate() {
                if !bound.contains(value) {
                    let Bound { lower, upper } = *bound;
                    return Err(SwarmError::StartOutside {
                        point,
                        coordinate,
                        value,
                        lower,
                        upper,
                    });
                }
            }
        }
        Ok(())
    }

    /// Draws the start positions; the start and the bounds are checked.
    pub(crate) fn positions<R: Rng>(
        &self,
        particles: usize,
        bounds: &[Bound],
        generator: &mut R,
    ) -> Vec<Vec<f64>> {
        match self {
            Self::Uniform => (0..particles)
                .map(|_| {
                    bounds
                        .iter()
                        .map(|bound| bound.at(unit(generator)))
                        .collect()
                })
                .collect(),
            Self::LatinHypercube => latin_hypercube(particles, bounds, generator),
            Self::Given(points) => {
                let mut positions = latin_hypercube(particles, bounds, generator);
                positions[..points.len()].clone_from_slice(points);
                positions
            }
        }
    }
}

fn latin_hypercube<R: Rng>(particles: usize, bounds: &[Bound], generator: &mut R) -> Vec<Vec<f64>> {
    let mut positions = vec![vec![0.0; bounds.len()]; particles];
    let mut strata: Vec<usize> = Vec::with_capacity(particles);
    for (coordinate, bound) in bounds.iter().enumerate() {
        strata.clear();
        strata.extend(0..particles);
        // Fisher and Yates, from the end.
        for last in (1..particles).rev() {
            strata.swap(last, index(generator, last + 1));
        }
        for (position, &stratum) in positions.iter_mut().zip(&strata) {
            let fraction = (stratum as f64 + unit(generator)) / particles as f64;
            position[coordinate] = bound.at(fraction);
        }
    }
    positions
}

/// Draws the start velocities, each the way to a uniform point.
pub(crate) fn velocities<R: Rng>(
    positions: &[Vec<f64>],
    bounds: &[Bound],
    generator: &mut R,
) -> Vec<Vec<f64>> {
    positions
        .iter()
        .map(|position| {
            bounds
                .iter()
                .zip(position)
                .map(|(bound, x)| bound.at(unit(generator)) - x)
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn latin_hypercube_fills_each_stratum_once() {
        let bounds = [
            Bound {
                lower: 0.0,
                upper: 20.0,
            },
            Bound {
                lower: -20.0,
                upper: 0.0,
            },
        ];
        let mut generator = ChaCha8Rng::seed_from_u64(3);
        let positions = Start::LatinHypercube.positions(20, &bounds, &mut generator);
        for (coordinate, bound) in bounds.iter().enumerate() {
            let mut strata: Vec<i64> = positions
                .iter()
                .map(|x| (x[coordinate] - bound.lower).floor() as i64)
                .collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..20).collect::<Vec<i64>>());
        }
    }
}
