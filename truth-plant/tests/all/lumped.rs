//! The second plant: its laws, and what each addition does to it.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test may end in a panic"
)]

use truth_plant::{
    Addition, DriveKind, LatentHeat, LoopFamily, RelayLoop, TanakaLoop, Traces, TruthPlant,
};

const DT_S: f64 = 0.2;
const SAMPLES: usize = 2_400;

fn families() -> [LoopFamily; 2] {
    [
        LoopFamily::Relays(RelayLoop::default()),
        LoopFamily::Tanaka(TanakaLoop::default()),
    ]
}

fn plain(hysteresis: LoopFamily) -> TruthPlant {
    TruthPlant {
        hysteresis,
        ..TruthPlant::default()
    }
}

/// A slow triangle, inner loops, squares: 480 s.
fn drive() -> Vec<f64> {
    let level = |k: usize| {
        let t = k as f64 * DT_S;
        match t {
            _ if t < 20.0 => 0.0,
            _ if t < 80.0 => 2.2 * (t - 20.0) / 60.0,
            _ if t < 140.0 => 2.2 * (140.0 - t) / 60.0,
            _ if t < 320.0 => 1.45 + 0.35 * (0.35 * (t - 140.0)).sin(),
            _ if t < 440.0 => 2.2 * ((t - 320.0) / 20.0 % 2.0).floor(),
            _ => 0.0,
        }
    };
    (0..SAMPLES).map(level).collect()
}

fn shown(plant: &TruthPlant) -> Traces {
    plant.simulate(&drive(), DT_S, 3).unwrap()
}

/// With an addition of a size, and without.
fn pair(addition: Addition, size: f64, hysteresis: LoopFamily) -> [Traces; 2] {
    let mut without = plain(hysteresis);
    let has_spring = matches!(addition, Addition::SpringChange | Addition::MountSlip);
    if has_spring || (addition == Addition::StressCoupling && size > 0.0) {
        let mut with_spring = without.clone();
        Addition::StressCoupling.install(&mut with_spring, 1.0, 480.0);
        without.bias_spring = with_spring.bias_spring;
    }
    let mut with = without.clone();
    addition.install(&mut with, size, 480.0);
    [shown(&with), shown(&without)]
}

/// A step of power: T = T_amb + P R (1 - exp(-t/τ)).
#[test]
fn the_plain_rod_is_the_first_order_answer() {
    for hysteresis in families() {
        let plant = TruthPlant {
            drive: DriveKind::Power,
            ..plain(hysteresis)
        };
        let tau_s = plant.time_constant_s();
        let surface_m2 = plant.rod.perimeter_m() * plant.rod.length_m;
        let w_per_k = plant.convective_coefficient_w_per_m2_k * surface_m2;
        let power_w = 40.0 * w_per_k;
        let traces = plant.simulate(&[power_w; 600], DT_S, 1).unwrap();
        for (time_s, degc) in traces.time_s.iter().zip(&traces.temperature_degc) {
            let expected_degc = plant.ambient_degc - 40.0 * (-time_s / tau_s).exp_m1();
            assert!((degc - expected_degc).abs() < 1e-8, "{time_s} s");
        }
    }
}

/// The temperature is that of the first plant where nothing but the loop differs, under any drive.
#[test]
fn both_plants_have_one_temperature_where_the_loop_does_not_act_on_it() {
    let first = shown(&TruthPlant::default());
    for hysteresis in families() {
        let second = shown(&plain(hysteresis));
        let pairs = first.temperature_degc.iter().zip(&second.temperature_degc);
        let apart_k = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart_k < 1e-4, "{apart_k}");
    }
}

