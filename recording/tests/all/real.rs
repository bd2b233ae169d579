//! Recordings measured by others. They are not part of this project: where they are missing, the
//! tests say so and pass.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(clippy::panic)]

use std::io::Write;
use std::path::PathBuf;

use recording::{
    ColumnSpec, Columns, NoiseConfig, Quantity, ReadOptions, Recording, Sampling, Side, Warning,
    clipping, inspect, noise_floor, quantization_step, read_csv, repeat_floor, resample,
};

/// The file, or a loud skip: on stderr itself, since the test harness hides what is printed.
fn real(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../shared/recordings"
    ))
    .join(name);
    if path.is_file() {
        return Some(path);
    }
    let note = format!("\nSKIPPED: ../shared/recordings/{name} is missing; nothing was tested\n");
    std::io::stderr().write_all(note.as_bytes()).ok();
    None
}

fn read(name: &str, options: &ReadOptions) -> Option<Recording> {
    real(name).map(|path| read_csv(path, options).unwrap_or_else(|fault| panic!("{fault}")))
}

fn name(name: &str) -> Option<ColumnSpec> {
    Some(ColumnSpec::name(name))
}

fn assert_close(found: f64, expected: f64) {
    assert!(
        (found - expected).abs() <= 1e-12 * expected.abs(),
        "{found} is not {expected}"
    );
}

#[test]
fn bologna_open_loop_reads_with_defaults() {
    for (file, n_samples) in [
        ("ramp01", 5000),
        ("ramp02", 10000),
        ("step01", 5000),
        ("step02", 7000),
    ] {
        let options = ReadOptions::new(Quantity::Duty);
        let Some(recording) = read(&format!("bologna/{file}.csv"), &options) else {
            return;
        };
        assert_eq!(recording.len(), n_samples, "{file}");
        assert_eq!(recording.output_unit(), "mm");
        assert!(recording.temperature_degc().is_none() && recording.ambient_degc().is_none());
        match recording.sampling() {
            Sampling::Uniform { dt_s } => assert_close(dt_s, 0.01),
            other => panic!("{file}: {other:?}"),
        }
        assert!(recording.gaps().is_empty());
        recording.check_identifiable().unwrap();
    }
}

#[test]
fn bologna_repeats_to_a_tenth_of_a_millimeter() {
    let options = ReadOptions::new(Quantity::Duty);
    let runs = ["ramp01", "ramp02", "step01", "step02"];
    let runs: Option<Vec<Recording>> = runs
        .iter()
        .map(|file| read(&format!("bologna/{file}.csv"), &options))
        .collect();
    let Some(runs) = runs else { return };
    // Of four runs two begin with the same drive, for 30 s: 0.17 mm apart beside an offset, ten times the noise.
    let floor = repeat_floor(&runs).unwrap();
    assert_eq!(floor.pairs.len(), 1);
    let pair = &floor.pairs[0];
    assert!(pair.second.recording.ends_with("step02.csv"));
    assert!((pair.first.end_s - 30.0).abs() < 0.1);
    assert!((floor.rms().unwrap() / 0.17 - 1.0).abs() < 0.1);
    assert!((floor.nearest().unwrap() / 0.085 - 1.0).abs() < 0.1);
    assert!(!floor.is_noise());
}

#[test]
fn boston_repeats_to_half_a_degree() {
    for (file, drive) in [("c1", "pwm_duty_limb0_rev"), ("c2", "pwm_duty_limb0_fwd")] {
        let columns = Columns {
            time: name("t_s"),
            drive: name(drive),
            output: name("limb0_angle_deg"),
            ..Columns::default()
        };
        let options = ReadOptions {
            columns,
            ..ReadOptions::new(Quantity::Duty)
        };
        let Some(run) = read(&format!("boston/{file}.csv"), &options) else {
            return;
        };
        // Two equal pulses, 189 s apart; the recording begins with the first, so that nothing is known of before.
        let floor = repeat_floor(&[run]).unwrap();
        assert_eq!(
            (floor.pairs.len(), floor.first_cycles.len()),
            (0, 1),
            "{file}"
        );
        let apart = floor.first_cycles[0].apart.rms;
        assert!((0.7..1.0).contains(&apart), "{file}: {apart}");
    }
}

