//! Settings and checks that are common to the tuning of all controllers of this program.

mod bench;
mod promise;
mod rest;
mod schedule;

pub use bench::Bench;
pub use promise::{Kept, Promise};
pub use rest::{Approaches, CHATTER, End, Rest, Side};
pub use schedule::{Scheduled, TriedSchedule};

use pid_tune::{AntiWindup, DerivativeOf, DriveLimits, PidGains, PidParams};

use crate::rig::Rig;

/// Gains that ran on the rig of the paper: A/mm, A/(mm s), A s/mm there.
pub const PAPER: PidGains = PidGains {
    kp: 200.0,
    ki: 0.01,
    kd: 0.0,
};

/// Time constant of the derivative's filter, in samples: short beside the rod, long beside the noise.
pub const FILTER_SAMPLES: f64 = 4.0;

/// All of a rig's controller but its gains.
#[must_use]
pub fn controller(rig: &Rig, dt_s: f64) -> PidParams {
    PidParams {
        dt_s,
        limits: DriveLimits {
            lower: 0.0,
            upper: rig.drive_max,
        },
        anti_windup: AntiWindup::Clamping,
        derivative_of: DerivativeOf::Measurement,
        derivative_filter_s: FILTER_SAMPLES * dt_s,
        setpoint_weight: 1.0,
        gain_schedule: None,
    }
}
