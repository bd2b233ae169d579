//! A slow change of unknown shape: a smooth curve through knots spread over the run.

/// Knots after the start, equally spaced; the last one stands at the end of the run.
pub(crate) const KNOTS: usize = 4;

/// Change since the start of the run, in each lane: the polynomial through the knots and 0 at the start.
///
/// ```text
/// v(s) = Σ_k v_k Π_(j ≠ k) (4 s - j)/(k - j),   s = (start + t)/run length in [0, 1],   j = 0 … 4,   v_0 = 0
/// ```
///
/// Rooms and sensors warm smoothly: straight lines between so few knots would leave corners.
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
            let own = (k + 1) as f64;
            let mut weight = 1.0;
            for other in 0..=KNOTS {
                let other = other as f64;
                if (other - own).abs() > 0.5 {
                    weight *= (place - other) / (own - other);
                }
            }
            for l in 0..L {
                to[l] += value[l] * weight;
            }
        }
    }
}
