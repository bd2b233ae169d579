//! The model turned around.

use crate::common;

use common::{AMBIENT_DEGC, PARAMS, rod, undisturbed};
use pid_tune::{
    ClosedLoop, ClosedLoopParams, DriveLimits, PidGains, PidParams, Reference, RodLoop,
    RodLoopParams, Task,
};
use wiener::hysteresis::Rule;
use wiener::{Drive, Ensemble, Member, Start};

const NOTHING: PidGains = PidGains {
    kp: 0.0,
    ki: 0.0,
    kd: 0.0,
};
const CONTROLLER: PidParams = PidParams {
    dt_s: 0.1,
    limits: DriveLimits {
        lower: 0.0,
        upper: 4.0,
    },
    ..PARAMS
};

#[test]
fn a_rod_follows_its_own_inverse_without_a_controller() {
    // Up, down a little, up again, and down: minor loops too.
    let levels: Vec<f64> = [1.0, 3.0, 2.2, 3.5, 0.8]
        .into_iter()
        .flat_map(|level| vec![level; 400])
        .collect();
    let reference = Reference::Samples(&levels);
    for rule in [Rule::Nested, Rule::LastReversal] {
        let rod_loop = RodLoop::new(RodLoopParams {
            rod: rod(6.0),
            drive: Drive::Current,
            rule,
            controller: CONTROLLER,
            gains: NOTHING,
            setpoint: 1.0,
            ambient_degc: AMBIENT_DEGC,
            dead_time_samples: 0,
            quantization_step: 0.0,
        })
        .unwrap();
        let run = rod_loop.inverse_run(&reference, levels.len()).unwrap();
        let drive = &run.drive;
        assert!(drive.iter().all(|drive| (0.0..=4.0).contains(drive)));
        let closed_loop = ClosedLoop::new(ClosedLoopParams {
            feed_forward: Some(drive),
            ..undisturbed(reference, levels.len())
        })
        .unwrap();
        let rods = Ensemble {
            drive: Drive::Current,
            rule,
        };
        let task = Task::new(rods, closed_loop, CONTROLLER).unwrap();
        let member = Member {
            params: rod(6.0),
            start: Start::rest(AMBIENT_DEGC),
        };
        let (mut errors, mut foretold) = (Vec::new(), 0.0_f64);
        task.show(member, NOTHING, &mut |snapshot| {
            foretold = foretold.max((snapshot.output[0] - run.output[snapshot.k]).abs());
            // The last quarter of each level, when it has had time to get there.
            if snapshot.k % 400 >= 300 {
                errors.push((snapshot.output[0] - snapshot.setpoint).abs());
            }
        })
        .unwrap();
        // The output on the way is foretold, sample by sample.
        assert!(foretold < 1e-9, "{foretold}");
        let worst = errors.iter().copied().fold(0.0, f64::max);
        assert!(worst < 2e-3, "{rule:?}: {worst} mm of 5");
    }
}
