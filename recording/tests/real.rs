//! Recordings measured by others. They are not part of this project: where they are missing, the
//! tests say so and pass.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(clippy::panic)]

use std::io::Write;
use std::path::PathBuf;

use recording::{ColumnSpec, Columns, Quantity, ReadOptions, Recording, Sampling, read_csv};

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
    let fault = read_csv(&path, &options).unwrap_err().to_string();
    let expected = ":72: t_s = 7 after 7 in the row before; expected time to rise";
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
fn text_of_a_test_machine_is_refused_at_its_first_line() {
    let Some(path) = real("sma-react/mts_3cycle.txt") else {
        return;
    };
    let fault = read_csv(&path, &ReadOptions::new(Quantity::Temperature))
        .unwrap_err()
        .to_string();
    assert!(
        fault.contains(":1: drive = \"temperature_degc\": no such column"),
        "{fault}"
    );
}
