//! Units of columns: how they are written and how they convert.

/// A unit that a column can be in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unit {
    Second,
    Millisecond,
    Microsecond,
    Minute,
    Hour,
    Ampere,
    Milliampere,
    Volt,
    Millivolt,
    Watt,
    Milliwatt,
    Millimeter,
    Centimeter,
    Inch,
    Micrometer,
    Meter,
    DegreeCelsius,
    Kelvin,
    DegreeFahrenheit,
    Degree,
    Newton,
    Megapascal,
    Pascal,
    Ohm,
    Percent,
    /// Of a converter, over its full scale.
    Counts,
    One,
    /// Kept as data: values stay as they are.
    Own,
}

/// 0 °C on the kelvin scale, by definition.
const ZERO_CELSIUS_K: f64 = 273.15;

/// 0 °C on the Fahrenheit scale, and degrees Fahrenheit in a kelvin, by definition.
const ZERO_CELSIUS_DEGF: f64 = 32.0;
const DEGF_PER_K: f64 = 1.8;

impl Unit {
    /// The unit written `text`, in either case, or `None`.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        Some(match text.trim().to_lowercase().as_str() {
            "s" | "sec" | "secs" | "second" | "seconds" => Self::Second,
            "ms" | "msec" | "millis" | "milliseconds" => Self::Millisecond,
            "us" | "\u{b5}s" | "\u{3bc}s" | "usec" | "micros" | "microseconds" => Self::Microsecond,
            "min" | "minute" | "minutes" => Self::Minute,
            "h" | "hr" | "hour" | "hours" => Self::Hour,
            "a" | "amp" | "amps" | "ampere" | "amperes" => Self::Ampere,
            "ma" => Self::Milliampere,
            "v" | "volt" | "volts" => Self::Volt,
            "mv" => Self::Millivolt,
            "w" | "watt" | "watts" => Self::Watt,
            "mw" => Self::Milliwatt,
            "mm" => Self::Millimeter,
            // The micro sign and the Greek letter are different characters.
            "um" | "\u{b5}m" | "\u{3bc}m" => Self::Micrometer,
            "m" => Self::Meter,
            "cm" => Self::Centimeter,
            "in" | "inch" | "inches" => Self::Inch,
            "counts" => Self::Counts,
            "degc" | "c" | "°c" => Self::DegreeCelsius,
            "k" => Self::Kelvin,
            "degf" | "f" | "°f" => Self::DegreeFahrenheit,
            "deg" | "°" => Self::Degree,
            "n" => Self::Newton,
            "mpa" => Self::Megapascal,
            "pa" => Self::Pascal,
            "ohm" | "ohms" | "\u{3c9}" => Self::Ohm,
            "%" | "percent" => Self::Percent,
            "1" => Self::One,
            _ => return None,
        })
    }

    /// How the unit is written in reports.
    pub(crate) const fn symbol(self) -> &'static str {
        match self {
            Self::Second => "s",
            Self::Millisecond => "ms",
            Self::Microsecond => "us",
            Self::Minute => "min",
            Self::Hour => "h",
            Self::Ampere => "A",
            Self::Milliampere => "mA",
            Self::Volt => "V",
            Self::Millivolt => "mV",
            Self::Watt => "W",
            Self::Milliwatt => "mW",
            Self::Millimeter => "mm",
            Self::Micrometer => "um",
            Self::Meter => "m",
            Self::Centimeter => "cm",
            Self::Inch => "in",
            Self::DegreeCelsius => "degC",
            Self::Kelvin => "K",
            Self::DegreeFahrenheit => "degF",
            Self::Degree => "deg",
            Self::Newton => "N",
            Self::Megapascal => "MPa",
            Self::Pascal => "Pa",
            Self::Ohm => "ohm",
            Self::Percent => "%",
            Self::Counts => "counts",
            Self::One | Self::Own => "1",
        }
    }

    /// A value in this unit, in s, A, V, W, °C, Pa, as a fraction; other units stay.
    ///
    /// Divides where it could multiply: 287 ms / 1000 is the number nearest to 0.287.
    pub(crate) fn to_base(self, value: f64) -> f64 {
        match self {
            Self::Millisecond | Self::Milliampere | Self::Millivolt | Self::Milliwatt => {
                value / 1000.0
            }
            Self::Microsecond => value / 1e6,
            Self::Minute => value * 60.0,
            Self::Hour => value * 3600.0,
            Self::Percent => value / 100.0,
            Self::Megapascal => value * 1e6,
            Self::Kelvin => value - ZERO_CELSIUS_K,
            Self::DegreeFahrenheit => (value - ZERO_CELSIUS_DEGF) / DEGF_PER_K,
            _ => value,
        }
    }
}

