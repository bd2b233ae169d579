//! A rod, a run and traces, for all tests.

#![allow(dead_code, reason = "no test file uses all of it")]
#![allow(unreachable_pub, reason = "shared by test files, each its own crate")]

use sma_effects::{EffectId, EffectSet, EffectValues, Extended, ExtendedPlant, Member, Setting};
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Drive, Input, Plant, Profile, Start, WienerParams};

pub const AMBIENT_DEGC: f64 = 22.0;

pub fn rod() -> RodParams {
    RodParams {
        diameter_m: 0.75e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 480.0,
        resistance_ohm_per_m: 2.13,
        convective_coefficient_w_per_m2_k: 60.0,
    }
}

/// A wire with τ = 9.7 s that transforms between 40 and 70 °C, with a stroke of 5 mm.
pub fn params() -> WienerParams {
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

/// All that an effect may need.
pub fn setting(active: EffectSet) -> Setting {
    Setting {
        active,
        rule: Rule::LastReversal,
        mass_kg_per_m: Some(rod().mass_kg_per_m()),
        surface_m2_per_m: Some(rod().surface_m2_per_m()),
        length_output: Some(125.0),
        run_length_s: Some(120.0),
        largest_drive: Some(2.4),
        ..Setting::default()
    }
}

/// 120 s: a full cycle, partial ones, a hold, in steps of `dt_s`.
pub fn current_a(dt_s: f64) -> Vec<f64> {
    let levels = [
        (0.0, 3.0),
        (2.4, 15.0),
        (0.0, 18.0),
        (2.1, 12.0),
        (1.5, 6.0),
        (2.2, 6.0),
        (1.0, 6.0),
        (2.0, 9.0),
        (0.6, 9.0),
        (1.9, 12.0),
        (0.0, 24.0),
    ];
    let mut current_a = Vec::new();
    for (level, length_s) in levels {
        let count = (length_s / dt_s).round() as usize;
        current_a.extend(std::iter::repeat_n(level, count));
    }
    current_a
}

/// Converts a current to the unit of another drive, so that the rod gets about as warm.
pub fn drive_of(drive: Drive, current_a: &[f64]) -> Vec<f64> {
    let power_w_per_m = |i: f64| i * i * rod().resistance_ohm_per_m;
    let resistance = rod().resistance_ohm_per_m;
    current_a
        .iter()
        .map(|&i| match drive {
            Drive::Current => i,
            Drive::Duty { supply_v, length_m } => {
                power_w_per_m(i) * resistance * length_m * length_m / (supply_v * supply_v)
            }
            Drive::Voltage { length_m } => i * resistance * length_m,
            Drive::Power { length_m } => power_w_per_m(i) * length_m,
        })
        .collect()
}

pub const DRIVES: [Drive; 4] = [
    Drive::Current,
    Drive::Duty {
        supply_v: 12.0,
        length_m: 0.5,
    },
    Drive::Voltage { length_m: 0.5 },
    Drive::Power { length_m: 0.5 },
];

/// Outputs and state of one plant, sample by sample, and the largest residual of its steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    pub displacement: Vec<f64>,
    pub recorded_degc: Vec<f64>,
    pub temperature_degc: Vec<f64>,
    pub fraction: Vec<f64>,
    pub largest_residual_k: f64,
}

pub fn trace(
    setting: &Setting,
    params: &WienerParams,
    values: &EffectValues,
    drive: &[f64],
    dt_s: f64,
) -> Trace {
    let plant = ExtendedPlant::new(setting, params, values).unwrap();
    let mut state = plant.rest(AMBIENT_DEGC);
    let mut trace = Trace {
        displacement: Vec::new(),
        recorded_degc: Vec::new(),
        temperature_degc: Vec::new(),
        fraction: Vec::new(),
        largest_residual_k: 0.0,
    };
    for &drive in drive {
        let output = plant.output(&state);
        trace.displacement.push(output.displacement[0]);
        trace.recorded_degc.push(output.temperature_degc[0]);
        trace.temperature_degc.push(state.temperature_degc());
        trace.fraction.push(state.fraction());
        let input = Input {
            drive: [drive],
            ambient_degc: AMBIENT_DEGC,
        };
        plant.step(&mut state, &input, dt_s);
        let residual_k = state.residual_k().abs();
        trace.largest_residual_k = trace.largest_residual_k.max(residual_k);
    }
    trace
}

/// The run of [`current_a`] with one effect active.
pub fn with_effect(effect: EffectId, values: &EffectValues, dt_s: f64) -> Trace {
    trace(
        &setting(EffectSet::of(effect)),
        &params(),
        values,
        &current_a(dt_s),
        dt_s,
    )
}

/// Displacement and temperature of all members, one after another.
pub fn fleet(setting: &Setting, members: &[Member], profile: &Profile<'_>) -> Vec<Vec<u64>> {
    let mut traces = vec![Vec::new(); members.len()];
    Extended { setting: *setting }
        .run(members, profile, &mut |block| {
            for (shown, degc) in block
                .displacement
                .chunks(block.stride)
                .zip(block.temperature_degc.chunks(block.stride))
            {
                for column in 0..block.members {
                    traces[block.first_member + column].push(shown[column].to_bits());
                    traces[block.first_member + column].push(degc[column].to_bits());
                }
            }
        })
        .unwrap();
    traces
}

/// Members that differ in everything that a lane may differ in.
pub fn various(count: usize, effects: EffectValues) -> Vec<Member> {
    (0..count)
        .map(|k| {
            let k = k as f64;
            let mut params = params();
            params.heat.heat_capacity_j_per_m_k *= 1.0 + 0.01 * k;
            params.limiting_loop.loop_center_degc += 0.3 * k;
            params.limiting_loop.loop_spread_k += 0.1 * k;
            params.gain *= 1.0 - 0.07 * k;
            Member {
                params,
                effects,
                start: Start {
                    temperature_degc: AMBIENT_DEGC + 0.1 * k,
                    share: 1.0 - 0.02 * k,
                    since_reversal_k: 0.0,
                },
            }
        })
        .collect()
}

/// Root mean square difference.
pub fn rms(one: &[f64], other: &[f64]) -> f64 {
    assert_eq!(one.len(), other.len());
    let sum: f64 = one.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
    (sum / one.len() as f64).sqrt()
}

/// Largest difference.
pub fn largest(one: &[f64], other: &[f64]) -> f64 {
    assert_eq!(one.len(), other.len());
    one.iter()
        .zip(other)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// Every effect at its typical size.
pub fn all_typical() -> EffectValues {
    let mut all = EffectValues::default();
    for effect in EffectId::ALL {
        for index in 0..effect.info().parameters.len() {
            let typical = EffectValues::typical(effect, 1.0)
                .get(effect, index)
                .unwrap();
            *all.slot(effect, index).unwrap() = typical;
        }
    }
    all
}
