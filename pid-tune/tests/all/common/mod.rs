//! Plants, controllers and runs that the tests share.

#![allow(dead_code, reason = "no test file needs all of it")]

#[cfg(feature = "std")]
pub(crate) mod lags;
#[cfg(feature = "std")]
pub(crate) mod screened;

use approx::assert_abs_diff_eq;
use pid_tune::{
    AntiWindup, ClosedLoop, ClosedLoopParams, DerivativeOf, Disturbances, DriveLimits, Pid,
    PidGains, PidParams, PidState, Reference, Sample, Snapshot,
};
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::{HeatBalanceParams, ThermalConstants};
use wiener::{Drive, Input, Lanes, Output, Plant, Started, Wiener, WienerParams};

pub(crate) const AMBIENT_DEGC: f64 = 22.0;

pub(crate) const P_ONLY: PidGains = PidGains {
    kp: 1.0,
    ki: 0.0,
    kd: 0.0,
};

/// A controller of one second that is hardly ever saturated.
pub(crate) const PARAMS: PidParams = PidParams {
    dt_s: 1.0,
    limits: DriveLimits {
        lower: -1e6,
        upper: 1e6,
    },
    anti_windup: AntiWindup::Clamping,
    derivative_of: DerivativeOf::Error,
    derivative_filter_s: 0.0,
    setpoint_weight: 1.0,
    gain_schedule: None,
};

pub(crate) const ALL_ANTI_WINDUP: [AntiWindup; 3] = [
    AntiWindup::Off,
    AntiWindup::Clamping,
    AntiWindup::BackCalculation { tracking_s: 2.0 },
];

pub(crate) fn pid(params: PidParams, gains: PidGains) -> Pid {
    Pid::new(params, &[gains]).unwrap()
}

/// Inputs of a single controller, without feed-forward.
pub(crate) fn sample(setpoint: f64, measured: f64) -> Sample {
    Sample {
        setpoint,
        measured: [measured],
        feed_forward: 0.0,
    }
}

/// Drives for measurements one after another, at one set point, and the state behind the last.
pub(crate) fn drives(pid: &Pid, setpoint: f64, measured: &[f64]) -> (Vec<f64>, PidState) {
    let mut state = pid.rest([measured[0]]).unwrap();
    let drives = measured
        .iter()
        .map(|&measured| pid.step(&mut state, &sample(setpoint, measured)).drive[0])
        .collect();
    (drives, state)
}

/// A displacement that approaches the drive, exactly over a sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lag {
    pub(crate) tau_s: f64,
}

impl Plant for Lag {
    type State = f64;

    fn rest(&self, _: f64) -> f64 {
        0.0
    }

    fn output(&self, state: &f64) -> Output {
        Output {
            displacement: [*state],
            temperature_degc: [AMBIENT_DEGC],
        }
    }

    fn step(&self, state: &mut f64, input: &Input, dt_s: f64) {
        let [drive] = input.drive;
        *state = drive + (*state - drive) * (-dt_s / self.tau_s).exp();
    }
}

/// A rod that goes through its loop between 1 and 3 A; in mm, 0 at rest.
pub(crate) fn rod(tau_s: f64) -> WienerParams {
    WienerParams {
        heat: HeatBalanceParams::from_constants(ThermalConstants {
            tau_s,
            lambda_k_per_a2: 15.0,
        }),
        limiting_loop: LoopParams {
            loop_center_degc: 55.0,
            loop_half_width_k: 8.0,
            loop_spread_k: 3.0,
            ..LoopParams::default()
        },
        zeta: 0.85,
        gain: 5.0,
        offset: -0.19,
    }
}

pub(crate) fn rods<const L: usize>(lanes: &[WienerParams; L]) -> Wiener<L> {
    Wiener::new(Drive::Current, Rule::Nested, lanes).unwrap()
}

/// A loop of some samples without disturbances.
pub(crate) fn undisturbed(reference: Reference<'_>, n_samples: usize) -> ClosedLoopParams<'_> {
    ClosedLoopParams {
        reference,
        n_samples,
        ambient_degc: AMBIENT_DEGC,
        feed_forward: None,
        aim: None,
        disturbances: Disturbances::default(),
    }
}

/// Plants in a state.
pub(crate) fn at<const L: usize, Q: Plant<L>>(plant: Q, state: Q::State) -> Started<L, Q> {
    Started { plant, state }
}

/// Runs a loop from rest.
pub(crate) fn snapshots<Q: Plant>(
    params: ClosedLoopParams<'_>,
    plant: &Q,
    pid: &Pid,
) -> Vec<Snapshot> {
    let mut plants = at(plant, plant.rest(params.ambient_degc));
    let mut pid_state = pid.rest(plants.output().displacement).unwrap();
    let mut snapshots = Vec::new();
    ClosedLoop::new(params)
        .unwrap()
        .run(&mut plants, pid, &mut pid_state, |snapshot| {
            snapshots.push(*snapshot);
        });
    snapshots
}

/// Asserts that two series are the same to the last bit.
#[track_caller]
pub(crate) fn assert_same(found: &[f64], expected: &[f64]) {
    let bits = |values: &[f64]| {
        values
            .iter()
            .map(|value| value.to_bits())
            .collect::<Vec<_>>()
    };
    assert_eq!(bits(found), bits(expected), "{found:?} {expected:?}");
}

#[track_caller]
pub(crate) fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert_abs_diff_eq!(found, expected, epsilon = tolerance);
}
