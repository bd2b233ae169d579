//! Rods, drives, and what the program makes of them.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]
#![allow(clippy::print_stdout, reason = "tests say what they find")]

use pid_tune::{
    AntiWindup, DerivativeOf, DriveLimits, GainSchedule, GainScheduleParams, Pid, PidGains,
    PidParams, Sample as PidSample,
};
use sma_effects::{EffectId, EffectSet, EffectValues, ExtendedPlant, Member, Setting};
use sma_export::{Controller, Exported, Labels};
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Drive, Input, Plant, Start, Wiener, WienerParams};

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
                since_reversal_k: 0.0,
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
            ambient_degc: Some(AMBIENT_DEGC),
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
            gain_schedule: None,
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

pub(crate) const DRIVES: [Drive; 4] = [
    Drive::Current,
    Drive::Duty {
        supply_v: 12.0,
        length_m: 0.7,
    },
    Drive::Voltage { length_m: 0.7 },
    Drive::Power { length_m: 0.7 },
];

/// The drives of models, one model after another.
pub(crate) fn drives(models: &[Exported], n_samples: usize) -> Vec<Vec<f64>> {
    let currents = currents_a(n_samples);
    models
        .iter()
        .map(|model| {
            let drive = model.setting.drive;
            currents.iter().map(|&one| driven(drive, one)).collect()
        })
        .collect()
}

/// Largest differences over the stroke, of displacement, and in kelvins.
pub(crate) fn apart(expected: &[[f64; 2]], found: &[[f64; 2]], stroke: f64) -> [f64; 2] {
    assert_eq!(expected.len(), found.len());
    let mut largest = [0.0_f64; 2];
    for (a, b) in expected.iter().zip(found) {
        assert!(b.iter().all(|value| value.is_finite()));
        largest[0] = largest[0].max((a[0] - b[0]).abs() / stroke);
        largest[1] = largest[1].max((a[1] - b[1]).abs());
    }
    largest
}

/// Asserts that source computes what the program computes: to the last bit, or, where it calls a library of its own, to 1e-12 of the stroke
/// and 1e-10 K.
pub(crate) fn assert_agrees(
    model: &Exported,
    [expected, found]: [&[[f64; 2]]; 2],
    by_library: &[EffectId],
) {
    let active: Vec<&str> = model.setting.active.iter().map(EffectId::id).collect();
    let [output, kelvin] = apart(expected, found, 5.0);
    println!("{active:?}: {output:e} of the stroke, {kelvin:e} K");
    let is_bound = |&one: &EffectId| model.setting.active.contains(one);
    if by_library.iter().any(is_bound) {
        assert!(
            output <= 1e-12 && kelvin <= 1e-10,
            "{active:?}: {output:e} {kelvin:e}"
        );
    } else {
        assert!(
            bits(expected) == bits(found),
            "{active:?}: {output:e} {kelvin:e}"
        );
    }
}

pub(crate) fn bits(rows: &[[f64; 2]]) -> Vec<[u64; 2]> {
    rows.iter().map(|row| row.map(f64::to_bits)).collect()
}

/// Plain rods: every drive, both memories; one that starts warm, one that falls on heating, one behind a supply that saturates.
pub(crate) fn plain() -> Vec<Exported> {
    let mut models = Vec::new();
    for rule in [Rule::LastReversal, Rule::Nested] {
        models.extend(DRIVES.map(|drive| exported(drive, rule, &[])));
    }
    let mut warm = exported(Drive::Current, Rule::Nested, &[]);
    warm.member.start.temperature_degc = 31.0;
    warm.member.start.share = 0.4;
    models.push(warm);
    let mut falling = exported(Drive::Current, Rule::Nested, &[]);
    falling.member.params.gain = -4.0;
    models.push(falling);
    let mut limited = exported(Drive::Current, Rule::LastReversal, &[]);
    limited.drive_limit = Some(1.9);
    models.push(limited);
    models
}

/// A model under a duty, with duties below 0 and above 1, and the same within 0 and 1.
pub(crate) fn of_wild_duty() -> (Exported, [Vec<f64>; 2]) {
    let model = exported(DRIVES[1], Rule::Nested, &[]);
    let Drive::Duty { .. } = model.setting.drive else {
        unreachable!("the second drive is a duty")
    };
    let beyond: Vec<f64> = currents_a(500)
        .into_iter()
        .map(|level| level - 1.0)
        .collect();
    let within = beyond.iter().map(|duty| duty.clamp(0.0, 1.0)).collect();
    (model, [beyond, within])
}

