use std::fmt;

/// Halvings of an interval of probabilities: below the last digit of a double.
const HALVINGS: usize = 60;

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Proportion {
    /// So many.
    pub hits: usize,
    /// Of so many.
    pub n: usize,
}

impl Proportion {
    /// Counts.
    pub fn of<T>(all: impl IntoIterator<Item = T>, is_hit: impl Fn(&T) -> bool) -> Self {
        let (mut hits, mut n) = (0, 0);
        for one in all {
            n += 1;
            hits += usize::from(is_hit(&one));
        }
        Self { hits, n }
    }

    /// Share; NaN of none.
    #[must_use]
    pub fn share(self) -> f64 {
        self.hits as f64 / self.n as f64
    }

    /// Exact 95 % interval of the probability (Clopper and Pearson).
    ///
    /// ```text
    /// P(X ≥ hits | lower) = P(X ≤ hits | upper) = 0.025
    /// ```
    #[must_use]
    pub fn interval(self) -> [f64; 2] {
        let Self { hits, n } = self;
        let lower = if hits == 0 {
            0.0
        } else {
            root(|p| at_most(hits - 1, n, p) > 0.975)
        };
        let upper = if hits == n {
            1.0
        } else {
            root(|p| at_most(hits, n, p) > 0.025)
        };
        [lower, upper]
    }
}

impl fmt::Display for Proportion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.n == 0 {
            return f.write_str("none");
        }
        let [lower, upper] = self.interval();
        write!(
            f,
            "{} of {}, {:.1} % ({:.1} to {:.1})",
            self.hits,
            self.n,
            100.0 * self.share(),
            100.0 * lower,
            100.0 * upper
        )
    }
}

/// Where a condition that holds at 0 stops to hold.
fn root(holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// P(X ≤ k) of a binomial distribution, 0 < p < 1.
fn at_most(k: usize, n: usize, p: f64) -> f64 {
    let mut log = n as f64 * (1.0 - p).ln();
    let mut sum = log.exp();
    for j in 0..k {
        log += ((n - j) as f64 / (j + 1) as f64).ln() + p.ln() - (1.0 - p).ln();
        sum += log.exp();
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn none_of_n_has_the_closed_form() {
        let [lower, upper] = Proportion { hits: 0, n: 200 }.interval();
        assert!(lower <= 0.0);
        assert!((upper - (1.0 - 0.025_f64.powf(1.0 / 200.0))).abs() < 1e-12);
        let [lower, upper] = Proportion { hits: 7, n: 7 }.interval();
        assert!((lower - 0.025_f64.powf(1.0 / 7.0)).abs() < 1e-12);
        assert!(upper >= 1.0);
    }

    #[test]
    fn the_interval_mirrors() {
        let [lower, upper] = Proportion { hits: 3, n: 40 }.interval();
        let [other_lower, other_upper] = Proportion { hits: 37, n: 40 }.interval();
        assert!((lower - (1.0 - other_upper)).abs() < 1e-12);
        assert!((upper - (1.0 - other_lower)).abs() < 1e-12);
        assert!(lower < 3.0 / 40.0 && 3.0 / 40.0 < upper);
    }
}
