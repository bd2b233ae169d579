//! A change that wanders: a smooth curve, bent anew at each of the knots that are spread over the run.

/// Change since the start of the run, in each lane: a smooth curve through 0 at the start and `K` knots after it, equally
/// spaced, the last one at the end of the run.
///
/// ```text
/// v(s) = Σ_j v_j c(K s - j),   s = (start + t)/run length in [0, 1],   v_0 = 0      [Keys1981]
/// c(x) = 1 - 5/2 x² + 3/2 |x|³ for |x| ≤ 1,   2 - 4 |x| + 5/2 x² - ½ |x|³ for |x| ≤ 2
/// ```
///
/// with v_(-1) = 2 v_0 - v_1 before the start and v_(K+1) = 2 v_K - v_(K-1) behind the end. A knot changes its
/// neighborhood alone, as the airing of a room does; a sensor warms up once ([`Knots`](crate::knots::Knots)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spline<const L: usize, const K: usize> {
    pub(crate) value: [[f64; L]; K],
}

impl<const L: usize, const K: usize> Spline<L, K> {
    /// Adds the change at a share of the run; beyond its end that at the end.
    #[inline(always)]
    pub(crate) fn add(&self, run_share: f64, to: &mut [f64; L]) {
        let place = K as f64 * run_share.clamp(0.0, 1.0);
        for (k, value) in self.value.iter().enumerate() {
            let weight = weight(K, k + 1, place);
            for l in 0..L {
                to[l] += value[l] * weight;
            }
        }
    }
}

/// Weight of the knot `own` of 1 to `last` at a place among them.
#[inline(always)]
fn weight(last: usize, own: usize, place: f64) -> f64 {
    let at = |knot: f64| cubic(place - knot);
    let (before, behind) = (-1.0, last as f64 + 1.0);
    let mut weight = at(own as f64);
    // The knots beyond the ends are made of those within.
    if own == 1 {
        weight -= at(before);
    }
    if own == last {
        weight += 2.0 * at(behind);
    }
    if own + 1 == last {
        weight -= at(behind);
    }
    weight
}

/// c(x).
#[inline(always)]
fn cubic(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        1.0 + x * x * (1.5 * x - 2.5)
    } else if x < 2.0 {
        2.0 + x * (x * (2.5 - 0.5 * x) - 4.0)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_abs_diff_eq;

    use super::*;

    fn at(value: [[f64; 1]; 8], run_share: f64) -> f64 {
        let mut to = [0.0];
        Spline { value }.add(run_share, &mut to);
        to[0]
    }

    #[test]
    fn it_goes_through_its_knots_and_is_straight_between_those_of_a_line() {
        let line = core::array::from_fn(|k| [0.5 * (k + 1) as f64]);
        for step in 0..=40 {
            let run_share = f64::from(step) / 40.0;
            assert_abs_diff_eq!(at(line, run_share), 4.0 * run_share, epsilon = 1e-12);
        }
        assert_abs_diff_eq!(at(line, 1.7), 4.0, epsilon = 1e-12);
        let bent = [[3.0], [-1.0], [2.0], [0.5], [0.0], [4.0], [1.0], [-2.0]];
        for (k, [value]) in bent.into_iter().enumerate() {
            assert_abs_diff_eq!(at(bent, (k + 1) as f64 / 8.0), value, epsilon = 1e-12);
        }
        assert_abs_diff_eq!(at(bent, 0.0), 0.0, epsilon = 1e-12);
    }

    #[test]
    fn it_has_no_corners() {
        let bent = [[3.0], [-1.0], [2.0], [0.5], [0.0], [4.0], [1.0], [-2.0]];
        let step = 1e-6;
        for k in 1..8 {
            let knot = f64::from(k) / 8.0;
            let slope = |from: f64| (at(bent, from + step) - at(bent, from)) / step;
            assert_abs_diff_eq!(slope(knot - step), slope(knot), epsilon = 1e-2);
        }
    }
}
