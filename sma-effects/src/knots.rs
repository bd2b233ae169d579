//! A slow change of unknown shape: straight lines between knots spread over the run.

/// Knots after the start, equally spaced; the last one stands at the end of the run.
pub(crate) const KNOTS: usize = 4;

/// What has changed since the start of the run, in each lane.
///
/// ```text
/// v(s) = Σ_k v_k max(0, 1 - |4 s - k|),   s = (start + t)/run length in [0, 1],   v_0 = 0
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Knots<const L: usize> {
    pub(crate) value: [[f64; L]; KNOTS],
}

impl<const L: usize> Knots<L> {
    /// Adds the change at a share of the run; beyond its end that at the end.
    #[inline(always)]
    pub(crate) fn add(&self, run_share: f64, to: &mut [f64; L]) {
        let place = KNOTS as f64 * run_share.clamp(0.0, 1.0);
        for (k, value) in self.value.iter().enumerate() {
            let weight = (1.0 - (place - (k + 1) as f64).abs()).max(0.0);
            for l in 0..L {
                to[l] += value[l] * weight;
            }
        }
    }
}
