/// Most steps of [`root`]: far more than a smooth function needs.
const MAX_STEPS: usize = 180;

/// A zero of a function between two ends of different sign, to within `tolerance`; `None` without a change of
/// sign, or where an end is `NaN`.
///
/// Two steps of regula falsi that halves the weight of an end that stays (the Illinois rule, `[Dowell1971]`), then one
/// of bisection, which makes an end of kinks and jumps.
pub(crate) fn root(
    mut function: impl FnMut(f64) -> f64,
    ends: [f64; 2],
    tolerance: f64,
) -> Option<f64> {
    let [mut a, mut b] = ends;
    let [mut at_a, mut at_b] = [function(a), function(b)];
    if at_a == 0.0 {
        return Some(a);
    }
    if at_b == 0.0 {
        return Some(b);
    }
    if !differ(at_a, at_b) {
        return None;
    }
    for step in 0..MAX_STEPS {
        if (b - a).abs() <= tolerance {
            break;
        }
        let secant = b - at_b * (b - a) / (at_b - at_a);
        let middle = 0.5 * (a + b);
        let x = if step % 3 < 2 && differ(secant - a, secant - b) {
            secant
        } else {
            middle
        };
        let at_x = function(x);
        if at_x == 0.0 {
            return Some(x);
        }
        // b is the newest point; a the other side.
        if differ(at_x, at_b) {
            a = b;
            at_a = at_b;
        } else {
            at_a *= 0.5;
        }
        b = x;
        at_b = at_x;
    }
    Some(b)
}

/// True if two values are of opposite sign; false for 0 and `NaN`.
fn differ(value: f64, other: f64) -> bool {
    (value < 0.0 && other > 0.0) || (value > 0.0 && other < 0.0)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may end in a panic")]
mod tests {
    use super::root;

    #[test]
    fn finds_the_zero_of_smooth_and_of_kinked_functions() {
        for (function, expected) in [
            ((|x| x * x * x - 2.0) as fn(f64) -> f64, 2.0_f64.cbrt()),
            (|x| (20.0 * (x - 1.25)).tanh(), 1.25),
            (|x| if x < 0.3 { -1e-3 } else { (x - 0.3) * 1e6 }, 0.3),
            (|x| x, 0.0),
        ] {
            let found = root(function, [-4.0, 5.0], 1e-12).unwrap();
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    #[test]
    fn no_change_of_sign_is_no_root() {
        assert_eq!(root(|x| x * x + 1.0, [-1.0, 1.0], 1e-9), None);
        assert_eq!(root(|_| f64::NAN, [-1.0, 1.0], 1e-9), None);
    }
}
