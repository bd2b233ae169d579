//! One branch between a reversal and the point to which it returns.

use crate::limiting_loop::LimitingLoop;
use crate::proximity::Proximity;

/// Smallest movement against the current direction that counts as a reversal, K.
///
/// Below it the operator follows its branch backward. The movement is measured from the extreme
/// reached, so that a slow creep is a reversal as soon as it has come this far.
pub const REVERSAL_DEAD_BAND_K: f64 = 1e-9;

/// Proximity below which a point counts as lying on the limiting curve, K: nothing is divided by it.
const SMALLEST_PROXIMITY_K: f64 = 1e-9;

/// A remembered reversal point (T_r, ξ_r).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reversal {
    /// Temperature at the reversal, °C.
    pub temperature_degc: f64,
    /// Fraction at the reversal.
    pub fraction: f64,
}

/// A point of the loop in the coordinates in which the equations are short.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Turn {
    /// T̂ = T - T_mid, K.
    pub(crate) temperature_k: f64,
    /// Anhysteretic temperature h_0 tan(π (ξ - ξ_0)/(2 ξ_s)), K: the numerator of the atan in eqs 4
    /// and 11, known from the sample before.
    pub(crate) level_k: f64,
}

/// A branch, eqs 5-11, in the anhysteretic temperature u = h_0 tan(π (ξ - ξ_0)/(2 ξ_s)).
///
/// ```text
/// T_pr = u_r + δ T_c - T̂_r                          [Sadeghi, eqs 5-8]
/// x = (T̂ - T̂_r)/T_pr                                [Sadeghi, eq. 10]
/// u = u_r + g (T̂ - T̂_r) - s T_pr (1 - P(x))         [Sadeghi, eqs 9, 11, where g = s = 1]
/// ```
///
/// With g = s = 1 this is the paper's u = T_pr P(x) + T̂ - δ T_c, written from the reversal point so
/// that the branch starts there to the last bit. A nested branch must also end in its return point
/// (T̂_p, u_p). The natural branch misses it; what is rescaled depends on the side:
///
/// - it would pass beyond the point: the whole rise u - u_r shrinks, g = s = (u_p - u_r)/(u(T̂_p) - u_r);
/// - it would fall short: the distance to the limiting curve fades more slowly, g = 1 and
///   s = (d_p - T_pr)/(d(T̂_p) - T_pr) with d = u - T̂ + δ T_c.
///
/// Where branches spread differently u is that of the branch, h_0 k_δ tan(…): with u_r times k_δ the same equations
/// hold, and g and T_pr over k_δ give the common one.
///
/// Both factors lie in \[0, 1\], also where rounding leaves nothing of their quotients, so the slope
/// stays within 0 and that of the limiting curve: the branch is monotone and never leaves the loop,
/// whatever ζ.
///
/// # Differs from the source
///
/// Eqs 7 and 8 are printed with ξ_0 where the fraction of the point itself (ξ, ξ_r) must stand, eq. 11
/// without its ξ_0. Rescaling is ours: the source remembers the last reversal only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Path {
    pub(crate) start: Turn,
    /// g.
    pub(crate) rise: f64,
    /// s T_pr, K.
    pub(crate) proximity_k: f64,
    /// 1/T_pr, 1/K. On the limiting curve, where nothing is left to fade, any value of the right sign:
    /// 0 would make ∞ to `NaN`.
    pub(crate) inverse_proximity_per_k: f64,
    /// Of relays of two populations what the start of the branch fixes of the second; 0 of all others.
    pub(crate) further: f64,
}

impl Path {
    /// The branch of a course. Written with selections alone: lanes are computed side by side.
    #[inline(always)]
    pub(crate) fn new<const L: usize, P: Proximity>(
        limits: &LimitingLoop<L>,
        proximity: &P,
        lane: usize,
        course: &Course,
    ) -> Self {
        let Course {
            sign,
            start,
            end,
            returns,
        } = *course;
        let shift_k = sign * limits.half_width_k(lane);
        let widening = limits.widening(lane, sign);
        let Natural {
            path: natural,
            distance_k,
            is_limiting,
        } = Self::natural(limits, lane, sign, start);
        let reached_k = natural.level_k(proximity, lane, end.temperature_k);
        let excess_k = sign * (reached_k - end.level_k);
        let shrunk = factor((end.level_k - start.level_k) / (reached_k - start.level_k));
        let limit_k = end.temperature_k - shift_k;
        let left_k = |level_k: f64| level_k * widening - limit_k - distance_k;
        let slowed = factor(left_k(end.level_k) / left_k(reached_k));
        let passes = returns & (excess_k > 0.0);
        let falls_short = returns & (excess_k < 0.0);
        let rise_scale = if passes { shrunk } else { 1.0 };
        let proximity_scale = if falls_short { slowed } else { rise_scale };
        Self {
            rise: rise_scale * natural.rise,
            proximity_k: proximity_scale * natural.proximity_k,
            ..natural
        }
        .or_limiting(is_limiting, sign, natural.rise)
    }

