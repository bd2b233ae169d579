use pso::{Stall, SwarmConfig};

use crate::error::positive;
use crate::{PidGains, Task, TuneError};

/// Moves of the paper's swarm, and of ours.
const MOVES: u64 = 150;
/// Independent swarms of [`TunerConfig::for_task`].
const STARTS: usize = 8;
/// Moves over which the best cost has stalled if it falls by no more than a share of itself.
const STALLED_MOVES: u64 = 40;
/// See [`STALLED_MOVES`].
const STALLED: f64 = 1e-3;
/// Share of a range below which [`GainScale::Logarithmic`] is linear.
const FLOOR: f64 = 1e-4;
/// Share of a scaled range that counts as its end.
const AT_BOUND: f64 = 1e-3;
/// Largest proportional gain of [`TunerConfig::for_task`], in drive ranges a stroke.
const LARGEST_KP: f64 = 1e3;
/// Largest integral gain, in drive ranges a stroke and sample.
const LARGEST_KI: f64 = 100.0;

/// Where gains are looked for.
///
/// Both ends may be found. Equal ends fix a gain: `kd` in 0 .. 0 asks for a PI controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainBounds {
    /// Smallest gains; each finite and ≥ 0.
    pub lower: PidGains,
    /// Largest gains; each finite and at least the smallest.
    pub upper: PidGains,
}

/// How a swarm sees a range of gains: as shares from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GainScale {
    /// In proportion, as in the paper: of a range 0 .. 500, one share in a hundred is below 5.
    Linear,
    /// In decades:
    ///
    /// ```text
    /// gain = lower + f ((1 + (upper - lower)/f)^share - 1),   f = 10⁻⁴ (upper - lower)
    /// ```
    ///
    /// The four decades below `upper` take about equal parts of the shares; below the floor f the scale is
    /// linear, so that a lower end of 0, no such term at all, is within reach.
    Logarithmic,
}

/// Which end of its range a gain was found at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoundEnd {
    /// The lower one; of 0, the term is not wanted.
    Lower,
    /// The upper one: there may be better gains beyond.
    Upper,
}

/// Settings of a search for gains.
///
/// There is no default: ranges have units. See [`TunerConfig::for_task`].
#[derive(Debug, Clone, PartialEq)]
pub struct TunerConfig {
    /// A swarm. Starts that are given in it are shares, 0 to 1, of the scaled ranges of kp, ki and kd.
    pub swarm: SwarmConfig,
    /// Number of such swarms, which do not know of one another; ≥ 1.
    pub starts: usize,
    /// Moves of each swarm after it was evaluated where it starts, at most.
    pub moves: u64,
    /// Ends the search where the best cost of all swarms stalls while three of them agree on it; `None` makes all moves.
    pub stall: Option<Stall>,
    /// Where gains are looked for.
    pub bounds: GainBounds,
    /// How the swarm sees these ranges.
    pub scale: GainScale,
    /// Seed of the random numbers, ChaCha8; each swarm takes a stream of it.
    pub seed: u64,
}

impl TunerConfig {
    /// The paper's search: [`SwarmConfig::sadeghi_tuning`], 50 particles and 150 moves, with gains in
    /// [0, 0, 0] to [500, 1, 1] `[Sadeghi, section 5]`, uniformly.
    ///
    /// Those bounds have units, which are not printed. A/mm, A/(mm s) and A s/mm are ours: for outputs in mm and
    /// drives in A.
    #[must_use]
    pub fn sadeghi() -> Self {
        Self {
            swarm: SwarmConfig::sadeghi_tuning(),
            starts: 1,
            moves: MOVES,
            stall: None,
            bounds: GainBounds {
                lower: PidGains {
                    kp: 0.0,
                    ki: 0.0,
                    kd: 0.0,
                },
                upper: PidGains {
                    kp: 500.0,
                    ki: 1.0,
                    kd: 1.0,
                },
            },
            scale: GainScale::Linear,
            seed: 0,
        }
    }

