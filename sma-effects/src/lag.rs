//! A first-order lag of something whose course within a sample is known.

use crate::elementary::mean_exponential;

/// First-order lag: follows a signal with a time constant, in each lane.
///
/// ```text
/// θ dv/dt + v = u,   u(s) = u_0 + (u_1 - u_0) s + 4 b s(1 - s),   s = t/dt
/// v_1 = u_1 + (v_0 - u_0) e^(-a) - (u_1 - u_0) (1 - e^(-a))/a + 4 b ((1 + e^(-a))/a - 2(1 - e^(-a))/a²)
/// ```
///
/// with a = dt/θ and the bend b of the signal in the middle of the sample. θ = 0 gives v = u to the
/// last bit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lag<const L: usize> {
    followed: [f64; L],
    value: [f64; L],
    retained: [f64; L],
    trailing: [f64; L],
    bent: [f64; L],
}

impl<const L: usize> Lag<L> {
    pub(crate) fn still() -> Self {
        Self {
            followed: [0.0; L],
            value: [0.0; L],
            retained: [0.0; L],
            trailing: [0.0; L],
            bent: [0.0; L],
        }
    }

    /// Prepares for samples of `dt_s`.
    pub(crate) fn over(&mut self, lag_s: &[f64; L], dt_s: f64) {
        // Below, the difference of quotients is its series to eight digits.
        const SMALL: f64 = 1e-2;
        for l in 0..L {
            // Not 0/0: in no time nothing is followed, but without a lag all is.
            let a = dt_s.max(f64::MIN_POSITIVE) / lag_s[l];
            self.retained[l] = libm::exp(-a);
            self.trailing[l] = mean_exponential(-a);
            self.bent[l] = 4.0
                * if a < SMALL {
                    a * (1.0 / 6.0 - a * (1.0 / 12.0 - a / 40.0))
                } else {
                    ((1.0 + self.retained[l]) - 2.0 * self.trailing[l]) / a
                };
        }
    }

    /// Starts where the signal has been for long.
    pub(crate) fn settle(&mut self, signal: &[f64; L]) {
        self.followed = *signal;
        self.value = *signal;
    }

    /// Puts what follows in place of the signal, which has passed `middle` in the middle of the sample.
    #[inline(always)]
    pub(crate) fn follow(&mut self, middle: &[f64; L], signal: &mut [f64; L]) {
        for l in 0..L {
            let behind = self.value[l] - self.followed[l];
            let change = signal[l] - self.followed[l];
            let bend = middle[l] - (self.followed[l] + 0.5 * change);
            self.followed[l] = signal[l];
            self.value[l] = signal[l]
                + (behind * self.retained[l] - change * self.trailing[l] + bend * self.bent[l]);
            signal[l] = self.value[l];
        }
    }
}
