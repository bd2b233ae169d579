//! Laws of the whole plant: energy, equilibria, convergence, equal bytes.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test may end in a panic"
)]

use truth_plant::{
    Addition, AmbientDrift, BiasSpring, CosineLoop, DriveKind, EndFittings, LatentHeat, LoopFamily,
    Noise, NoiseKind, PhaseResistivity, PreisachLoop, Radiation, SecondRod, StressCoupling, Supply,
    TruthPlant,
};

const DT_S: f64 = 0.1;

fn families() -> [LoopFamily; 3] {
    [
        LoopFamily::default(),
        LoopFamily::Preisach(PreisachLoop::default()),
        LoopFamily::Cosine(CosineLoop::default()),
    ]
}

/// 60 s of heating, 340 s of cooling.
fn pulse() -> Vec<f64> {
    (0..4000).map(|k| if k < 600 { 2.2 } else { 0.0 }).collect()
}

/// Electrical energy in, and energy lost to the air up to each sample (trapezoid), J/m.
fn ledger(plant: &TruthPlant, drive: &[f64], temperature_degc: &[f64]) -> Vec<(f64, f64)> {
    let hp = plant.convective_coefficient_w_per_m2_k * plant.rod.perimeter_m();
    let (mut supplied, mut lost) = (0.0, 0.0);
    let mut ledger = vec![(0.0, 0.0)];
    for k in 1..drive.len() {
        supplied += plant.rod.resistance_ohm_per_m * drive[k - 1].powi(2) * DT_S;
        let mean_degc = 0.5 * (temperature_degc[k - 1] + temperature_degc[k]);
        lost += hp * (mean_degc - plant.ambient_degc) * DT_S;
        ledger.push((supplied, lost));
    }
    ledger
}

/// Heat that is supplied and not lost is stored, as sensible and as latent heat; over the closed cycle, none is.
#[test]
fn latent_heat_conserves_energy() {
    for hysteresis in families() {
        let plant = TruthPlant {
            hysteresis,
            latent_heat: Some(LatentHeat {
                enthalpy_j_per_kg: 20_000.0,
            }),
            ..TruthPlant::default()
        };
        let traces = plant.simulate(&pulse(), DT_S, 1).unwrap();
        let ledger = ledger(&plant, &pulse(), &traces.temperature_degc);
        let capacity = plant.rod.heat_capacity_j_per_m_k();
        let latent_k = 20_000.0 / plant.rod.specific_heat_j_per_kg_k;
        let total = ledger[ledger.len() - 1].0;
        for (k, (supplied, lost)) in ledger.into_iter().enumerate() {
            let warm_k = traces.temperature_degc[k] - plant.ambient_degc;
            let phase = traces.fraction[k] - traces.fraction[0];
            let stored = capacity * (warm_k + latent_k * phase);
            // The trapezoid errs where the power steps.
            let gap = (supplied - lost - stored) / total;
            assert!(
                gap.abs() < 2e-4,
                "sample {k}: {gap:e} of all energy is missing"
            );
        }
        let phase = traces.fraction[3999] - traces.fraction[0];
        assert!(phase.abs() < 2e-3, "the cycle is closed: {phase:e}");
        let top = traces.fraction.iter().copied().fold(0.0, f64::max);
        assert!(top > 0.9, "{top}");
    }
}

#[test]
fn latent_heat_slows_the_middle_of_both_branches() {
    let with = TruthPlant {
        latent_heat: Some(LatentHeat {
            enthalpy_j_per_kg: 15_000.0,
        }),
        ..TruthPlant::default()
    };
    let time_between = |plant: &TruthPlant, from: f64, to: f64| {
        let traces = plant.simulate(&pulse(), DT_S, 1).unwrap();
        let range = from.min(to)..from.max(to);
        traces
            .fraction
            .iter()
            .filter(|xi| range.contains(xi))
            .count() as f64
            * DT_S
    };
    let (plain, slow) = (
        time_between(&TruthPlant::default(), 0.3, 0.7),
        time_between(&with, 0.3, 0.7),
    );
    assert!(slow > 1.5 * plain, "{plain} s, {slow} s");
}

