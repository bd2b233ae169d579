use std::fmt;

use crate::Proportion;

/// A quantity with what it should come to.
#[derive(Debug, Clone, PartialEq)]
pub struct Score {
    /// Description of the quantity, for people.
    pub quantity: String,
    /// Its value.
    pub figure: Figure,
    /// Its target; `None` if it is only reported.
    pub target: Option<Target>,
}

/// Value of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Figure {
    /// So many of so many.
    Share(Proportion),
    /// A number over so many cases.
    Number {
        /// The number.
        value: f64,
        /// Of so many.
        n: usize,
        /// Its unit; empty if it has none.
        unit: &'static str,
    },
}

/// Target of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// At least.
    AtLeast(f64),
    /// At most.
    AtMost(f64),
    /// At most, and the upper end of its 95 % interval at most.
    AtMostSurely(f64, f64),
}

impl Score {
    /// True if it meets its target; `None` without a target or without a case.
    #[must_use]
    pub fn holds(&self) -> Option<bool> {
        let value = self.figure.value()?;
        Some(match self.target? {
            Target::AtLeast(least) => value >= least,
            Target::AtMost(most) => value <= most,
            Target::AtMostSurely(most, surely) => {
                let upper = match self.figure {
                    Figure::Share(proportion) => proportion.interval()[1],
                    Figure::Number { value, .. } => value,
                };
                value <= most && upper <= surely
            }
        })
    }
}

impl Figure {
    /// The number; `None` of no case.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        match *self {
            Self::Share(proportion) => (proportion.n > 0).then(|| proportion.share()),
            Self::Number { value, n, .. } => (n > 0).then_some(value),
        }
    }

    fn is_share(&self) -> bool {
        matches!(self, Self::Share(_))
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Share(proportion) => write!(f, "{proportion}"),
            Self::Number { n: 0, .. } => f.write_str("none"),
            Self::Number { value, n, unit } => {
                let space = if unit.is_empty() { "" } else { " " };
                write!(f, "{value:.3}{space}{unit} (n = {n})")
            }
        }
    }
}

impl Score {
    /// The target for people; empty if there is none.
    #[must_use]
    pub fn target_text(&self) -> String {
        let number = |value: f64| {
            if self.figure.is_share() {
                format!("{:.0} %", 100.0 * value)
            } else {
                format!("{value}")
            }
        };
        match self.target {
            None => String::new(),
            Some(Target::AtLeast(least)) => format!("≥ {}", number(least)),
            Some(Target::AtMost(most)) => format!("≤ {}", number(most)),
            Some(Target::AtMostSurely(most, surely)) => {
                format!("≤ {}, upper end ≤ {}", number(most), number(surely))
            }
        }
    }
}

/// The median of some numbers.
pub(super) fn median(mut values: Vec<f64>, unit: &'static str) -> Figure {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    let value = match n {
        0 => f64::NAN,
        n => f64::midpoint(values[(n - 1) / 2], values[n / 2]),
    };
    Figure::Number { value, n, unit }
}

/// The mean of some numbers.
pub(super) fn mean(values: &[f64]) -> Figure {
    let n = values.len();
    Figure::Number {
        value: values.iter().sum::<f64>() / n as f64,
        n,
        unit: "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_target_holds_or_not_and_says_nothing_of_no_case() {
        let score = |hits, n, target| Score {
            quantity: String::new(),
            figure: Figure::Share(Proportion { hits, n }),
            target: Some(target),
        };
        assert_eq!(score(19, 20, Target::AtLeast(0.95)).holds(), Some(true));
        assert_eq!(score(18, 20, Target::AtLeast(0.95)).holds(), Some(false));
        // 1 of 20 may be 25 %.
        assert_eq!(
            score(1, 20, Target::AtMostSurely(0.05, 0.08)).holds(),
            Some(false)
        );
        assert_eq!(
            score(1, 300, Target::AtMostSurely(0.05, 0.08)).holds(),
            Some(true)
        );
        assert_eq!(score(0, 0, Target::AtMost(0.05)).holds(), None);
    }

    #[test]
    fn the_median_of_an_even_number_is_between() {
        let Figure::Number { value, n, .. } = median(vec![4.0, 1.0, 2.0, 3.0], "") else {
            unreachable!();
        };
        assert!((value - 2.5).abs() < 1e-12 && n == 4);
    }
}
