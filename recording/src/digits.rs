//! How many digits numbers are printed with.

/// How many digits numbers are printed with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Digits {
    /// So many that rounding is that of binary numbers.
    Full,
    /// This many behind the point, this many in all, at most.
    Decimal { decimals: i32, significant: i32 },
}

/// Digits of C's `%g`: a number of fewer may have lost zeros, not resolution.
const LEAST_SIGNIFICANT: i32 = 6;

/// Decimal numbers of up to 15 digits survive conversion to binary and back.
const MOST_SIGNIFICANT: i32 = 15;

impl Digits {
    /// The most that any of the numbers needs.
    pub(crate) fn of(numbers: &[f64]) -> Self {
        let mut decimals = 0;
        let mut significant = LEAST_SIGNIFICANT;
        for &number in numbers {
            while !has_decimals(number, decimals) {
                decimals += 1;
                if decimals > MOST_SIGNIFICANT {
                    return Self::Full;
                }
            }
            let magnitude = (number.abs() * 10_f64.powi(decimals)).round();
            if magnitude >= 10_f64.powi(significant) {
                significant = significant.max(count_digits(magnitude));
            }
            if significant > MOST_SIGNIFICANT {
                return Self::Full;
            }
        }
        Self::Decimal {
            decimals,
            significant,
        }
    }

    /// Resolution of one number, in its unit; 0 for [`Self::Full`].
    pub(crate) fn resolution(self, number: f64) -> f64 {
        let Self::Decimal {
            decimals,
            significant,
        } = self
        else {
            return 0.0;
        };
        let by_decimals = 10_f64.powi(-decimals);
        if number.abs() < 10_f64.powi(significant - decimals) {
            return by_decimals;
        }
        let leading = number.abs().log10().floor() as i32;
        by_decimals.max(10_f64.powi(leading + 1 - significant))
    }
}

/// True if `number` is the binary number nearest to a decimal number with so many decimals.
fn has_decimals(number: f64, decimals: i32) -> bool {
    // Exact up to 15 digits: the product is within half a unit of the whole number it stands for,
    // and the quotient of that number and a power of ten is rounded once, as parsing rounds it.
    let scale = 10_f64.powi(decimals);
    ((number * scale).round() / scale).to_bits() == number.to_bits()
}

/// Digits of a whole number without the zeros at its end.
fn count_digits(magnitude: f64) -> i32 {
    // Beyond 2^64 the cast saturates, to 20 digits, which counts as full.
    let mut whole = magnitude as u64;
    while whole > 0 && whole.is_multiple_of(10) {
        whole /= 10;
    }
    whole.checked_ilog10().map_or(0, |log| log as i32 + 1)
}
