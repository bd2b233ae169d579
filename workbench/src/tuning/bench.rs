//! A rig with its sensor, its supply and the controller's delay.

use identify::Sensor;
use pid_tune::{
    Across, ClosedLoop, ClosedLoopParams, CostWeights, Disturbances, Goal, InverseRun, PidGains,
    PidParams, PlantResponse, Reference, RelayTest, RestTest, RodLoop, RodLoopParams, Screen,
    SmallChanges, Task, TunerConfig,
};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::DriveResolution;
use sma_effects::Turned;

use super::CHATTER;
use crate::WorkbenchError;
use crate::rig::Rig;

/// A controller that does nothing.
const NO_GAINS: PidGains = PidGains {
    kp: 0.0,
    ki: 0.0,
    kd: 0.0,
};

/// Beyond the outputs that are asked for, small changes are looked at by this share of the way more: a response that
/// overshoots goes there.
const OVERSHOOT: f64 = 0.05;
/// A relay switches this many jumps of the sensor off the set point, at least, so that it does not switch on noise
/// `[Astrom1984]`, and this share of the step.
const RELAY: [f64; 2] = [2.0, 0.01];

/// A rig and what stands between it and its controller.
#[derive(Debug, Clone, Copy)]
pub struct Bench<'a> {
    /// The rig.
    pub rig: &'a Rig,
    /// The controller but for its gains.
    pub pid: PidParams,
    /// Step and noise of the sensor.
    pub sensor: Sensor,
    /// Samples from a measurement to what is commanded by it.
    pub dead_time_samples: usize,
    /// How finely the drive can be set; 0 or `None` for an ideal one.
    pub resolution: DriveResolution,
    /// Seed of the sensor's noise.
    pub seed: u64,
}

impl<'a> Bench<'a> {
    /// Noise of the sensor, a value a sample: of the standard deviation and the correlation that it has; nothing for one
    /// without noise.
    #[must_use]
    pub fn noise(&self, n_samples: usize) -> Vec<f64> {
        if self.sensor.noise <= 0.0 {
            return Vec::new();
        }
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        // Not the stream of the rods that are drawn.
        rng.set_stream(1);
        let kept = (-self.pid.dt_s / self.sensor.correlation_s).exp();
        let new = (1.0 - kept * kept).sqrt();
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut state = normal();
        let noise = (0..n_samples).map(|_| {
            let value = self.sensor.noise * state;
            state = kept * state + new * normal();
            value
        });
        noise.collect()
    }