#[test]
fn a_held_drive_ends_in_the_balance_of_heat() {
    let hold = |plant: &TruthPlant, drive: f64| {
        let traces = plant.simulate(&vec![drive; 3000], DT_S, 1).unwrap();
        traces.temperature_degc[2999] - plant.ambient_degc
    };
    let plain = TruthPlant::default();
    let hp = plain.convective_coefficient_w_per_m2_k * plain.rod.perimeter_m();
    let expected_k = plain.rod.resistance_ohm_per_m * 2.25 / hp;
    assert!((hold(&plain, 1.5) - expected_k).abs() < 1e-6);
    // The same power by every kind of drive.
    let ohm = plain.rod.resistance_ohm_per_m * plain.rod.length_m;
    let same = [
        (DriveKind::Voltage, 1.5 * ohm),
        (DriveKind::Power, 2.25 * ohm),
        (
            DriveKind::Duty {
                supply_v: 3.0 * ohm,
            },
            0.25,
        ),
    ];
    for (kind, value) in same {
        let plant = TruthPlant {
            drive: kind,
            ..plain.clone()
        };
        assert!((hold(&plant, value) - expected_k).abs() < 1e-6, "{kind:?}");
    }
    // Radiation alone, from the balance solved by hand: h P (T - T_a) + ε σ P (T⁴ - T_a⁴) = R i².
    let plant = TruthPlant {
        radiation: Some(Radiation { emissivity: 0.8 }),
        ..plain.clone()
    };
    let rise_k = hold(&plant, 1.5);
    let fourth = |degc: f64| (degc + 273.15_f64).powi(4);
    let radiated = 0.8 * 5.670_374_419e-8 * (fourth(22.0 + rise_k) - fourth(22.0));
    let balance = plain.convective_coefficient_w_per_m2_k * rise_k + radiated;
    let supplied = plain.rod.resistance_ohm_per_m * 2.25 / plain.rod.perimeter_m();
    assert!((balance / supplied - 1.0).abs() < 1e-7);
}

/// A rod held by fittings at ambient: the fin of the textbooks.
#[test]
fn clamped_ends_give_the_profile_of_a_fin() {
    let mut plant = TruthPlant::default();
    plant.rod.conductivity.austenite_w_per_m_k = 8.6;
    plant.rod.conductivity.rise_per_k = 0.0;
    plant.rod.length_m = 0.02;
    plant.end_fittings = Some(EndFittings {
        contact_w_per_k: 100.0,
        heat_capacity_j_per_k: 1e6,
        loss_w_per_k: 100.0,
    });
    plant.rod.cells = 41;
    let traces = plant.simulate(&vec![1.5; 2000], DT_S, 1).unwrap();
    let (k, d) = (8.6, plant.rod.diameter_m);
    let length_m = (k * d / (4.0 * plant.convective_coefficient_w_per_m2_k)).sqrt();
    let hp = plant.convective_coefficient_w_per_m2_k * plant.rod.perimeter_m();
    let far_k = plant.rod.resistance_ohm_per_m * 2.25 / hp;
    let expected_k = far_k * (1.0 - 1.0 / (0.01 / length_m).cosh());
    let middle_k = traces.temperature_degc[1999] - plant.ambient_degc;
    assert!(
        (middle_k / expected_k - 1.0).abs() < 1e-3,
        "{middle_k} K, {expected_k} K"
    );
}

#[test]
fn cells_converge_and_without_fittings_do_not_matter() {
    let displacement = |cells: usize, fittings: bool| {
        let mut plant = TruthPlant::default();
        if fittings {
            Addition::EndFittings.install(&mut plant, 1.0, 400.0);
        }
        plant.rod.cells = cells;
        plant.simulate(&pulse(), DT_S, 1).unwrap().displacement_mm
    };
    let largest = |a: &[f64], b: &[f64]| {
        let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs() / 5.0);
        differences.fold(0.0, f64::max)
    };
    assert!(largest(&displacement(1, false), &displacement(20, false)) < 1e-9);
    let finest = displacement(40, true);
    let errors = [5, 10, 20].map(|cells| largest(&displacement(cells, true), &finest));
    assert!(errors[2] < 2e-3, "{errors:?}");
    assert!(
        errors[0] > 1.8 * errors[1] && errors[1] > 1.8 * errors[2],
        "{errors:?}"
    );
}

