use core::f64::consts::PI;

use wiener::{Fleet, Input, NARROW};

use crate::{DriveLimits, FirstOrder, PidGains, Screen, TaskError};

/// Decades by which gains are slowed down, at most.
const DECADES: f64 = 6.0;
/// Steps in which they are, at first.
const STEPS: usize = 120;
/// Halvings of a step afterwards.
const HALVINGS: usize = 20;
/// Time constants of a relay test.
const RELAY_TAUS: f64 = 60.0;
/// Most samples of one.
const MOST_SAMPLES: f64 = 400_000.0;
/// Periods at its end that count.
const PERIODS: usize = 4;

impl FirstOrder {
    /// Gains of a PI controller by internal-model control as simplified by Skogestad, SIMC `[Skogestad2003]`:
    ///
    /// ```text
    /// kp = τ/(K (τ_c + θ)),   T_i = min(τ, 4 (τ_c + θ)),   ki = kp/T_i
    /// ```
    ///
    /// The time constant τ_c of the closed loop is the user's; its author recommends the dead time θ.
    #[must_use]
    pub fn simc(&self, closed_loop_tau_s: f64) -> PidGains {
        let slow_s = closed_loop_tau_s + self.dead_time_s;
        let kp = self.tau_s / (self.gain * slow_s);
        PidGains {
            kp,
            ki: kp / self.tau_s.min(4.0 * slow_s),
            kd: 0.0,
        }
    }
}

impl Screen {
    /// SIMC for the plant where it is steepest: with the recommended τ_c = θ, or the shortest above it that meets what is
    /// required. `None` if the plant does not rise, or if none does.
    #[must_use]
    pub fn simc(&self) -> Option<PidGains> {
        let models = self.plants().iter().filter_map(|plant| plant.first_order());
        // The one whose gains are the smallest is safe for all.
        let model = models.min_by(|a, b| {
            let kp = |model: &FirstOrder| model.simc(model.dead_time_s).kp;
            kp(a).total_cmp(&kp(b))
        })?;
        // A closed loop that is slower by a factor in τ_c + θ.
        self.fastest(|slower| model.simc((2.0 * slower - 1.0) * model.dead_time_s))
    }
}

/// A plant that a relay switches between the limits of its drive, around a set point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayTest {
    /// Limits of the drive: what the relay switches between.
    pub limits: DriveLimits,
    /// Temperature of the surroundings, °C.
    pub ambient_degc: f64,
    /// Sample time, s.
    pub dt_s: f64,
    /// Slowest time constant that the plant is thought to have, s.
    pub tau_s: f64,
    /// Output around which it switches.
    pub setpoint: f64,
    /// Samples from a command to its effect.
    pub dead_time_samples: usize,
    /// Half of the relay's own hysteresis, in the output's unit: above what the sensor does by itself.
    pub hysteresis: f64,
}

/// The cycle that a relay test ends in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayCycle {
    /// First harmonic of the drive over that of the output: the gain at which the loop would just swing.
    pub ultimate_gain: f64,
    /// Period, s.
    pub period_s: f64,
}

impl RelayTest {
    /// Runs the test; `None` if no cycle shows.
    ///
    /// # Errors
    ///
    /// [`TaskError::Plant`].
    pub fn run<F: Fleet>(
        &self,
        fleet: &F,
        member: F::Member,
    ) -> Result<Option<RelayCycle>, TaskError<F::Error>> {
        let mut plants = fleet.narrow(&[member; NARROW]).map_err(TaskError::Plant)?;
        let DriveLimits { lower, upper } = self.limits;
        let n_samples = (RELAY_TAUS * self.tau_s / self.dt_s).min(MOST_SAMPLES) as usize;
        let mut commands = vec![lower; n_samples + self.dead_time_samples];
        let mut outputs = Vec::with_capacity(n_samples);
        let mut rises = Vec::new();
        let mut drive = upper;
        for k in 0..n_samples {
            let output = plants.output().displacement[0];
            outputs.push(output);
            if output > self.setpoint + self.hysteresis {
                drive = lower;
            } else if output < self.setpoint - self.hysteresis {
                if drive <= lower {
                    rises.push(k);
                }
                drive = upper;
            }
            commands[k + self.dead_time_samples] = drive;
            let input = Input {
                drive: [commands[k]; NARROW],
                ambient_degc: self.ambient_degc,
            };
            plants.step(&input, self.dt_s);
        }
        let Some(first) = rises.len().checked_sub(PERIODS + 1) else {
            return Ok(None);
        };
        let [begin, end] = [rises[first], rises[rises.len() - 1]];
        let harmonic = |series: &[f64]| {
            let n = series.len() as f64;
            let angle = |k: usize| 2.0 * PI * PERIODS as f64 * k as f64 / n;
            let [re, im] = series
                .iter()
                .enumerate()
                .fold([0.0, 0.0], |sum, (k, value)| {
                    [
                        sum[0] + value * libm::cos(angle(k)),
                        sum[1] + value * libm::sin(angle(k)),
                    ]
                });
            libm::hypot(re, im)
        };
        // What the controller would have commanded, not what acts after the dead time.
        let drives = &commands[begin + self.dead_time_samples..end + self.dead_time_samples];
        let of_output = harmonic(&outputs[begin..end]);
        Ok((of_output > 0.0).then(|| RelayCycle {
            ultimate_gain: harmonic(drives) / of_output,
            period_s: (end - begin) as f64 * self.dt_s / PERIODS as f64,
        }))
    }
}

impl Screen {
    /// A relay test's gains, or, where they miss what is required, the fastest that are slower by one factor in kp and in
    /// T_i; `None` if none meets it.
    #[must_use]
    pub fn relay(&self, cycle: &RelayCycle) -> Option<PidGains> {
        let PidGains { kp, ki, kd } = cycle.pi();
        self.fastest(|slower| PidGains {
            kp: kp / slower,
            ki: ki / (slower * slower),
            kd,
        })
    }

    /// The fastest of gains that are slowed down by a factor from 1 on, and meet what is required.
    fn fastest(&self, slowed: impl Fn(f64) -> PidGains) -> Option<PidGains> {
        let meets = |decades: f64| self.shortfall(&slowed(libm::exp10(decades))) <= 0.0;
        // From the fast end: margins need not rise all the way.
        let met = (0..=STEPS).map(|k| k as f64 * DECADES / STEPS as f64);
        let mut met = met.into_iter().find(|&decades| meets(decades))?;
        let mut missed = (met - DECADES / STEPS as f64).max(0.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (missed + met);
            if meets(middle) {
                met = middle;
            } else {
                missed = middle;
            }
        }
        Some(slowed(libm::exp10(met)))
    }
}

impl RelayCycle {
    /// Gains of a PI controller by Ziegler and Nichols from a relay test, `[Astrom1984]`: kp = 0.4 K_u, T_i = 0.8 T_u.
    #[must_use]
    pub fn pi(&self) -> PidGains {
        let kp = 0.4 * self.ultimate_gain;
        PidGains {
            kp,
            ki: kp / (0.8 * self.period_s),
            kd: 0.0,
        }
    }
}
