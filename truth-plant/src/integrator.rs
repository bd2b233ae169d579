//! Dormand and Prince's pair of orders 5 and 4, with steps of its own choice.
//!
//! J. R. Dormand, P. J. Prince: *A family of embedded Runge-Kutta formulae*. Journal of Computational and Applied
//! Mathematics 6(1), pp. 19-26, 1980. doi:10.1016/0771-050X(80)90013-3.

/// Rows of the tableau below its first; the last is the solution of order 5 as well.
const WEIGHTS: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
    ],
    &[
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
    ],
    &[
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// Times of the stages as shares of the step.
const NODES: [f64; 6] = [1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

/// Order 5 less order 4.
const ERROR_WEIGHTS: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Smallest step as a share of the span: a kink in the right-hand side is passed at this size, where what it costs
/// no longer counts.
const SMALLEST_SHARE: f64 = 1e-5;

/// System of differential equations to be integrated.
pub(crate) trait System {
    /// Rates of change of `state`, per second.
    fn rates(&mut self, time_s: f64, state: &[f64], rates: &mut [f64]);
    /// A step has been made: memory may move on.
    fn accept(&mut self, step: &Step<'_>);
}

/// A step that has been made.
#[derive(Debug)]
pub(crate) struct Step<'a> {
    pub(crate) length_s: f64,
    pub(crate) start: &'a [f64],
    pub(crate) start_rates: &'a [f64],
    pub(crate) end_s: f64,
    pub(crate) end: &'a [f64],
    pub(crate) end_rates: &'a [f64],
}

/// The state became infinite or NaN.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NotFinite;

/// The integrator with its working memory.
#[derive(Debug, Clone)]
pub(crate) struct Integrator {
    /// Largest accepted error of a step, in the unit of the state.
    tolerance: f64,
    longest_step_s: f64,
    step_s: f64,
    rates: [Vec<f64>; 7],
    trial: Vec<f64>,
}

impl Integrator {
    pub(crate) fn new(n_states: usize, tolerance: f64, longest_step_s: f64) -> Self {
        Self {
            tolerance,
            longest_step_s,
            step_s: longest_step_s,
            rates: std::array::from_fn(|_| vec![0.0; n_states]),
            trial: vec![0.0; n_states],
        }
    }

    /// Takes `state` from `from_s` to `to_s`; the right-hand side may have a step before and after, not within.
    pub(crate) fn advance<S: System>(
        &mut self,
        system: &mut S,
        state: &mut [f64],
        (from_s, to_s): (f64, f64),
    ) -> Result<(), NotFinite> {
        let smallest_s = SMALLEST_SHARE * (to_s - from_s);
        let mut time_s = from_s;
        system.rates(time_s, state, &mut self.rates[0]);
        while to_s - time_s > 0.0 {
            let wanted_s = self.step_s.min(self.longest_step_s);
            // Equal steps to the end: none is left over.
            let n_steps = ((to_s - time_s) / wanted_s - 1e-9).ceil().max(1.0);
            let length_s = (to_s - time_s) / n_steps;
            let error = self.attempt(system, state, (time_s, length_s));
            if !error.is_finite() && length_s <= smallest_s {
                return Err(NotFinite);
            }
            let growth = if error.is_finite() {
                (0.9 * (self.tolerance / error.max(1e-300)).powf(0.2)).clamp(0.2, 5.0)
            } else {
                0.2
            };
            if error <= self.tolerance || (error.is_finite() && length_s <= smallest_s) {
                let end_s = if n_steps < 1.5 {
                    to_s
                } else {
                    time_s + length_s
                };
                system.accept(&Step {
                    length_s,
                    start: state,
                    start_rates: &self.rates[0],
                    end_s,
                    end: &self.trial,
                    end_rates: &self.rates[6],
                });
                state.copy_from_slice(&self.trial);
                self.rates.swap(0, 6);
                time_s = end_s;
                // A step cut short by the end says nothing against longer ones.
                let next_s = growth * length_s;
                self.step_s = if next_s < length_s {
                    next_s
                } else {
                    next_s.max(self.step_s)
                };
            } else {
                self.step_s = (growth * length_s).max(smallest_s);
            }
        }
        Ok(())
    }

    /// Fills the trial and the rates of all stages; the largest error of any state.
    fn attempt<S: System>(
        &mut self,
        system: &mut S,
        state: &[f64],
        (time_s, length_s): (f64, f64),
    ) -> f64 {
        for (stage, weights) in WEIGHTS.iter().enumerate() {
            for (j, trial) in self.trial.iter_mut().enumerate() {
                let mut rate = 0.0;
                for (weight, rates) in weights.iter().zip(&self.rates) {
                    rate += weight * rates[j];
                }
                *trial = state[j] + length_s * rate;
            }
            let at_s = time_s + NODES[stage] * length_s;
            system.rates(at_s, &self.trial, &mut self.rates[stage + 1]);
        }
        let mut largest: f64 = 0.0;
        for j in 0..state.len() {
            let mut error = 0.0;
            for (weight, rates) in ERROR_WEIGHTS.iter().zip(&self.rates) {
                error += weight * rates[j];
            }
            let error = (length_s * error).abs();
            if error.is_nan() {
                return f64::NAN; // which `max` would drop
            }
            largest = largest.max(error);
        }
        largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pendulum: y'' = -y.
    struct Circle(usize);

    impl System for Circle {
        fn rates(&mut self, _time_s: f64, state: &[f64], rates: &mut [f64]) {
            self.0 += 1;
            rates[0] = state[1];
            rates[1] = -state[0];
        }
        fn accept(&mut self, _step: &Step<'_>) {}
    }

    fn error_after_one_turn(longest_step_s: f64, tolerance: f64) -> (f64, usize) {
        let mut system = Circle(0);
        let mut state = [1.0, 0.0];
        let mut integrator = Integrator::new(2, tolerance, longest_step_s);
        let turn_s = 2.0 * std::f64::consts::PI;
        integrator
            .advance(&mut system, &mut state, (0.0, turn_s))
            .unwrap();
        ((state[0] - 1.0).hypot(state[1]), system.0)
    }

    #[test]
    fn is_of_order_five() {
        let (coarse, _) = error_after_one_turn(0.2, 1.0);
        let (fine, _) = error_after_one_turn(0.1, 1.0);
        assert!((28.0..40.0).contains(&(coarse / fine)), "{coarse} {fine}");
    }

    #[test]
    fn keeps_its_tolerance() {
        let (error, rates) = error_after_one_turn(10.0, 1e-9);
        assert!(error < 1e-7, "{error}");
        assert!(rates < 1000, "{rates}");
    }

    #[test]
    fn reports_what_is_not_finite() {
        struct Explodes;
        impl System for Explodes {
            fn rates(&mut self, _time_s: f64, state: &[f64], rates: &mut [f64]) {
                rates[0] = f64::NAN * state[0];
            }
            fn accept(&mut self, _step: &Step<'_>) {}
        }
        let mut integrator = Integrator::new(1, 1e-9, 1.0);
        let end = integrator.advance(&mut Explodes, &mut [1.0], (0.0, 1.0));
        assert_eq!(end, Err(NotFinite));
    }
}