/// Heat that is supplied and not lost is stored, as sensible and as latent heat.
#[test]
fn energy_is_conserved() {
    for hysteresis in families() {
        let plant = TruthPlant {
            drive: DriveKind::Power,
            latent_heat: Some(LatentHeat {
                enthalpy_j_per_kg: 20_000.0,
            }),
            ..plain(hysteresis)
        };
        let surface_m2 = plant.rod.perimeter_m() * plant.rod.length_m;
        let w_per_k = plant.convective_coefficient_w_per_m2_k * surface_m2;
        let mut drive = vec![70.0 * w_per_k; 800];
        drive.extend([0.0; 1_700]);
        let dt_s = 0.05;
        let traces = plant.simulate(&drive, dt_s, 1).unwrap();
        let capacity = plant.rod.heat_capacity_j_per_m_k() * plant.rod.length_m;
        let latent_k = 20_000.0 / plant.rod.specific_heat_j_per_kg_k;
        let (mut supplied_j, mut lost_j) = (0.0, 0.0);
        let total_j = 70.0 * w_per_k * 800.0 * dt_s;
        for k in 1..drive.len() {
            supplied_j += drive[k - 1] * dt_s;
            let mean_degc = 0.5 * (traces.temperature_degc[k - 1] + traces.temperature_degc[k]);
            lost_j += w_per_k * (mean_degc - plant.ambient_degc) * dt_s;
            let warm_k = traces.temperature_degc[k] - plant.ambient_degc;
            let phase = traces.fraction[k] - traces.fraction[0];
            let stored_j = capacity * (warm_k + latent_k * phase);
            let gap = (supplied_j - lost_j - stored_j) / total_j;
            assert!(gap.abs() < 1e-3, "{hysteresis:?} {k}: {gap:e}");
        }
        let top = traces.fraction.iter().copied().fold(0.0, f64::max);
        assert!(top > 0.8, "{top}");
        assert!((traces.fraction[2_499] - traces.fraction[0]).abs() < 0.02);
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_finer_steps_move_little() {
    for hysteresis in families() {
        for addition in Addition::ALL {
            let mut plant = plain(hysteresis);
            addition.install(&mut plant, 1.0, 480.0);
            let coarse = shown(&plant);
            assert_eq!(coarse, shown(&plant));
            let finer = shown(&TruthPlant {
                longest_step_s: DT_S / 80.0,
                ..plant
            });
            let pairs = coarse.quiet_displacement_mm.iter();
            let pairs = pairs.zip(&finer.quiet_displacement_mm);
            let squares: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
            let rms = (squares / SAMPLES as f64).sqrt() / 5.0;
            assert!(
                rms < 1.5e-3,
                "{hysteresis:?} {addition:?}: {rms} of the stroke"
            );
        }
    }
}

#[test]
fn every_addition_shows_at_its_typical_size_and_vanishes_with_it() {
    for hysteresis in families() {
        for addition in Addition::ALL {
            let nests = matches!(hysteresis, LoopFamily::Relays(_));
            if addition == Addition::NestedMemory && nests {
                continue;
            }
            let rms = |size: f64| {
                let [with, without] = pair(addition, size, hysteresis);
                let channel = |traces: &Traces| match addition {
                    Addition::Thermocouple => traces.quiet_thermocouple_degc.clone(),
                    _ => traces.quiet_displacement_mm.clone(),
                };
                let (with, without) = (channel(&with), channel(&without));
                let pairs = with.iter().zip(&without);
                let squares: f64 = pairs.map(|(a, b)| (a - b).powi(2)).sum();
                (squares / SAMPLES as f64).sqrt() / 5.0
            };
            let (typical, none) = (rms(1.0), rms(0.0));
            assert!(
                (0.002..0.5).contains(&typical) || addition == Addition::Thermocouple,
                "{hysteresis:?} {addition:?}: {typical} of the stroke"
            );
            assert!(
                none < 1e-3,
                "{hysteresis:?} {addition:?} of no size: {none}"
            );
        }
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Each changes the output the way that physics says.
#[test]
fn every_addition_acts_in_the_expected_direction() {
    for hysteresis in families() {
        let changed = |addition: Addition, samples: std::ops::Range<usize>| {
            let [with, without] = pair(addition, 1.0, hysteresis);
            let part = |traces: &Traces| mean(&traces.quiet_displacement_mm[samples.clone()]);
            part(&with) - part(&without)
        };
        // The first triangle rises to sample 400 and falls to 700.
        let (rise, fall, hot) = (250..400, 550..700, 380..420);
        let both = |addition: Addition| {
            (
                changed(addition, rise.clone()),
                changed(addition, fall.clone()),
            )
        };
        for late in [
            Addition::SupplyLag,
            Addition::SupplyDeadTime,
            Addition::OutputFilter,
            Addition::OutputDelay,
            Addition::LatentHeat,
        ] {
            let (rising, falling) = both(late);
            assert!(
                rising < 0.0 && falling > 0.0,
                "{late:?}: {rising} {falling}"
            );
        }
        for (less, samples) in [
            // Heat is lost where it is hot.
            (Addition::Radiation, fall.clone()),
            (Addition::EndFittings, hot.clone()),
            // More stress, a higher loop; a longer rod; a stop.
            (Addition::StressCoupling, fall.clone()),
            (Addition::ThermalExpansion, hot.clone()),
            (Addition::EndStop, hot.clone()),
            // Less resistance, less heat.
            (Addition::PhaseResistivity, hot),
            // What is R lacks its strain.
            (Addition::RPhase, 250..700),
        ] {
            let change = changed(less, samples);
            assert!(change < 0.0, "{less:?}: {change}");
        }
        // The loop comes down with wear, so that more of the inner loops is up.
        assert!(changed(Addition::Fatigue, 1_500..1_600) > -0.3);
        assert!(changed(Addition::SensorDrift, 1_000..2_400) > 0.05);
        let (rising, falling) = both(Addition::Friction);
        assert!(rising < 0.0 && falling > -0.1, "{rising} {falling}");
    }
}

#[test]
fn kinetics_forget_and_relays_remember_a_return_point() {
    let at = |hysteresis: LoopFamily, level: f64| {
        let plant = TruthPlant {
            drive: DriveKind::Power,
            ..plain(hysteresis)
        };
        let surface_m2 = plant.rod.perimeter_m() * plant.rod.length_m;
        let w_per_k = plant.convective_coefficient_w_per_m2_k * surface_m2;
        // Up into the loop, down to a level inside it, up again: slow.
        let holds = [45.0, level, 45.0].map(|rise_k| vec![rise_k * w_per_k; 600]);
        let traces = plant.simulate(&holds.concat(), DT_S, 1).unwrap();
        (traces.fraction[599], traces.fraction[1_799])
    };
    let (before, after) = at(LoopFamily::Relays(RelayLoop::default()), 26.0);
    assert!((before - after).abs() < 1e-3, "{before} {after}");
    let (before, after) = at(LoopFamily::Tanaka(TanakaLoop::default()), 26.0);
    assert!((before - after).abs() > 0.05, "{before} {after}");
}
