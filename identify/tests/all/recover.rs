//! A fit of generated recordings returns what generated them.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

use crate::common;

use common::{ROD, TRUE_TAU_S, recording, rod, steps, triangles, with_output};
use identify::{
    Fit, FitConfig, ForwardModel, IdentifyError, LeastSquaresConfig, Loss, OffsetSource,
    ParameterState, ParameterVector, RefineConfig, WienerModel, fit, refine, validate,
};
use recording::{Quantity, Recording, RecordingParts};
use std::ops::ControlFlow;
use wiener::hysteresis::Rule;
use wiener::{Drive, Plant, Profile, Wiener, run};

fn fitted(rod_text: &str, training: &[Recording], seed: u64) -> (WienerModel, Fit) {
    let model = WienerModel::new(&rod(rod_text), Rule::LastReversal, training).unwrap();
    let config = FitConfig {
        seed,
        ..FitConfig::default()
    };
    let fit = fit(
        &model,
        training,
        &config,
        &mut |_| ControlFlow::Continue(()),
    )
    .unwrap();
    (model, fit)
}

fn value(fit: &Fit, name: &str) -> f64 {
    fit.parameter(name).unwrap().values[0]
}

#[test]
fn two_recordings_with_their_own_offsets_return_the_truth() {
    let training = [
        recording("a.csv", triangles(1200, 4.2), 0.5),
        recording("b.csv", steps(900), -1.25),
    ];
    let (model, fit) = fitted(ROD, &training, 1);
    assert!(fit.train_rmse < 1e-6, "{}", fit.train_rmse);
    assert!(fit.termination.is_minimum());
    for (name, truth) in [
        ("tau_s", TRUE_TAU_S),
        ("loop_center_degc", 70.0),
        ("loop_half_width_k", 8.0),
        ("loop_spread_k", 6.0),
        ("zeta", 0.8),
        ("gain", -3.0),
        ("offset", 0.5),
    ] {
        let found = value(&fit, name);
        assert!(
            (found - truth).abs() < 1e-4 * truth.abs(),
            "{name}: {found} {truth}"
        );
    }
    assert!((fit.parameter("offset").unwrap().values[1] + 1.25).abs() < 1e-5);
    // Nothing of the unseen recording but its rest decides its offset.
    let unseen = recording("unseen.csv", triangles(700, 3.9), 2.0);
    let validated = validate(&model, &fit, &unseen).unwrap();
    assert_eq!(
        validated.offset_source,
        OffsetSource::BeforeDrive { n_samples: 22 }
    );
    assert!(validated.rmse < 1e-5, "{}", validated.rmse);
    assert!((validated.offset - 2.0).abs() < 1e-5);
}

#[test]
fn a_recording_that_starts_driven_takes_its_offset_from_the_whole() {
    let training = [recording("a.csv", triangles(1200, 4.2), 0.5)];
    let (model, fit) = fitted(ROD, &training, 1);
    let unseen = recording("unseen.csv", triangles(700, 3.9)[25..].to_vec(), 2.0);
    let validated = validate(&model, &fit, &unseen).unwrap();
    assert_eq!(
        validated.offset_source,
        OffsetSource::WholeRecording { at_rest: 0 }
    );
    assert!(validated.rmse < 1e-5, "{}", validated.rmse);
}

#[test]
fn same_seed_same_bits_on_any_number_of_threads() {
    let on = |training: &[Recording], threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| fitted(ROD, training, 7).1)
    };
    let two = [
        recording("a.csv", triangles(600, 4.2), 0.5),
        recording("b.csv", steps(500), -1.25),
    ];
    let one = on(&two, 1);
    assert_eq!(one, on(&two, 2));
    assert_eq!(one, on(&two, 7));
    // Its loop lies beyond the temperatures reached: searches that hold it within run side by side, and meet now and then only.
    let cold = &two[..1];
    let one = on(cold, 1);
    assert!(!one.beyond_reach.is_empty());
    for _ in 0..50 {
        assert_eq!(one, on(cold, 7));
    }
}

