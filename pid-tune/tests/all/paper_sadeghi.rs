//! The gains of [Sadeghi, section 5] on rods like the paper's: output in mm, drive in A.

use crate::common;

use common::{pid, rod, rods, snapshots, undisturbed};
use fixtures::sadeghi;
use pid_tune::{
    AntiWindup, ClosedLoopParams, DerivativeOf, Disturbances, DriveLimits, PidGains, PidParams,
    Reference,
};

const UPPER_A: f64 = 3.0;

fn printed(key: &str) -> f64 {
    sadeghi::setting(key).unwrap().value()
}

fn gains(set: &str) -> PidGains {
    PidGains {
        kp: printed(&format!("pid.{set}.kp")),
        ki: printed(&format!("pid.{set}.ki")),
        kd: printed(&format!("pid.{set}.kd")),
    }
}

fn params() -> PidParams {
    PidParams {
        dt_s: printed("rig.sample_time"),
        limits: DriveLimits {
            lower: 0.0,
            upper: UPPER_A,
        },
        anti_windup: AntiWindup::Clamping,
        derivative_of: DerivativeOf::Error,
        derivative_filter_s: 0.0,
        setpoint_weight: 1.0,
        gain_schedule: None,
    }
}

fn step() -> Reference<'static> {
    Reference::Step {
        from: 0.0,
        to: printed("reference.step"),
        at_s: 0.0,
    }
}

#[test]
fn all_printed_gains_are_accepted() {
    let mut compared = 0;
    for set in ["lower", "upper", "found", "used"] {
        pid(params(), gains(set));
        compared += 1;
    }
    assert_eq!(compared, 4);
}

#[test]
fn the_drive_is_saturated_until_the_error_is_below_the_supply_over_the_gain() {
    let gains = gains("used");
    // What the integral may have added in these 30 s of at most 0.7 mm.
    let integral_a = gains.ki * 30.0 * 0.7;
    for tau_s in [3.0, 10.0, 30.0] {
        let plant = rods(&[rod(tau_s)]);
        let found = snapshots(undisturbed(step(), 100), &plant, &pid(params(), gains));
        let (mut saturated, mut between) = (0, 0);
        for shown in &found {
            let error = shown.setpoint - shown.measured[0];
            let [drive] = shown.drive;
            if error > UPPER_A / gains.kp {
                assert!(drive >= UPPER_A, "{drive} at {error}");
                saturated += 1;
            } else if error < -integral_a / gains.kp {
                assert!(drive <= 0.0, "{drive} at {error}");
            } else if error < (UPPER_A - integral_a) / gains.kp {
                assert!(drive < UPPER_A, "{drive} at {error}");
                between += 1;
            }
        }
        assert!(saturated >= 4 && between >= 1, "{saturated} {between}");
    }
}

#[test]
fn the_same_gain_is_another_controller_in_meters() {
    let gains = gains("used");
    // In meters the same rod has a gain of 0.005, and 200 A/m ask for 0.1 A at an error of 0.5 mm.
    let mut params_m = rod(10.0);
    params_m.gain *= 1e-3;
    params_m.offset *= 1e-3;
    let reference = Reference::Step {
        from: 0.0,
        to: 1e-3 * printed("reference.step"),
        at_s: 0.0,
    };
    let found = snapshots(
        undisturbed(reference, 300),
        &rods(&[params_m]),
        &pid(params(), gains),
    );
    let highest_a = found.iter().map(|shown| shown.drive[0]).fold(0.0, f64::max);
    assert!(highest_a < 0.11, "{highest_a}");
}

#[test]
fn a_fast_rod_does_not_come_to_rest_and_a_slow_one_does() {
    // The converter of the rig.
    let quantization_step = printed("rig.lvdt_range") / printed("rig.converter_bits").exp2();
    let swing_mm = |tau_s| {
        let params_of_loop = ClosedLoopParams {
            disturbances: Disturbances {
                quantization_step,
                ..Disturbances::default()
            },
            ..undisturbed(step(), 1000)
        };
        let found = snapshots(
            params_of_loop,
            &rods(&[rod(tau_s)]),
            &pid(params(), gains("used")),
        );
        let late = found[900..].iter().map(|shown| shown.output[0]);
        late.clone().fold(f64::MIN, f64::max) - late.fold(f64::MAX, f64::min)
    };
    assert!(swing_mm(3.0) > 0.05);
    assert!(swing_mm(30.0) < 2.0 * quantization_step);
}
