//! A resistance as it was measured.

/// Measured resistance of the actuator, sample by sample.
///
/// # Examples
///
/// ```
/// use recording::Resistance;
///
/// let measured = Resistance::VoltageOverCurrent {
///     voltage_v: vec![0.0, 1.5],
///     current_a: vec![0.0, 0.5],
/// };
/// // Without a current nothing is known.
/// assert_eq!(measured.ohm().collect::<Vec<_>>(), [None, Some(3.0)]);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Resistance {
    /// As it stands, Ω.
    Ohm(Vec<f64>),
    /// From the voltage and the current through it: kept apart, since the ratio tells the less, the smaller the
    /// current is.
    VoltageOverCurrent {
        /// Voltage over the actuator, V.
        voltage_v: Vec<f64>,
        /// Current through it, A.
        current_a: Vec<f64>,
    },
}

impl Resistance {
    /// Voltage, V, and current, A, of each sample; the current is 1 A where the resistance itself was measured.
    pub fn voltage_and_current(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let (voltage_v, current_a) = match self {
            Self::Ohm(ohm) => (ohm, None),
            Self::VoltageOverCurrent {
                voltage_v,
                current_a,
            } => (voltage_v, Some(current_a)),
        };
        let current_a = move |k: usize| current_a.map_or(1.0, |current_a| current_a[k]);
        (0..voltage_v.len()).map(move |k| (voltage_v[k], current_a(k)))
    }

    /// Resistance of each sample, Ω; `None` where no current flows.
    pub fn ohm(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        self.voltage_and_current()
            .map(|(voltage_v, current_a)| voltage_v / current_a)
            .map(|ohm| ohm.is_finite().then_some(ohm))
    }

    /// This resistance with other values in each column.
    pub(crate) fn map(&self, mut of: impl FnMut(&Vec<f64>) -> Vec<f64>) -> Self {
        match self {
            Self::Ohm(ohm) => Self::Ohm(of(ohm)),
            Self::VoltageOverCurrent {
                voltage_v,
                current_a,
            } => Self::VoltageOverCurrent {
                voltage_v: of(voltage_v),
                current_a: of(current_a),
            },
        }
    }

    /// Name, unit and values of its columns.
    pub(crate) fn columns(&self) -> Vec<(&'static str, &'static str, &[f64])> {
        match self {
            Self::Ohm(ohm) => vec![("resistance_ohm", "ohm", ohm)],
            Self::VoltageOverCurrent {
                voltage_v,
                current_a,
            } => vec![
                ("resistance_voltage_v", "V", voltage_v),
                ("resistance_current_a", "A", current_a),
            ],
        }
    }
}
