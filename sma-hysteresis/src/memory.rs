use crate::family::Curves;
use crate::limiting_loop::{Branch, LimitingLoop};
use crate::path::{Course, Courses, Path, Paths, REVERSAL_DEAD_BAND_K, Reversal, Turn};
use crate::proximity::Proximity;
use crate::vectors::widest_vectors;

/// Reversals that a nested memory holds in each lane.
///
/// A cascade of minor loops deeper than this forgets its innermost pair, the smallest loop of all,
/// to remember the new reversal: the forgotten loop does not close, the larger ones still do.
/// [`Memory::forgotten`] counts such pairs.
pub const NESTING_CAPACITY: usize = 32;

/// Where what is remembered ends, K from the middle of the loop: beyond every loop, and so near that
/// differences from there keep ten digits after the point. With ∞ they would be `NaN`.
pub(crate) const FARTHEST_K: f64 = 1e6;

/// Which reversals the operator remembers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Rule {
    /// Only the last one: the paper's operator. Minor loops do not close.
    #[default]
    LastReversal,
    /// All that have not been wiped out: minor loops close exactly, and once a return point is
    /// passed the curve goes on as if the loop had never been (Madelung's rules). See
    /// [`NESTING_CAPACITY`] for its bound.
    Nested,
}

/// State of the operator in each of `L` lanes: the current branch, the extreme reached, and under
/// [`Rule::Nested`] the reversals that enclose it.
///
/// Made by [`Hysteresis`](crate::Hysteresis), which alone can read and move it. The memory also holds the
/// coefficients of the current branch. It therefore belongs to the model that made it; another model
/// would follow the old branch until its end.
#[derive(Debug, Clone, PartialEq)]
#[repr(align(64))]
pub struct Memory<const L: usize> {
    /// δ of the current branch, +1 or -1.
    sign: [f64; L],
    /// The current branches.
    paths: Paths<L>,
    /// δ T̂ of the point that the current branch returns to, infinite if there is none.
    return_k: [f64; L],
    /// δ T̂ of the furthest point in the current direction, where a reversal would start. Its level
    /// is not kept: reversals are rare, and the branch knows it.
    furthest_k: [f64; L],
    /// Start of the branch of depth 0: where the record begins.
    base: [Turn; L],
    turns: [[Turn; NESTING_CAPACITY]; L],
    depth: [usize; L],
    forgotten: [u32; L],
}

/// The operator's parts that memory needs: borrowed together, as they always go together.
#[derive(Debug)]
pub(crate) struct Rules<'a, const L: usize, P> {
    pub(crate) limits: &'a LimitingLoop<L>,
    pub(crate) proximity: &'a P,
    pub(crate) rule: Rule,
    /// Of another family than the paper's.
    pub(crate) curves: Option<&'a Curves<L>>,
}