/// Every effect that is a formula, at its typical sizes, then pairs that share the middle of a sample or its parts.
pub(crate) fn with_effects() -> Vec<Exported> {
    let mut models: Vec<Exported> = Exported::formulas()
        .iter()
        .map(|effect| exported(Drive::Current, Rule::LastReversal, &[effect]))
        .collect();
    for (drive, effects) in [
        (DRIVES[1], &[EffectId::SupplyLimit, EffectId::SupplyLag][..]),
        (
            DRIVES[2],
            &[EffectId::SupplyLag, EffectId::DeadTime, EffectId::OutputLag][..],
        ),
        (
            DRIVES[3],
            &[
                EffectId::ReturnPointMemory,
                EffectId::LoopShape,
                EffectId::LoopAsymmetry,
                EffectId::RPhase,
                EffectId::ThermalExpansion,
                EffectId::EndStop,
                EffectId::Backlash,
                EffectId::OutputLag,
                EffectId::SensorNonlinearity,
                EffectId::ThermocoupleLag,
            ][..],
        ),
    ] {
        models.push(exported(drive, Rule::Nested, effects));
    }
    // Held before the first sample.
    let late = [EffectId::SupplyLag, EffectId::DeadTime];
    for effects in [&late[..], &late[..1], &late[1..]] {
        let mut warm = exported(Drive::Current, Rule::LastReversal, effects);
        warm.member.start.temperature_degc = 31.0;
        warm.member.start.share = 0.4;
        models.push(warm);
    }
    // Longer than samples: the power of two samples ago, in part, and an output that is late as well.
    for (dead_time_s, share) in [(0.13, 0.0), (0.31, 0.6), (0.2, 1.0), (0.02, 1.0)] {
        let mut late = exported(Drive::Current, Rule::LastReversal, &[EffectId::DeadTime]);
        late.member.effects.dead_time.dead_time_s = dead_time_s;
        late.member.effects.dead_time.dead_time_output_share = share;
        models.push(late);
    }
    // Falls through what the rod loses within a sample, slowly.
    for drive in [DRIVES[0], DRIVES[1]] {
        let mut lags = exported(drive, Rule::Nested, &[EffectId::SupplyLag]);
        lags.member.effects.supply_lag.supply_lag_s = 0.7;
        models.push(lags);
    }
    let mut soft = exported(Drive::Current, Rule::Nested, &[EffectId::Backlash]);
    soft.member.effects.backlash.backlash_softness = 2.0;
    soft.member.effects.backlash.backlash_relaxed = 0.7;
    soft.member.params.gain = -5.0;
    models.push(soft);
    let mut parted = exported(
        Drive::Current,
        Rule::LastReversal,
        &[EffectId::DeadTime, EffectId::ThermocoupleLag],
    );
    parted.setting.sub_steps = 3;
    models.push(parted);
    models
}

/// Rods under controllers of every anti-windup; one that falls on heating.
pub(crate) fn with_controllers() -> Vec<Exported> {
    let mut models: Vec<Exported> = [
        (AntiWindup::Off, DerivativeOf::Measurement),
        (AntiWindup::Clamping, DerivativeOf::Measurement),
        (
            AntiWindup::BackCalculation {
                tracking_s: 10.0 * DT_S,
            },
            DerivativeOf::Error,
        ),
    ]
    .into_iter()
    .map(|(windup, watched)| Exported {
        controller: Some(controller(windup, watched)),
        ..exported(Drive::Current, Rule::Nested, &[])
    })
    .collect();
    let mut falling = models[1].clone();
    falling.member.params.gain = -5.0;
    falling.member.params.offset = 6.0;
    falling.controller.as_mut().unwrap().is_turned = true;
    models.push(falling);
    // Each of them with a schedule as well.
    let scheduled = models.clone().into_iter().map(|mut model| {
        if let Some(controller) = &mut model.controller {
            let sign = if controller.is_turned { -1.0 } else { 1.0 };
            let mut outputs = [1.0, 6.0].map(|output| sign * output);
            outputs.sort_by(f64::total_cmp);
            controller.params.gain_schedule = Some(
                GainSchedule::new(GainScheduleParams {
                    outputs,
                    turn: 0.3,
                    heating: [4.0, 2.5, 1.4, 1.0, 1.1, 1.6, 3.0, 4.0],
                    cooling: [4.0, 3.1, 1.9, 1.3, 1.2, 1.9, 3.7, 4.0],
                })
                .unwrap(),
            );
        }
        model
    });
    let scheduled: Vec<Exported> = scheduled.collect();
    models.extend(scheduled);
    models
}

/// Set points that drive controllers to both limits, with missed samples.
pub(crate) fn setpoints() -> Vec<f64> {
    let mut setpoints: Vec<f64> = currents_a(4_000)
        .iter()
        .map(|one| 1.3 + 1.7 * one)
        .collect();
    // Missed samples, one and three in a row.
    for k in [500, 1_700, 1_701, 1_702] {
        setpoints[k] = f64::NAN;
    }
    setpoints
}

/// A nested rod and currents about a level, by ever less: loops inside of loops, more than a memory has room for, and at
/// last out of all of them.
pub(crate) fn deeply_nested() -> (Exported, Vec<f64>) {
    let model = exported(Drive::Current, Rule::Nested, &[]);
    let mut drive = vec![2.4; 400];
    let mut swing = 1.2;
    for turn in 0..90 {
        let sign = if turn % 2 == 0 { -1.0 } else { 1.0 };
        drive.extend([1.7 + sign * swing; 40]);
        swing *= 0.96;
    }
    drive.extend([2.4; 400]);
    let plant: Wiener = Wiener::new(Drive::Current, Rule::Nested, &[model.member.params]).unwrap();
    let mut state = plant.rest(AMBIENT_DEGC);
    for &current_a in &drive {
        let input = Input {
            drive: [current_a],
            ambient_degc: AMBIENT_DEGC,
        };
        plant.step(&mut state, &input, DT_S);
    }
    assert!(state.memory().forgotten()[0] > 0);
    (model, drive)
}