#[test]
fn without_heat_capacity_only_ratios_are_found() {
    // Any factor on all temperature differences gives the same output: with λ assumed, the ratios
    // that remain are those of the truth.
    let training = [recording("a.csv", triangles(1200, 4.2), 0.5)];
    let text = ROD.replace("specific_heat_j_per_kg_k = 500.0\n", "");
    let (model, fit) = fitted(&text, &training, 1);
    assert!(!model.knows_temperature());
    assert!(fit.train_rmse < 1e-6);
    assert!((value(&fit, "tau_s") - TRUE_TAU_S).abs() < 1e-4 * TRUE_TAU_S);
    let width = value(&fit, "loop_half_width_k");
    assert!((width / value(&fit, "loop_spread_k") - 8.0 / 6.0).abs() < 1e-4);
    assert!(((value(&fit, "loop_center_degc") - 21.0) / width - 49.0 / 8.0).abs() < 1e-3);
}

#[test]
fn fixed_parameters_stay_and_bounds_hold() {
    let training = [recording("a.csv", triangles(600, 4.2), 0.5)];
    let text =
        format!("{ROD}[model]\nzeta = {{ fixed = 0.5 }}\ntau_s = {{ bounds = [1.0, 5.0] }}\n");
    let (_, fit) = fitted(&text, &training, 1);
    assert_eq!(value(&fit, "zeta").to_bits(), 0.5_f64.to_bits());
    let tau = fit.parameter("tau_s").unwrap();
    assert!(
        tau.at_bound && (1.0..=5.0).contains(&tau.values[0]),
        "{tau:?}"
    );
    assert!(fit.train_rmse > 1e-3);
}

