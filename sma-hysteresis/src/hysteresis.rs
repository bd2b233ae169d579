use crate::family::{Curves, HEAVIEST_TAILS};
use crate::limiting_loop::{Branch, LimitingLoop};
use crate::memory::{FARTHEST_K, Memory, Rule, Rules};
use crate::path::{Paths, Reversal};
use crate::proximity::{Proximity, SineProximity};
use crate::roots::rising_roots;
use crate::{HysteresisError, LoopFamily, SecondPopulation};

/// Rounding of a sum of bends that is 1.
const SUM_ROUNDING: f64 = 1e-12;

/// Fraction and slope, as [`Hysteresis::peek`] returns them.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Sensed<const L: usize> {
    /// Fraction.
    pub fraction: [f64; L],
    /// Its slope along the branch, 1/K: from 0 to that of the limiting curve.
    pub slope_per_k: [f64; L],
}

/// The hysteresis of `L` materials side by side: limiting-loop proximity (L2P).
///
/// ```text
/// ξ(T) = (2 ξ_s/π) atan((T_pr P(x) + T̂ - δ T_c)/h_0) + ξ_0,   x = (T̂ - T̂_r)/T_pr     [Sadeghi, eqs 9-12]
/// ```
///
/// The model is immutable; [`Memory`] holds the reversals and is passed in. The operator is rate
/// independent: only the temperatures visited count, not the time between them. A temperature of
/// `NaN` gives a fraction of `NaN` and leaves the memory as it was; ±∞ is a saturating excursion like any
/// other that goes far enough, with the fraction of an asymptote.
///
/// Left out: anything that moves the loop itself (stress, fatigue, R-phase).
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct Hysteresis<const L: usize, P = SineProximity<L>> {
    limits: LimitingLoop<L>,
    proximity: P,
    rule: Rule,
    /// Of another family than the paper's.
    curves: Option<Curves<L>>,
}

impl<const L: usize> Hysteresis<L> {
    /// Replaces the curves by those of another family; the limiting loop is kept. A memory belongs to the family that made
    /// it.
    #[must_use]
    pub fn of_family(mut self, family: LoopFamily) -> Self {
        self.curves = Curves::new(family, &self.limits, self.proximity.zeta());
        self
    }

    /// Sets the tails τ of the relays' distribution, 0 (normal) to 4, see [`LoopFamily::Relays`]. Loops of other families
    /// have no tails and stay as they are.
    ///
    /// # Errors
    ///
    /// [`HysteresisError::Tails`] for a τ outside of this range.
    pub fn with_tails(mut self, tails: [f64; L]) -> Result<Self, HysteresisError> {
        let is_possible = |value: &f64| (0.0..=HEAVIEST_TAILS).contains(value);
        if let Some(value) = tails.into_iter().find(|value| !is_possible(value)) {
            return Err(HysteresisError::Tails { value });
        }
        self.curves = self.curves.map(|curves| curves.with_tails(tails));
        Ok(self)
    }

    /// Sets how sharply kinetics set in: from s = 0, smoothly, to 1, at once at a finite rate, see [`LoopFamily::Kinetics`]. Loops of
    /// other families have no onset and stay as they are.
    ///
    /// # Errors
    ///
    /// [`HysteresisError::Onset`] for an s outside of this range.
    pub fn with_onset(mut self, sharpness: [f64; L]) -> Result<Self, HysteresisError> {
        let is_possible = |value: &f64| (0.0..=1.0).contains(value);
        if let Some(value) = sharpness.into_iter().find(|value| !is_possible(value)) {
            return Err(HysteresisError::Onset { value });
        }
        self.curves = self.curves.map(|curves| curves.with_onset(sharpness));
        Ok(self)
    }

    /// Sets a second population of relays beside the first. Loops of other families have none and stay as they are.
    ///
    /// # Errors
    ///
    /// [`HysteresisError::SecondPopulation`] for a number outside of its range.
    pub fn with_second_population(
        mut self,
        second: [SecondPopulation; L],
    ) -> Result<Self, HysteresisError> {
        for lane in &second {
            lane.check()?;
        }
        let (limits, zeta) = (self.limits, self.proximity.zeta());
        self.curves = self
            .curves
            .map(|curves| curves.with_second_population(&limits, zeta, second));
        Ok(self)
    }

