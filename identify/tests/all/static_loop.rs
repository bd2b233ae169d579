//! Data without time: the loop alone, on measured and on generated recordings.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it reads its data"
)]

use std::ops::ControlFlow;

use identify::{Fit, FitConfig, LoopModel, OneWay, Rod, fit};
use recording::{Quantity, Recording, RecordingParts, read_csv};
use rig_files::rod_file;
use wiener::hysteresis::{Branch, Hysteresis, LimitingLoop, LoopParams, Rule, SineProximity};

fn fitted(rod: &Rod, rule: Rule, training: &[Recording]) -> Fit {
    let model = LoopModel::new(rod, rule, training).unwrap();
    fit(&model, training, &FitConfig::default(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

/// Training error as a share of the output's range.
fn share_of_range(fit: &Fit, training: &[Recording]) -> f64 {
    let outputs = || training.iter().flat_map(Recording::output).copied();
    let range =
        outputs().fold(f64::NEG_INFINITY, f64::max) - outputs().fold(f64::INFINITY, f64::min);
    fit.train_rmse / range
}

const STATIC: &str = "[drive]\nkind = \"temperature\"\n";

#[test]
fn first_order_reversal_curves_of_a_morphing_wing() {
    let Some(path) = fixtures::shared::path("recordings/morphing-wing/training.csv") else {
        return;
    };
    // No header, no time; the loop's input is the voltage of the source.
    let columns = "[columns]\ndrive = { number = 1, unit = \"V\" }\noutput = 2\n";
    let rod = rod_file::parse("rod.toml", &format!("{STATIC}{columns}")).unwrap();
    let training = [read_csv(&path, &rod.read_options()).unwrap()];
    let fit = fitted(&rod, Rule::LastReversal, &training);
    assert!(fit.converged());
    assert_eq!(fit.parameter("loop_half_width").unwrap().info.unit, "V");
    // 2.466 % of the range.
    assert!(share_of_range(&fit, &training) < 0.0247);
}

#[test]
fn static_loop_of_a_wire_under_constant_load() {
    let Some(path) = fixtures::shared::path("recordings/mk-zuk/static.csv") else {
        return;
    };
    // The way up and the way down stand side by side in the file: temperature and displacement of each.
    let columns = "[columns]\ndrive = { number = 5, unit = \"degc\" }\noutput = { number = 4, unit = \"mm\" }\n\
                   [columns.then]\ndrive = { number = 10, unit = \"degc\" }\noutput = { number = 9, unit = \"mm\" }\n";
    let rod = rod_file::parse("rod.toml", &format!("{STATIC}{columns}")).unwrap();
    let training = [read_csv(&path, &rod.read_options()).unwrap()];
    let fit = fitted(&rod, Rule::LastReversal, &training);
    assert!(fit.converged());
    // 3.344 % of the range.
    assert!(share_of_range(&fit, &training) < 0.0335);
}

#[test]
fn nested_minor_loops_tell_the_memories_apart() {
    let input = nested_loops();
    let material = Hysteresis::new(
        LimitingLoop::new([LoopParams {
            loop_center_degc: 70.0,
            loop_half_width_k: 8.0,
            loop_spread_k: 6.0,
            ..LoopParams::default()
        }])
        .unwrap(),
        SineProximity::new([0.8]).unwrap(),
        Rule::Nested,
    );
    let mut memory = material.on_limiting_curve(Branch::Cooling, [input[0]]);
    let output = input
        .iter()
        .map(|&input| 5.0 * material.commit(&mut memory, [input])[0])
        .collect();
    let training = [static_recording(input, output)];
    let rod = rod_file::parse("rod.toml", STATIC).unwrap();

    let nested = fitted(&rod, Rule::Nested, &training);
    assert!(share_of_range(&nested, &training) < 1e-6);
    let width = nested.parameter("loop_half_width_k").unwrap().values[0];
    assert!((width - 8.0).abs() < 1e-4, "{width}");

    let last = fitted(&rod, Rule::LastReversal, &training);
    let share = share_of_range(&last, &training);
    // 1.255 % of the range, without any noise.
    assert!((0.012..0.013).contains(&share), "{share}");
}

/// Down and up between the limiting curves in loops within loops, each closed before the next, °C.
fn nested_loops() -> Vec<f64> {
    let turns: [f64; 15] = [
        20.0, 110.0, 60.0, 78.0, 66.0, 74.0, 66.0, 78.0, 60.0, 84.0, 64.0, 80.0, 64.0, 84.0, 20.0,
    ];
    let mut input = vec![turns[0]];
    for pair in turns.windows(2) {
        let steps = ((pair[1] - pair[0]).abs() / 0.5).round();
        input
            .extend((1..=steps as usize).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / steps));
    }
    input
}

fn static_recording(drive: Vec<f64>, output: Vec<f64>) -> Recording {
    Recording::new(RecordingParts {
        name: "static".to_owned(),
        drive_quantity: Quantity::Temperature,
        drive,
        output_unit: "mm".to_owned(),
        output,
        ..RecordingParts::default()
    })
    .unwrap()
}

/// A branch of a loop of center 20 °C and half width 3 K, over an input.
fn branch(input: &[f64], start: Branch) -> Recording {
    let material = Hysteresis::new(
        LimitingLoop::new([LoopParams {
            loop_center_degc: 20.0,
            loop_half_width_k: 3.0,
            loop_spread_k: 2.0,
            ..LoopParams::default()
        }])
        .unwrap(),
        SineProximity::new([0.8]).unwrap(),
        Rule::LastReversal,
    );
    let mut memory = material.on_limiting_curve(start, [input[0]]);
    let output = input
        .iter()
        .map(|&degc| 5.0 * material.commit(&mut memory, [degc])[0] + 1.0)
        .collect();
    Recording::new(RecordingParts {
        name: "branch.csv".to_owned(),
        drive_quantity: Quantity::Temperature,
        drive: input.to_vec(),
        output_unit: "mm".to_owned(),
        output,
        ..RecordingParts::default()
    })
    .unwrap()
}

#[test]
fn one_branch_has_a_center_and_no_width() {
    // A thermometer that trembles turns nothing.
    let rising: Vec<f64> = (0..400)
        .map(|k| -40.0 + 0.3 * f64::from(k) + 0.5 * f64::from(k % 2))
        .collect();
    let falling: Vec<f64> = rising.iter().rev().copied().collect();
    let rod = rod_file::parse("rod.toml", STATIC).unwrap();
    for (input, start, way, center_degc) in [
        (&rising, Branch::Heating, OneWay::Heating, 23.0),
        (&falling, Branch::Cooling, OneWay::Cooling, 17.0),
    ] {
        let training = [branch(input, start)];
        let model = LoopModel::new(&rod, Rule::LastReversal, &training).unwrap();
        assert_eq!(model.one_way(), Some(way));
        assert!(model.knows_one_branch());
        let fit = fitted(&rod, Rule::LastReversal, &training);
        assert!(fit.converged());
        let half_width = fit.parameter("loop_half_width_k").unwrap();
        assert_eq!(half_width.intervals, [None]);
        let center = fit.parameter("loop_center_degc").unwrap();
        assert!((center.values[0] - center_degc).abs() < 0.5, "{center:?}");
    }
    // Both ways there is a loop, and who knows its width may say so.
    let both: Vec<f64> = rising.iter().chain(&falling).copied().collect();
    let training = [branch(&both, Branch::Heating)];
    let model = LoopModel::new(&rod, Rule::LastReversal, &training).unwrap();
    assert!(model.one_way().is_none() && !model.knows_one_branch());
    let known = format!("{STATIC}[model]\nloop_half_width_k = {{ fixed = 3.0 }}\n");
    let known = rod_file::parse("rod.toml", &known).unwrap();
    let training = [branch(&rising, Branch::Heating)];
    let model = LoopModel::new(&known, Rule::LastReversal, &training).unwrap();
    assert!(model.one_way().is_none() && !model.knows_one_branch());
}
