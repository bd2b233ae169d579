use crate::CaseLine;

/// Bins of stated probabilities.
const BINS: usize = 10;

/// How often names of a stated probability are right.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// Bins of equal width from 0 to 1; those without a name are left out.
    pub bins: Vec<Bin>,
}

/// Names of about one stated probability.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bin {
    /// Mean of the stated probabilities.
    pub stated: f64,
    /// Share of the names that are right.
    pub right: f64,
    /// Number of names.
    pub n: usize,
}

impl Calibration {
    /// Counts the names of all cases. Where the loop is of another family, a name in the transformation is neither
    /// right nor wrong, and does not count.
    pub(super) fn of<'a>(lines: impl IntoIterator<Item = &'a CaseLine>) -> Self {
        let mut names = Vec::new();
        for line in lines {
            for finding in &line.verdict.findings {
                if let Some(is_right) = line.is_right(&finding.effect) {
                    names.push((finding.probability, is_right));
                }
            }
        }
        Self::of_names(&names)
    }

    fn of_names(names: &[(f64, bool)]) -> Self {
        let bin = |number: usize| {
            let inside = names
                .iter()
                .filter(|(stated, _)| ((stated * BINS as f64) as usize).min(BINS - 1) == number);
            let (mut stated, mut right, mut n) = (0.0, 0.0, 0);
            for &(probability, is_right) in inside {
                stated += probability;
                right += f64::from(u8::from(is_right));
                n += 1;
            }
            (n > 0).then(|| Bin {
                stated: stated / n as f64,
                right: right / n as f64,
                n,
            })
        };
        Self {
            bins: (0..BINS).filter_map(bin).collect(),
        }
    }

    /// Number of names.
    #[must_use]
    pub fn n(&self) -> usize {
        self.bins.iter().map(|bin| bin.n).sum()
    }

    /// Mean distance of stated and true probability, a bin by the number of its names.
    ///
    /// ```text
    /// Σ n |right - stated| / Σ n
    /// ```
    #[must_use]
    pub fn error(&self) -> f64 {
        let apart = self
            .bins
            .iter()
            .map(|bin| bin.n as f64 * (bin.right - bin.stated).abs());
        apart.sum::<f64>() / self.n() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_the_mean_distance() {
        let sure = [(0.95, true), (0.95, true), (0.95, false), (0.95, true)];
        let calibration = Calibration::of_names(&sure);
        assert!((calibration.error() - 0.2).abs() < 1e-12);
        let both = Calibration::of_names(&[(0.5, true), (0.5, false), (1.0, true)]);
        assert!(both.error() < 1e-12);
        assert_eq!(both.n(), 3);
    }
}