/// Splits a column name into what it names and the unit at its end, if there is one.
///
/// In brackets anything is a unit; after an underscore only a known one is, so that `phase_rev` and
/// `thermocouple_1` have none.
pub(crate) fn split_name(name: &str) -> (&str, Option<&str>) {
    let name = name.trim();
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some((stem, unit)) = name.strip_suffix(close).and_then(|n| n.rsplit_once(open)) {
            let (stem, unit) = (stem.trim_end(), unit.trim());
            if !stem.is_empty() && !unit.is_empty() {
                return (stem, Some(unit));
            }
        }
    }
    match name.rsplit_once('_') {
        Some((stem, unit)) if !stem.is_empty() && is_suffix(unit) => (stem, Some(unit)),
        _ => (name, None),
    }
}

/// True if a word after an underscore is a unit. Some units are words of their own in many names, as in `plug_in`: these
/// count as no unit.
pub(crate) fn is_suffix(word: &str) -> bool {
    let is_word = [
        "1", "in", "f", "h", "hour", "min", "minute", "second", "counts",
    ];
    !is_word.contains(&word.to_lowercase().as_str()) && Unit::parse(word).is_some()
}

/// A column name as it is compared: lower case, a unit turned into a suffix, in its usual spelling if it is known.
pub(crate) fn normalized(name: &str) -> String {
    let (stem, unit) = split_name(name);
    match unit {
        Some(unit) => {
            let symbol = Unit::parse(unit).map(Unit::symbol);
            let symbol = symbol.unwrap_or(unit);
            format!("{stem}_{symbol}").to_lowercase()
        }
        None => stem.to_lowercase(),
    }
}

/// A unit of an output: a known one in its usual spelling, any other as it stands, `"1"` for none.
pub(crate) fn output_symbol(text: &str) -> String {
    let text = text.trim();
    match Unit::parse(text) {
        _ if text.is_empty() => Unit::One.symbol().to_owned(),
        Some(unit) => unit.symbol().to_owned(),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suffix_and_brackets_are_one_name() {
        for name in ["current_A", " Current [A]", "CURRENT(a)", "current_a"] {
            assert_eq!(normalized(name), "current_a");
        }
    }

    #[test]
    fn only_known_suffixes_are_units() {
        assert_eq!(
            split_name("pwm_duty_limb0_rev"),
            ("pwm_duty_limb0_rev", None)
        );
        assert_eq!(split_name("MCPtemp_1"), ("MCPtemp_1", None));
        assert_eq!(split_name("_mm"), ("_mm", None));
        assert_eq!(split_name("strain_f"), ("strain_f", None));
        assert_eq!(split_name("temp (F)"), ("temp", Some("F")));
        assert_eq!(split_name("tempg [stC]"), ("tempg", Some("stC")));
        assert_eq!(split_name("limb0_angle_deg"), ("limb0_angle", Some("deg")));
    }

    #[test]
    fn every_documented_suffix_is_known_in_both_cases() {
        for suffix in "s ms a ma v w mm um m degc c k degf deg n mpa pa ohm %".split(' ') {
            let unit = Unit::parse(suffix);
            assert!(unit.is_some(), "{suffix}");
            assert_eq!(Unit::parse(&suffix.to_uppercase()), unit, "{suffix}");
        }
    }

    #[test]
    fn symbols_parse_to_their_unit() {
        for symbol in "s ms A mA V W mm um m degC K degF deg N MPa Pa ohm % 1".split(' ') {
            assert_eq!(Unit::parse(symbol).map(Unit::symbol), Some(symbol));
        }
    }
}
