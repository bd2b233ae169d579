use crate::bound::Bound;
use crate::boundary::Step;
use crate::checkpoint::Checkpoint;
use crate::start::velocities;
use crate::topology::lowest;
use crate::uniform::unit;
use crate::{Boundary, Stop, SwarmConfig, SwarmError, Termination};
use rand::Rng;

/// A particle swarm that proposes points and is told their costs.
///
/// ```text
/// v ← w v + c1 r1 (own best − x) + c2 r2 (informer's best − x),   cut to the velocity limit
/// x ← x + v,   brought inside by the boundary
/// ```
///
/// - **Order of updates.** Synchronous: all costs of an iteration are known before anybody moves.
/// - **Random numbers.** The start draws as [`Start`](crate::Start) says. A move draws particle by
///   particle, in each coordinate by coordinate r1, then r2, then, with [`Boundary::Random`] only, one
///   more. Nothing else draws, and how much is drawn depends on no cost, position or fixed coordinate.
/// - **Costs.** Any number; −∞ is the best there is. NaN counts as +∞ and is counted. A best cost of
///   +∞ pulls nobody.
/// - **Ties.** A particle keeps its best point until a cost is lower; between particles of equal cost
///   the lower index counts.
/// - **Overflow.** A step that is not finite (weights that are unstable, without a velocity limit) is
///   not made: the coordinate stays and its velocity becomes zero.
///
/// Same seed, configuration and costs: same bits, whoever computes the costs on however many threads.
///
/// # Examples
///
/// ```
/// use pso::{Bound, Swarm, SwarmConfig};
/// use rand::SeedableRng;
/// use rand_chacha::ChaCha8Rng;
///
/// let bounds = [Bound { lower: -5.0, upper: 5.0 }; 2];
/// let mut swarm = Swarm::new(SwarmConfig::default(), &bounds, ChaCha8Rng::seed_from_u64(1))?;
/// for _ in 0..100 {
///     let costs: Vec<f64> = swarm.ask().iter().map(|x| (x[0] - 1.0).powi(2) + x[1].powi(2)).collect();
///     swarm.tell(&costs)?;
/// }
/// assert!(swarm.best_cost().is_some_and(|cost| cost < 1e-9));
/// # Ok::<(), pso::SwarmError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Swarm<R> {
    config: SwarmConfig,
    bounds: Vec<Bound>,
    memory: Checkpoint<R>,
}

impl<R: Rng> Swarm<R> {
    /// Checks the settings and draws the starts.
    ///
    /// The generator is to be of a named, portable algorithm (`rand_chacha::ChaCha8Rng`, say) if the
    /// run is to be repeated elsewhere or later.
    ///
    /// # Errors
    ///
    /// Any setting, bound or start point that [`SwarmConfig`], [`Bound`] or
    /// [`Start`](crate::Start) does not accept.
    pub fn new(
        config: SwarmConfig,
        bounds: &[Bound],
        mut generator: R,
    ) -> Result<Self, SwarmError> {
        config.check(bounds)?;
        let positions = config
            .start
            .positions(config.particles, bounds, &mut generator);
        let mut velocities = velocities(&positions, bounds, &mut generator);
        for velocity in &mut velocities {
            for (v, bound) in velocity.iter_mut().zip(bounds) {
                *v = limited(*v, config.velocity_limit, *bound);
            }
        }
        let memory = Checkpoint {
            generator,
            best_positions: positions.clone(),
            positions,
            velocities,
            best_costs: vec![f64::INFINITY; config.particles],
            history: Vec::new(),
            damping: 1.0,
            rejected_costs: 0,
        };
        Ok(Self {
            config,
            bounds: bounds.to_vec(),
            memory,
        })
    }

    /// Goes on from a checkpoint, bit for bit if the configuration and the bounds are those that it
    /// was taken under. `config.start` is not used again.
    ///
    /// # Errors
    ///
    /// All errors of [`Swarm::new`], and a checkpoint of another size, with a point outside the bounds, or
    /// with a NaN.
    pub fn resume(
        config: SwarmConfig,
        bounds: &[Bound],
        checkpoint: Checkpoint<R>,
    ) -> Result<Self, SwarmError> {
        config.check(bounds)?;
        checkpoint.check(&config, bounds)?;
        Ok(Self {
            config,
            bounds: bounds.to_vec(),
            memory: checkpoint,
        })
    }

    /// The points to evaluate, one for each particle; the same ones until [`Swarm::tell`].
    #[must_use]
    pub fn ask(&self) -> &[Vec<f64>] {
        &self.memory.positions
    }

    /// The lowest cost of each particle so far, ∞ before its first. A point that costs more than this changes nothing.
    #[must_use]
    pub fn best_costs(&self) -> &[f64] {
        &self.memory.best_costs
    }

    /// Takes the costs of the points of [`Swarm::ask`], in their order, and moves the swarm.
    ///
    /// # Errors
    ///
    /// Not one cost for each particle; the swarm is then unchanged.
    pub fn tell(&mut self, costs: &[f64]) -> Result<(), SwarmError> {
        if costs.len() != self.config.particles {
            let (count, particles) = (costs.len(), self.config.particles);
            return Err(SwarmError::CostCount { count, particles });
        }
        let memory = &mut self.memory;
        for (particle, &cost) in costs.iter().enumerate() {
            if cost.is_nan() {
                memory.rejected_costs += 1;
            } else if cost < memory.best_costs[particle] {
                memory.best_costs[particle] = cost;
                memory.best_positions[particle].copy_from_slice(&memory.positions[particle]);
            }
        }
        memory
            .history
            .push(memory.best_costs[lowest(0..costs.len(), &memory.best_costs)]);
        self.advance();
        Ok(())
    }