/// Everything at once, in every family: a tighter tolerance and far shorter steps give the same.
#[test]
fn tighter_tolerances_move_the_output_by_less_than_a_millionth() {
    let drive: Vec<f64> = (0..2000)
        .map(|k| {
            let t = f64::from(k) * DT_S;
            if t < 150.0 {
                1.5 + 0.6 * (0.2 * t).sin() * (1.0 - t / 200.0)
            } else {
                0.0
            }
        })
        .collect();
    for hysteresis in families() {
        let mut plant = TruthPlant {
            hysteresis,
            ..TruthPlant::default()
        };
        for addition in [
            Addition::LatentHeat,
            Addition::StressCoupling,
            Addition::PhaseResistivity,
            Addition::FreeConvection,
            Addition::Radiation,
            Addition::ThermalExpansion,
            Addition::Friction,
        ] {
            addition.install(&mut plant, 1.0, 200.0);
        }
        let displacement =
            |plant: &TruthPlant| plant.simulate(&drive, DT_S, 1).unwrap().displacement_mm;
        let usual = displacement(&plant);
        plant.tolerance_k *= 0.5;
        plant.longest_step_s = DT_S / 17.0;
        let finer = displacement(&plant);
        let differences = usual.iter().zip(&finer).map(|(a, b)| (a - b).abs() / 5.0);
        let largest = differences.fold(0.0, f64::max);
        assert!(
            largest < 1e-6,
            "{:?}: {largest:e} of the stroke",
            plant.hysteresis
        );
    }
}

#[test]
fn stress_moves_the_loop_by_clausius_and_clapeyron() {
    // Loops with and without coupling, at the temperature where half is transformed on heating.
    let half_degc = |coupled: bool| {
        let mut plant = TruthPlant::default();
        plant.rod.elastic_modulus_pa = 1e12;
        plant.bias_spring = Some(BiasSpring {
            stiffness_n_per_m: 100e6 * plant.rod.section_m2() / plant.stroke_m,
            preload_n: 10.0,
        });
        plant.stress_coupling = coupled.then_some(StressCoupling {
            clausius_clapeyron_pa_per_k: 5e6,
        });
        let traces = plant.simulate(&pulse(), DT_S, 1).unwrap();
        let k = traces.fraction.iter().position(|&xi| xi > 0.5).unwrap();
        let share = (0.5 - traces.fraction[k - 1]) / (traces.fraction[k] - traces.fraction[k - 1]);
        let temperature = &traces.temperature_degc;
        temperature[k - 1] + share * (temperature[k] - temperature[k - 1])
    };
    // Half of 100 MPa over 5 MPa/K, less what the rod gives way: 0.2 %.
    let shift_k = half_degc(true) - half_degc(false);
    assert!((shift_k - 10.0).abs() < 0.1, "{shift_k} K");
}

#[test]
fn resistance_acts_with_opposite_signs_on_current_and_voltage() {
    let hottest = |drive: DriveKind, value: f64, excess: f64| {
        let plant = TruthPlant {
            drive,
            phase_resistivity: Some(PhaseResistivity {
                austenite_excess: excess,
                rise_per_k: 0.0,
                martensite_strain: 0.0,
            }),
            ..TruthPlant::default()
        };
        plant
            .simulate(&vec![value; 2000], DT_S, 1)
            .unwrap()
            .temperature_degc[1999]
    };
    let ohm = 2.13 * 0.11;
    for (kind, value, sign) in [
        (DriveKind::Current, 2.0, 1.0),
        (DriveKind::Voltage, 2.0 * ohm, -1.0),
        (
            DriveKind::Duty {
                supply_v: 4.0 * ohm,
            },
            0.25,
            -1.0,
        ),
    ] {
        let change_k = hottest(kind, value, 0.1) - hottest(kind, value, 0.0);
        assert!(sign * change_k > 3.0, "{kind:?}: {change_k} K");
    }
    let change_k =
        hottest(DriveKind::Power, 4.0 * ohm, 0.1) - hottest(DriveKind::Power, 4.0 * ohm, 0.0);
    assert!(change_k.abs() < 1e-6, "{change_k} K");
}

#[test]
fn the_hot_rods_resistance_is_that_of_its_phase_temperature_and_shape() {
    let plant = TruthPlant {
        hysteresis: LoopFamily::Cosine(CosineLoop::default()),
        phase_resistivity: Some(PhaseResistivity {
            austenite_excess: -0.1,
            rise_per_k: 3e-4,
            martensite_strain: 0.05,
        }),
        ..TruthPlant::default()
    };
    let traces = plant.simulate(&vec![2.4; 3000], DT_S, 1).unwrap();
    let rise_k = traces.temperature_degc[2999] - plant.ambient_degc;
    let hp = plant.convective_coefficient_w_per_m2_k * plant.rod.perimeter_m();
    let resistance = hp * rise_k / 2.4_f64.powi(2);
    // All austenite: 10 % less resistivity, shorter and thicker by 5 % each.
    let expected = 2.13 * 0.9 * (1.0 + 3e-4 * rise_k) / 1.05_f64.powi(2);
    assert!(
        (resistance / expected - 1.0).abs() < 1e-7,
        "{resistance} {expected}"
    );
}

