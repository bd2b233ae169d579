//! Any measurements for any controller that is accepted: the drive is a number within its limits.
#![no_main]

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use pid_tune::{
    AntiWindup, DerivativeOf, DriveLimits, GainSchedule, GainScheduleParams, Pid, PidGains,
    PidParams, Sample,
};

#[derive(Debug, Arbitrary)]
struct Drawn {
    gains: [f64; 3],
    dt_s: f64,
    limits: [f64; 2],
    filter_s: f64,
    tracking_s: f64,
    weight: u8,
    kind: u8,
    outputs: [f64; 2],
    turn: f64,
    factors: [[f64; 8]; 2],
    samples: Vec<(f64, f64, f64)>,
}

fuzz_target!(|drawn: Drawn| {
    let [kp, ki, kd] = drawn.gains;
    let [lower, upper] = drawn.limits;
    let [heating, cooling] = drawn.factors;
    let schedule = GainSchedule::new(GainScheduleParams {
        outputs: drawn.outputs,
        turn: drawn.turn,
        heating,
        cooling,
    });
    let params = PidParams {
        dt_s: drawn.dt_s,
        limits: DriveLimits { lower, upper },
        anti_windup: match drawn.kind % 3 {
            0 => AntiWindup::Off,
            1 => AntiWindup::Clamping,
            _ => AntiWindup::BackCalculation {
                tracking_s: drawn.tracking_s,
            },
        },
        derivative_of: if drawn.kind & 4 == 0 {
            DerivativeOf::Error
        } else {
            DerivativeOf::Measurement
        },
        derivative_filter_s: drawn.filter_s,
        setpoint_weight: f64::from(drawn.weight) / 255.0,
        // Half of the controllers, if it is accepted.
        gain_schedule: (drawn.kind & 8 != 0)
            .then_some(schedule)
            .and_then(Result::ok),
    };
    let Ok(pid) = Pid::new(params, &[PidGains { kp, ki, kd }]) else {
        return;
    };
    let Ok(mut state) = pid.rest([0.0]) else {
        return;
    };
    for &(setpoint, measured, feed_forward) in &drawn.samples {
        let sample = Sample {
            setpoint,
            measured: [measured],
            feed_forward,
        };
        let command = pid.step(&mut state, &sample);
        assert!((lower..=upper).contains(&command.drive[0]), "{:?}", command);
        assert!(state.integral()[0].is_finite(), "{state:?}");
    }
});
