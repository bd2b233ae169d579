use wiener::hysteresis::Branch;

use crate::complex::Complex;
use crate::fraction_response::SampledCycle;
use crate::{Approach, RodLoop, TemperatureSine};

/// Amplitudes of the temperature.
const N_AMPLITUDES: usize = 40;
/// The smallest and the largest, in spreads of the loop.
const AMPLITUDES: [f64; 2] = [0.05, 50.0];

impl RodLoop {
    /// -1/N of the hysteresis at amplitudes of the temperature in equal ratios, K, about the temperature at which the
    /// heated rod is at the set point: the curve that a Nyquist plot is crossed with.
    ///
    /// N is the describing function over the steepest slope of the limiting loop, so that -1/N is beside the L of
    /// [`RodLoop::worst_linear`]: where the two cross, harmonic balance of the first harmonic has a cycle. The limits of
    /// the drive are left out. Empty where no temperature brings the output to the set point.
    #[must_use]
    pub fn describing_curve(&self) -> Vec<(f64, Complex)> {
        let params = self.params();
        let Some(bias_degc) = self.limiting_degc(Branch::Heating, params.setpoint) else {
            return Vec::new();
        };
        let limiting_loop = params.rod.limiting_loop;
        let steepest_per_k = core::f64::consts::FRAC_2_PI * limiting_loop.fraction_swing
            / limiting_loop.loop_spread_k;
        let memory = self.history(Approach::FromBelow);
        let cycle = SampledCycle::new();
        let ratio = (AMPLITUDES[1] / AMPLITUDES[0]).ln() / (N_AMPLITUDES - 1) as f64;
        let curve = (0..N_AMPLITUDES).map(|k| {
            let amplitude_k =
                AMPLITUDES[0] * limiting_loop.loop_spread_k * (ratio * k as f64).exp();
            let sine = TemperatureSine {
                bias_degc,
                amplitude_k,
            };
            let response = cycle.response(self.plant().hysteresis(), memory.clone(), sine);
            let gain = response.first * (1.0 / (amplitude_k * steepest_per_k));
            (amplitude_k, Complex::real(-1.0) / gain)
        });
        curve
            .filter(|(_, value)| value.re.is_finite() && value.im.is_finite())
            .collect()
    }
}
