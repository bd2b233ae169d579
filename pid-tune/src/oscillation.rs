use wiener::hysteresis::Branch;
use wiener::{Plant, Started, State};

use crate::{
    Approach, ClosedLoop, ClosedLoopParams, Disturbances, PidState, Reference, RodLoop, Sample,
    TuneError,
};

/// Windows at the end of a run that are compared.
const WINDOWS: usize = 3;
/// Time constants that a run lasts before the windows.
const SETTLING_TAUS: f64 = 60.0;
/// Integral times kp/ki that it lasts, if there is an integral.
const SETTLING_INTEGRAL_TIMES: f64 = 2.0;
/// Most samples before the windows: beyond, a slow integral has not settled.
const MAX_SETTLING_SAMPLES: usize = 200_000;
/// Time constants of a window.
const WINDOW_TAUS: f64 = 10.0;
/// Samples of a window besides, for each sample of delay.
const WINDOW_SAMPLES: usize = 200;
/// Share of the set point below which an amplitude counts as rest.
const SMALLEST_SHARE: f64 = 5e-4;
/// Share of the output's whole range below which it does: far above rounding.
const SMALLEST_OF_RANGE: f64 = 1e-6;
/// Share of its amplitude that an oscillation must keep from window to window.
const SUSTAINED: f64 = 0.9;
/// Passes through the mean, upward, that a window must have.
const FEWEST_CROSSINGS: usize = 3;
/// Perturbation of the start near the set point, as a share of the output's whole range.
const PERTURBATION: f64 = 2e-3;

/// Where a simulation starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StartFrom {
    /// Cold and still, the controller idle.
    Rest,
    /// Heated at the upper limit for long, the controller idle.
    Hot,
    /// On the heating curve, 0.2 % of the output's range above the set point, the controller holding it there; at
    /// rest where no temperature brings the output there.
    Near,
}

impl StartFrom {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Rest, Self::Hot, Self::Near];

    /// Which history of the rod a prediction must assume for it.
    #[must_use]
    pub fn approach(self) -> Approach {
        match self {
            Self::Rest | Self::Near => Approach::FromBelow,
            Self::Hot => Approach::FromAbove,
        }
    }
}

/// A sustained oscillation of the output in a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillation {
    /// Half peak-to-peak over the last window, in the output's unit.
    pub amplitude: f64,
    /// Amplitude of the sine of the same mean square, √2 times the standard deviation: what compares with a first
    /// harmonic, and hardly depends on where samples fall.
    pub sine_amplitude: f64,
    /// Passes upward through the mean, per second.
    pub frequency_hz: f64,
    /// Mean output.
    pub mean: f64,
}

impl RodLoop {
    /// Amplitude below which the output counts as at rest: one step of the converter, but at least 0.05 % of the
    /// set point and a millionth of the output's range.
    #[must_use]
    pub fn smallest_amplitude(&self) -> f64 {
        let params = self.params();
        params
            .quantization_step
            .max(SMALLEST_SHARE * params.setpoint.abs())
            .max(SMALLEST_OF_RANGE * params.rod.gain.abs())
    }

    /// Sustained oscillation of the simulated loop; `None` if it comes to rest, or drifts.
    ///
    /// The run lasts 60 τ, or twice kp/ki where that is longer (but no more than 200,000 samples), and then three
    /// windows of 10 τ and 200 samples for each sample of delay, hold included. An oscillation is *sustained* if in each
    /// window its amplitude (half peak-to-peak) is at least [`RodLoop::smallest_amplitude`] and 90 % of that in the window
    /// before, and if it passes its mean upward three times.
    ///
    /// # Errors
    ///
    /// None for a loop that was checked, but for an output that is not finite.
    pub fn simulated(&self, start: StartFrom) -> Result<Option<Oscillation>, TuneError> {
        let params = self.params();
        let dt_s = self.dt_s();
        let gains = params.gains;
        let integral_s = if gains.ki > 0.0 {
            SETTLING_INTEGRAL_TIMES * gains.kp / gains.ki
        } else {
            0.0
        };
        let settling_s = integral_s.max(SETTLING_TAUS * self.tau_s());
        let settling = ((settling_s / dt_s) as usize).min(MAX_SETTLING_SAMPLES);
        let window = ((WINDOW_TAUS * self.tau_s() / dt_s) as usize).min(MAX_SETTLING_SAMPLES)
            + WINDOW_SAMPLES * (params.dead_time_samples + 1);
        let (state, mut pid_state) = self.started(start)?;
        let closed_loop = ClosedLoop::new(ClosedLoopParams {
            reference: Reference::Step {
                from: params.setpoint,
                to: params.setpoint,
                at_s: 0.0,
            },
            n_samples: settling + WINDOWS * window,
            ambient_degc: params.ambient_degc,
            feed_forward: None,
            aim: None,
            disturbances: Disturbances {
                quantization_step: params.quantization_step,
                dead_time_samples: params.dead_time_samples,
                ..Disturbances::default()
            },
        })?;
        let mut outputs = Vec::with_capacity(WINDOWS * window);
        let mut rod = Started {
            plant: *self.plant(),
            state,
        };
        closed_loop.run(&mut rod, self.pid(), &mut pid_state, |snapshot| {
            if snapshot.k >= settling {
                outputs.push(snapshot.output[0]);
            }
        });
        Ok(sustained(&outputs, window, dt_s, self.smallest_amplitude()))
    }

