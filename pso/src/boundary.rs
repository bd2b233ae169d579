use crate::bound::Bound;

/// Boundary condition: treatment of one coordinate of a particle that would leave its bounds.
///
/// The other coordinates of the particle are left alone. The names and an experimental comparison
/// are in [`Helwig2013`](crate#references).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Boundary {
    /// Position: on the bound. Velocity: zero.
    Absorb,
    /// Position: mirrored at the bound, as often as it takes to be inside. Velocity: its sign changes
    /// with every mirroring, its size is kept.
    Reflect,
    /// Position: drawn anew, uniform in the range. Velocity: zero.
    ///
    /// The number is drawn (after r1 and r2) whether it is needed or not, so that the sequence of
    /// random numbers does not depend on where particles fly.
    Random,
    /// Position: enters at the opposite bound and goes on, as often as it takes. Velocity: kept.
    ///
    /// For angles and phases. The pulls toward the best points are not wrapped: they take the way
    /// through the range.
    Periodic,
}

/// Position and velocity of one coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    pub(crate) position: f64,
    pub(crate) velocity: f64,
}

impl Boundary {
    /// Brings a finite step inside; `spare` is the third random number, used by `Random` only.
    pub(crate) fn confine(self, step: Step, bound: Bound, spare: f64) -> Step {
        if bound.contains(step.position) {
            return step;
        }
        let Step { position, velocity } = step;
        match self {
            Self::Absorb => Step {
                position: position.clamp(bound.lower, bound.upper),
                velocity: 0.0,
            },
            Self::Reflect => {
                let range = bound.range();
                let unfolded = (position - bound.lower).rem_euclid(2.0 * range);
                let (offset, velocity) = if unfolded > range {
                    (2.0 * range - unfolded, -velocity)
                } else {
                    (unfolded, velocity)
                };
                // Rounding of the sum may end a hair outside.
                Step {
                    position: (bound.lower + offset).clamp(bound.lower, bound.upper),
                    velocity,
                }
            }
            Self::Random => Step {
                position: bound.at(spare),
                velocity: 0.0,
            },
            Self::Periodic => {
                let offset = (position - bound.lower).rem_euclid(bound.range());
                Step {
                    position: (bound.lower + offset).clamp(bound.lower, bound.upper),
                    velocity,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    const BOUND: Bound = Bound {
        lower: -1.0,
        upper: 3.0,
    };

    fn confined(boundary: Boundary, position: f64, velocity: f64) -> [f64; 2] {
        let step = boundary.confine(Step { position, velocity }, BOUND, 0.25);
        [step.position, step.velocity]
    }

    #[track_caller]
    fn assert_close(found: [f64; 2], expected: [f64; 2]) {
        assert_abs_diff_eq!(found[0], expected[0], epsilon = 1e-12);
        assert_abs_diff_eq!(found[1], expected[1], epsilon = 1e-12);
    }

    #[test]
    fn inside_and_on_the_bounds_nothing_changes() {
        for boundary in [
            Boundary::Absorb,
            Boundary::Reflect,
            Boundary::Random,
            Boundary::Periodic,
        ] {
            for position in [-1.0, 0.5, 3.0] {
                assert_close(confined(boundary, position, 0.7), [position, 0.7]);
            }
        }
    }

    #[test]
    fn absorb_stops_on_the_bound() {
        assert_close(confined(Boundary::Absorb, 3.5, 0.7), [3.0, 0.0]);
        assert_close(confined(Boundary::Absorb, -9.0, -0.7), [-1.0, 0.0]);
    }

    #[test]
    fn reflect_mirrors_position_and_turns_velocity() {
        assert_close(confined(Boundary::Reflect, 3.5, 0.7), [2.5, -0.7]);
        assert_close(confined(Boundary::Reflect, -1.5, -0.7), [-0.5, 0.7]);
        // Two mirrorings: at 3, then at −1.
        assert_close(confined(Boundary::Reflect, 7.5, 9.0), [-0.5, 9.0]);
        // Three.
        assert_close(confined(Boundary::Reflect, 11.5, 9.0), [2.5, -9.0]);
    }

    #[test]
    fn random_takes_the_spare_number_and_stops() {
        assert_close(confined(Boundary::Random, 3.5, 0.7), [0.0, 0.0]);
    }

    #[test]
    fn periodic_wraps_and_keeps_velocity() {
        assert_close(confined(Boundary::Periodic, 3.5, 0.7), [-0.5, 0.7]);
        assert_close(confined(Boundary::Periodic, -1.5, -0.7), [2.5, -0.7]);
        assert_close(confined(Boundary::Periodic, 11.5, 9.0), [-0.5, 9.0]);
    }
}
