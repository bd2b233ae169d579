//! Numbers for people.

/// A value with four significant digits, as plainly as its size allows.
#[must_use]
pub fn significant(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = value.abs().log10().floor();
    if (-4.0..6.0).contains(&exponent) {
        // Between 0 and 7 by the range above.
        let decimals = (3.0 - exponent).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.3e}")
    }
}

/// A unit behind a number: nothing where there is none.
#[must_use]
pub fn behind(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        unit => format!(" {unit}"),
    }
}

/// A value with two significant digits, to be read aloud.
#[must_use]
pub fn spoken(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = value.abs().log10().floor();
    if (-4.0..6.0).contains(&exponent) {
        // Between 0 and 5 by the range above.
        let decimals = (1.0 - exponent).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.1e}")
    }
}

/// A share in whole percent, with a decimal where it is all but the whole or all but nothing.
#[must_use]
pub fn spoken_percent(share: f64) -> String {
    let whole = 100.0 * share;
    let is_near_end = (0.05..1.0).contains(&whole) || (99.0..99.95).contains(&whole);
    if is_near_end {
        format!("{whole:.1} %")
    } else {
        format!("{whole:.0} %")
    }
}

/// Probability that is not told from certainty.
const CERTAIN: f64 = 0.9995;

/// A probability in percent, never 100.
#[must_use]
pub fn probability(value: f64) -> String {
    if value > CERTAIN {
        "> 99.9 %".to_owned()
    } else {
        spoken_percent(value)
    }
}

/// A share as a percentage with one decimal.
#[must_use]
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// A count with its digits in groups of three.
#[must_use]
pub fn count(value: usize) -> String {
    let digits = value.to_string();
    let mut grouped = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::{count, percent, probability, significant, spoken, spoken_percent};

    #[test]
    fn numbers_keep_four_digits() {
        for (value, shown) in [
            (0.0, "0"),
            (0.368_605_9, "0.3686"),
            (-2.360_4, "-2.360"),
            (77.5, "77.50"),
            (123_456.0, "123456"),
            (1.28e-6, "1.280e-6"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(significant(value), shown);
        }
        assert_eq!(
            [0.921, 15_234.0, 0.0044, 5.53e-6, 0.0].map(spoken),
            ["0.92", "15234", "0.0044", "5.5e-6", "0"]
        );
        assert_eq!(percent(0.95012), "95.0 %");
        assert_eq!(
            [0.874, 0.998, 0.9998, 0.004, 1.0, -0.31].map(spoken_percent),
            ["87 %", "99.8 %", "100 %", "0.4 %", "100 %", "-31 %"]
        );
        assert_eq!(
            [0.51, 0.9961, 1.0].map(probability),
            ["51 %", "99.6 %", "> 99.9 %"]
        );
        assert_eq!(
            [999, 1000, 1_234_567].map(count),
            ["999", "1,000", "1,234,567"]
        );
    }
}