impl<const L: usize, P: Proximity> Rules<'_, L, P> {
    /// The branches of courses.
    #[inline(always)]
    fn paths(&self, courses: &Courses<L>) -> Paths<L> {
        match self.curves {
            None => Paths::of(
                courses,
                #[inline(always)]
                |l, course| Path::new(self.limits, self.proximity, l, course),
            ),
            Some(curves) => curves.paths(courses),
        }
    }

    /// The branches of directions `sign` that return to no point.
    #[inline(always)]
    fn paths_without_return(&self, sign: &[f64; L], starts: &Starts<L>) -> Paths<L> {
        match self.curves {
            None => Paths::from_fn(
                #[inline(always)]
                |l| Path::without_return(self.limits, l, sign[l], starts.get(l)),
            ),
            Some(curves) => curves.paths(&Courses::from_fn(
                #[inline(always)]
                |l| Course::new(sign[l], starts.get(l), None),
            )),
        }
    }

    /// Levels (`Turn::level_k`) of reversals at T̂ on branches.
    #[inline(always)]
    fn levels(&self, paths: &Paths<L>, temperature_k: &[f64; L]) -> [f64; L] {
        if let Some(curves) = self.curves {
            return curves.levels_by_call(paths, temperature_k).0;
        }
        let mut level_k = [0.0; L];
        for l in 0..L {
            level_k[l] = paths.get(l).level_k(self.proximity, l, temperature_k[l]);
        }
        level_k
    }

    /// Levels (`Turn::level_k`) of reversals at T̂ on the limiting curves, heating first.
    pub(crate) fn limits_at(&self, lane: usize, temperature_k: f64) -> [f64; 2] {
        match self.curves {
            None => [1.0, -1.0].map(|sign| self.limits.limiting_level_k(lane, sign, temperature_k)),
            Some(curves) => curves.limits_at(lane, temperature_k),
        }
    }

    /// Level (`Turn::level_k`) at a fraction, the inverse of [`Rules::fraction`]; `None` if no level has this fraction.
    pub(crate) fn level_of(&self, lane: usize, fraction: f64) -> Option<f64> {
        if self.curves.is_none() {
            return self.limits.level_of(lane, Branch::Heating, fraction).ok();
        }
        let (middle, per_share) = self.limits.fraction_of_share(lane, 0.5);
        Some(0.5 + (fraction - middle) / per_share)
    }

    /// Fraction at a level (`Turn::level_k`).
    pub(crate) fn fraction(&self, lane: usize, level_k: f64) -> f64 {
        match self.curves {
            None => self.limits.fraction_at(lane, level_k),
            Some(_) => self.limits.fraction_of_share(lane, level_k).0,
        }
    }

    /// True if nothing but the last reversal counts.
    #[inline(always)]
    fn remember_one(&self) -> bool {
        self.rule == Rule::LastReversal && !self.are_kinetics()
    }

    #[inline(always)]
    fn are_kinetics(&self) -> bool {
        matches!(self.curves, Some(Curves::Kinetics(_)))
    }
}

/// Where branches of lanes side by side start.
#[derive(Debug)]
#[repr(align(64))]
struct Starts<const L: usize> {
    temperature_k: [f64; L],
    level_k: [f64; L],
}

impl<const L: usize> Starts<L> {
    #[inline(always)]
    fn get(&self, lane: usize) -> Turn {
        Turn {
            temperature_k: self.temperature_k[lane],
            level_k: self.level_k[lane],
        }
    }
}

/// The lanes after a step: their branches, and what those that leave theirs remember.
#[derive(Debug)]
struct Change<const L: usize> {
    paths: Paths<L>,
    recollections: [Option<Recollection>; L],
}

/// The remembered reversals of one lane after a step: how many stay, and whether one is added.
#[derive(Debug, Clone, Copy)]
struct Recollection {
    sign: f64,
    kept: usize,
    added: Option<Turn>,
    forgets: bool,
}

impl<const L: usize> Memory<L> {
    /// A memory that begins at `share` of the way from the heating to the cooling curve; see [`Memory::restart`].
    pub(crate) fn starting<P: Proximity>(
        rules: &Rules<'_, L, P>,
        temperature_k: [f64; L],
        share: [f64; L],
    ) -> Self {
        let mut memory = Self {
            sign: [0.0; L],
            paths: Paths::NONE,
            return_k: [0.0; L],
            furthest_k: [0.0; L],
            base: [Turn::default(); L],
            turns: [[Turn::default(); NESTING_CAPACITY]; L],
            depth: [0; L],
            forgotten: [0; L],
        };
        memory.restart(rules, temperature_k, share, [false; L]);
        memory
    }

