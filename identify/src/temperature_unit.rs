//! Units of an output that is a temperature.

/// 0 °C on the kelvin scale and on that of Fahrenheit, by definition.
const ZERO_CELSIUS_K: f64 = 273.15;
const ZERO_CELSIUS_DEGF: f64 = 32.0;

/// Degrees Fahrenheit in a kelvin.
const DEGF_PER_K: f64 = 1.8;

/// A scale that temperatures are shown on, by the degree Celsius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TemperatureUnit {
    /// Degrees in a kelvin.
    per_k: f64,
    /// Value shown at 0 °C.
    zero_celsius: f64,
}

impl TemperatureUnit {
    /// The scale of a unit as recordings write it; `None` for what is no temperature.
    pub(crate) fn of(unit: &str) -> Option<Self> {
        let (per_k, zero_celsius) = match unit {
            "degC" => (1.0, 0.0),
            "K" => (1.0, ZERO_CELSIUS_K),
            "degF" => (DEGF_PER_K, ZERO_CELSIUS_DEGF),
            _ => return None,
        };
        Some(Self {
            per_k,
            zero_celsius,
        })
    }

    /// A temperature as it is shown.
    pub(crate) fn shown(self, degc: f64) -> f64 {
        self.per_k * degc + self.zero_celsius
    }

    /// A temperature that is shown, °C.
    pub(crate) fn degc(self, shown: f64) -> f64 {
        (shown - self.zero_celsius) / self.per_k
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn water_freezes_and_boils_on_every_scale() {
        for (unit, freezes, boils) in [
            ("degC", 0.0, 100.0),
            ("K", 273.15, 373.15),
            ("degF", 32.0, 212.0),
        ] {
            let scale = TemperatureUnit::of(unit).unwrap();
            for (degc, shown) in [(0.0, freezes), (100.0, boils)] {
                assert!((scale.shown(degc) - shown).abs() < 1e-12, "{unit}");
                assert!((scale.degc(shown) - degc).abs() < 1e-12, "{unit}");
            }
        }
        assert_eq!(TemperatureUnit::of("deg"), None);
    }
}
