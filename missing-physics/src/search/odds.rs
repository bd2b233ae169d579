//! From when a difference counts while models are searched.

/// Residual over noise, squared, of the best model from which all are misfits.
pub(crate) const MISFIT: f64 = 2.0;

/// Advantage in units of log-likelihood, parameters counted, from which a model is beyond doubt against
/// another: odds of e⁶.
pub(crate) const BEYOND_DOUBT_NATS: f64 = 6.0;
