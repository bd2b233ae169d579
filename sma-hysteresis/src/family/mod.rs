//! Loops of other families: relays and kinetics, where the share of the material that has transformed is what is known.

mod bends;
mod kinetics;
mod populations;
mod relays;

pub use populations::SecondPopulation;

use core::fmt;

use crate::limiting_loop::LimitingLoop;
use crate::memory::FARTHEST_K;
use crate::path::{Course, Courses, Path, Paths, Turn};
use crate::vectors::widest_vectors;
use bends::Bends;
use kinetics::Kinetics;
use populations::Populations;
use relays::Relays;

/// Which curves the branches of a loop are. All have the same center and half width, and spread over about the same
/// temperatures for the same `h_0`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum LoopFamily {
    /// Arc tangents, and branches that near them: the paper's.
    #[default]
    Proximity,
    /// Independent relays, Preisach's operator \[Preisach1935, Mayergoyz2003\]. The temperatures A and B at which one
    /// switches up and down are normally distributed, joined by Plackett's copula \[Plackett1965\]:
    ///
    /// ```text
    /// deviations 1.5 h_0 about T_mid ± T_c,   odds ratio e^(5 ζ): the larger ζ, the more alike the relays' widths
    /// in deviations, x counts as x/(1 + (τ x)²)^¼,   τ: the tails, 0 for the normal distribution
    /// heating from T_r: Δξ ∝ P(T_r < A ≤ T, B ≥ T_r),   cooling: Δξ ∝ P(A ≤ T_r, T ≤ B < T_r)
    /// ```
    ///
    /// with the factor that leads the branch to its return point, which is 1 for relays that are all wider than 0. One
    /// part in a thousand takes no heed of the other temperature, so that from every start all relays can be reached.
    /// Bends change the distribution of either temperature, see
    /// [`Hysteresis::with_bends`](crate::Hysteresis::with_bends), and a second population of relays may stand beside the first, see
    /// [`SecondPopulation`].
    Relays,
    /// Cosine kinetics of Liang and Rogers \[LiangRogers1990\], of what is left to transform, skewed:
    ///
    /// ```text
    /// heating from T_r: ξ = ξ_r + (1 - ξ_r) ((1 - s) sin²(π/2 v) + s sin(π/2 v))
    /// v = (1 + k) u/(1 + k u),   u = (T - A)/(A_f - A),   A = max(A_s, T_r)
    /// A_s, A_f = T_mid + T_c ∓ 2.25 h_0,   1 + k = e^(6 (ζ - ½))
    /// ```
    ///
    /// and below, mirrored, cooling. ζ = ½ and s = 0 are the source's; with a larger ζ a transformation ends slowly, and with a
    /// larger s it sets in sharply, at a finite rate, as polynomial \[BoydLagoudas1996\] and exponential \[Tanaka1986\] laws have it. An
    /// excursion in which nothing transforms leaves no trace; any other starts anew. Bends change the course, see
    /// [`Hysteresis::with_bends`](crate::Hysteresis::with_bends).
    Kinetics,
}

impl LoopFamily {
    /// All of them, the paper's first.
    pub const ALL: [Self; 3] = [Self::Proximity, Self::Relays, Self::Kinetics];

    /// Name in files.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Proximity => "limiting-loop-proximity",
            Self::Relays => "relays",
            Self::Kinetics => "cosine-kinetics",
        }
    }

    /// True if an excursion after which hardly anything has transformed changes all that follows. Fractions then jump where a
    /// parameter passes the value from which one leaves a trace.
    #[must_use]
    pub const fn jumps(self) -> bool {
        matches!(self, Self::Kinetics)
    }

    /// The family of that name.
    #[must_use]
    pub fn parse(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|family| family.id() == id)
    }
}

impl fmt::Display for LoopFamily {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}

/// Share of the material that is as good as none.
const NOTHING: f64 = 1e-13;
/// Largest τ: beyond, a tenth of the relays lies outside of ten deviations.
pub(crate) const HEAVIEST_TAILS: f64 = 4.0;
/// Upper limit of the factor that stretches a branch, and its rounding error with it. To return to a start between the
/// limiting curves, a branch must lead farther than relays do.
const STRETCH: f64 = 1e8;

/// The curves of lanes side by side, other than the paper's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Curves<const L: usize> {
    Relays(Relays<L>),
    Populations(Populations<L>),
    Kinetics(Kinetics<L>),
}

/// Constants of a branch, from which the share at a temperature is computed.
///
/// ```text
/// share = share at the start + rise (w(T) - w at the start),   w = w(T; fixed)
/// ```
#[derive(Debug, Clone, Copy)]
struct Along {
    /// Of relays the share that is still up (heating), or was up (cooling); of kinetics where its transformation begins,
    /// δ T̂.
    fixed: f64,
    /// Of relays w at the start; of kinetics 1/K of the range.
    scale: f64,
    /// Of a second population of relays what `fixed` is of the first.
    further: f64,
}

