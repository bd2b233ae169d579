//! The transformed share: the fraction, 0 cold to 1 hot, whatever its own scale.

use wiener::WienerParams;

/// Scale of the fraction in each lane.
///
/// ```text
/// p = (ξ - (ξ_0 - ξ_s))/(2 ξ_s)
/// ```
///
/// p = ξ for a fraction from 0 to 1; a martensite fraction falls on heating, p still rises.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LoopScale<const L: usize> {
    cold: [f64; L],
    /// 2 ξ_s.
    pub(crate) span: [f64; L],
    per_span: [f64; L],
}

impl<const L: usize> LoopScale<L> {
    pub(crate) fn new(params: &[WienerParams; L]) -> Self {
        let swing = params
            .each_ref()
            .map(|lane| lane.limiting_loop.fraction_swing);
        Self {
            cold: params
                .each_ref()
                .map(|lane| lane.limiting_loop.fraction_center - lane.limiting_loop.fraction_swing),
            span: swing.map(|swing| 2.0 * swing),
            per_span: swing.map(|swing| 0.5 / swing),
        }
    }

    #[inline(always)]
    pub(crate) fn transformed(&self, lane: usize, fraction: f64) -> f64 {
        (fraction - self.cold[lane]) * self.per_span[lane]
    }

    /// Slope of the transformed share from that of the fraction, 1/K.
    #[inline(always)]
    pub(crate) fn slope_per_k(&self, lane: usize, fraction_slope_per_k: f64) -> f64 {
        fraction_slope_per_k * self.per_span[lane]
    }
}