    /// A search that works in any unit: eight of [`SwarmConfig::reliable`], 50 particles and 150 moves each, over
    /// ranges that the task sets, on a logarithmic scale.
    ///
    /// ```text
    /// kp: 0 .. 1000 U/Y       there, an error of a thousandth of the stroke saturates the drive
    /// ki: 0 .. 100 U/(Y Δt)   there, an error of a hundredth goes through the drive's range in a sample
    /// kd: 0 .. U N Δt/Y       there, the pace of one stroke a run is answered by the whole range
    /// ```
    ///
    /// with the drive's range U from limit to limit, the stroke Y, the sample time Δt and N samples. The ranges
    /// are our own choice: wide, which costs little on this scale.
    ///
    /// Eight, because the cost has cliffs and several valleys wherever the drive saturates and rise or settling
    /// count: on the six rods of `examples/paper_rods.rs` 17 to 40 of 40 swarms ended within 1 % of the lowest cost
    /// known, and eight together did with each of 20 seeds. See [`Tuned::agreeing`](crate::Tuned::agreeing).
    ///
    /// `stroke`: how far the output can go, in its unit; > 0.
    ///
    /// # Errors
    ///
    /// [`TuneError::NotPositive`] for the stroke.
    pub fn for_task<F>(task: &Task<'_, F>, stroke: f64) -> Result<Self, TuneError> {
        positive("stroke", stroke)?;
        let dt_s = task.pid().dt_s;
        let run_s = task.closed_loop().params().n_samples as f64 * dt_s;
        let limits = task.pid().limits;
        let per_stroke = (limits.upper - limits.lower) / stroke;
        let upper = PidGains {
            kp: LARGEST_KP * per_stroke,
            ki: LARGEST_KI * per_stroke / dt_s,
            kd: per_stroke * run_s,
        };
        Ok(Self {
            swarm: SwarmConfig::reliable(),
            starts: STARTS,
            bounds: GainBounds {
                upper,
                ..Self::sadeghi().bounds
            },
            scale: GainScale::Logarithmic,
            stall: Some(Stall {
                iterations: STALLED_MOVES,
                relative_improvement: STALLED,
            }),
            ..Self::sadeghi()
        })
    }

    /// Accepts at least one start, and bounds that rise or are equal.
    pub(crate) fn check(&self) -> Result<(), TuneError> {
        if self.starts == 0 {
            return Err(TuneError::NoStarts);
        }
        for (name, [lower, upper]) in ["kp", "ki", "kd"].into_iter().zip(self.ranges()) {
            if !(lower >= 0.0 && lower <= upper && upper.is_finite()) {
                return Err(TuneError::Bounds { name, lower, upper });
            }
        }
        Ok(())
    }

    fn ranges(&self) -> [[f64; 2]; 3] {
        let GainBounds { lower, upper } = self.bounds;
        [
            [lower.kp, upper.kp],
            [lower.ki, upper.ki],
            [lower.kd, upper.kd],
        ]
    }

    /// The gains at shares of their ranges, 0 to 1.
    pub(crate) fn gains(&self, shares: &[f64]) -> PidGains {
        let at = |coordinate: usize| {
            let [lower, upper] = self.ranges()[coordinate];
            let share = shares[coordinate];
            let along = match self.scale {
                GainScale::Linear => share,
                // In units of the range.
                GainScale::Logarithmic => FLOOR * libm::expm1(share * libm::log1p(1.0 / FLOOR)),
            };
            (lower + along * (upper - lower)).clamp(lower, upper)
        };
        PidGains {
            kp: at(0),
            ki: at(1),
            kd: at(2),
        }
    }

    /// The shares at which gains stand in their ranges; 0 in a range of no length.
    pub(crate) fn shares(&self, gains: &PidGains) -> [f64; 3] {
        let values = [gains.kp, gains.ki, gains.kd];
        let ranges = self.ranges();
        core::array::from_fn(|coordinate| {
            let [lower, upper] = ranges[coordinate];
            if lower >= upper {
                return 0.0;
            }
            let along = ((values[coordinate] - lower) / (upper - lower)).clamp(0.0, 1.0);
            match self.scale {
                GainScale::Linear => along,
                GainScale::Logarithmic => libm::log1p(along / FLOOR) / libm::log1p(1.0 / FLOOR),
            }
        })
    }

    /// Which gains stand at an end of their ranges. One that is fixed does not.
    pub(crate) fn at_bound(&self, gains: &PidGains) -> [Option<BoundEnd>; 3] {
        let shares = self.shares(gains);
        let ranges = self.ranges();
        core::array::from_fn(|coordinate| {
            let [lower, upper] = ranges[coordinate];
            match shares[coordinate] {
                _ if lower >= upper => None,
                share if share <= AT_BOUND => Some(BoundEnd::Lower),
                share if share >= 1.0 - AT_BOUND => Some(BoundEnd::Upper),
                _ => None,
            }
        })
    }
}
