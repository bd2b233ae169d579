//! Rods, drives, and what the program makes of them.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use pid_tune::{
    AntiWindup, DerivativeOf, DriveLimits, Pid, PidGains, PidParams, Sample as PidSample,
};
use sma_effects::{EffectId, EffectSet, EffectValues, ExtendedPlant, Member, Setting};
use sma_export::{Controller, Exported, Labels};
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Drive, Input, Plant, Start, WienerParams};

pub(crate) const AMBIENT_DEGC: f64 = 22.0;
pub(crate) const DT_S: f64 = 0.05;

fn rod() -> RodParams {
    RodParams {
        diameter_m: 0.75e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 480.0,
        resistance_ohm_per_m: 2.13,
        convective_coefficient_w_per_m2_k: 60.0,
    }
}

/// A wire with τ = 9.7 s that transforms between 40 and 70 °C, with a stroke of 5 mm.
pub(crate) fn params() -> WienerParams {
    WienerParams {
        heat: rod().heat_balance().unwrap(),
        limiting_loop: LoopParams {
            loop_center_degc: 55.0,
            loop_half_width_k: 8.0,
            loop_spread_k: 3.0,
            ..LoopParams::default()
        },
        zeta: 0.85,
        gain: 5.0,
        offset: 1.0,
    }
}

/// A model with some effects at their typical sizes.
pub(crate) fn exported(drive: Drive, rule: Rule, effects: &[EffectId]) -> Exported {
    let mut values = EffectValues::default();
    for &effect in effects {
        let typical = EffectValues::typical(effect, 1.0);
        for index in 0..effect.info().parameters.len() {
            *values.slot(effect, index).unwrap() = typical.get(effect, index).unwrap();
        }
    }
    let active: EffectSet = effects.iter().copied().collect();
    Exported {
        setting: Setting {
            drive,
            rule,
            active,
            mass_kg_per_m: Some(rod().mass_kg_per_m()),
            surface_m2_per_m: Some(rod().surface_m2_per_m()),
            length_output: Some(125.0),
            run_length_s: Some(120.0),
            largest_drive: Some(driven(drive, 2.4)),
            ..Setting::default()
        },
        member: Member {
            params: params(),
            effects: values,
            start: Start {
                temperature_degc: 0.0,
                share: 1.0,
            },
        },
        dt_s: DT_S,
        drive_limit: None,
        controller: None,
        labels: Labels {
            model_file: "model.toml".to_owned(),
            sha256: "0".repeat(64),
            version: "0".to_owned(),
            command: "sma export".to_owned(),
            drive_unit: "A".to_owned(),
            output_unit: "mm".to_owned(),
            recording: "train.csv".to_owned(),
            left_out: Vec::new(),
        },
    }
}

/// A current in the unit of another drive, so that the rod gets as warm.
pub(crate) fn driven(drive: Drive, current_a: f64) -> f64 {
    let resistance = rod().resistance_ohm_per_m;
    let power_w_per_m = current_a * current_a * resistance;
    match drive {
        Drive::Current => current_a,
        Drive::Duty { supply_v, length_m } => {
            power_w_per_m * resistance * length_m * length_m / (supply_v * supply_v)
        }
        Drive::Voltage { length_m } => current_a * resistance * length_m,
        Drive::Power { length_m } => power_w_per_m * length_m,
    }
}

/// Currents that make the rod turn often, with loops inside of loops: levels between 0 and 3 A.
pub(crate) fn currents_a(n_samples: usize) -> Vec<f64> {
    let mut state: u64 = 0x9e37_79b9_7f4a_7c15;
    let mut level = 0.0;
    let mut left = 0;
    (0..n_samples)
        .map(|_| {
            if left == 0 {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                left = 1 + (state >> 40) as usize % 160;
                level = 3.0 * ((state & 0xffff) as f64 / 65_536.0);
                if state & 0x30000 == 0 {
                    level = 0.0;
                }
            }
            left -= 1;
            level
        })
        .collect()
}

/// Outputs and temperatures of a model in the program, before each sample.
pub(crate) fn simulated(exported: &Exported, drive: &[f64]) -> Vec<[f64; 2]> {
    let Exported {
        setting, member, ..
    } = exported;
    let plant = ExtendedPlant::new(setting, &member.params, &member.effects).unwrap();
    let start = &member.start;
    let warm_degc = AMBIENT_DEGC + start.temperature_degc;
    let mut state = plant.between_limiting_curves(warm_degc, start.share);
    let limit = exported.drive_limit.unwrap_or(f64::INFINITY);
    let samples = drive.iter().map(|&drive| {
        let output = plant.output(&state);
        let input = Input {
            drive: [drive.abs().min(limit).copysign(drive)],
            ambient_degc: AMBIENT_DEGC,
        };
        plant.step(&mut state, &input, exported.dt_s);
        [output.displacement[0], output.temperature_degc[0]]
    });
    samples.collect()
}

/// A controller with everything that a structure may have.
pub(crate) fn controller(anti_windup: AntiWindup, derivative_of: DerivativeOf) -> Controller {
    Controller {
        params: PidParams {
            dt_s: DT_S,
            limits: DriveLimits {
                lower: 0.0,
                upper: 2.4,
            },
            anti_windup,
            derivative_of,
            derivative_filter_s: 4.0 * DT_S,
            setpoint_weight: 0.8,
        },
        gains: PidGains {
            kp: 1.7,
            ki: 0.45,
            kd: 0.2,
        },
        is_turned: false,
    }
}

/// Outputs and drives of a model under its controller, along set points; a set point that is `NaN` is a missed sample.
pub(crate) fn controlled(exported: &Exported, setpoints: &[f64]) -> Vec<[f64; 2]> {
    let Exported {
        setting, member, ..
    } = exported;
    let controller = exported.controller.unwrap();
    let sign = if controller.is_turned { -1.0 } else { 1.0 };
    let plant = ExtendedPlant::new(setting, &member.params, &member.effects).unwrap();
    let pid: Pid = Pid::new(controller.params, &[controller.gains]).unwrap();
    let mut state = plant.rest(AMBIENT_DEGC);
    let first = sign * plant.output(&state).displacement[0];
    let mut pid_state = pid.rest([first]).unwrap();
    let samples = setpoints.iter().map(|&setpoint| {
        let output = plant.output(&state).displacement[0];
        let sample = PidSample {
            setpoint: sign * setpoint,
            measured: [sign * output],
            feed_forward: 0.0,
        };
        let [drive] = pid.step(&mut pid_state, &sample).drive;
        let input = Input {
            drive: [drive],
            ambient_degc: AMBIENT_DEGC,
        };
        plant.step(&mut state, &input, exported.dt_s);
        [output, drive]
    });
    samples.collect()
}