    /// Bends the course of the transformation, so that a loop of relays or kinetics takes another shape.
    ///
    /// ```text
    /// p' = p + Σ_k c_k φ_k(p),   φ_k' = P_k(1 - 2p),   |c_1| + max(-c_2, c_2/2) + |c_3| ≤ 1
    /// φ_1 = p(1 - p),   φ_2 = p(1 - p)(1 - 2p),   φ_3 = p(1 - p)(5(1 - 2p)² - 1)/4
    /// ```
    ///
    /// P_k are Legendre's polynomials. The sum is the most by which a slope falls. p is the share of the relays that have switched, or of
    /// what is left to transform that kinetics have transformed, on heating and, mirrored, on cooling. So the limiting curves change
    /// and the memory does not. The first index of `bends` is k - 1. The paper's loop has no bends and stays as it is.
    ///
    /// # Errors
    ///
    /// [`HysteresisError::Bends`] if the sum is no number up to 1: branches would turn back.
    pub fn with_bends(mut self, bends: [[f64; L]; 3]) -> Result<Self, HysteresisError> {
        for lane in 0..L {
            let [skew, bend, third] = bends.map(|lanes| lanes[lane]);
            let value = skew.abs() + (-bend).max(0.5 * bend) + third.abs();
            if !(0.0..=1.0 + SUM_ROUNDING).contains(&value) {
                return Err(HysteresisError::Bends { value });
            }
        }
        self.curves = self.curves.map(|curves| curves.with_bends(bends));
        Ok(self)
    }
}

impl<const L: usize, P: Proximity> Hysteresis<L, P> {
    /// Puts a limiting loop, a proximity function and a rule of memory together; each was checked
    /// when it was made.
    pub fn new(limits: LimitingLoop<L>, proximity: P, rule: Rule) -> Self {
        Self {
            limits,
            proximity,
            rule,
            curves: None,
        }
    }

    /// The limiting loop.
    #[must_use]
    pub fn limits(&self) -> &LimitingLoop<L> {
        &self.limits
    }

    /// Memory of a material that came to `temperature_degc` along a limiting curve: for a rod at rest
    /// the cooling one. A `NaN` stays `NaN` in the fractions.
    #[must_use]
    pub fn on_limiting_curve(&self, branch: Branch, temperature_degc: [f64; L]) -> Memory<L> {
        let share = match branch {
            Branch::Heating => 0.0,
            Branch::Cooling => 1.0,
        };
        self.between_limiting_curves(temperature_degc, [share; L])
    }

    /// Memory of a material whose past is unknown, between the limiting curves: `share` = 0 is the
    /// point on the heating curve, 1 that on the cooling curve. Shares outside \[0, 1\] count as the
    /// nearer end, so that a fit may move freely.
    ///
    /// The material counts as having come there by cooling: left by heating, the start is a
    /// reversal; left by cooling, it is none, and a nested loop does not return to it. With `share` = 0
    /// it came along the heating curve, and the other way round.
    ///
    /// So later fractions follow `share` without a step up to and including the cooling curve, and a
    /// first movement that is small moves them little, whatever its direction. One step remains under
    /// [`Rule::Nested`], at `share` = 0: that start is not a return point where those above it are,
    /// when heated first, and is one where they are none, when cooled first. The first branch and
    /// [`Rule::LastReversal`] have no step there.
    #[must_use]
    pub fn between_limiting_curves(
        &self,
        temperature_degc: [f64; L],
        share: [f64; L],
    ) -> Memory<L> {
        Memory::starting(
            &self.rules(),
            self.relative_k(temperature_degc),
            share.map(|share| share.clamp(0.0, 1.0)),
        )
    }

    /// Takes a memory to where [`Hysteresis::between_limiting_curves`] begins: cheaper than another one, as a memory is large.
    pub fn restart(&self, memory: &mut Memory<L>, temperature_degc: [f64; L], share: [f64; L]) {
        memory.restart(
            &self.rules(),
            self.relative_k(temperature_degc),
            share.map(|share| share.clamp(0.0, 1.0)),
            [false; L],
        );
    }

