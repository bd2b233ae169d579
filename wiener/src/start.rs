//! Where a model starts.

/// Where a model starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Temperature, °C.
    pub temperature_degc: f64,
    /// Place between the limiting curves, 0 (heating) to 1 (cooling).
    pub share: f64,
    /// By how much the model was heated (below 0: cooled) since it last turned, K; 0 if it has not turned but does so now.
    pub since_reversal_k: f64,
}

impl Start {
    /// At ambient, cooled along the limiting curve.
    #[must_use]
    pub fn rest(ambient_degc: f64) -> Self {
        Self {
            temperature_degc: ambient_degc,
            share: 1.0,
            since_reversal_k: 0.0,
        }
    }
}