#[test]
fn bologna_closed_loop_has_no_drive() {
    let Some(path) = real("bologna/closed-loop-sine.csv") else {
        return;
    };
    let fault = read_csv(&path, &ReadOptions::new(Quantity::Duty))
        .unwrap_err()
        .to_string();
    let expected = ":1: drive = \"duty\": no such column; expected drive under [columns] to be one \
                    of the 3 present: time_s, reference_mm, position_mm";
    assert_eq!(fault, format!("{}{expected}", path.display()));
}

#[test]
fn boston_limb_is_jittered_with_a_temperature() {
    let columns = Columns {
        time: name("t_s"),
        drive: name("pwm_duty_limb0_rev"),
        output: name("limb0_angle_deg"),
        temperature: Some(ColumnSpec::name("MCPtemp_0").in_unit("degc")),
        ..Columns::default()
    };
    let options = ReadOptions {
        columns,
        ..ReadOptions::new(Quantity::Duty)
    };
    let Some(recording) = read("boston/c1.csv", &options) else {
        return;
    };
    assert_eq!(recording.len(), 1036);
    assert_eq!(recording.output_unit(), "deg");
    assert_close(recording.temperature_degc().unwrap()[0], 20.81);
    assert_close(recording.drive()[0], 0.35);
    match recording.sampling() {
        Sampling::Jittered {
            median_dt_s,
            min_dt_s,
            max_dt_s,
        } => {
            assert!((0.15..0.25).contains(&median_dt_s), "{median_dt_s}");
            assert!(min_dt_s < median_dt_s && median_dt_s < max_dt_s);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn morphing_wing_reads_by_number_without_header_and_time() {
    let columns = Columns {
        drive: Some(ColumnSpec::number(1).in_unit("V")),
        output: Some(ColumnSpec::number(2)),
        ..Columns::default()
    };
    let mut options = ReadOptions {
        columns,
        ..ReadOptions::new(Quantity::Voltage)
    };
    let Some(path) = real("morphing-wing/training.csv") else {
        return;
    };
    let fault = read_csv(&path, &options).unwrap_err().to_string();
    assert!(
        fault.contains(":1: time = \"time_s\": the file has no header"),
        "{fault}"
    );

    options.allow_untimed = true;
    let recording = read_csv(&path, &options).unwrap();
    assert_eq!((recording.len(), recording.output_unit()), (358, "1"));
    assert_eq!(recording.sampling(), Sampling::Untimed);
    assert!(recording.time_s().is_empty());
    assert_close(recording.drive()[1], 0.05);
    recording.check_identifiable().unwrap();
}

#[test]
fn flexinol_loops_are_static_data_between_spaces() {
    let columns = Columns {
        drive: Some(ColumnSpec::name("temperature").in_unit("degC")),
        output: name("Strain"),
        ..Columns::default()
    };
    let options = ReadOptions {
        columns,
        ..ReadOptions::new(Quantity::Temperature)
    };
    for stress in [50, 100, 150] {
        let file = format!("flexinol/filtered_data_{stress}MPa.txt");
        let Some(recording) = read(&file, &options) else {
            return;
        };
        assert_eq!(
            (recording.len(), recording.output_unit()),
            (499, "1"),
            "{file}"
        );
        assert_eq!(recording.sampling(), Sampling::Untimed);
        let hottest = recording
            .drive()
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        assert!((80.0..200.0).contains(&hottest), "{hottest} °C");
    }
}

#[test]
fn mk_zuk_static_loop_reads_with_units_in_brackets() {
    let columns = Columns {
        drive: name("Izmg [A]"),
        output: name("dLzmg0 [mm]"),
        temperature: Some(ColumnSpec::name("tempg [stC]").in_unit("degc")),
        ..Columns::default()
    };
    let options = ReadOptions {
        columns,
        allow_untimed: true,
        ..ReadOptions::new(Quantity::Current)
    };
    let Some(recording) = read("mk-zuk/static.csv", &options) else {
        return;
    };
    assert_eq!((recording.len(), recording.output_unit()), (41, "mm"));
    assert_close(recording.drive()[3], 0.062);
    assert_close(recording.temperature_degc().unwrap()[40], 150.792);

    // The same loop over temperature; its first column carries the byte-order mark.
    let columns = Columns {
        drive: Some(ColumnSpec::name("tempg [stC]").in_unit("degc")),
        output: name("izadg_a"),
        ..Columns::default()
    };
    let options = ReadOptions {
        columns,
        ..ReadOptions::new(Quantity::Temperature)
    };
    let recording = read("mk-zuk/static.csv", &options).unwrap();
    assert_eq!((recording.len(), recording.output_unit()), (41, "A"));
}

#[test]
fn tamu_muscle_repeats_a_time_stamp() {
    let columns = Columns {
        time: name("t_s"),
        drive: name("power_col_as_labelled_A"),
        output: name("load_N"),
        ..Columns::default()
    };
    let options = ReadOptions {
        columns,
        ..ReadOptions::default()
    };
    let Some(path) = real("tamu-muscle/P25_duty_phase_50_m25.csv") else {
        return;
    };
    let found = read_csv(&path, &options).unwrap();
    let said: Vec<String> = found
        .adaptations()
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(said, ["left out: the row stands twice (7 lines, first 72)"]);
    let strict = ReadOptions {
        columns: Columns {
            strict: true,
            ..options.columns.clone()
        },
        ..options
    };
    let fault = read_csv(&path, &strict).unwrap_err().to_string();
    let expected =
        ":72: t_s = 7 after 7 in the row before; expected time to rise; 7 such faults in all";
    assert_eq!(fault, format!("{}{expected}", path.display()));
}

#[test]
fn sma_react_cycles_read_by_number() {
    let columns = Columns {
        drive: Some(ColumnSpec::number(1).in_unit("degc")),
        output: Some(ColumnSpec::number(2)),
        ..Columns::default()
    };
    let options = ReadOptions {
        columns,
        ..ReadOptions::new(Quantity::Temperature)
    };
    let Some(recording) = read("sma-react/nitico-150-MPa.txt", &options) else {
        return;
    };
    assert_eq!(recording.len(), 314);
}

#[test]
fn text_of_a_test_machine_is_refused_at_its_header() {
    let Some(path) = real("sma-react/mts_3cycle.txt") else {
        return;
    };
    let fault = read_csv(&path, &ReadOptions::new(Quantity::Temperature))
        .unwrap_err()
        .to_string();
    assert!(
        fault.contains(":6: drive = \"temperature_degc\": no such column"),
        "{fault}"
    );
}

#[test]
fn bologna_potentiometer_has_its_step_and_a_floor_of_its_order() {
    for file in ["ramp01", "ramp02", "step01", "step02"] {
        let options = ReadOptions::new(Quantity::Duty);
        let Some(recording) = read(&format!("bologna/{file}.csv"), &options) else {
            return;
        };
        let found = inspect(&recording);
        let step_mm = found.output.quantization_step.unwrap();
        assert!(
            (step_mm / 0.0206 - 1.0).abs() < 0.01,
            "{file}: {step_mm} mm"
        );
        let floor = found.noise_floor.unwrap();
        let lower_mm = floor.lower();
        assert!(
            (0.25..1.0).contains(&(lower_mm / step_mm)),
            "{file}: {floor:?}"
        );
        // 50 to 100 s, no hold of 60 s: nothing more can be said.
        assert!(floor.is_lower_bound_only());
        let warnings = found.warnings();
        let lower_only = |warning: &Warning| matches!(warning, Warning::LowerBoundOnly { .. });
        assert!(warnings.iter().any(lower_only), "{warnings:?}");
        let coarse = |warning: &Warning| matches!(warning, Warning::CoarseSteps { .. });
        assert!(warnings.iter().any(coarse), "{warnings:?}");
        assert_eq!(
            (found.gaps.len(), found.output.flat.len()),
            (0, 0),
            "{file}"
        );
        assert!(found.rest_samples > 100, "{file}: {}", found.rest_samples);

        // At a tenth of the rate white noise keeps √0.08 to √0.1 of itself; q/√12 of the old step
        // is no part of it any more.
        let slow = resample(&recording, 0.1).unwrap();
        let config = NoiseConfig::default();
        let slow_mm = noise_floor(&slow, config)
            .unwrap()
            .differences
            .robust_standard_deviation;
        let fast_mm = floor.differences.robust_standard_deviation;
        assert!(slow_mm < fast_mm, "{file}: {slow_mm} mm after {fast_mm} mm");
    }
}

#[test]
fn bologna_closed_loop_has_the_same_step() {
    let columns = Columns {
        drive: Some(ColumnSpec::name("reference_mm").in_unit("w")),
        ..Columns::default()
    };
    // No drive was saved; the reference stands in for it, in a unit that passes.
    let options = ReadOptions {
        columns,
        ..ReadOptions::new(Quantity::Power)
    };
    for file in ["sine", "square80", "stairs"] {
        let Some(recording) = read(&format!("bologna/closed-loop-{file}.csv"), &options) else {
            return;
        };
        let step_mm = quantization_step(recording.output()).unwrap();
        assert!(
            (step_mm / 0.0206 - 1.0).abs() < 0.01,
            "{file}: {step_mm} mm"
        );
    }
}

#[test]
fn mk_zuk_thermometer_ends_at_150_8() {
    for (drive, output, temperature, side) in [
        ("Izmg [A]", "dLzmg0 [mm]", "tempg [stC]", Side::Highest),
        ("Izmd [A]", "dLzmd0 [mm]", "tempd [stC]", Side::Highest),
    ] {
        let columns = Columns {
            drive: name(drive),
            output: name(output),
            temperature: Some(ColumnSpec::name(temperature).in_unit("degc")),
            ..Columns::default()
        };
        let options = ReadOptions {
            columns,
            allow_untimed: true,
            ..ReadOptions::new(Quantity::Current)
        };
        let Some(recording) = read("mk-zuk/static.csv", &options) else {
            return;
        };
        let flat = clipping(recording.temperature_degc().unwrap());
        assert_eq!(flat.len(), 1, "{flat:?}");
        assert_close(flat[0].at, 150.792);
        assert_eq!(
            (flat[0].side, flat[0].samples, flat[0].occasions),
            (side, 5, 1)
        );
        assert_eq!(clipping(recording.output()), []);
        let warnings = inspect(&recording).warnings();
        assert!(warnings.contains(&Warning::Untimed), "{warnings:?}");
        let flat = |warning: &&Warning| matches!(warning, Warning::Flat { .. });
        let text: Vec<_> = warnings
            .iter()
            .filter(flat)
            .map(Warning::to_string)
            .collect();
        assert!(text[0].starts_with("temperature is flat at its highest, 150.8 degC: 5 samples"));
    }
}

#[test]
fn boston_thermocouple_has_a_step_of_a_sixteenth_of_a_degree() {
    let columns = Columns {
        time: name("t_s"),
        drive: name("pwm_duty_limb0_rev"),
        output: name("limb0_angle_deg"),
        temperature: Some(ColumnSpec::name("MCPtemp_0").in_unit("degc")),
        ..Columns::default()
    };
    let options = ReadOptions {
        columns,
        ..ReadOptions::new(Quantity::Duty)
    };
    let Some(recording) = read("boston/c1.csv", &options) else {
        return;
    };
    let found = inspect(&recording);
    assert_eq!(found.output.quantization_step, None);
    let step_k = found
        .temperature
        .as_ref()
        .unwrap()
        .quantization_step
        .unwrap();
    assert!((step_k / 0.0625 - 1.0).abs() < 0.001, "{step_k} K");
    let jitter = |warning: &Warning| matches!(warning, Warning::Jitter { .. });
    assert!(found.warnings().iter().any(jitter));
}

/// The recording of the speed comparison, beside the other ones: no converter, white noise.
#[test]
fn unquantized_numbers_of_six_decimals_have_no_step() {
    let Some(recording) = read("../performance/recording.csv", &ReadOptions::default()) else {
        return;
    };
    let found = inspect(&recording);
    assert_eq!(found.output.quantization_step, None);
    // Generated with 0.010708 mm.
    let floor = found.noise_floor.unwrap();
    assert!((floor.lower() / 0.010_708 - 1.0).abs() < 0.1, "{floor:?}");
}

/// Generated, part of this project: noise of 5 µm, a converter of 5 mm / 4096.
#[test]
fn bundled_recording_has_its_step_and_noise() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../sma-cli/bundled/train.csv");
    let Ok(recording) = read_csv(path, &ReadOptions::default()) else {
        let note = "\nSKIPPED: sma-cli/bundled/train.csv is missing; nothing was tested\n";
        std::io::stderr().write_all(note.as_bytes()).ok();
        return;
    };
    let found = inspect(&recording);
    let step_mm = found.output.quantization_step.unwrap();
    assert!(
        (step_mm / (5.0 / 4096.0) - 1.0).abs() < 1e-4,
        "{step_mm} mm"
    );
    let floor = found.noise_floor.unwrap();
    assert!(
        floor.lower() <= 0.0052 && floor.upper().unwrap() >= 0.0048,
        "{floor:?}"
    );
}