    /// Memory of a material whose last reversal is known; see [`Hysteresis::restart_since_reversal`].
    #[must_use]
    pub fn since_reversal(
        &self,
        temperature_degc: [f64; L],
        share: [f64; L],
        since_reversal_k: [f64; L],
    ) -> Memory<L> {
        let mut memory = self.between_limiting_curves(temperature_degc, share);
        self.lead_from_reversal(&mut memory, temperature_degc, share, since_reversal_k);
        memory
    }

    /// Takes a memory to where [`Hysteresis::between_limiting_curves`] begins, of a material that last turned where it was
    /// `since_reversal_k` colder (below 0: warmer), K; 0 is [`Hysteresis::restart`]. A `NaN` stays `NaN` in the fractions.
    ///
    /// The place at the reversal is sought from which the branch leads to `share`; where none does, the nearest is taken.
    pub fn restart_since_reversal(
        &self,
        memory: &mut Memory<L>,
        temperature_degc: [f64; L],
        share: [f64; L],
        since_reversal_k: [f64; L],
    ) {
        self.restart(memory, temperature_degc, share);
        self.lead_from_reversal(memory, temperature_degc, share, since_reversal_k);
    }

    /// Has a memory that begins between the limiting curves come there from its last reversal.
    fn lead_from_reversal(
        &self,
        memory: &mut Memory<L>,
        temperature_degc: [f64; L],
        share: [f64; L],
        since_reversal_k: [f64; L],
    ) {
        let since_k = since_reversal_k.map(|since_k| since_k.clamp(-FARTHEST_K, FARTHEST_K));
        if since_k.iter().all(|since_k| since_k.abs() <= 0.0) {
            return;
        }
        let wanted = self.peek(memory, temperature_degc).fraction;
        let turned_k = self.relative_k(core::array::from_fn(|l| temperature_degc[l] - since_k[l]));
        let by_heating = since_k.map(|since_k| since_k < 0.0);
        let is_sought = since_k.map(|since_k| since_k.abs() > 0.0);
        let share = share.map(|share| share.clamp(0.0, 1.0));
        let mut above = |at_reversal: &[f64; L]| {
            let from = core::array::from_fn(|l| {
                if is_sought[l] {
                    at_reversal[l]
                } else {
                    share[l]
                }
            });
            memory.restart(&self.rules(), turned_k, from, by_heating);
            let fraction = self.peek(memory, temperature_degc).fraction;
            core::array::from_fn(|l| fraction[l] - wanted[l])
        };
        let at_reversal = rising_roots(&mut above);
        above(&at_reversal);
        self.commit(memory, temperature_degc);
    }

    /// Memory of a material known to have `fraction` at `temperature_degc`.
    ///
    /// # Errors
    ///
    /// [`HysteresisError::StartTemperature`] unless finite, [`HysteresisError::OutsideLoop`] if no
    /// history leads there; `NaN` is outside.
    pub fn at(
        &self,
        temperature_degc: [f64; L],
        fraction: [f64; L],
    ) -> Result<Memory<L>, HysteresisError> {
        let mut share = [0.0; L];
        for l in 0..L {
            let relative_k = self.limits.relative_k(l, temperature_degc[l]);
            if !relative_k.is_finite() {
                return Err(HysteresisError::StartTemperature {
                    value: temperature_degc[l],
                });
            }
            let rules = self.rules();
            let levels_k = rules.limits_at(l, relative_k);
            let ends = levels_k.map(|level_k| rules.fraction(l, level_k));
            let outside = HysteresisError::OutsideLoop {
                value: fraction[l],
                temperature_degc: temperature_degc[l],
                lower: ends[0].min(ends[1]),
                upper: ends[0].max(ends[1]),
            };
            let Some(level_k) = rules.level_of(l, fraction[l]) else {
                return Err(outside);
            };
            // A fraction read off a limiting curve may be out by rounding.
            let margin = 1e-9;
            let [heating_k, cooling_k] = levels_k;
            let (above_k, width_k) = (level_k - heating_k, cooling_k - heating_k);
            // Far out both curves of some families are one.
            let is_one = width_k.abs() <= 0.0 && above_k.abs() <= margin;
            share[l] = if is_one { 1.0 } else { above_k / width_k };
            if !(share[l] >= -margin && share[l] <= 1.0 + margin) {
                return Err(outside);
            }
        }
        Ok(self.between_limiting_curves(temperature_degc, share))
    }

