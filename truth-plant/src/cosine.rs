use crate::Hysteresis;
use crate::error::{TruthError, in_order, within};
use std::f64::consts::PI;

/// Cosine kinetics of Liang and Rogers, with partial loops.
///
/// ```text
/// heating from ξ_r:  ξ = ξ_r + (1 - ξ_r) ½ (1 - cos(π (T - A)/(A_f - A))),   A = max(A_s, T_r)
/// cooling from ξ_r:  ξ = ξ_r ½ (1 + cos(π (M - T)/(M - M_f))),               M = min(M_s, T_r)
/// ```
///
/// C. Liang, C. A. Rogers: *One-dimensional thermomechanical constitutive relations for shape memory materials*,
/// Journal of Intelligent Material Systems and Structures 1, 1990. Stress acts on all four temperatures alike, as a
/// shift of T. A reversal inside a transformation starts the other one where it lies, if it lies in its range, and a
/// plateau up to its start, if not; an excursion in which nothing transforms leaves no trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CosineLoop {
    /// Martensite finish M_f, °C; -100 to 200.
    pub martensite_finish_degc: f64,
    /// Martensite start M_s, °C; above M_f and below A_f.
    pub martensite_start_degc: f64,
    /// Austenite start A_s, °C; above M_f and below A_f.
    pub austenite_start_degc: f64,
    /// Austenite finish A_f, °C; to 250.
    pub austenite_finish_degc: f64,
}

impl Default for CosineLoop {
    fn default() -> Self {
        Self {
            martensite_finish_degc: 42.0,
            martensite_start_degc: 56.0,
            austenite_start_degc: 60.0,
            austenite_finish_degc: 74.0,
        }
    }
}

impl CosineLoop {
    pub(crate) fn check(&self) -> Result<(), TruthError> {
        let accepted = -100.0..=250.0;
        let named = [
            ("martensite_finish_degc", self.martensite_finish_degc),
            ("martensite_start_degc", self.martensite_start_degc),
            ("austenite_start_degc", self.austenite_start_degc),
            ("austenite_finish_degc", self.austenite_finish_degc),
        ];
        for (name, value) in named {
            within(name, value, accepted.clone())?;
        }
        let [finish_m, start_m, start_a, finish_a] = named;
        in_order(finish_m, start_m)?;
        in_order(finish_m, start_a)?;
        in_order(start_m, finish_a)?;
        in_order(start_a, finish_a)
    }

    pub(crate) fn with_spread_ratio(self, ratio: f64) -> Self {
        let spread = |low: f64, high: f64, factor: f64| {
            let (middle, half) = (0.5 * (low + high), 0.5 * factor * (high - low));
            (middle - half, middle + half)
        };
        let root = ratio.sqrt();
        let (martensite_finish_degc, martensite_start_degc) = spread(
            self.martensite_finish_degc,
            self.martensite_start_degc,
            root,
        );
        let (austenite_start_degc, austenite_finish_degc) = spread(
            self.austenite_start_degc,
            self.austenite_finish_degc,
            1.0 / root,
        );
        Self {
            martensite_finish_degc,
            martensite_start_degc,
            austenite_start_degc,
            austenite_finish_degc,
        }
    }

    /// The operator.
    ///
    /// # Errors
    ///
    /// [`TruthError::OutOfRange`] or [`TruthError::WrongOrder`] naming the parameters.
    pub fn operator(&self) -> Result<Cosine, TruthError> {
        self.check()?;
        Ok(Cosine { parameters: *self })
    }
}

/// Cosine kinetics, ready to use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cosine {
    parameters: CosineLoop,
}

/// Memory of cosine kinetics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CosineMemory {
    temperature_degc: f64,
    fraction: f64,
    /// The transformation under way, of which a plateau is a part: it goes on where it was left.
    heating: Option<Onset>,
    cooling: Option<Onset>,
}

/// Where a transformation began.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Onset {
    temperature_degc: f64,
    fraction: f64,
}

impl Cosine {
    fn onset(&self, memory: &CosineMemory, heating: bool) -> Onset {
        let p = &self.parameters;
        let under_way = if heating {
            memory.heating
        } else {
            memory.cooling
        };
        under_way.unwrap_or(Onset {
            temperature_degc: if heating {
                p.austenite_start_degc.max(memory.temperature_degc)
            } else {
                p.martensite_start_degc.min(memory.temperature_degc)
            },
            fraction: memory.fraction,
        })
    }

    fn on(&self, onset: Onset, heating: bool, temperature_degc: f64) -> f64 {
        let p = &self.parameters;
        let finish_degc = if heating {
            p.austenite_finish_degc
        } else {
            p.martensite_finish_degc
        };
        let range_k = finish_degc - onset.temperature_degc;
        let travel_k = temperature_degc - onset.temperature_degc;
        // Beyond the finish nothing is left of the range.
        let progress = if (range_k > 0.0) == heating && range_k.abs() > 0.0 {
            (travel_k / range_k).clamp(0.0, 1.0)
        } else {
            1.0
        };
        let done = 0.5 * (1.0 - (PI * progress).cos());
        let goal = if heating { 1.0 } else { 0.0 };
        onset.fraction + (goal - onset.fraction) * done
    }
}

impl Hysteresis for Cosine {
    type Memory = CosineMemory;

    fn rest(&self, temperature_degc: f64) -> CosineMemory {
        let onset = Onset {
            temperature_degc: self.parameters.martensite_start_degc,
            fraction: 1.0,
        };
        CosineMemory {
            temperature_degc,
            fraction: self.on(onset, false, temperature_degc),
            heating: None,
            cooling: Some(onset),
        }
    }

    fn fraction(&self, memory: &CosineMemory, temperature_degc: f64) -> f64 {
        let heating = temperature_degc >= memory.temperature_degc;
        let fraction = self.on(self.onset(memory, heating), heating, temperature_degc);
        // A branch left on a plateau waits for where it was left.
        if heating {
            fraction.max(memory.fraction)
        } else {
            fraction.min(memory.fraction)
        }
    }

    fn commit(&self, memory: &mut CosineMemory, temperature_degc: f64) -> f64 {
        let heating = temperature_degc >= memory.temperature_degc;
        let onset = self.onset(memory, heating);
        let fraction = self.fraction(memory, temperature_degc);
        let change = fraction - memory.fraction;
        if heating && change > 0.0 {
            (memory.heating, memory.cooling) = (Some(onset), None);
        } else if !heating && change < 0.0 {
            (memory.heating, memory.cooling) = (None, Some(onset));
        }
        memory.temperature_degc = temperature_degc;
        memory.fraction = fraction;
        fraction
    }
}