    /// The loop around a reference. The noise is that of [`Bench::noise`], the feed-forward that of [`Bench::forward`] if there
    /// is one.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn closed_loop<'r>(
        &self,
        reference: Reference<'r>,
        n_samples: usize,
        noise: &'r [f64],
        forward: Option<&'r InverseRun>,
    ) -> Result<ClosedLoop<'r>, WorkbenchError> {
        Ok(ClosedLoop::new(ClosedLoopParams {
            reference,
            n_samples,
            ambient_degc: self.rig.ambient_degc,
            feed_forward: forward.map(|run| run.drive.as_slice()),
            aim: forward.map(|run| run.output.as_slice()),
            disturbances: Disturbances {
                measurement_noise: (!noise.is_empty()).then_some(noise),
                quantization_step: self.sensor.step,
                dead_time_samples: self.dead_time_samples,
                drive_step: self.resolution.step.unwrap_or(0.0),
                drive_dead_zone: self.resolution.dead_zone.unwrap_or(0.0),
                ..Disturbances::default()
            },
        })?)
    }

    /// Inverse of the baseline model along a reference.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn forward(
        &self,
        reference: &Reference<'_>,
        n_samples: usize,
    ) -> Result<InverseRun, WorkbenchError> {
        let plain = self.rod_loop(NO_GAINS, self.rig.rest_output()?)?;
        Ok(plain.inverse_run(reference, n_samples)?)
    }

    /// A task of the rig.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn task<'r>(
        &self,
        closed_loop: ClosedLoop<'r>,
    ) -> Result<Task<'r, Turned>, WorkbenchError> {
        Ok(Task::new(self.rig.fleet, closed_loop, self.pid)?)
    }

    /// How the rig answers small changes of the drive where it answers most, between rest and the highest output that
    /// is asked for, as the controller sees it.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn steepest(&self, highest: f64) -> Result<Vec<PlantResponse>, WorkbenchError> {
        let changes = self.small_changes(highest)?;
        Ok(changes.steepest(&self.rig.fleet, self.rig.member)?)
    }

    /// Small changes of the drive, between rest and the highest output that is asked for, as the controller sees it.
    pub(super) fn small_changes(&self, highest: f64) -> Result<SmallChanges, WorkbenchError> {
        let rest = self.rig.rest_output()?;
        Ok(SmallChanges {
            limits: self.pid.limits,
            ambient_degc: self.rig.ambient_degc,
            dt_s: self.pid.dt_s,
            tau_s: self.rig.tau_s(),
            outputs: [rest, highest + OVERSHOOT * (highest - rest)],
            dead_time_samples: self.dead_time_samples,
        })
    }

    /// Goal of a search: the least cost of gains that pass a screen, and rest from each side. `loops` are those of
    /// [`Bench::approaching`]; a set point is as the controller sees it.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn goal<'g>(
        &self,
        weights: CostWeights,
        screen: &'g Screen,
        loops: &'g [ClosedLoop<'g>],
        set_point: f64,
    ) -> Result<Goal<'g>, WorkbenchError> {
        let range = self.drive_range();
        Ok(Goal {
            weights,
            // A drive that makes its largest jump at every sample costs as much as a term of the response.
            wear: self.pid.dt_s / (screen.requirements().largest_kick * range),
            screen: Some(screen),
            rest: Some(RestTest {
                loops,
                height: set_point - self.rig.rest_output()?,
                drive_swing: CHATTER * range,
            }),
            across: Across::Worst,
        })
    }

    /// Where gains are looked for, with what a screen leaves of it.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn search(
        &self,
        task: &Task<'_, Turned>,
        screen: &Screen,
    ) -> Result<TunerConfig, WorkbenchError> {
        let mut config = TunerConfig::for_task(task, self.rig.stroke())?;
        let (upper, most) = (&mut config.bounds.upper, screen.largest_gains());
        upper.kp = upper.kp.min(most.kp);
        upper.ki = upper.ki.min(most.ki);
        upper.kd = upper.kd.min(most.kd);
        Ok(config)
    }

    /// Gains by a relay test around a set point, as the controller sees it, slowed down until they meet what
    /// is required; `None` if no cycle shows, or if none does.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn relay(
        &self,
        set_point: f64,
        screen: &Screen,
    ) -> Result<Option<PidGains>, WorkbenchError> {
        let [jumps, share] = RELAY;
        let height = (set_point - self.rig.rest_output()?).abs();
        let test = RelayTest {
            limits: self.pid.limits,
            ambient_degc: self.rig.ambient_degc,
            dt_s: self.pid.dt_s,
            tau_s: self.rig.tau_s(),
            setpoint: set_point,
            dead_time_samples: self.dead_time_samples,
            hysteresis: (jumps * self.sensor.jump()).max(share * height),
        };
        let cycle = test.run(&self.rig.fleet, self.rig.member)?;
        Ok(cycle.and_then(|cycle| screen.relay(&cycle)))
    }

    /// The baseline part under gains, for what is foreseen of limit cycles.
    ///
    /// # Errors
    ///
    /// [`WorkbenchError`] naming what is refused.
    pub fn rod_loop(&self, gains: PidGains, set_point: f64) -> Result<RodLoop, WorkbenchError> {
        Ok(RodLoop::new(RodLoopParams {
            rod: self.rig.params,
            drive: self.rig.drive,
            rule: self.rig.rule,
            controller: self.pid,
            gains,
            setpoint: set_point,
            ambient_degc: self.rig.ambient_degc,
            dead_time_samples: self.dead_time_samples,
            quantization_step: self.sensor.step,
        })?)
    }
}