impl Along {
    #[inline(always)]
    fn of(path: &Path) -> Self {
        Self {
            fixed: path.proximity_k,
            scale: path.inverse_proximity_per_k,
            further: path.further,
        }
    }
}

/// A way that a material transforms on: how much of it, from its start, and the slope of that, 1/K.
type Way = (f64, f64);

impl<const L: usize> Curves<L> {
    /// `None` for the paper's.
    pub(crate) fn new(
        family: LoopFamily,
        limits: &LimitingLoop<L>,
        zeta: [f64; L],
    ) -> Option<Self> {
        match family {
            LoopFamily::Proximity => None,
            LoopFamily::Relays => Some(Self::Relays(Relays::new(limits, zeta))),
            LoopFamily::Kinetics => Some(Self::Kinetics(Kinetics::new(limits, zeta))),
        }
    }

    /// Curves with tails τ. Only relays have tails; kinetics stay as they are.
    pub(crate) fn with_tails(self, tails: [f64; L]) -> Self {
        match self {
            Self::Relays(relays) => Self::Relays(relays.with_tails(tails)),
            Self::Populations(both) => {
                Self::Populations(both.map(|relays| relays.with_tails(tails)))
            }
            Self::Kinetics(_) => self,
        }
    }

    /// Curves with an onset of sharpness s. Only kinetics have one; relays stay as they are.
    pub(crate) fn with_onset(self, sharpness: [f64; L]) -> Self {
        match self {
            Self::Kinetics(kinetics) => Self::Kinetics(kinetics.with_onset(sharpness)),
            Self::Relays(_) | Self::Populations(_) => self,
        }
    }

    /// Curves with a second population. Only relays have one; kinetics stay as they are.
    pub(crate) fn with_second_population(
        self,
        limits: &LimitingLoop<L>,
        zeta: [f64; L],
        second: [SecondPopulation; L],
    ) -> Self {
        match self {
            Self::Relays(first) | Self::Populations(Populations { first, .. }) => {
                if second.iter().all(SecondPopulation::is_none) {
                    Self::Relays(first)
                } else {
                    Self::Populations(Populations::new(first, limits, zeta, second))
                }
            }
            Self::Kinetics(_) => self,
        }
    }

    /// Curves with bends c_1, c_2, c_3.
    pub(crate) fn with_bends(self, bends: [[f64; L]; 3]) -> Self {
        let bends = Bends(bends);
        match self {
            Self::Relays(relays) => Self::Relays(relays.with_bends(bends)),
            Self::Populations(both) => {
                Self::Populations(both.map(|relays| relays.with_bends(bends)))
            }
            Self::Kinetics(kinetics) => Self::Kinetics(kinetics.with_bends(bends)),
        }
    }

    /// Where a material begins that has come to T̂ between the limiting curves, by heating or by cooling: on one of them, far away,
    /// that of cooling with as much transformed in all as leads through the place, that of heating with as much that never does.
    pub(crate) fn start(
        &self,
        lane: usize,
        temperature_k: f64,
        share: f64,
        by_heating: bool,
    ) -> Turn {
        if share <= 0.0 {
            return Turn {
                temperature_k: -FARTHEST_K,
                level_k: 0.0,
            };
        }
        let [lower, upper] = self.limits_at(lane, temperature_k);
        let level = (1.0 - share) * lower + share * upper;
        if by_heating {
            let is_lower = level < 1.0 && lower < level;
            return Turn {
                temperature_k: -FARTHEST_K,
                level_k: if is_lower {
                    1.0 - (1.0 - level) / (1.0 - lower)
                } else {
                    0.0
                },
            };
        }
        Turn {
            temperature_k: FARTHEST_K,
            level_k: if upper > level { level / upper } else { 1.0 },
        }
    }

    /// The branches of courses. Their `rise` has the sign of their direction.
    ///
    /// By a call, as in [`Curves::levels_by_call`]: branches change rarely.
    #[cold]
    #[inline(never)]
    pub(crate) fn paths(&self, courses: &Courses<L>) -> Paths<L> {
        widest_vectors(
            #[inline(always)]
            || self.paths_inline(courses),
        )
    }

    #[inline(always)]
    fn paths_inline(&self, courses: &Courses<L>) -> Paths<L> {
        // A choice inside the loop would keep the lanes from being computed side by side.
        match self {
            Self::Relays(relays) => Paths::of(
                courses,
                #[inline(always)]
                |l, course| relays.path(l, course),
            ),
            Self::Populations(both) => Paths::of(
                courses,
                #[inline(always)]
                |l, course| both.path(l, course),
            ),
            Self::Kinetics(kinetics) => Paths::of(
                courses,
                #[inline(always)]
                |l, course| kinetics.path(l, course),
            ),
        }
    }

