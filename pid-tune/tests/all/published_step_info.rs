//! The example of [Stepinfo], whose numbers [Fuller2021] has among its tests too.

use fixtures::Printed;
use pid_tune::{Reference, ResponseTerms, Snapshot, StepTerms};

/// A transfer function without direct path, highest power first, denominator monic.
struct TransferFunction<const N: usize> {
    numerator: [f64; N],
    denominator: [f64; N],
}

impl<const N: usize> TransferFunction<N> {
    fn steady(&self) -> f64 {
        self.numerator[N - 1] / self.denominator[N - 1]
    }

    /// Derivative of the controllable canonical state under a drive of 1.
    fn derivative(&self, state: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|i| {
            if i + 1 < N {
                state[i + 1]
            } else {
                1.0 - (0..N)
                    .map(|j| self.denominator[N - 1 - j] * state[j])
                    .sum::<f64>()
            }
        })
    }

    fn output(&self, state: &[f64; N]) -> f64 {
        (0..N).map(|j| self.numerator[N - 1 - j] * state[j]).sum()
    }

    /// Terms of the response to a unit step over some time: Runge's and Kutta's method of order four.
    fn step_terms(&self, duration_s: f64, dt_s: f64) -> StepTerms {
        let reference = Reference::Step {
            from: 0.0,
            to: self.steady(),
            at_s: 0.0,
        };
        let mut response = ResponseTerms::new(&reference, dt_s).unwrap();
        let mut state = [0.0; N];
        for k in 0..(duration_s / dt_s) as usize {
            response.add(&Snapshot {
                k,
                time_s: dt_s * k as f64,
                setpoint: self.steady(),
                output: [self.output(&state)],
                measured: [self.output(&state)],
                drive: [1.0],
                temperature_degc: [0.0],
            });
            let ahead = |slope: &[f64; N], share: f64| -> [f64; N] {
                std::array::from_fn(|i| state[i] + share * dt_s * slope[i])
            };
            let first = self.derivative(&state);
            let second = self.derivative(&ahead(&first, 0.5));
            let third = self.derivative(&ahead(&second, 0.5));
            let fourth = self.derivative(&ahead(&third, 1.0));
            state = std::array::from_fn(|i| {
                state[i] + dt_s / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i])
            });
        }
        response.terms()[0].step.unwrap()
    }
}

/// The source samples at times of its own choice, which it does not print: what it reads from straight lines
/// between them is off by up to a thousandth, and so is the highest of its samples.
const SAMPLING: f64 = 1e-3;

fn assert_agrees(found: f64, printed: &str) {
    let printed = Printed::parse(printed).unwrap();
    let tolerance = printed.tolerance() + SAMPLING * printed.value();
    assert!(
        (found - printed.value()).abs() <= tolerance,
        "{found} instead of {}",
        printed.text()
    );
}

#[test]
fn third_order_example() {
    // (8 s² + 18 s + 32)/(s³ + 6 s² + 14 s + 24)
    let example = TransferFunction {
        numerator: [8.0, 18.0, 32.0],
        denominator: [6.0, 14.0, 24.0],
    };
    let found = example.step_terms(20.0, 0.002);
    // Printed in percent.
    assert_agrees(100.0 * found.overshoot, "26.5302");
    // These two to the digit.
    assert!(Printed::parse("0.2087").unwrap().agrees(found.rise_time_s));
    assert!(
        Printed::parse("3.4972")
            .unwrap()
            .agrees(found.settling_time_s)
    );
}

#[test]
fn fourth_order_example() {
    // (s² + 5 s + 5)/(s⁴ + 1.65 s³ + 5 s² + 6.5 s + 2)
    let example = TransferFunction {
        numerator: [0.0, 1.0, 5.0, 5.0],
        denominator: [1.65, 5.0, 6.5, 2.0],
    };
    let found = example.step_terms(60.0, 0.01);
    assert_agrees(found.rise_time_s, "3.8456");
    assert_agrees(found.settling_time_s, "27.9762");
    // The peak, of which the overshoot is a small difference.
    assert_agrees(2.5 * (1.0 + found.overshoot), "2.6873");
}
