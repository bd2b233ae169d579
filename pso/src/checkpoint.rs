use crate::SwarmError;
use crate::bound::Bound;
use crate::config::SwarmConfig;

/// Everything of a swarm that changes: resuming from it goes on bit for bit.
///
/// It does not hold the configuration and the bounds: pass the same ones to
/// [`Swarm::resume`](crate::Swarm::resume) (or others of the same size, and the search goes on under
/// them). With feature `serde` it goes to any format that knows 64-bit unsigned integers: numbers are
/// stored as the bits of the `f64`, since text formats lose infinities and some lose last digits.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Checkpoint<R> {
    pub(crate) generator: R,
    /// Positions to be evaluated next.
    #[cfg_attr(feature = "serde", serde(with = "crate::bits::rows"))]
    pub(crate) positions: Vec<Vec<f64>>,
    #[cfg_attr(feature = "serde", serde(with = "crate::bits::rows"))]
    pub(crate) velocities: Vec<Vec<f64>>,
    #[cfg_attr(feature = "serde", serde(with = "crate::bits::rows"))]
    pub(crate) best_positions: Vec<Vec<f64>>,
    /// +∞ for a particle that has had no cost below it.
    #[cfg_attr(feature = "serde", serde(with = "crate::bits::row"))]
    pub(crate) best_costs: Vec<f64>,
    /// Best cost of the swarm after each evaluation of it.
    #[cfg_attr(feature = "serde", serde(with = "crate::bits::row"))]
    pub(crate) history: Vec<f64>,
    /// Product of the damping factors of all moves.
    #[cfg_attr(feature = "serde", serde(with = "crate::bits::number"))]
    pub(crate) damping: f64,
    pub(crate) rejected_costs: u64,
}

impl<R> Checkpoint<R> {
    /// Checks what the moves rely on; the configuration and the bounds are checked.
    pub(crate) fn check(&self, config: &SwarmConfig, bounds: &[Bound]) -> Result<(), SwarmError> {
        expect_length("best_costs", self.best_costs.len(), config.particles)?;
        for (name, rows) in [
            ("positions", &self.positions),
            ("velocities", &self.velocities),
            ("best_positions", &self.best_positions),
        ] {
            expect_length(name, rows.len(), config.particles)?;
            for row in rows {
                expect_length(name, row.len(), bounds.len())?;
            }
        }
        for (name, rows) in [
            ("positions", &self.positions),
            ("best_positions", &self.best_positions),
        ] {
            let accepted = "inside the bounds";
            check_values(name, rows, bounds, accepted, |value, bound| {
                bound.contains(value)
            })?;
        }
        check_values("velocities", &self.velocities, bounds, "finite", |v, _| {
            v.is_finite()
        })?;
        for (name, costs) in [("best_costs", &self.best_costs), ("history", &self.history)] {
            if let Some(particle) = costs.iter().position(|cost| cost.is_nan()) {
                let (value, accepted) = (f64::NAN, "a number or infinite");
                return Err(SwarmError::CheckpointValue {
                    name,
                    particle,
                    value,
                    accepted,
                });
            }
        }
        if !(self.damping >= 0.0 && self.damping <= 1.0) {
            return Err(SwarmError::CheckpointValue {
                name: "damping",
                particle: 0,
                value: self.damping,
                accepted: "in 0..=1",
            });
        }
        Ok(())
    }
}

fn expect_length(name: &'static str, length: usize, expected: usize) -> Result<(), SwarmError> {
    if length == expected {
        Ok(())
    } else {
        Err(SwarmError::CheckpointLength {
            name,
            length,
            expected,
        })
    }
}

fn check_values(
    name: &'static str,
    rows: &[Vec<f64>],
    bounds: &[Bound],
    accepted: &'static str,
    accepts: impl Fn(f64, &Bound) -> bool,
) -> Result<(), SwarmError> {
    for (particle, row) in rows.iter().enumerate() {
        for (&value, bound) in row.iter().zip(bounds) {
            if !accepts(value, bound) {
                return Err(SwarmError::CheckpointValue {
                    name,
                    particle,
                    value,
                    accepted,
                });
            }
        }
    }
    Ok(())
}