    /// Fraction and slope at a temperature, without going there: for the trial temperatures of an
    /// implicit heat balance. °C in.
    #[inline(always)]
    #[must_use]
    pub fn peek(&self, memory: &Memory<L>, temperature_degc: [f64; L]) -> Sensed<L> {
        let temperature_k = self.relative_k(temperature_degc);
        let towards;
        let paths = if memory.leaves_branch(&temperature_k) {
            towards = memory.paths_towards(&self.rules(), &temperature_k);
            &towards
        } else {
            memory.paths()
        };
        if let Some(curves) = &self.curves {
            return self.peek_at_share(curves, paths, &temperature_k);
        }
        // First the level, K, and its slope, in the places of fraction and slope.
        let mut sensed = Sensed {
            fraction: [0.0; L],
            slope_per_k: [0.0; L],
        };
        for l in 0..L {
            let path = paths.get(l);
            sensed.fraction[l] = path.level_k(&self.proximity, l, temperature_k[l]);
            sensed.slope_per_k[l] = path.level_slope(&self.proximity, l, temperature_k[l]);
        }
        for l in 0..L {
            let level_k = sensed.fraction[l];
            sensed.fraction[l] = self.limits.fraction_at(l, level_k);
            sensed.slope_per_k[l] *= self.limits.fraction_slope_at(l, level_k);
        }
        sensed
    }

    /// Goes to a temperature, °C, and returns the fraction there: what [`Hysteresis::peek`] saw, to
    /// the last bit.
    #[inline(always)]
    pub fn commit(&self, memory: &mut Memory<L>, temperature_degc: [f64; L]) -> [f64; L] {
        let temperature_k = self.relative_k(temperature_degc);
        if memory.leaves_branch(&temperature_k) {
            memory.change_branch(&self.rules(), &temperature_k);
        }
        if let Some(curves) = &self.curves {
            return self.commit_at_share(curves, memory, &temperature_k);
        }
        let mut level_k = [0.0; L];
        for l in 0..L {
            level_k[l] = memory
                .paths()
                .get(l)
                .level_k(&self.proximity, l, temperature_k[l]);
            memory.advance(l, temperature_k[l]);
        }
        let mut fraction = [0.0; L];
        for l in 0..L {
            fraction[l] = self.limits.fraction_at(l, level_k[l]);
        }
        fraction
    }

    /// The reversals that a lane remembers, outermost first; none for a lane that does not exist.
    pub fn reversals<'a>(
        &'a self,
        memory: &'a Memory<L>,
        lane: usize,
    ) -> impl Iterator<Item = Reversal> + 'a {
        memory.reversals(self.rules(), lane)
    }

    /// [`Hysteresis::peek`] where the share of the material is what is known.
    #[inline(always)]
    fn peek_at_share(
        &self,
        curves: &Curves<L>,
        paths: &Paths<L>,
        temperature_k: &[f64; L],
    ) -> Sensed<L> {
        let (mut fraction, mut slope_per_k) = curves.levels_by_call(paths, temperature_k);
        for l in 0..L {
            let (at, per_share) = self.limits.fraction_of_share(l, fraction[l]);
            fraction[l] = at;
            slope_per_k[l] *= per_share;
        }
        Sensed {
            fraction,
            slope_per_k,
        }
    }

    /// [`Hysteresis::commit`] on a branch that was changed already.
    #[inline(always)]
    fn commit_at_share(
        &self,
        curves: &Curves<L>,
        memory: &mut Memory<L>,
        temperature_k: &[f64; L],
    ) -> [f64; L] {
        let (mut fraction, _) = curves.levels_by_call(memory.paths(), temperature_k);
        for l in 0..L {
            memory.advance(l, temperature_k[l]);
            fraction[l] = self.limits.fraction_of_share(l, fraction[l]).0;
        }
        fraction
    }

    #[inline(always)]
    fn relative_k(&self, temperature_degc: [f64; L]) -> [f64; L] {
        let mut relative_k = [0.0; L];
        for l in 0..L {
            relative_k[l] = self.limits.relative_k(l, temperature_degc[l]);
        }
        relative_k
    }

    fn rules(&self) -> Rules<'_, L, P> {
        Rules {
            limits: &self.limits,
            proximity: &self.proximity,
            rule: self.rule,
            curves: self.curves.as_ref(),
        }
    }
}
