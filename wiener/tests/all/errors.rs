//! The text of every error, and of the error below it.

use crate::common;

use std::error::Error;

use common::{AMBIENT_DEGC, params};
use sma_hysteresis::Rule;
use wiener::{Drive, Profile, Wiener, WienerError, WienerParams};

const NOT_POSITIVE: [(f64, &str); 5] = [
    (0.0, "0"),
    (-1.5, "-1.5"),
    (f64::NAN, "NaN"),
    (f64::INFINITY, "inf"),
    (f64::NEG_INFINITY, "-inf"),
];

const NOT_FINITE: [(f64, &str); 3] = [
    (f64::NAN, "NaN"),
    (f64::INFINITY, "inf"),
    (f64::NEG_INFINITY, "-inf"),
];

/// Refusal of a model with sound parameters but for one change.
fn refused(change: impl Fn(&mut WienerParams)) -> WienerError {
    let mut params = params();
    change(&mut params);
    Wiener::new(Drive::Current, Rule::LastReversal, &[params]).unwrap_err()
}

fn refused_drive(drive: Drive) -> String {
    // `Wiener::new` refuses what `checked` does.
    let by_model = Wiener::new(drive, Rule::LastReversal, &[params()]).unwrap_err();
    let text = drive.checked().unwrap_err().to_string();
    assert_eq!(text, by_model.to_string());
    text
}

fn refused_profile(profile: Result<Profile<'_>, WienerError>) -> String {
    profile.unwrap_err().to_string()
}

#[test]
fn a_fault_of_the_heat_balance_is_the_source() {
    let error = refused(|params| params.heat.resistance_ohm_per_m = f64::NAN);
    assert_eq!(error.to_string(), "heat balance");
    assert_eq!(
        error.source().unwrap().to_string(),
        "resistance_ohm_per_m = NaN Ω/m: must be finite and > 0"
    );
}

#[test]
fn a_fault_of_the_hysteresis_is_the_source() {
    for (error, text) in [
        (
            refused(|params| params.zeta = 1.5),
            "zeta = 1.5: must be > 0 and <= 1, or a branch would run backward",
        ),
        (
            refused(|params| params.limiting_loop.loop_spread_k = 0.0),
            "loop_spread_k = 0 K: must be finite and > 0",
        ),
    ] {
        assert_eq!(error.to_string(), "hysteresis");
        assert_eq!(error.source().unwrap().to_string(), text);
    }
}

#[test]
fn the_wiring_of_a_drive_must_be_positive() {
    for (value, shown) in NOT_POSITIVE {
        let length = format!("length_m = {shown} m: must be finite and > 0");
        for drive in [
            Drive::Voltage { length_m: value },
            Drive::Power { length_m: value },
            Drive::Duty {
                supply_v: 12.0,
                length_m: value,
            },
        ] {
            assert_eq!(refused_drive(drive), length);
        }
        let drive = Drive::Duty {
            supply_v: value,
            length_m: 0.1,
        };
        assert_eq!(
            refused_drive(drive),
            format!("supply_v = {shown} V: must be finite and > 0")
        );
    }
}

#[test]
fn the_readout_must_be_finite() {
    for (value, shown) in NOT_FINITE {
        let text =
            |name| format!("{name} = {shown}: must be finite, in the unit of the displacement");
        let gain = refused(|params| params.gain = value);
        assert_eq!(gain.to_string(), text("gain"));
        let offset = refused(|params| params.offset = value);
        assert_eq!(offset.to_string(), text("offset"));
        assert!(gain.source().is_none());
    }
}

#[test]
fn every_lane_is_checked() {
    for lane in 0..3 {
        let mut lanes = [params(); 3];
        lanes[lane].offset = f64::NAN;
        let error = Wiener::new(Drive::Current, Rule::Nested, &lanes).unwrap_err();
        assert_eq!(
            error.to_string(),
            "offset = NaN: must be finite, in the unit of the displacement"
        );
    }
}

#[test]
fn a_profile_has_samples() {
    let text = "the profile has no samples; at least 1 is needed";
    assert_eq!(
        refused_profile(Profile::uniform(&[], 0.3, AMBIENT_DEGC)),
        text
    );
    assert_eq!(
        refused_profile(Profile::timed(&[], &[], AMBIENT_DEGC)),
        text
    );
    let one = Profile::timed(&[1.0], &[0.0], AMBIENT_DEGC).unwrap();
    assert_eq!(one.len(), 1);
}

#[test]
fn slices_of_a_profile_are_of_one_length() {
    assert_eq!(
        refused_profile(Profile::timed(&[1.0, 2.0], &[0.0], AMBIENT_DEGC)),
        "time_s has 1 values where the drive has 2: lengths must be equal"
    );
    let profile = Profile::uniform(&[1.0, 2.0], 0.3, AMBIENT_DEGC).unwrap();
    assert_eq!(
        refused_profile(profile.with_ambient(&[AMBIENT_DEGC; 3])),
        "ambient_degc has 3 values where the drive has 2: lengths must be equal"
    );
}

#[test]
fn values_of_a_profile_must_be_finite() {
    for (value, shown) in NOT_FINITE {
        let spoiled = [1.0, 2.0, value];
        let sound = [1.0, 2.0, 3.0];
        let drive = format!("drive[2] = {shown}: must be finite");
        assert_eq!(
            refused_profile(Profile::uniform(&spoiled, 0.3, AMBIENT_DEGC)),
            drive
        );
        assert_eq!(
            refused_profile(Profile::timed(&spoiled, &sound, AMBIENT_DEGC)),
            drive
        );
        assert_eq!(
            refused_profile(Profile::timed(&sound, &spoiled, AMBIENT_DEGC)),
            format!("time_s[2] = {shown}: must be finite")
        );
        assert_eq!(
            refused_profile(Profile::uniform(&sound, 0.3, value)),
            format!("ambient_degc[0] = {shown}: must be finite")
        );
        let profile = Profile::uniform(&sound, 0.3, AMBIENT_DEGC).unwrap();
        assert_eq!(
            refused_profile(profile.with_ambient(&spoiled)),
            format!("ambient_degc[2] = {shown}: must be finite")
        );
    }
}

#[test]
fn a_sample_time_must_be_positive() {
    for (value, shown) in NOT_POSITIVE {
        assert_eq!(
            refused_profile(Profile::uniform(&[1.0], value, AMBIENT_DEGC)),
            format!("dt_s = {shown}: the sample time must be finite and > 0")
        );
    }
}

#[test]
fn time_must_rise() {
    for (value, shown) in [(0.25, "0.25"), (0.5, "0.5")] {
        assert_eq!(
            refused_profile(Profile::timed(&[1.0; 3], &[0.0, 0.5, value], AMBIENT_DEGC)),
            format!("time_s[2] = {shown} after 0.5: time must rise")
        );
    }
}
