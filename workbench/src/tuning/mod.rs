//! What every controller of this program is tuned with.

use missing_physics::PhysicsError;
use pid_tune::{
    AntiWindup, DerivativeOf, DriveLimits, PidGains, PidParams, Task, TaskError, Terms,
};

use crate::rig::Rig;
use crate::turned::Turned;

/// Gains that ran on the rig of the paper: A/mm, A/(mm s), A s/mm there.
pub const PAPER: PidGains = PidGains {
    kp: 200.0,
    ki: 0.01,
    kd: 0.0,
};

/// Time constant of the derivative's filter, in samples: short beside the rod, long beside the noise.
const FILTER_SAMPLES: f64 = 4.0;

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
    }
}

/// The rig's response to the paper's gains: each of its terms counts one unless weights are given.
///
/// # Errors
///
/// What the task refuses of the plant or the controller.
pub fn of_paper(task: &Task<'_, Turned>, rig: &Rig) -> Result<Terms, TaskError<PhysicsError>> {
    let [terms] = task.evaluate(&[(rig.member, PAPER)])?[..] else {
        unreachable!("one case has one response");
    };
    Ok(terms)
}
