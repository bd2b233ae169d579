//! How much noise there is, and what it is like.

/// Noise of the output: standard deviations, in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Floor {
    /// At least this much.
    pub lower: f64,
    /// At most about this much; `None` where neither holds nor repeated cycles tell.
    pub upper: Option<f64>,
    /// Class of the noise.
    pub class: NoiseClass,
    /// Error that noise of the drives may make in the training, root mean square, though it was smoothed; 0 where none was.
    pub of_drive: f64,
}

/// Class of noise, which decides what may be claimed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum NoiseClass {
    /// Neighbors are independent.
    White,
    /// An autoregressive model describes it.
    Colored,
    /// It grows toward low frequencies without end: tests cry wolf, names become suspects unless repeated
    /// cycles tell the noise.
    OneOverF,
    /// The converter's step exceeds the noise: the same.
    Quantized,
}

impl NoiseClass {
    /// Name in files and reports.
    #[must_use]
    pub fn id(self) -> &'static str {
        match self {
            NoiseClass::White => "white",
            NoiseClass::Colored => "colored",
            NoiseClass::OneOverF => "one_over_f",
            NoiseClass::Quantized => "quantized",
        }
    }
}
