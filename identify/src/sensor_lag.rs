//! A sensor that follows a rod late.

/// Reading of a sensor of one time constant on a rod of another. Exact over a sample in which the rod relaxes toward
/// one end temperature T_∞.
///
/// ```text
/// T(t) = T_∞ + (T_0 - T_∞) e^(-t/τ)      [Sadeghi, eq. 2]
/// θ dT'/dt = T - T':   T'_1 = T_∞ + (T'_0 - T_∞) e^(-Δt/θ) + (T_0 - T_∞) τ/(τ - θ) (e^(-Δt/τ) - e^(-Δt/θ))
/// ```
///
/// T_∞ follows from the two ends of the sample. The sensor starts as warm as the rod.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SensorLag {
    tau_s: f64,
    lag_s: f64,
    rod_degc: f64,
    shown_degc: f64,
    sample: Over,
}

/// The exponentials of a sample, kept because most samples are of one length.
#[derive(Debug, Clone, Copy)]
struct Over {
    dt_s: f64,
    /// 1/(1 - e^(-Δt/τ)): of the change in a sample, the way to where it would end.
    whole: f64,
    /// e^(-Δt/θ).
    kept: f64,
    /// τ/(τ - θ) (e^(-Δt/τ) - e^(-Δt/θ)).
    led: f64,
}

impl Over {
    fn new(tau_s: f64, lag_s: f64, dt_s: f64) -> Self {
        let kept = (-dt_s / lag_s).exp();
        // With τ near θ both factors of the difference are near 0: e^(-Δt/θ) Δt/θ (e^x - 1)/x does not mind.
        let x = dt_s * (tau_s - lag_s) / (lag_s * tau_s);
        let mean = if x.abs() > 0.0 { x.exp_m1() / x } else { 1.0 };
        // Far slower than the rod, e^x leaves the range of numbers before e^(-Δt/θ) brings it back.
        let led = if x < 700.0 {
            kept * (dt_s / lag_s) * mean
        } else {
            (-dt_s / tau_s).exp() * tau_s / (tau_s - lag_s)
        };
        Self {
            dt_s,
            whole: -1.0 / (-dt_s / tau_s).exp_m1(),
            kept,
            led,
        }
    }
}

impl SensorLag {
    /// A sensor of the time constant `lag_s`, s, on a rod of the time constant `tau_s`, s; without a lag it shows the rod.
    pub(crate) fn new(tau_s: f64, lag_s: f64) -> Self {
        Self {
            tau_s,
            lag_s,
            rod_degc: f64::NAN,
            shown_degc: f64::NAN,
            sample: Over {
                dt_s: f64::NAN,
                whole: f64::NAN,
                kept: f64::NAN,
                led: f64::NAN,
            },
        }
    }

    /// Reading, °C, when the rod has come to `rod_degc`, °C, in `dt_s`, s; `dt_s` is 0 at the start.
    pub(crate) fn follow(&mut self, rod_degc: f64, dt_s: f64) -> f64 {
        if !(dt_s > 0.0 && self.lag_s > 0.0) {
            (self.rod_degc, self.shown_degc) = (rod_degc, rod_degc);
            return rod_degc;
        }
        if self.sample.dt_s.to_bits() != dt_s.to_bits() {
            self.sample = Over::new(self.tau_s, self.lag_s, dt_s);
        }
        let Over {
            whole, kept, led, ..
        } = self.sample;
        let to_go_k = (self.rod_degc - rod_degc) * whole;
        let end_degc = self.rod_degc - to_go_k;
        self.shown_degc = end_degc + (self.shown_degc - end_degc) * kept + to_go_k * led;
        self.rod_degc = rod_degc;
        self.shown_degc
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rod that goes from 100 to 20 °C, in steps of `dt_s`.
    fn after(tau_s: f64, lag_s: f64, dt_s: f64, until_s: f64) -> f64 {
        let mut sensor = SensorLag::new(tau_s, lag_s);
        let rod = |t_s: f64| 20.0 + 80.0 * (-t_s / tau_s).exp();
        let mut shown = sensor.follow(rod(0.0), 0.0);
        for k in 1..=(until_s / dt_s).round() as usize {
            shown = sensor.follow(rod(k as f64 * dt_s), dt_s);
        }
        shown
    }

    #[test]
    fn one_step_is_as_good_as_a_thousand() {
        for (tau_s, lag_s) in [
            (3.0, 0.4),
            (0.4, 3.0),
            (3.0, 3.0),
            (3.0, 2.999_999_9),
            (3.0, 1e-4),
        ] {
            let [fine, coarse] = [1e-3, 1.0].map(|dt_s| after(tau_s, lag_s, dt_s, 2.0));
            assert!(
                (fine - coarse).abs() < 1e-8,
                "{tau_s} {lag_s}: {fine} {coarse}"
            );
        }
    }

    #[test]
    fn equal_time_constants_give_the_critical_response() {
        // (1 + t/τ) e^(-t/τ) of the way is left.
        let shown = after(3.0, 3.0, 0.1, 3.0);
        let expected = 20.0 + 80.0 * 2.0 * (-1.0_f64).exp();
        assert!((shown - expected).abs() < 1e-9, "{shown} {expected}");
    }

    #[test]
    fn without_a_lag_it_shows_the_rod() {
        let rod = 20.0 + 80.0 * (-2.0_f64 / 3.0).exp();
        assert_eq!(after(3.0, 0.0, 0.1, 2.0).to_bits(), rod.to_bits());
    }
}