    /// Begins anew at `share` of the way from the heating to the cooling curve.
    ///
    /// The material came there by cooling unless it is said that it came `by_heating`, or with `share` = 0 along the heating curve
    /// and with 1 along the cooling curve: the beginning is a reversal only if left in the other direction.
    pub(crate) fn restart<P: Proximity>(
        &mut self,
        rules: &Rules<'_, L, P>,
        temperature_k: [f64; L],
        share: [f64; L],
        by_heating: [bool; L],
    ) {
        let by_heating: [bool; L] = core::array::from_fn(|lane| {
            share[lane] <= 0.0 || by_heating[lane] && share[lane] < 1.0
        });
        let temperature_k = temperature_k.map(|degrees| degrees.clamp(-FARTHEST_K, FARTHEST_K));
        self.base = core::array::from_fn(|lane| {
            let (temperature_k, share) = (temperature_k[lane], share[lane]);
            if let Some(curves) = rules.curves {
                return curves.start(lane, temperature_k, share, by_heating[lane]);
            }
            let half_width_k = rules.limits.half_width_k(lane);
            // Straight between the curves; what asymmetry adds to either is exactly 0 without one.
            let added_k = |sign: f64| {
                let limiting_k = rules.limits.limiting_level_k(lane, sign, temperature_k);
                limiting_k - (temperature_k - sign * half_width_k)
            };
            Turn {
                temperature_k,
                level_k: temperature_k
                    + (2.0 * share - 1.0) * half_width_k
                    + ((1.0 - share) * added_k(1.0) + share * added_k(-1.0)),
            }
        });
        self.sign = by_heating.map(|by_heating| if by_heating { 1.0 } else { -1.0 });
        self.paths = rules.paths(&Courses::from_fn(|l| {
            Course::new(self.sign[l], self.base[l], None)
        }));
        self.return_k = [f64::INFINITY; L];
        for lane in 0..L {
            self.furthest_k[lane] = self.sign[lane] * temperature_k[lane];
        }
        self.depth = [0; L];
        self.forgotten = [0; L];
    }

    /// Direction of the branch that lane `lane` is on; lanes count from 0.
    ///
    /// `None` if there is no such lane.
    #[must_use]
    pub fn branch(&self, lane: usize) -> Option<Branch> {
        self.sign.get(lane).map(|&sign| {
            if sign > 0.0 {
                Branch::Heating
            } else {
                Branch::Cooling
            }
        })
    }

    /// How many pairs of reversals each lane has forgotten because its memory was full.
    #[must_use]
    pub fn forgotten(&self) -> [u32; L] {
        self.forgotten
    }

    /// Number of reversals that each lane remembers.
    #[must_use]
    pub fn depth(&self) -> [usize; L] {
        self.depth
    }