#[test]
fn a_dead_time_of_whole_samples_shifts_the_output() {
    let plain = TruthPlant::default();
    let late = TruthPlant {
        supply: Some(Supply {
            dead_time_s: 0.5,
            ..Supply::default()
        }),
        ..plain.clone()
    };
    let [early, late] =
        [plain, late].map(|p| p.simulate(&pulse(), DT_S, 1).unwrap().displacement_mm);
    for k in 5..4000 {
        assert!((late[k] - early[k - 5]).abs() < 1e-9);
    }
}

#[test]
fn two_equal_rods_are_one_and_a_compliance_clips() {
    let displacement =
        |plant: &TruthPlant| plant.simulate(&pulse(), DT_S, 1).unwrap().displacement_mm;
    let plain = displacement(&TruthPlant::default());
    let pair = displacement(&TruthPlant {
        second_rod: Some(SecondRod {
            resistance_ratio: 1.0,
        }),
        ..TruthPlant::default()
    });
    assert!(plain.iter().zip(&pair).all(|(a, b)| (a - b).abs() < 1e-9));
    // 1.5 A at most: as a drive of 1.5 A.
    let clipped = displacement(&TruthPlant {
        supply: Some(Supply {
            compliance_v: 1.5 * 2.13 * 0.11,
            ..Supply::default()
        }),
        ..TruthPlant::default()
    });
    let lower: Vec<f64> = pulse().iter().map(|a| a.min(1.5)).collect();
    let lower = TruthPlant::default()
        .simulate(&lower, DT_S, 1)
        .unwrap()
        .displacement_mm;
    assert!(
        clipped
            .iter()
            .zip(&lower)
            .all(|(a, b)| (a - b).abs() < 1e-9)
    );
}

#[test]
fn samples_are_read_before_their_drive() {
    let mut drive = vec![0.0; 10];
    drive[3] = 2.2;
    let traces = TruthPlant::default().simulate(&drive, DT_S, 1).unwrap();
    assert!((traces.temperature_degc[3] - 22.0).abs() < 1e-12);
    assert!(traces.temperature_degc[4] > 22.5);
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
    let mut plant = TruthPlant {
        displacement_noise: Some(Noise {
            kind: NoiseKind::OneOverF,
            deviation: 1e-5,
        }),
        temperature_noise: Some(Noise {
            kind: NoiseKind::HeavyTails,
            deviation: 0.2,
        }),
        ..TruthPlant::default()
    };
    Addition::Draughts.install(&mut plant, 1.0, 400.0);
    Addition::AmbientDrift.install(&mut plant, 1.0, 400.0);
    let run = |seed| plant.simulate(&pulse(), DT_S, seed).unwrap();
    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    let (one, again, other) = (run(7), run(7), run(8));
    for pick in [
        |t: &truth_plant::Traces| t.displacement_mm.clone(),
        |t: &truth_plant::Traces| t.thermocouple_degc.clone(),
        |t: &truth_plant::Traces| t.ambient_degc.clone(),
    ] {
        assert_eq!(bits(&pick(&one)), bits(&pick(&again)));
        assert_ne!(bits(&pick(&one)), bits(&pick(&other)));
    }
}

/// An addition that is random takes nothing from the streams of the others.
#[test]
fn noise_does_not_depend_on_what_else_is_random() {
    let noise = Some(Noise {
        kind: NoiseKind::White,
        deviation: 1e-5,
    });
    let plain = TruthPlant {
        displacement_noise: noise,
        ..TruthPlant::default()
    };
    let drifting = TruthPlant {
        ambient_drift: Some(AmbientDrift {
            rate_k_per_s: 0.0,
            wave_amplitude_k: 0.0,
            wave_period_s: 100.0,
            wave_phase_rad: 0.0,
            random_walk_k_per_root_s: 0.1,
        }),
        ..plain.clone()
    };
    let [a, b] = [plain, drifting].map(|plant| {
        let t = plant.simulate(&pulse()[..500], DT_S, 3).unwrap();
        let pairs = t.displacement_mm.iter().zip(&t.quiet_displacement_mm);
        pairs
            .map(|(noisy, quiet)| noisy - quiet)
            .collect::<Vec<_>>()
    });
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-12));
}
