/// Secant steps before the bracket is halved instead; three or four are usual.
const SECANT_STEPS: usize = 12;
/// Halvings after which the bracket is taken as it is.
const HALVINGS: usize = 80;

/// The root of a function whose slope is nowhere below 1, from a guess of it and of the slope there.
///
/// The least slope gives the bracket: the root lies no farther from the guess than the function's value there.
/// Inside, the secant. The function is last asked at what is returned.
pub(crate) fn rising_root(
    (guess, slope): (f64, f64),
    tolerance: f64,
    mut f: impl FnMut(f64) -> f64,
) -> f64 {
    let (mut a, mut fa) = (guess, f(guess));
    if fa.abs() <= tolerance {
        return a;
    }
    // A little farther, against rounding.
    let far = a - fa * (1.0 + 1e-6);
    let (mut low, mut high) = (far.min(a), far.max(a));
    let mut b = a - fa / slope.max(1.0);
    for iteration in 0..SECANT_STEPS + HALVINGS {
        let fb = f(b);
        if fb.abs() <= tolerance {
            break;
        }
        if fb > 0.0 {
            high = b;
        } else {
            low = b;
        }
        let secant = b - fb * (b - a) / (fb - fa);
        (a, fa) = (b, fb);
        b = if iteration < SECANT_STEPS && secant > low && secant < high {
            secant
        } else {
            0.5 * (low + high)
        };
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_root_of_a_kinked_function_from_both_sides() {
        let f = |x: f64| x + 20.0 * x.clamp(0.0, 1.0) - 7.0;
        for guess in [-50.0, 0.2, 0.9, 50.0] {
            let x = rising_root((guess, 3.0), 1e-12, f);
            assert!((x - 1.0 / 3.0).abs() < 1e-12, "{guess}: {x}");
        }
    }
}
