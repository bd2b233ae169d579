//! Impossible values are refused: the error names the value and what is accepted.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test may end in a panic"
)]

use truth_plant::{
    Converter, CosineLoop, DriveKind, Fatigue, Friction, L2pLoop, LatentHeat, LoopFamily,
    MountSlip, Noise, NoiseKind, OutputFilter, PreisachLoop, Radiation, SpringChange,
    StressCoupling, Supply, TruthError, TruthPlant,
};

fn message(change: impl FnOnce(&mut TruthPlant)) -> String {
    let mut plant = TruthPlant::default();
    change(&mut plant);
    plant.simulate(&[0.0, 1.0], 0.1, 0).unwrap_err().to_string()
}

#[test]
fn every_error_names_the_value_and_what_is_accepted() {
    let plant = TruthPlant::default();
    let text = |drive: &[f64], dt_s: f64| plant.simulate(drive, dt_s, 0).unwrap_err().to_string();
    assert_eq!(
        text(&[], 0.1),
        "the drive has no samples: at least 1 is needed"
    );
    assert_eq!(
        text(&[0.0, f64::NAN], 0.1),
        "sample 1 of the drive = NaN: must be from -1000 to 1000"
    );
    assert_eq!(
        text(&[0.0], f64::NAN),
        "dt_s = NaN: must be from 0.0001 to 1000"
    );
    assert_eq!(
        message(|p| p.radiation = Some(Radiation { emissivity: 1.2 })),
        "emissivity = 1.2: must be from 0 to 1"
    );
    assert_eq!(
        message(|p| p.stress_coupling = Some(StressCoupling {
            clausius_clapeyron_pa_per_k: 7e6
        })),
        "stress_coupling is set without bias_spring or end_stop: set bias_spring or end_stop too"
    );
    assert_eq!(
        message(|p| {
            p.hysteresis = LoopFamily::Cosine(CosineLoop {
                martensite_start_degc: 80.0,
                ..CosineLoop::default()
            });
        }),
        "martensite_start_degc = 80: must be below austenite_finish_degc = 74"
    );
    assert_eq!(
        TruthError::Diverged { index: 3 }.to_string(),
        "the integration left the numbers in sample 3: less power or shorter samples are needed"
    );
}

#[test]
fn too_much_power_is_an_error_and_not_a_recording() {
    let mut plant = TruthPlant::default();
    plant.rod.resistance_ohm_per_m = 1e5;
    plant.rod.diameter_m = 1e-5;
    plant.radiation = Some(Radiation { emissivity: 1.0 });
    let end = plant.simulate(&[1e3; 10], 1e3, 0);
    assert!(!matches!(&end, Ok(traces) if traces.displacement_mm.iter().any(|y| !y.is_finite())));
}

#[test]
fn needs_are_told() {
    let change = SpringChange {
        at_s: 1.0,
        over_s: 1.0,
        ratio: 0.8,
    };
    assert!(
        message(|p| p.spring_change = Some(change)).starts_with("spring_change is set without")
    );
    let slip = MountSlip {
        holding_force_n: 1.0,
        mobility_m_per_n_s: 1e-6,
    };
    assert!(message(|p| p.mount_slip = Some(slip)).starts_with("mount_slip is set without"));
}

#[test]
fn nan_is_refused_wherever_it_stands() {
    type Spoil = fn(&mut TruthPlant);
    let spoils: [(&str, Spoil); 24] = [
        ("diameter_m", |p| p.rod.diameter_m = f64::NAN),
        ("length_m", |p| p.rod.length_m = f64::NAN),
        ("density_kg_per_m3", |p| p.rod.density_kg_per_m3 = f64::NAN),
        ("specific_heat_j_per_kg_k", |p| {
            p.rod.specific_heat_j_per_kg_k = f64::NAN
        }),
        ("resistance_ohm_per_m", |p| {
            p.rod.resistance_ohm_per_m = f64::NAN
        }),
        ("martensite_w_per_m_k", |p| {
            p.rod.conductivity.martensite_w_per_m_k = f64::NAN
        }),
        ("convective_coefficient_w_per_m2_k", |p| {
            p.convective_coefficient_w_per_m2_k = f64::NAN
        }),
        ("ambient_degc", |p| p.ambient_degc = f64::NAN),
        ("stroke_m", |p| p.stroke_m = f64::NAN),
        ("offset_m", |p| p.offset_m = f64::NAN),
        ("tolerance_k", |p| p.tolerance_k = f64::NAN),
        ("longest_step_s", |p| p.longest_step_s = f64::NAN),
        ("supply_v", |p| {
            p.drive = DriveKind::Duty { supply_v: f64::NAN }
        }),
        ("time_constant_s", |p| {
            p.supply = Some(Supply {
                time_constant_s: f64::NAN,
                ..Supply::default()
            });
        }),
        ("zeta", |p| {
            p.hysteresis = LoopFamily::L2p(L2pLoop {
                zeta: f64::NAN,
                ..L2pLoop::default()
            });
        }),
        ("correlation", |p| {
            let l = PreisachLoop {
                correlation: f64::NAN,
                ..PreisachLoop::default()
            };
            p.hysteresis = LoopFamily::Preisach(l);
        }),
        ("austenite_start_degc", |p| {
            let l = CosineLoop {
                austenite_start_degc: f64::NAN,
                ..CosineLoop::default()
            };
            p.hysteresis = LoopFamily::Cosine(l);
        }),
        ("enthalpy_j_per_kg", |p| {
            p.latent_heat = Some(LatentHeat {
                enthalpy_j_per_kg: f64::NAN,
            });
        }),
        ("shift_k", |p| {
            p.fatigue = Some(Fatigue {
                shift_k: f64::NAN,
                stroke_loss: 0.0,
                cycles: 5.0,
            });
        }),
        ("coulomb_force_n", |p| {
            p.friction = Some(Friction {
                coulomb_force_n: f64::NAN,
                coupling_stiffness_n_per_m: 1e4,
                bristle_stiffness_n_per_m: 1e3,
            });
        }),
        ("dead_time_s", |p| {
            p.output_filter = Some(OutputFilter {
                time_constant_s: 0.0,
                dead_time_s: f64::NAN,
            });
        }),
        ("deviation", |p| {
            p.displacement_noise = Some(Noise {
                kind: NoiseKind::White,
                deviation: f64::NAN,
            });
        }),
        ("factor", |p| {
            let kind = NoiseKind::Outliers {
                share: 0.01,
                factor: f64::NAN,
            };
            p.displacement_noise = Some(Noise {
                kind,
                deviation: 1e-6,
            });
        }),
        ("full_scale_m", |p| {
            p.converter = Some(Converter {
                full_scale_m: f64::NAN,
                lowest_m: 0.0,
                bits: 12,
            });
        }),
    ];
    for (name, spoil) in spoils {
        let text = message(spoil);
        assert!(
            text.starts_with(&format!("{name} = NaN: must be ")),
            "{name}: {text}"
        );
    }
}