    /// The branch of direction `sign` from `start` that returns to no point.
    #[inline(always)]
    pub(crate) fn without_return<const L: usize>(
        limits: &LimitingLoop<L>,
        lane: usize,
        sign: f64,
        start: Turn,
    ) -> Self {
        let Natural {
            path, is_limiting, ..
        } = Self::natural(limits, lane, sign, start);
        path.or_limiting(is_limiting, sign, path.rise)
    }

    /// The paper's branch of direction `sign` from `start`.
    #[inline(always)]
    fn natural<const L: usize>(
        limits: &LimitingLoop<L>,
        lane: usize,
        sign: f64,
        start: Turn,
    ) -> Natural {
        let shift_k = sign * limits.half_width_k(lane);
        let widening = limits.widening(lane, sign);
        let distance_k = start.level_k * widening + shift_k - start.temperature_k;
        // T_pr has the sign of the direction; what does not reach the threshold, or has the wrong
        // sign by rounding, lies on the limiting curve already. Where curves cross it may lie beyond.
        let within_k = sign * distance_k;
        let is_beyond =
            (widening.to_bits() != 1.0_f64.to_bits()) & (within_k < -SMALLEST_PROXIMITY_K);
        Natural {
            path: Self {
                start,
                rise: 1.0 / widening,
                proximity_k: distance_k / widening,
                inverse_proximity_per_k: sign / distance_k.abs(),
                further: 0.0,
            },
            distance_k,
            is_limiting: (within_k <= SMALLEST_PROXIMITY_K) & !is_beyond,
        }
    }

    /// The branch, or where it begins on the limiting curve one along that, wherever it returns to.
    #[inline(always)]
    fn or_limiting(self, is_limiting: bool, sign: f64, rise: f64) -> Self {
        Self {
            rise: if is_limiting { rise } else { self.rise },
            proximity_k: if is_limiting { 0.0 } else { self.proximity_k },
            inverse_proximity_per_k: if is_limiting {
                sign
            } else {
                self.inverse_proximity_per_k
            },
            ..self
        }
    }

    /// Another branch if `is_left`, else this one.
    #[inline(always)]
    pub(crate) fn or(self, other: Self, is_left: bool) -> Self {
        let chosen = |own: f64, others: f64| if is_left { others } else { own };
        Self {
            start: Turn {
                temperature_k: chosen(self.start.temperature_k, other.start.temperature_k),
                level_k: chosen(self.start.level_k, other.start.level_k),
            },
            rise: chosen(self.rise, other.rise),
            proximity_k: chosen(self.proximity_k, other.proximity_k),
            inverse_proximity_per_k: chosen(
                self.inverse_proximity_per_k,
                other.inverse_proximity_per_k,
            ),
            further: chosen(self.further, other.further),
        }
    }

    /// u at T̂, K.
    #[inline(always)]
    pub(crate) fn level_k<P: Proximity>(
        &self,
        proximity: &P,
        lane: usize,
        temperature_k: f64,
    ) -> f64 {
        let travel_k = temperature_k - self.start.temperature_k;
        let x = travel_k * self.inverse_proximity_per_k;
        self.start.level_k + self.rise * travel_k - self.proximity_k * proximity.decay(lane, x)
    }

    /// du/dT̂, from 0 to 1; `NaN` gives `NaN`.
    #[inline(always)]
    pub(crate) fn level_slope<P: Proximity>(
        &self,
        proximity: &P,
        lane: usize,
        temperature_k: f64,
    ) -> f64 {
        let x = (temperature_k - self.start.temperature_k) * self.inverse_proximity_per_k;
        let slope = self.rise
            - self.proximity_k * self.inverse_proximity_per_k * proximity.decay_slope(lane, x);
        // T_pr times 1/T_pr may exceed 1 by rounding.
        if slope < 0.0 { 0.0 } else { slope }
    }
}

/// A branch before what it returns to is heeded.
#[derive(Debug, Clone, Copy)]
struct Natural {
    path: Path,
    /// T_pr times the widening, K.
    distance_k: f64,
    /// True if it begins on the limiting curve.
    is_limiting: bool,
}

