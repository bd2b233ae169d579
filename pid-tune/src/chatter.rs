use wiener::hysteresis::Rule;

use crate::bracket::root;
use crate::fraction_response::{MAX_SETTLING_CYCLES, TemperatureSine, crept_memory};
use crate::{Approach, DriveLimits, RodLoop};

/// Longest period that is looked at, samples, in a loop without dead time.
pub const MAX_CHATTER_SAMPLES: usize = 64;

/// Samples by which each sample of dead time makes the longest period longer.
const CHATTER_SAMPLES_PER_DEAD_TIME: usize = 12;

/// Largest change of a fraction from period to period that counts as none.
const PERIODIC: f64 = 1e-10;
/// To this a partial drive is found, in the drive's unit.
const DRIVE_TOLERANCE: f64 = 1e-10;
/// Largest share of samples that may be between the limits in an orbit that is not exact.
const MOST_BETWEEN: f64 = 0.25;
/// How far a command may be from what the pattern has, in the drive's unit: rounding.
const CONSISTENT: f64 = 1e-6;

/// A periodic orbit of the sampled loop: `on_samples` at the upper limit, at most one sample between the limits, the
/// others at the lower limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChatterOrbit {
    /// How the rod came there; under [`Rule::LastReversal`] always from below, and the same from above.
    pub approach: Approach,
    /// Period, samples.
    pub period_samples: usize,
    /// Samples of it at the upper limit.
    pub on_samples: usize,
    /// Drive of the sample between, if there is one.
    pub partial_drive: Option<f64>,
    /// Half peak-to-peak of the output at the samples, in its unit.
    pub amplitude: f64,
    /// √2 times the standard deviation of the output.
    pub sine_amplitude: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Mean temperature at the samples, °C.
    pub mean_degc: f64,
    /// True if the controller commands exactly these drives. If false, a switch without a linear zone would command them:
    /// at each sample the error has the sign of the drive, but at some samples it is so small that the command is
    /// between the limits.
    pub exact: bool,
    /// True if a small disturbance of the temperature dies out. If all drives are at the limits, it always does.
    pub stable: bool,
}

/// Where the sample between the limits stands.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Partial {
    None,
    /// Right after those at the upper limit.
    After(f64),
    /// Right before them.
    Before(f64),
}

/// Drives over one period.
#[derive(Debug, Clone, Copy)]
struct Pattern {
    period: usize,
    on: usize,
    partial: Partial,
}

/// Response of the rod to a pattern, once periodic.
struct Forced {
    outputs: Vec<f64>,
    /// Output per temperature on the branch that led to each sample, 1/K times the output's unit.
    slopes_per_k: Vec<f64>,
    mean_degc: f64,
}

impl RodLoop {
    /// Periodic orbits of up to [`MAX_CHATTER_SAMPLES`] samples, and 12 more for each sample of dead time; for each
    /// approach the shortest first.
    ///
    /// For each pattern of drives the temperature's periodic solution is a closed form, the hysteresis is driven until
    /// it repeats, and the orbit is kept if the controller would command that very pattern, `dead_time_samples` later:
    /// no approximation, a Tsypkin locus point by point `[Tsypkin1984]`. How many samples of a period are at the upper
    /// limit is found by bisection, as more of them make the output higher at any sample, and its neighbors are tried
    /// too; a drive between the limits is found by a root search, in periods of up to [`MAX_CHATTER_SAMPLES`].
    ///
    /// Not found are orbits with several samples between the limits. A loop in which all others are unstable
    /// wanders, aperiodic, about those that are.
    ///
    /// The integral counts as constant over a period: 0 where ki = 0; else any value between the limits for which the
    /// pattern is consistent, and with a sample between the limits the value for which its error is 0, because clamping
    /// integrates little else.
    #[must_use]
    pub fn chatter_orbits(&self) -> Vec<ChatterOrbit> {
        let approaches: &[Approach] = match self.params().rule {
            Rule::LastReversal => &[Approach::FromBelow],
            Rule::Nested => &[Approach::FromBelow, Approach::FromAbove],
        };
        let mut orbits = Vec::new();
        for &approach in approaches {
            let search = Search {
                rod_loop: self,
                approach,
                memory: self.history(approach),
            };
            let longest = MAX_CHATTER_SAMPLES
                + CHATTER_SAMPLES_PER_DEAD_TIME * self.params().dead_time_samples;
            for period in 2..=longest {
                let enough = search.enough_on(period);
                for on in enough.max(1) - 1..=(enough + 1).min(period - 1) {
                    orbits.extend(search.orbits(period, on));
                }
            }
        }
        orbits
    }
}