    /// One move of all particles, after their costs.
    fn advance(&mut self) {
        let Self {
            config,
            bounds,
            memory,
        } = self;
        let n_moves = memory.history.len() as u64 - 1;
        let inertia = config.weights.inertia.at(n_moves, memory.damping);
        memory.damping *= config.weights.inertia.factor();
        let informers = config.topology.informers(&memory.best_costs);
        for (particle, &informer) in informers.iter().enumerate() {
            let cognitive = pull(config.weights.cognitive, memory.best_costs[particle]);
            let social = pull(config.weights.social, memory.best_costs[informer]);
            for (coordinate, bound) in bounds.iter().enumerate() {
                let r1 = unit(&mut memory.generator);
                let r2 = unit(&mut memory.generator);
                let spare = match config.boundary {
                    Boundary::Random => unit(&mut memory.generator),
                    Boundary::Absorb | Boundary::Reflect | Boundary::Periodic => 0.0,
                };
                let x = memory.positions[particle][coordinate];
                let to_own = memory.best_positions[particle][coordinate] - x;
                let to_informer = memory.best_positions[informer][coordinate] - x;
                let velocity = limited(
                    inertia * memory.velocities[particle][coordinate]
                        + cognitive * r1 * to_own
                        + social * r2 * to_informer,
                    config.velocity_limit,
                    *bound,
                );
                let position = x + velocity;
                let step = if position.is_finite() {
                    config
                        .boundary
                        .confine(Step { position, velocity }, *bound, spare)
                } else {
                    Step {
                        position: x,
                        velocity: 0.0,
                    }
                };
                memory.positions[particle][coordinate] = step.position;
                memory.velocities[particle][coordinate] = step.velocity;
            }
        }
    }

    /// The reason to stop now, if there is one; `time` is for [`Swarm::run`] only.
    ///
    /// For loops of one's own around [`Swarm::ask`] and [`Swarm::tell`]:
    ///
    /// ```
    /// # use pso::{Bound, Stop, Swarm, SwarmConfig, Termination};
    /// # use rand::SeedableRng;
    /// # let bounds = [Bound { lower: -5.0, upper: 5.0 }];
    /// # let generator = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    /// let mut swarm = Swarm::new(SwarmConfig::default(), &bounds, generator)?;
    /// let stop = Stop { target: Some(1e-6), ..Stop::default() };
    /// let termination = loop {
    ///     if let Some(reason) = swarm.finished(&stop)? {
    ///         break reason;
    ///     }
    ///     let costs: Vec<f64> = swarm.ask().iter().map(|x| x[0].powi(2)).collect();
    ///     swarm.tell(&costs)?;
    /// };
    /// assert_eq!(termination, Termination::Target);
    /// # Ok::<(), pso::SwarmError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// A limit that [`Stop`] does not accept.
    pub fn finished(&self, stop: &Stop) -> Result<Option<Termination>, SwarmError> {
        stop.check(self.config.particles)?;
        let history = &self.memory.history;
        let reached = |target: f64| history.last().is_some_and(|&best| best <= target);
        let started = !history.is_empty();
        let next = self
            .evaluations()
            .saturating_add(self.config.particles as u64);
        Ok(if stop.target.is_some_and(reached) {
            Some(Termination::Target)
        } else if stop.stall.is_some_and(|stall| stall.holds(history)) {
            Some(Termination::Stall)
        } else if started
            && stop
                .iterations
                .is_some_and(|limit| self.iterations() >= limit)
        {
            Some(Termination::Iterations)
        } else if stop.evaluations.is_some_and(|limit| next > limit) {
            Some(Termination::Evaluations)
        } else {
            None
        })
    }

    /// Lowest cost so far; `None` before the first costs, and while all were +∞ or NaN.
    #[must_use]
    pub fn best_cost(&self) -> Option<f64> {
        let best = self.memory.best_costs[self.leader()];
        (best < f64::INFINITY).then_some(best)
    }

    /// Point of the lowest cost so far; `None` as for [`Swarm::best_cost`].
    #[must_use]
    pub fn best_point(&self) -> Option<&[f64]> {
        self.best_cost()
            .map(|_| self.memory.best_positions[self.leader()].as_slice())
    }

    fn leader(&self) -> usize {
        lowest(0..self.config.particles, &self.memory.best_costs)
    }

    /// Evaluated moves of the swarm; the evaluation of the starts is not one.
    #[must_use]
    pub fn iterations(&self) -> u64 {
        (self.memory.history.len() as u64).saturating_sub(1)
    }

    /// Costs told so far.
    #[must_use]
    pub fn evaluations(&self) -> u64 {
        self.memory.history.len() as u64 * self.config.particles as u64
    }

    /// Costs that were NaN.
    #[must_use]
    pub fn rejected_costs(&self) -> u64 {
        self.memory.rejected_costs
    }

    /// Best cost after each evaluation of the swarm, that of the starts first: never rises; +∞ where
    /// there was none.
    #[must_use]
    pub fn history(&self) -> &[f64] {
        &self.memory.history
    }
}

impl<R: Rng + Clone> Swarm<R> {
    /// All that [`Swarm::resume`] needs to go on bit for bit.
    #[must_use]
    pub fn checkpoint(&self) -> Checkpoint<R> {
        self.memory.clone()
    }
}

/// Weight of the pull to a best point: none where there has been no cost yet.
fn pull(weight: f64, best_cost: f64) -> f64 {
    if best_cost < f64::INFINITY {
        weight
    } else {
        0.0
    }
}

/// A velocity cut to a fraction of the range.
fn limited(velocity: f64, limit: Option<f64>, bound: Bound) -> f64 {
    match limit {
        Some(fraction) => {
            let largest = fraction * bound.range();
            velocity.clamp(-largest, largest)
        }
        None => velocity,
    }
}
