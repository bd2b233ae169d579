/// Signals of a run, one value a sample, read at its start.
#[derive(Debug, Clone, PartialEq)]
pub struct Traces {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Command to the supply from that time on, in the unit of the drive's kind.
    pub drive: Vec<f64>,
    /// Recorded displacement, mm: with noise and the converter's steps.
    pub displacement_mm: Vec<f64>,
    /// Displacement before noise and converter, mm: not for the diagnosis.
    pub quiet_displacement_mm: Vec<f64>,
    /// Temperature of the middle of the rod, °C: not for the diagnosis.
    pub temperature_degc: Vec<f64>,
    /// Recorded temperature, °C: that of the bead, if there is one, with noise.
    pub thermocouple_degc: Vec<f64>,
    /// Temperature of the thermocouple before noise, °C: not for the diagnosis.
    pub quiet_thermocouple_degc: Vec<f64>,
    /// Ambient temperature as recorded, °C.
    pub ambient_degc: Vec<f64>,
    /// Transformed fraction, the mean over the length: not for the diagnosis.
    pub fraction: Vec<f64>,
}

impl Traces {
    pub(crate) fn with_capacity(n_samples: usize) -> Self {
        let empty = || Vec::with_capacity(n_samples);
        Self {
            time_s: empty(),
            drive: empty(),
            displacement_mm: empty(),
            quiet_displacement_mm: empty(),
            temperature_degc: empty(),
            thermocouple_degc: empty(),
            quiet_thermocouple_degc: empty(),
            ambient_degc: empty(),
            fraction: empty(),
        }
    }
}