/// A rescaling factor: over the shortest way to a return point its quotient may be off by rounding
/// or 0/0, and the natural branch, factor 1, then misses the point by no more than rounding.
#[inline(always)]
fn factor(quotient: f64) -> f64 {
    let nearest = if quotient < 0.0 { 0.0 } else { 1.0 };
    if (0.0..=1.0).contains(&quotient) {
        quotient
    } else {
        nearest
    }
}

/// Where a branch leads.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Course {
    /// δ, +1 or -1.
    pub(crate) sign: f64,
    pub(crate) start: Turn,
    /// The point to return to, if `returns`.
    pub(crate) end: Turn,
    pub(crate) returns: bool,
}

impl Course {
    /// The course of direction `sign` from `start` through `end`, if there is a point to return to.
    #[inline(always)]
    pub(crate) fn new(sign: f64, start: Turn, end: Option<Turn>) -> Self {
        Self {
            sign,
            start,
            end: end.unwrap_or_default(),
            returns: end.is_some(),
        }
    }
}

/// Branches of lanes side by side, a [`Path`] each.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub(crate) struct Paths<const L: usize> {
    start_temperature_k: [f64; L],
    start_level_k: [f64; L],
    rise: [f64; L],
    proximity_k: [f64; L],
    inverse_proximity_per_k: [f64; L],
    further: [f64; L],
}

impl<const L: usize> Paths<L> {
    /// Before any branch is known.
    pub(crate) const NONE: Self = Self {
        start_temperature_k: [0.0; L],
        start_level_k: [0.0; L],
        rise: [0.0; L],
        proximity_k: [0.0; L],
        inverse_proximity_per_k: [0.0; L],
        further: [0.0; L],
    };

    /// Branches that a function gives for each lane.
    #[inline(always)]
    pub(crate) fn from_fn(path_of: impl Fn(usize) -> Path) -> Self {
        let mut paths = Self::NONE;
        for l in 0..L {
            paths.put(l, &path_of(l));
        }
        paths
    }

    /// The branches of courses, each made by `path_of` of its lane and its course.
    #[inline(always)]
    pub(crate) fn of(courses: &Courses<L>, path_of: impl Fn(usize, &Course) -> Path) -> Self {
        Self::from_fn(
            #[inline(always)]
            |l| path_of(l, &courses.get(l)),
        )
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Path {
        Path {
            start: Turn {
                temperature_k: self.start_temperature_k[lane],
                level_k: self.start_level_k[lane],
            },
            rise: self.rise[lane],
            proximity_k: self.proximity_k[lane],
            inverse_proximity_per_k: self.inverse_proximity_per_k[lane],
            further: self.further[lane],
        }
    }

    #[inline(always)]
    pub(crate) fn put(&mut self, lane: usize, path: &Path) {
        self.start_temperature_k[lane] = path.start.temperature_k;
        self.start_level_k[lane] = path.start.level_k;
        self.rise[lane] = path.rise;
        self.proximity_k[lane] = path.proximity_k;
        self.inverse_proximity_per_k[lane] = path.inverse_proximity_per_k;
        self.further[lane] = path.further;
    }
}

/// Where the branches of lanes side by side lead, a [`Course`] each.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Courses<const L: usize> {
    sign: [f64; L],
    start_temperature_k: [f64; L],
    start_level_k: [f64; L],
    end_temperature_k: [f64; L],
    end_level_k: [f64; L],
    /// 1 if the branch returns, 0 if not: a lane as wide as the others.
    returns: [f64; L],
}

impl<const L: usize> Courses<L> {
    /// Courses that a function gives for each lane.
    #[inline(always)]
    pub(crate) fn from_fn(course_of: impl Fn(usize) -> Course) -> Self {
        let mut courses = Self {
            sign: [0.0; L],
            start_temperature_k: [0.0; L],
            start_level_k: [0.0; L],
            end_temperature_k: [0.0; L],
            end_level_k: [0.0; L],
            returns: [0.0; L],
        };
        for l in 0..L {
            let course = course_of(l);
            courses.sign[l] = course.sign;
            courses.start_temperature_k[l] = course.start.temperature_k;
            courses.start_level_k[l] = course.start.level_k;
            courses.end_temperature_k[l] = course.end.temperature_k;
            courses.end_level_k[l] = course.end.level_k;
            courses.returns[l] = f64::from(u8::from(course.returns));
        }
        courses
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Course {
        Course {
            sign: self.sign[lane],
            start: Turn {
                temperature_k: self.start_temperature_k[lane],
                level_k: self.start_level_k[lane],
            },
            end: Turn {
                temperature_k: self.end_temperature_k[lane],
                level_k: self.end_level_k[lane],
            },
            returns: self.returns[lane] > 0.0,
        }
    }
}