    /// Transformed shares on branches at T̂, and their slopes, 1/K.
    #[inline(always)]
    fn levels(&self, paths: &Paths<L>, temperature_k: &[f64; L]) -> ([f64; L], [f64; L]) {
        match self {
            Self::Relays(relays) => relays.levels(paths, temperature_k),
            Self::Populations(both) => both.levels(paths, temperature_k),
            Self::Kinetics(kinetics) => kinetics.levels(paths, temperature_k),
        }
    }

    /// [`Curves::levels`] by a call: the paper's loop, which makes it in no sample, keeps its registers where both are inlined.
    #[cold]
    #[inline(never)]
    pub(crate) fn levels_by_call(
        &self,
        paths: &Paths<L>,
        temperature_k: &[f64; L],
    ) -> ([f64; L], [f64; L]) {
        widest_vectors(
            #[inline(always)]
            || self.levels(paths, temperature_k),
        )
    }

    /// Transformed shares on the limiting curves at T̂, that of heating first.
    pub(crate) fn limits_at(&self, lane: usize, temperature_k: f64) -> [f64; 2] {
        [1.0, -1.0].map(|sign| {
            let far = Turn {
                temperature_k: -sign * FARTHEST_K,
                level_k: if sign > 0.0 { 0.0 } else { 1.0 },
            };
            let course = Course::new(sign, far, None);
            match self {
                Self::Relays(relays) => relays.limit_at(lane, &course, temperature_k),
                Self::Populations(both) => both.limit_at(lane, &course, temperature_k),
                Self::Kinetics(kinetics) => kinetics.limit_at(lane, &course, temperature_k),
            }
        })
    }
}

/// How the materials of a family transform along a branch.
trait Transforms<const L: usize> {
    /// Constants of a branch of direction `sign` that starts at T̂.
    fn along(&self, lane: usize, sign: f64, start_k: f64) -> Along;

    /// The way from the start of a branch to T̂.
    fn way(&self, lane: usize, sign: f64, along: &Along, temperature_k: f64) -> Way;

    /// The branch of a course, to the end of the transformation if it does not return.
    #[inline(always)]
    fn path(&self, lane: usize, course: &Course) -> Path {
        let Course { sign, start, .. } = *course;
        let last = Turn {
            temperature_k: sign * FARTHEST_K,
            level_k: if sign > 0.0 { 1.0 } else { 0.0 },
        };
        let end = if course.returns { course.end } else { last };
        let along = self.along(lane, sign, start.temperature_k);
        let natural = Path {
            start,
            rise: 1.0_f64.copysign(sign),
            proximity_k: along.fixed,
            inverse_proximity_per_k: along.scale,
            further: along.further,
        };
        let (sign, end_k) = going(&natural, end.temperature_k);
        let (way, _) = self.way(lane, sign, &along, end_k);
        let left = sign * (end.level_k - start.level_k);
        let leads = (way > NOTHING) & (left > 0.0) & (left < STRETCH * way);
        let rise = if leads { left / way } else { 0.0 };
        Path {
            rise: rise.copysign(sign),
            ..natural
        }
    }

    /// Transformed share on a branch at T̂, and its slope, 1/K.
    #[inline(always)]
    fn level(&self, lane: usize, path: &Path, temperature_k: f64) -> Way {
        let (sign, at_k) = going(path, temperature_k);
        let (way, per_k) = self.way(lane, sign, &Along::of(path), at_k);
        let slope_per_k = path.rise.abs() * per_k;
        (
            path.start.level_k + path.rise * way,
            if slope_per_k < 0.0 { 0.0 } else { slope_per_k },
        )
    }

    /// [`Curves::levels`] of one family.
    #[inline(always)]
    fn levels(&self, paths: &Paths<L>, temperature_k: &[f64; L]) -> ([f64; L], [f64; L]) {
        let (mut share, mut per_k) = ([0.0; L], [0.0; L]);
        for l in 0..L {
            (share[l], per_k[l]) = self.level(l, &paths.get(l), temperature_k[l]);
        }
        (share, per_k)
    }

    /// Transformed share at T̂ on the branch of a course.
    fn limit_at(&self, lane: usize, course: &Course, temperature_k: f64) -> f64 {
        self.level(lane, &self.path(lane, course), temperature_k).0
    }
}

/// Direction of a branch, and T̂ as it counts there: backward within the dead band nothing happens.
#[inline(always)]
fn going(path: &Path, temperature_k: f64) -> (f64, f64) {
    let sign = path.rise.signum();
    let start_k = path.start.temperature_k;
    // Written so that NaN passes.
    let is_behind = sign * (temperature_k - start_k) < 0.0;
    (sign, if is_behind { start_k } else { temperature_k })
}

/// That of the branch of a direction, of both of a lane, heating first.
#[inline(always)]
fn of<const L: usize>(both: &[[f64; L]; 2], sign: f64, lane: usize) -> f64 {
    // Both are read: lanes of different directions stay side by side.
    let [heating, cooling] = [both[0][lane], both[1][lane]];
    if sign < 0.0 { cooling } else { heating }
}