    fn started(&self, start: StartFrom) -> Result<(State, PidState), TuneError> {
        let params = self.params();
        let plant = self.plant();
        let idle = |state: State| {
            let pid_state = self.pid().rest(plant.output(&state).displacement)?;
            Ok((state, pid_state))
        };
        let perturbation = PERTURBATION * params.rod.gain;
        match start {
            StartFrom::Rest => idle(plant.rest(params.ambient_degc)),
            StartFrom::Hot => idle(self.hot()),
            StartFrom::Near => {
                let Some(near_degc) =
                    self.limiting_degc(Branch::Heating, params.setpoint + perturbation)
                else {
                    return idle(plant.rest(params.ambient_degc));
                };
                let state = plant.on_limiting_curve(Branch::Heating, [near_degc]);
                // Taken over at the measurement, so that the perturbation is not charged to the integral.
                let measured = plant.output(&state).displacement;
                let sample = Sample {
                    setpoint: measured[0],
                    measured,
                    feed_forward: 0.0,
                };
                let drive = [self.holding_drive(near_degc)];
                let pid_state = self.pid().start(&sample, drive)?;
                Ok((state, pid_state))
            }
        }
    }
}

/// Oscillation in a window of outputs, and its upward passes through the mean.
#[derive(Debug, Clone, Copy)]
struct Window {
    oscillation: Oscillation,
    crossings: usize,
}

/// The oscillation of the last window, if it is sustained over all.
fn sustained(
    outputs: &[f64],
    length: usize,
    dt_s: f64,
    smallest_amplitude: f64,
) -> Option<Oscillation> {
    let mut before = smallest_amplitude;
    let mut last = None;
    for outputs in outputs.chunks_exact(length) {
        let Window {
            oscillation,
            crossings,
        } = window(outputs, dt_s);
        let lasts = oscillation.amplitude >= before.max(smallest_amplitude)
            && crossings >= FEWEST_CROSSINGS;
        if !lasts {
            return None;
        }
        before = SUSTAINED * oscillation.amplitude;
        last = Some(oscillation);
    }
    last
}

fn window(outputs: &[f64], dt_s: f64) -> Window {
    let count = outputs.len() as f64;
    let mean = outputs.iter().sum::<f64>() / count;
    let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
    let mut square = 0.0;
    let mut crossings = 0;
    let mut crossed = [0.0; 2];
    for k in 0..outputs.len() {
        let here = outputs[k] - mean;
        ends = [ends[0].min(here), ends[1].max(here)];
        square += here * here;
        let before = outputs[k.max(1) - 1] - mean;
        if here >= 0.0 && before < 0.0 {
            let at = k as f64 - here / (here - before);
            if crossings == 0 {
                crossed[0] = at;
            }
            crossed[1] = at;
            crossings += 1;
        }
    }
    let cycles = crossings.max(1) as f64 - 1.0;
    Window {
        oscillation: Oscillation {
            amplitude: 0.5 * (ends[1] - ends[0]),
            sine_amplitude: (2.0 * square / count).sqrt(),
            frequency_hz: cycles / ((crossed[1] - crossed[0]) * dt_s),
            mean,
        },
        crossings,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may end in a panic")]
mod tests {
    use super::sustained;
    use core::f64::consts::PI;

    fn series(value: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..3000).map(|k| value(0.1 * f64::from(k))).collect()
    }

    #[test]
    fn a_sine_on_a_slope_is_found_with_its_numbers() {
        let sine = series(|t| 2.0 + 1e-5 * t + 0.3 * (2.0 * PI * 0.17 * t).sin());
        let found = sustained(&sine, 1000, 0.1, 0.01).unwrap();
        assert!((found.amplitude - 0.3).abs() < 3e-3, "{found:?}");
        assert!((found.sine_amplitude - 0.3).abs() < 3e-3, "{found:?}");
        assert!((found.frequency_hz - 0.17).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn what_decays_drifts_or_is_small_is_rest() {
        let decays = series(|t| (-0.004 * t).exp() * (2.0 * PI * 0.17 * t).sin());
        assert_eq!(sustained(&decays, 1000, 0.1, 0.01), None);
        let drifts = series(|t| 5.0 - (-0.01 * t).exp());
        assert_eq!(sustained(&drifts, 1000, 0.1, 0.01), None);
        let small = series(|t| 0.009 * (2.0 * PI * 0.17 * t).sin());
        assert_eq!(sustained(&small, 1000, 0.1, 0.01), None);
        let missing = series(|_| f64::NAN);
        assert_eq!(sustained(&missing, 1000, 0.1, 0.01), None);
    }
}