#[test]
fn everything_fixed_is_nothing_to_identify() {
    let training = [recording("a.csv", triangles(600, 4.2), 0.5)];
    let names = [
        "tau_s",
        "loop_center_degc",
        "loop_half_width_k",
        "loop_spread_k",
        "zeta",
    ];
    let fixed: String = names
        .map(|name| format!("{name} = {{ fixed = 0.7 }}\n"))
        .concat();
    let model = WienerModel::new(
        &rod(&format!("{ROD}[model]\n{fixed}")),
        Rule::LastReversal,
        &training,
    )
    .unwrap();
    let error = fit(&model, &training, &FitConfig::default(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap_err();
    assert_eq!(
        error.to_string(),
        "every parameter is fixed: nothing to identify"
    );
}

#[test]
fn recordings_must_share_unit_and_drive_and_move() {
    let first = recording("a.csv", steps(300), 0.0);
    let model =
        WienerModel::new(&rod(ROD), Rule::LastReversal, std::slice::from_ref(&first)).unwrap();
    let fitted = |training: &[Recording]| {
        fit(&model, training, &FitConfig::default(), &mut |_| {
            ControlFlow::Continue(())
        })
    };
    let refused = |training: &[Recording]| fitted(training).unwrap_err().to_string();
    let in_degrees = with_output(&first, "deg", first.output().to_vec());
    let units = "b.csv: output in deg, but a.csv is in mm: one unit is needed";
    assert_eq!(refused(&[first.clone(), in_degrees.clone()]), units);
    let by_power = Recording::new(RecordingParts {
        name: "b.csv".to_owned(),
        time_s: Some(first.time_s().to_vec()),
        drive_quantity: Quantity::Power,
        drive: first.drive().to_vec(),
        output_unit: "mm".to_owned(),
        output: first.output().to_vec(),
        ..RecordingParts::default()
    })
    .unwrap();
    let drives = "b.csv: driven by power, but a.csv by current: one kind of drive is needed";
    assert_eq!(refused(&[first.clone(), by_power.clone()]), drives);
    let still = refused(&[first.clone(), with_output(&first, "mm", vec![1.0; 300])]);
    assert!(still.starts_with("b.csv: output is 1 mm"), "{still}");
    assert_eq!(refused(&[]), "no training recording; at least 1 is needed");
    // The same holds for what is validated.
    let fit = fitted(std::slice::from_ref(&first)).unwrap();
    assert_eq!(
        validate(&model, &fit, &in_degrees).unwrap_err().to_string(),
        units
    );
    assert_eq!(
        validate(&model, &fit, &by_power).unwrap_err().to_string(),
        drives
    );
}

#[test]
fn a_recording_that_is_never_driven_tests_nothing() {
    let first = recording("a.csv", triangles(600, 4.2), 0.5);
    let (model, fit) = fitted(ROD, &[first], 1);
    let validated = validate(&model, &fit, &recording("cold.csv", vec![0.0; 100], 0.7)).unwrap();
    assert_eq!(validated.offset_source, OffsetSource::NeverDriven);
    assert_eq!(validated.fit_fraction, None);
}

#[test]
fn an_idle_current_is_rest() {
    // A supply that cannot go below 20 mA, which the rod does not feel.
    let idle = |drive: Vec<f64>| drive.into_iter().map(|drive| drive.max(0.02)).collect();
    let (model, fit) = fitted(
        ROD,
        &[recording("a.csv", idle(triangles(900, 4.2)), 0.5)],
        1,
    );
    let unseen = recording("unseen.csv", idle(triangles(700, 3.9)), 2.0);
    let validated = validate(&model, &fit, &unseen).unwrap();
    assert!(matches!(
        validated.offset_source,
        OffsetSource::BeforeDrive { n_samples: 20..=24 }
    ));
    assert!(validated.rmse < 1e-4, "{}", validated.rmse);
}

#[test]
fn a_fixed_offset_stays_fixed() {
    let text = format!("{ROD}[model]\noffset = {{ fixed = 0.5 }}\n");
    let (model, fit) = fitted(&text, &[recording("a.csv", triangles(900, 4.2), 0.5)], 1);
    assert!(fit.train_rmse < 1e-6, "{}", fit.train_rmse);
    let validated = validate(&model, &fit, &recording("b.csv", triangles(500, 4.0), 0.8)).unwrap();
    assert!((validated.offset - 0.5).abs() < 1e-12 && (validated.rmse - 0.3).abs() < 1e-5);
}

#[test]
fn a_start_between_the_curves_is_found() {
    // The second recording is cut off in mid-course, so that it starts warm and half transformed.
    let whole = recording("a.csv", triangles(900, 4.2), 0.5);
    let cut = Recording::new(RecordingParts {
        name: "cut.csv".to_owned(),
        time_s: Some(whole.time_s()[100..].to_vec()),
        drive: whole.drive()[100..].to_vec(),
        output_unit: "mm".to_owned(),
        output: whole.output()[100..].to_vec(),
        ..RecordingParts::default()
    })
    .unwrap();
    let fixed = fitted(ROD, &[whole.clone(), cut.clone()], 1).1;
    let text = format!(
        "{ROD}[model]\nstart_rise_k = {{ bounds = [0, 100] }}\nstart_share = {{ bounds = [0, 1] }}\n"
    );
    let (model, free) = fitted(&text, &[whole, cut.clone()], 1);
    assert!(fixed.train_rmse > 0.01, "{}", fixed.train_rmse);
    assert!(
        free.train_rmse < 0.1 * fixed.train_rmse,
        "{}",
        free.train_rmse
    );
    assert_eq!(free.parameter("start_rise_k").unwrap().values.len(), 2);
    // Its start is found again where it is validated.
    let validated = validate(&model, &free, &cut).unwrap();
    assert!(
        validated.rmse < 0.2 * fixed.train_rmse,
        "{}",
        validated.rmse
    );
}

/// A recording with the rod's temperature, and with ripples on both that no model has: of a millimeter and a kelvin, times `ripple`.
fn with_temperature(ripple: f64) -> Recording {
    let plain = recording("a.csv", triangles(900, 4.2), 0.5);
    let truth = Wiener::new(Drive::Current, Rule::LastReversal, &[common::truth()]).unwrap();
    let profile = Profile::uniform(plain.drive(), 0.25, 21.0).unwrap();
    let mut temperature_degc = Vec::new();
    run(&truth, &mut truth.rest(21.0), &profile, |_, shown| {
        let bent_k = ripple * (0.03 * temperature_degc.len() as f64).cos();
        temperature_degc.push(shown.temperature_degc[0] + bent_k);
    });
    let output = plain.output().iter().enumerate();
    let output = output.map(|(k, y)| y + ripple * (0.02 * k as f64).sin());
    Recording::new(RecordingParts {
        name: "warm.csv".to_owned(),
        time_s: Some(plain.time_s().to_vec()),
        drive: plain.drive().to_vec(),
        output_unit: "mm".to_owned(),
        output: output.collect(),
        temperature_degc: Some(temperature_degc),
        ..RecordingParts::default()
    })
    .unwrap()
}

#[test]
fn a_recorded_temperature_fixes_the_scale() {
    // Heat capacity unknown, but the temperature is recorded: kelvins are kelvins again.
    let training = [with_temperature(0.0)];
    let (model, fit) = fitted("surroundings.ambient_degc = 21.0", &training, 1);
    assert!(model.knows_temperature());
    assert!((value(&fit, "loop_center_degc") - 70.0).abs() < 0.01);
    assert!((value(&fit, "loop_half_width_k") - 8.0).abs() < 0.01);
    assert!(fit.temperature_rmse_k.unwrap() < 1e-3);
}

#[test]
fn a_search_that_weighs_temperatures_as_they_are_met_stays_where_it_ended() {
    let training = [with_temperature(0.2)];
    let text = "surroundings.ambient_degc = 21.0";
    let (model, first) = fitted(text, &training, 1);
    let vector = ParameterVector::new(model.parameters(), 1);
    let again = |temperature_weight| {
        let config = FitConfig {
            from: vec![first.coordinates(&vector)],
            starts: 0,
            temperature_weight,
            least_squares: LeastSquaresConfig {
                least_gain: 1e-6,
                ..LeastSquaresConfig::default()
            },
            ..FitConfig::default()
        };
        let go_on = &mut |_: &_| ControlFlow::Continue(());
        fit(&model, &training, &config, go_on).unwrap()
    };
    let as_met = (first.train_rmse / first.temperature_rmse_k.unwrap()).powi(2);
    let [equal_spreads, as_met] = [None, Some(as_met)].map(again);
    for found in [&equal_spreads, &as_met] {
        // Both channels count by the logarithms of their errors.
        let [found, first] =
            [found, &first].map(|fit| fit.train_rmse * fit.temperature_rmse_k.unwrap());
        assert!((found / first - 1.0).abs() < 1e-3, "{found} {first}");
    }
    let simulations = [as_met, equal_spreads].map(|fit| fit.simulations);
    assert!(4 * simulations[0] < 3 * simulations[1], "{simulations:?}");
}

#[test]
fn outliers_hardly_move_hubers_loss() {
    // Hot enough for the whole loop: nothing holds it.
    let clean = recording("a.csv", triangles(900, 5.4), 0.5);
    // One sample in fifty jumps by 2 mm to either side; the others carry a small ripple.
    let output = clean.output().iter().enumerate().map(|(k, y)| {
        if k % 50 == 7 {
            y + if k % 100 == 7 { 2.0 } else { -2.0 }
        } else {
            y + 0.01 * (k as f64 * 1.7).sin()
        }
    });
    let training = [with_output(&clean, "mm", output.collect())];
    let with = |loss| {
        let model = WienerModel::new(&rod(ROD), Rule::LastReversal, &training).unwrap();
        let config = FitConfig {
            loss,
            ..FitConfig::default()
        };
        let fit = fit(&model, &training, &config, &mut |_| {
            ControlFlow::Continue(())
        })
        .unwrap();
        (value(&fit, "gain") + 3.0).abs() + (value(&fit, "loop_center_degc") - 70.0).abs()
    };
    let (squares, huber) = (with(Loss::Squares), with(Loss::Huber));
    assert!(huber < 0.02 * squares, "{huber} {squares}");
}

#[test]
fn a_direction_that_the_data_leave_open_is_named() {
    let text =
        "surroundings.ambient_degc = 21.0\n[model]\nlambda_k_per_a2 = { bounds = [0.5, 50.0] }";
    let (_, fit) = fitted(text, &[recording("a.csv", triangles(900, 4.2), 0.5)], 1);
    let said: Vec<String> = fit.unfixed.iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        [
            "lambda_k_per_a2, loop center above ambient, half width and spread scale together: give R and \
          m·Cp, or record the temperature"
        ]
    );
    // And no interval is claimed for them.
    assert_eq!(
        fit.parameter("loop_half_width_k").unwrap().intervals,
        [None]
    );
    assert!(fit.parameter("tau_s").unwrap().intervals[0].is_some());
}

#[test]
fn the_search_can_be_ended_with_what_it_has() {
    let training = [recording("a.csv", triangles(600, 4.2), 0.5)];
    let model = WienerModel::new(&rod(ROD), Rule::LastReversal, &training).unwrap();
    let fit = fit(&model, &training, &FitConfig::default(), &mut |_| {
        ControlFlow::Break(())
    })
    .unwrap();
    assert_eq!(fit.starts, 1);
}

#[test]
fn absurd_numbers_are_not_a_perfect_fit() {
    // A glitch so large that its square is infinite.
    let mut drive = triangles(600, 4.2);
    drive[300] = 1e200;
    let clean = recording("a.csv", triangles(600, 4.2), 0.5);
    let glitch = Recording::new(RecordingParts {
        name: "glitch.csv".to_owned(),
        time_s: Some(clean.time_s().to_vec()),
        drive,
        output_unit: "mm".to_owned(),
        output: clean.output().to_vec(),
        ..RecordingParts::default()
    })
    .unwrap();
    let training = [glitch];
    let model = WienerModel::new(&rod(ROD), Rule::LastReversal, &training).unwrap();
    let error = fit(&model, &training, &FitConfig::default(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap_err();
    assert_eq!(
        error.to_string(),
        "no point within the bounds gives a finite cost; check the recordings for absurd values"
    );
}

#[test]
fn recordings_need_time() {
    let timed = recording("a.csv", steps(300), 0.0);
    let untimed = Recording::new(RecordingParts {
        name: "static.csv".to_owned(),
        drive: timed.drive().to_vec(),
        output_unit: "mm".to_owned(),
        output: timed.output().to_vec(),
        ..RecordingParts::default()
    })
    .unwrap();
    let error = WienerModel::new(&rod(ROD), Rule::LastReversal, &[untimed]).unwrap_err();
    assert!(matches!(error, IdentifyError::Untimed { .. }));
    assert_eq!(
        error.to_string(),
        "static.csv: no time; a heat balance can only be identified from timed samples"
    );
}

#[test]
fn samples_of_no_weight_are_left_out() {
    let clean = recording("a.csv", triangles(900, 5.0), 0.5);
    // From the 300th sample to the 400th the sensor was off.
    let spoiled = clean.output().iter().enumerate();
    let spoiled = spoiled.map(|(k, y)| if (300..400).contains(&k) { 9.0 } else { *y });
    let training = [with_output(&clean, "mm", spoiled.collect())];
    let model = WienerModel::new(&rod(ROD), Rule::LastReversal, &training).unwrap();
    let vector = ParameterVector::new(model.parameters(), 1);
    let near = [TRUE_TAU_S * 1.3, 75.0, 6.0, 7.0, 0.7];
    let start = vector.coordinates(|parameter, _| near.get(parameter).copied());
    let weights = (0..900)
        .map(|k| f64::from(u8::from(!(300..400).contains(&k))))
        .collect();
    let all = RefineConfig::default();
    let config = RefineConfig {
        weights: Some(vec![weights]),
        ..all.clone()
    };
    let refined = refine(&model, &training, std::slice::from_ref(&start), &config).unwrap();
    assert!(refined.mean_square < 1e-12, "{}", refined.mean_square);
    assert!((refined.points[0][0] / TRUE_TAU_S - 1.0).abs() < 1e-5);
    let spoiled = refine(&model, &training, &[start], &all).unwrap();
    assert!(spoiled.mean_square > 0.1);
    let none = refine(&model, &training, &[], &all).unwrap_err();
    assert!(matches!(none, IdentifyError::NothingFinite));
}

#[test]
fn without_a_specific_heat_the_drive_still_heats_with_its_power() {
    let training = [recording("a.csv", triangles(600, 4.2), 0.5)];
    let loss_w_per_m = |keys: &str| {
        let text = format!("{keys}\nsurroundings.ambient_degc = 21.0");
        let model = WienerModel::new(&rod(&text), Rule::LastReversal, &training).unwrap();
        let infos = model.parameters();
        let rise = infos.iter().find(|info| info.name == "lambda_k_per_a2");
        let ParameterState::Fixed(rise_k) = rise.unwrap().state else {
            panic!("nothing fixes the scale of temperature");
        };
        let mut point: Vec<f64> = infos.iter().map(|info| info.bounds.lower).collect();
        point[infos.len() - 1] = rise_k;
        rise_k * model.wiener_params(&point).heat.conductance_w_per_m_k
    };
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
    // At 1 A in the end what comes in goes out.
    assert!(close(loss_w_per_m("rod.resistance_ohm_per_m = 4.3"), 4.3));
    // NiTi's 0.8 µΩ m in the section of the rod.
    let niti = 0.8e-6 / (std::f64::consts::PI * 0.25e-3 * 0.25e-3);
    assert!(close(loss_w_per_m("rod.diameter_mm = 0.5"), niti));
    assert!(close(loss_w_per_m(""), 1.0));
}