    /// The remembered reversals of a lane, outermost first; see
    /// [`Hysteresis::reversals`](crate::Hysteresis::reversals).
    pub(crate) fn reversals<'a, P: Proximity>(
        &'a self,
        rules: Rules<'a, L, P>,
        lane: usize,
    ) -> impl Iterator<Item = Reversal> + 'a {
        let depth = self.depth.get(lane).copied().unwrap_or(0);
        (0..depth).map(move |k| {
            let turn = self.turns[lane][k];
            Reversal {
                temperature_degc: rules.limits.absolute_degc(lane, turn.temperature_k),
                fraction: rules.fraction(lane, turn.level_k),
            }
        })
    }

    /// True if T̂ leaves the current branch of any lane: a reversal, or a return point passed.
    ///
    /// Reversals are rare and lanes reverse nearly together, so one test for all lanes is cheaper
    /// than a selection in each.
    #[inline(always)]
    pub(crate) fn leaves_branch(&self, temperature_k: &[f64; L]) -> bool {
        let mut leaves = false;
        for lane in 0..L {
            leaves |= self.leaves(lane, temperature_k[lane]);
        }
        leaves
    }

    #[inline(always)]
    fn leaves(&self, lane: usize, temperature_k: f64) -> bool {
        self.turns_back(lane, temperature_k) | self.passes_return(lane, temperature_k)
    }

    #[inline(always)]
    fn turns_back(&self, lane: usize, temperature_k: f64) -> bool {
        self.sign[lane] * temperature_k - self.furthest_k[lane] < -REVERSAL_DEAD_BAND_K
    }

    #[inline(always)]
    fn passes_return(&self, lane: usize, temperature_k: f64) -> bool {
        self.sign[lane] * temperature_k > self.return_k[lane]
    }

    /// The current branches.
    #[inline(always)]
    pub(crate) fn paths(&self) -> &Paths<L> {
        &self.paths
    }

    /// The branches on which the lanes come to T̂, without moving there.
    #[inline(never)]
    pub(crate) fn paths_towards<P: Proximity>(
        &self,
        rules: &Rules<'_, L, P>,
        temperature_k: &[f64; L],
    ) -> Paths<L> {
        widest_vectors(
            #[inline(always)]
            || {
                if rules.remember_one() {
                    let starts = self.turning_points(rules);
                    return self.turned(rules, temperature_k, &starts);
                }
                self.change(rules, temperature_k).paths
            },
        )
    }

    /// Takes every lane that leaves its branch to the branch on which it comes to T̂.
    #[inline(never)]
    pub(crate) fn change_branch<P: Proximity>(
        &mut self,
        rules: &Rules<'_, L, P>,
        temperature_k: &[f64; L],
    ) {
        if rules.remember_one() {
            widest_vectors(
                #[inline(always)]
                || self.turn_back(rules, temperature_k),
            );
            return;
        }
        let change = widest_vectors(
            #[inline(always)]
            || self.change(rules, temperature_k),
        );
        self.paths = change.paths;
        for lane in 0..L {
            let Some(next) = change.recollections[lane] else {
                continue;
            };
            self.forgotten[lane] += u32::from(next.forgets);
            self.depth[lane] = next.kept;
            if let Some(turn) = next.added {
                self.turns[lane][next.kept] = turn;
                self.depth[lane] += 1;
            }
            if rules.are_kinetics() {
                self.begin_anew(lane);
            }
            self.sign[lane] = next.sign;
            self.return_k[lane] = match self.return_point(rules, lane, self.depth[lane], None) {
                Some(end) => next.sign * end.temperature_k,
                None => f64::INFINITY,
            };
            // The extreme of the direction left behind must not hold back the new one.
            self.furthest_k[lane] = next.sign * temperature_k[lane];
        }
    }

    /// Where the lanes would turn back.
    #[inline(always)]
    fn turning_points<P: Proximity>(&self, rules: &Rules<'_, L, P>) -> Starts<L> {
        let mut temperature_k = [0.0; L];
        for l in 0..L {
            temperature_k[l] = (self.sign[l] * self.furthest_k[l]).clamp(-FARTHEST_K, FARTHEST_K);
        }
        let level_k = rules.levels(&self.paths, &temperature_k);
        Starts {
            temperature_k,
            level_k,
        }
    }

    /// The branches on which the lanes come to T̂ where nothing but the last reversal counts. With selections alone: lanes are computed side
    /// by side.
    #[inline(always)]
    fn turned<P: Proximity>(
        &self,
        rules: &Rules<'_, L, P>,
        temperature_k: &[f64; L],
        starts: &Starts<L>,
    ) -> Paths<L> {
        let opposite = self.sign.map(|sign| -sign);
        let turned = rules.paths_without_return(&opposite, starts);
        Paths::from_fn(
            #[inline(always)]
            |l| {
                let [turned, before] = [turned.get(l), self.paths.get(l)];
                before.or(turned, self.turns_back(l, temperature_k[l]))
            },
        )
    }

    /// Takes every lane that turns back to its other branch, where nothing but the last reversal counts.
    #[inline(always)]
    fn turn_back<P: Proximity>(&mut self, rules: &Rules<'_, L, P>, temperature_k: &[f64; L]) {
        let starts = self.turning_points(rules);
        self.paths = self.turned(rules, temperature_k, &starts);
        for l in 0..L {
            let (sign, furthest_k) = (self.sign[l], self.furthest_k[l]);
            let turns = self.turns_back(l, temperature_k[l]);
            if turns {
                self.turns[l][0] = starts.get(l);
            }
            self.depth[l] = if turns { 1 } else { self.depth[l] };
            self.sign[l] = if turns { -sign } else { sign };
            // The extreme of the direction left behind must not hold back the new one.
            self.furthest_k[l] = if turns {
                -sign * temperature_k[l]
            } else {
                furthest_k
            };
        }
    }

    /// Change of the memory by a step to T̂. Lanes leave their branches nearly together, so all lanes are computed side by
    /// side; a lane that stays on its branch keeps it.
    #[inline(always)]
    fn change<P: Proximity>(&self, rules: &Rules<'_, L, P>, temperature_k: &[f64; L]) -> Change<L> {
        let starts = self.turning_points(rules);
        let recollections: [_; L] =
            core::array::from_fn(|l| self.recollection(rules, l, temperature_k[l], starts.get(l)));
        let mut paths = rules.paths(&Courses::from_fn(|l| {
            recollections[l].map_or(Course::new(1.0, self.base[l], None), |next| {
                self.course(rules, l, &next)
            })
        }));
        for l in 0..L {
            if recollections[l].is_none() {
                paths.put(l, &self.paths.get(l));
            }
        }
        Change {
            paths,
            recollections,
        }
    }

    /// Moves the extreme of a lane on, if T̂ lies beyond it.
    #[inline(always)]
    pub(crate) fn advance(&mut self, lane: usize, temperature_k: f64) {
        let progress_k = self.sign[lane] * temperature_k;
        let furthest_k = self.furthest_k[lane];
        self.furthest_k[lane] = if progress_k > furthest_k {
            progress_k
        } else {
            furthest_k
        };
    }

    /// Which reversals a lane remembers once it has come to T̂, `turn` if it turns back; `None` if it stays on its branch.
    fn recollection<P: Proximity>(
        &self,
        rules: &Rules<'_, L, P>,
        lane: usize,
        temperature_k: f64,
        turn: Turn,
    ) -> Option<Recollection> {
        let (depth, sign) = (self.depth[lane], self.sign[lane]);
        let mut next = if self.turns_back(lane, temperature_k) {
            let full = depth == NESTING_CAPACITY;
            let is_nested = rules.rule == Rule::Nested || rules.are_kinetics();
            Recollection {
                sign: -sign,
                kept: match is_nested {
                    false => 0,
                    true if full => depth - 2,
                    true => depth,
                },
                added: Some(turn),
                forgets: is_nested && full,
            }
        } else if self.passes_return(lane, temperature_k) {
            Recollection {
                sign,
                kept: depth,
                added: None,
                forgets: false,
            }
        } else {
            return None;
        };
        // Wiping out: a loop whose return point is passed leaves no trace, neither its start nor the
        // reversal that it returns to.
        while let Some(end) = self.return_point(rules, lane, next.kept, next.added) {
            if next.sign * (temperature_k - end.temperature_k) <= 0.0 {
                break;
            }
            next.kept -= if next.added.take().is_some() { 1 } else { 2 };
        }
        Some(next)
    }

    /// The reversal before the last: where a branch that starts from the last one returns to. Kinetics return where
    /// nothing has transformed since.
    fn return_point<P: Proximity>(
        &self,
        rules: &Rules<'_, L, P>,
        lane: usize,
        kept: usize,
        added: Option<Turn>,
    ) -> Option<Turn> {
        let before = if added.is_some() {
            kept
        } else {
            kept.max(1) - 1
        };
        let end = (before > 0).then(|| self.turns[lane][before - 1])?;
        let start = added.unwrap_or(self.turns[lane][before]);
        let returns = !rules.are_kinetics() || is_level(start, end);
        returns.then_some(end)
    }

    /// Forgets all but the last reversal and the one before, unless nothing has transformed between these.
    fn begin_anew(&mut self, lane: usize) {
        let depth = self.depth[lane];
        let turns = &mut self.turns[lane];
        if depth > 2 && !is_level(turns[depth - 1], turns[depth - 2]) {
            (turns[0], turns[1]) = (turns[depth - 2], turns[depth - 1]);
            self.depth[lane] = 2;
        }
    }

    /// The course that belongs to what a lane remembers.
    fn course<P: Proximity>(
        &self,
        rules: &Rules<'_, L, P>,
        lane: usize,
        next: &Recollection,
    ) -> Course {
        let Recollection {
            sign, kept, added, ..
        } = *next;
        let last = if kept > 0 {
            self.turns[lane][kept - 1]
        } else {
            self.base[lane]
        };
        let end = self.return_point(rules, lane, kept, added);
        Course::new(sign, added.unwrap_or(last), end)
    }
}

/// True if nothing has transformed between two reversals: their shares are equal, to the bit.
fn is_level(one: Turn, other: Turn) -> bool {
    one.level_k.to_bits() == other.level_k.to_bits()
}