struct Search<'a> {
    rod_loop: &'a RodLoop,
    approach: Approach,
    memory: wiener::hysteresis::Memory<1>,
}

impl Search<'_> {
    /// Fewest samples of a period at the upper limit after which the controller does not ask for another one.
    fn enough_on(&self, period: usize) -> usize {
        let [mut few, mut enough] = [0, period - 1];
        while few < enough {
            let on = usize::midpoint(few, enough);
            let pattern = Pattern {
                period,
                on,
                partial: Partial::None,
            };
            let asked = self.commanded_at(&pattern, on);
            if self.forced(&pattern).outputs[asked] < self.rod_loop.params().setpoint {
                few = on + 1;
            } else {
                enough = on;
            }
        }
        enough
    }

    /// Orbits of one period and one number of samples at the upper limit.
    fn orbits(&self, period: usize, on: usize) -> Vec<ChatterOrbit> {
        let mut orbits = Vec::new();
        if on > 0 {
            orbits.extend(self.consistent(Pattern {
                period,
                on,
                partial: Partial::None,
            }));
        }
        // With a single other sample before and after are the same.
        let places: &[fn(f64) -> Partial] = if period > MAX_CHATTER_SAMPLES {
            &[]
        } else if on == 0 || on + 1 == period {
            &[Partial::After]
        } else {
            &[Partial::After, Partial::Before]
        };
        let DriveLimits { lower, upper } = self.rod_loop.limits();
        for place in places {
            let pattern = |drive: f64| Pattern {
                period,
                on,
                partial: place(drive),
            };
            let excess = |drive: f64| self.partial_excess(&pattern(drive), drive);
            if let Some(drive) = root(excess, [lower, upper], DRIVE_TOLERANCE) {
                orbits.extend(self.consistent(pattern(drive)));
            }
        }
        orbits
    }

    /// Shortfall of the drive at the sample between the limits: 0 if the controller commands it. With integral
    /// action: the error at the sample that commands it.
    fn partial_excess(&self, pattern: &Pattern, drive: f64) -> f64 {
        let forced = self.forced(pattern);
        let at = self.commanded_at(pattern, pattern.partial_index());
        let gains = self.rod_loop.params().gains;
        if gains.ki > 0.0 {
            self.rod_loop.params().setpoint - forced.outputs[at]
        } else {
            self.without_integral(&forced.outputs)[at] - drive
        }
    }

    /// The orbit of a pattern, if the controller would command it.
    fn consistent(&self, pattern: Pattern) -> Option<ChatterOrbit> {
        let DriveLimits { lower, upper } = self.rod_loop.limits();
        let forced = self.forced(&pattern);
        let commands = self.without_integral(&forced.outputs);
        if !commands.iter().all(|command| command.is_finite()) {
            return None;
        }
        let is_switch = pattern.partial == Partial::None;
        // Bounds of the integral.
        let mut bounds = if self.rod_loop.params().gains.ki > 0.0 {
            [lower, upper]
        } else {
            [0.0, 0.0]
        };
        let mut switches = is_switch;
        let mut n_between = 0;
        for index in 0..pattern.period {
            let command = commands[self.commanded_at(&pattern, index)];
            if index < pattern.on {
                bounds[0] = bounds[0].max(upper - command);
                switches &= command >= 0.0;
            } else if !is_switch && index == pattern.partial_index() {
                let drive = pattern.drive(index, self.rod_loop.limits());
                bounds = [
                    bounds[0].max(drive - command),
                    bounds[1].min(drive - command),
                ];
            } else {
                bounds[1] = bounds[1].min(lower - command);
                switches &= command <= 0.0;
            }
            n_between += usize::from(command.abs() < upper);
        }
        let exact = bounds[0] <= bounds[1] + CONSISTENT;
        switches &= n_between as f64 <= MOST_BETWEEN * pattern.period as f64;
        (exact || switches).then(|| self.orbit(&pattern, &forced, exact))
    }

    fn orbit(&self, pattern: &Pattern, forced: &Forced, exact: bool) -> ChatterOrbit {
        let count = pattern.period as f64;
        let mean = forced.outputs.iter().sum::<f64>() / count;
        let square: f64 = forced
            .outputs
            .iter()
            .map(|output| (output - mean) * (output - mean))
            .sum();
        let highest = forced.outputs.iter().copied().fold(mean, f64::max);
        let lowest = forced.outputs.iter().copied().fold(mean, f64::min);
        ChatterOrbit {
            approach: self.approach,
            period_samples: pattern.period,
            on_samples: pattern.on,
            partial_drive: (pattern.partial != Partial::None)
                .then(|| pattern.drive(pattern.partial_index(), self.rod_loop.limits())),
            amplitude: 0.5 * (highest - lowest),
            sine_amplitude: (2.0 * square / count).sqrt(),
            frequency_hz: 1.0 / (count * self.rod_loop.dt_s()),
            mean_degc: forced.mean_degc,
            exact,
            stable: self.is_stable(pattern, forced),
        }
    }

    /// A disturbance x of the temperature at the sample that commands the drive between the limits is, a period later,
    ///
    /// ```text
    /// x' = a^n x - c x,   c = a^(n-1-d) (1 - a) dB/du kp dy/dT
    /// ```
    ///
    /// with the steady temperature B(u) and the dead time d; the other drives do not answer. Where d is a period or more
    /// the second x is that of some periods before, and |c| < 1 - a^n is sufficient. The derivative's gain is left out.
    fn is_stable(&self, pattern: &Pattern, forced: &Forced) -> bool {
        if pattern.partial == Partial::None {
            return true;
        }
        let params = self.rod_loop.params();
        let (dead_time, period) = (params.dead_time_samples, pattern.period);
        let index = pattern.partial_index();
        let drive = pattern.drive(index, self.rod_loop.limits());
        let decay = self.rod_loop.dt_s() / self.rod_loop.tau_s();
        let over = |samples: usize| libm::exp(-decay * samples as f64);
        let answer = over(period - 1 - dead_time % period)
            * (1.0 - over(1))
            * self.rod_loop.rise_per_drive_k(drive)
            * params.gains.kp
            * forced.slopes_per_k[self.commanded_at(pattern, index)];
        if dead_time < period {
            (over(period) - answer).abs() < 1.0
        } else {
            answer.abs() < 1.0 - over(period)
        }
    }

    /// Sample of the period at which the drive of another one was commanded.
    fn commanded_at(&self, pattern: &Pattern, index: usize) -> usize {
        let delay = self.rod_loop.params().dead_time_samples % pattern.period;
        (index + pattern.period - delay) % pattern.period
    }

    /// Outputs under a pattern that goes on for ever.
    fn forced(&self, pattern: &Pattern) -> Forced {
        let limits = self.rod_loop.limits();
        let retained = libm::exp(-self.rod_loop.dt_s() / self.rod_loop.tau_s());
        let balances_degc: Vec<f64> = (0..pattern.period)
            .map(|index| self.rod_loop.balance_degc(pattern.drive(index, limits)))
            .collect();
        let temperatures_degc = periodic(retained, &balances_degc, 1.0 - retained);
        let mut ends_degc = [f64::NEG_INFINITY, f64::INFINITY];
        for &degc in &temperatures_degc {
            ends_degc = [ends_degc[0].max(degc), ends_degc[1].min(degc)];
        }
        let hysteresis = self.rod_loop.plant().hysteresis();
        let mut memory = match self.rod_loop.params().rule {
            Rule::LastReversal => crept_memory(
                hysteresis,
                TemperatureSine {
                    bias_degc: 0.5 * (ends_degc[0] + ends_degc[1]),
                    amplitude_k: 0.5 * (ends_degc[0] - ends_degc[1]),
                },
            ),
            Rule::Nested => self.memory.clone(),
        };
        // The temperature has one maximum and one minimum.
        let mut cycle = || ends_degc.map(|end_degc| hysteresis.commit(&mut memory, [end_degc])[0]);
        let mut ends = cycle();
        for _ in 0..MAX_SETTLING_CYCLES {
            let next = cycle();
            let change = (next[0] - ends[0]).abs().max((next[1] - ends[1]).abs());
            ends = next;
            if change <= PERIODIC {
                break;
            }
        }
        // The temperature of index 0 is the lowest or one on the way up from it.
        let lowest = temperatures_degc
            .iter()
            .position(|&degc| degc <= ends_degc[1])
            .unwrap_or(0);
        let mut outputs = vec![0.0; pattern.period];
        let mut slopes_per_k = vec![0.0; pattern.period];
        for step in 1..=pattern.period {
            let index = (lowest + step) % pattern.period;
            let sensed = hysteresis.peek(&memory, [temperatures_degc[index]]);
            let [fraction] = hysteresis.commit(&mut memory, [temperatures_degc[index]]);
            outputs[index] = self.rod_loop.output_at(fraction);
            slopes_per_k[index] = self.rod_loop.params().rod.gain * sensed.slope_per_k[0];
        }
        Forced {
            slopes_per_k,
            mean_degc: temperatures_degc.iter().sum::<f64>() / pattern.period as f64,
            outputs,
        }
    }

    /// Commands for periodic outputs, before limits and without the integral.
    fn without_integral(&self, outputs: &[f64]) -> Vec<f64> {
        let params = self.rod_loop.params();
        let period = outputs.len();
        let dt_s = self.rod_loop.dt_s();
        let retained = libm::exp(-dt_s / params.controller.derivative_filter_s);
        // Input of sample k shows in the derivative of sample k, hence in that of index k + 1 of `periodic`.
        let rates: Vec<f64> = (0..period)
            .map(|k| -(outputs[k] - outputs[(k + period - 1) % period]) / dt_s)
            .collect();
        let derivatives = periodic(retained, &rates, params.gains.kd * (1.0 - retained));
        (0..period)
            .map(|k| {
                params.gains.kp * (params.setpoint - outputs[k]) + derivatives[(k + 1) % period]
            })
            .collect()
    }
}

impl Pattern {
    fn partial_index(&self) -> usize {
        match self.partial {
            Partial::None | Partial::After(_) => self.on,
            Partial::Before(_) => self.period - 1,
        }
    }

    /// Drive of a sample of the period; those at the upper limit come first.
    fn drive(&self, index: usize, limits: DriveLimits) -> f64 {
        if index < self.on {
            return limits.upper;
        }
        match self.partial {
            Partial::After(drive) | Partial::Before(drive) if index == self.partial_index() => {
                drive
            }
            _ => limits.lower,
        }
    }
}

/// The periodic solution of x_(k+1) = a x_k + b w_k: x over one period.
fn periodic(retained: f64, inputs: &[f64], share: f64) -> Vec<f64> {
    let mut from_rest = 0.0;
    let mut power = 1.0;
    for input in inputs {
        from_rest = retained * from_rest + share * input;
        power *= retained;
    }
    let mut value = from_rest / (1.0 - power);
    inputs
        .iter()
        .map(|input| {
            let here = value;
            value = retained * value + share * input;
            here
        })
        .collect()
}
