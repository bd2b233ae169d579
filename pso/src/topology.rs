use crate::SwarmError;

/// Who tells whom of its best point.
///
/// A particle is drawn to the best point among its informers, itself included. Of equal costs the
/// particle with the lower index counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Topology {
    /// Everybody informs everybody ("gbest"): fast, and all of it settles where one particle is lowest.
    Global,
    /// Particles sit in a ring in index order ("lbest"): good news takes many moves around it. Slower,
    /// wider search.
    Ring {
        /// Informers on each side; >= 1. From (particles − 1)/2 on, where the ring reaches around, this
        /// is `Global`.
        neighbors: usize,
    },
}

impl Topology {
    /// Index of the best informer of each particle.
    pub(crate) fn informers(self, costs: &[f64]) -> Vec<usize> {
        let n_particles = costs.len();
        match self {
            Self::Ring { neighbors } if neighbors < n_particles.saturating_sub(1).div_ceil(2) => {
                (0..n_particles)
                    .map(|particle| {
                        let first = particle + n_particles - neighbors;
                        let mut around: Vec<usize> = (first..=first + 2 * neighbors)
                            .map(|i| i % n_particles)
                            .collect();
                        // Index order, for the tie rule.
                        around.sort_unstable();
                        lowest(around.into_iter(), costs)
                    })
                    .collect()
            }
            Self::Global | Self::Ring { .. } => vec![lowest(0..n_particles, costs); n_particles],
        }
    }

    pub(crate) fn check(self) -> Result<(), SwarmError> {
        match self {
            Self::Ring { neighbors: 0 } => Err(SwarmError::ZeroCount {
                name: "topology.neighbors",
            }),
            Self::Global | Self::Ring { .. } => Ok(()),
        }
    }
}

/// The candidate of the lowest cost, the first of equals; 0 if there is no candidate.
pub(crate) fn lowest(mut candidates: impl Iterator<Item = usize>, costs: &[f64]) -> usize {
    let first = candidates.next().unwrap_or(0);
    candidates.fold(
        first,
        |best, i| if costs[i] < costs[best] { i } else { best },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn global_informer_is_the_lowest_and_first() {
        assert_eq!(
            Topology::Global.informers(&[3.0, 1.0, 2.0, 1.0]),
            [1, 1, 1, 1]
        );
    }

    #[test]
    fn ring_informers_are_the_neighbors() {
        let costs = [5.0, 4.0, 3.0, 2.0, 1.0, 6.0];
        let ring = Topology::Ring { neighbors: 1 };
        assert_eq!(ring.informers(&costs), [1, 2, 3, 4, 4, 4]);
    }

    #[test]
    fn ring_tie_goes_to_the_lower_index_across_the_seam() {
        let ring = Topology::Ring { neighbors: 1 };
        assert_eq!(ring.informers(&[1.0; 5]), [0, 0, 1, 2, 0]);
    }

    #[test]
    fn ring_of_ten_leaves_out_one_of_22() {
        // The lowest cost is known to all but the particle across.
        let ring = Topology::Ring { neighbors: 10 };
        for n_particles in [1, 2, 20, 21, 22] {
            let mut costs = vec![1.0; n_particles];
            costs[0] = 0.0;
            let mut expected = vec![0; n_particles];
            if n_particles == 22 {
                expected[11] = 1;
            }
            assert_eq!(ring.informers(&costs), expected, "{n_particles}");
        }
    }

    #[test]
    fn wide_ring_is_global() {
        let costs = [5.0, 4.0, 3.0, 2.0, 1.0];
        for neighbors in [2, 3, 4, 5, 100, usize::MAX] {
            assert_eq!(Topology::Ring { neighbors }.informers(&costs), [4; 5]);
        }
        assert_eq!(Topology::Ring { neighbors: 1 }.informers(&[1.0]), [0]);
        assert_eq!(
            Topology::Ring { neighbors: 1 }.informers(&[2.0, 1.0]),
            [1, 1]
        );
    }
}
