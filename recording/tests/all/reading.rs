//! Accepted forms of files, and how `[columns]` says what is in them.

// Shared functions fail the test too; clippy.toml exempts only functions marked as tests.
#![allow(clippy::unwrap_used, clippy::panic)]

use recording::{
    ColumnKey, ColumnSpec, Columns, Gap, Quantity, ReadOptions, Recording, RecordingParts,
    Resistance, ResistanceSpec, Sampling, parse_csv, read_drive_csv, write_csv,
};

fn read(quantity: Quantity, csv: &str) -> Recording {
    match parse_csv(csv.as_bytes(), "run3.csv", &ReadOptions::new(quantity)) {
        Ok(recording) => recording,
        Err(fault) => panic!("{fault}"),
    }
}

#[test]
fn marks_comments_and_line_ends_are_skipped() {
    let csv = "\u{feff}# rig 2\r\n\r\nTime [ms],Current (mA),Position_UM\r\n  # cold\r\n0,0,1\r\n\
               \"287\", \"500\" ,2";
    let recording = read(Quantity::Current, csv);
    assert_eq!(recording.time_s(), [0.0, 0.287]);
    assert_eq!(recording.drive(), [0.0, 0.5]);
    assert_eq!(recording.output(), [1.0, 2.0]);
    assert_eq!(recording.output_unit(), "um");
    assert_eq!(recording.name(), "run3.csv");
}

#[test]
fn delimiters_are_detected() {
    for delimiter in [",", ";", "\t", "   "] {
        let csv = "time_s|duty|position_mm\n0|0|1\n1|1|2\n".replace('|', delimiter);
        assert_eq!(
            read(Quantity::Duty, &csv).output(),
            [1.0, 2.0],
            "{delimiter:?}"
        );
    }
}

#[test]
fn each_quantity_has_its_column_and_units() {
    let drive = |quantity, header: &str| {
        read(
            quantity,
            &format!("time_s,{header},position_mm\n0,10,0\n1,20,0\n"),
        )
        .drive()
        .to_vec()
    };
    assert_eq!(drive(Quantity::Current, "current_A"), [10.0, 20.0]);
    assert_eq!(drive(Quantity::Current, "current_ma"), [0.01, 0.02]);
    assert_eq!(drive(Quantity::Duty, "duty_%"), [0.1, 0.2]);
    assert_eq!(drive(Quantity::Voltage, "voltage_V"), [10.0, 20.0]);
    assert_eq!(drive(Quantity::Power, "POWER [W]"), [10.0, 20.0]);
    assert_eq!(drive(Quantity::Temperature, "temperature_c"), [10.0, 20.0]);
    assert_eq!(
        drive(Quantity::Temperature, "temperature_k"),
        [10.0 - 273.15, 20.0 - 273.15]
    );
}

#[test]
fn temperatures_are_taken_where_present() {
    let csv = "time_s,current_a,force_n,displacement_mm,position_mm,temperature_degc,ambient_k\n\
               0,0,9,1,5,20,293.15\n1,0,9,2,5,21,293.15\n";
    let recording = read(Quantity::Current, csv);
    assert_eq!(recording.output(), [1.0, 2.0]);
    assert_eq!(recording.temperature_degc(), Some([20.0, 21.0].as_slice()));
    assert_eq!(recording.ambient_degc(), Some([20.0, 20.0].as_slice()));
}

#[test]
fn temperature_drive_needs_no_time_but_takes_it() {
    let recording = read(
        Quantity::Temperature,
        "temperature_degc,position_mm\n90,1\n20,2\n",
    );
    assert_eq!(recording.sampling(), Sampling::Untimed);
    assert_eq!(recording.len(), 2);
    let csv = "time_s,temperature_degc,position_mm\n0,90,1\n1,20,2\n";
    assert_eq!(read(Quantity::Temperature, csv).time_s(), [0.0, 1.0]);
}

#[test]
fn columns_come_from_toml() {
    let text = r#"
        time = "Time"
        drive = 2
        output = { name = "Load (N)", unit = "kN" }
        temperature = { number = 4, unit = "K" }
    "#;
    let columns: Columns = toml::from_str(text).unwrap();
    let expected = Columns {
        time: Some(ColumnSpec::name("Time")),
        drive: Some(ColumnSpec {
            key: ColumnKey::Number(2),
            unit: None,
            full_scale: None,
        }),
        output: Some(ColumnSpec::name("Load (N)").in_unit("kN")),
        temperature: Some(ColumnSpec::number(4).in_unit("K")),
        ..Columns::default()
    };
    assert_eq!(columns, expected);
    assert_eq!(toml::from_str::<Columns>("").unwrap(), Columns::default());
}

#[test]
fn stress_and_resistance_are_found_by_their_names() {
    let csv =
        "temperature_c,displacement_mm,stress_mpa,resistance_ohm\n20,0,50,3.5\n90,1,51.5,2.8\n";
    let recording = read(Quantity::Temperature, csv);
    assert_eq!(recording.stress_pa(), Some([50e6, 51.5e6].as_slice()));
    assert_eq!(
        recording.resistance(),
        Some(&Resistance::Ohm(vec![3.5, 2.8]))
    );
    // A drive that is a stress is no other channel.
    let options = ReadOptions {
        columns: Columns {
            drive: Some(ColumnSpec::name("stress_mpa")),
            ..Columns::default()
        },
        ..ReadOptions::new(Quantity::Temperature)
    };
    let driven = parse_csv(csv.as_bytes(), "run3.csv", &options).unwrap();
    assert_eq!((driven.stress_pa(), driven.drive_unit()), (None, "MPa"));
    assert_eq!(driven.drive(), [50.0, 51.5]);
}

#[test]
fn a_resistance_is_a_voltage_over_a_current() {
    let columns = r#"resistance = { voltage = "u [V]", current = "current_ma" }"#;
    let options = ReadOptions {
        columns: toml::from_str(columns).unwrap(),
        ..ReadOptions::new(Quantity::Current)
    };
    let csv = "time_s,current_ma,u [V],position_mm\n0,0,0,0\n1,200,0.7,0\n2,400,1.2,1\n";
    let recording = parse_csv(csv.as_bytes(), "run3.csv", &options).unwrap();
    assert_eq!(recording.drive(), [0.0, 0.2, 0.4]);
    let ohm = |recording: &Recording| recording.resistance().unwrap().ohm().collect::<Vec<_>>();
    assert_eq!(ohm(&recording)[..2], [None, Some(0.7 / 0.2)]);
    assert_eq!(ohm(&recording.slice(1..3).unwrap()), ohm(&recording)[1..]);
}

#[test]
fn ways_that_stand_side_by_side_follow_one_another() {
    let text = r#"
        drive = { number = 1, unit = "degc" }
        output = { number = 2, unit = "mm" }
        stress = { number = 5, unit = "mpa" }
        [then]
        drive = { number = 3, unit = "k" }
        output = { number = 4, unit = "mm" }
        stress = { number = 5, unit = "mpa" }
    "#;
    let options = ReadOptions {
        columns: toml::from_str(text).unwrap(),
        ..ReadOptions::new(Quantity::Temperature)
    };
    let csv = "20,0,373.15,9,50\n90,8,313.15,1,60\n";
    let recording = parse_csv(csv.as_bytes(), "loop.csv", &options).unwrap();
    assert_eq!(recording.drive(), [20.0, 90.0, 100.0, 40.0]);
    assert_eq!(recording.output(), [0.0, 8.0, 9.0, 1.0]);
    assert_eq!(recording.stress_pa().unwrap(), [50e6, 60e6, 50e6, 60e6]);
}

#[test]
fn resistances_come_from_toml() {
    let spec = |text: &str| toml::from_str::<Columns>(text).map(|columns| columns.resistance);
    let column = |spec| Some(ResistanceSpec::Column(spec));
    assert_eq!(
        spec("resistance = 3").unwrap(),
        column(ColumnSpec::number(3))
    );
    assert_eq!(
        spec("resistance = { name = \"R\", unit = \"ohm\" }").unwrap(),
        column(ColumnSpec::name("R").in_unit("ohm"))
    );
    let fault = spec("resistance = { voltage = 3 }").unwrap_err();
    assert_eq!(
        fault.message(),
        "a resistance needs `voltage` and `current`, or a column of its own"
    );
    assert!(spec("resistance = 1.5").unwrap_err().message().ends_with(
        "a column name, a column number counted from 1, or a table { name or number, unit } or { voltage, \
         current }"
    ));
}

#[test]
fn columns_refuse_what_they_do_not_know() {
    let fault = |text: &str| {
        toml::from_str::<Columns>(text)
            .unwrap_err()
            .message()
            .to_owned()
    };
    assert_eq!(
        fault("dirve = 2"),
        "unknown field `dirve`, expected one of `time`, `drive`, `antagonist`, `output`, `temperature`, `ambient`, `stress`, `resistance`, `then`, `skip`, `decimal`, \
         `strict`, `as_recorded`"
    );
    assert_eq!(
        fault("drive = { name = \"a\", unti = \"mm\" }"),
        "unknown field `unti`, expected one of `name`, `number`, `unit`, `every_s`, `full_scale`"
    );
    for text in [
        "drive = { unit = \"mm\" }",
        "drive = { name = \"a\", number = 1 }",
    ] {
        assert_eq!(fault(text), "a column needs either `name` or `number`");
    }
    for text in ["drive = 0", "drive = { number = 0 }"] {
        assert_eq!(fault(text), "column number 0: columns are counted from 1");
    }
    assert_eq!(
        fault("drive = -1"),
        "column number -1: columns are counted from 1"
    );
    assert_eq!(
        fault("drive = true"),
        "invalid type: boolean `true`, expected a column name, a column number counted from 1, or a \
         table { name or number, unit }"
    );
}

#[test]
fn quantity_comes_from_its_name() {
    #[derive(serde::Deserialize)]
    struct Drive {
        kind: Quantity,
    }
    for quantity in ["current", "duty", "voltage", "power", "temperature"] {
        let drive: Drive = toml::from_str(&format!("kind = \"{quantity}\"")).unwrap();
        assert_eq!(drive.kind.name(), quantity);
    }
}

fn sampling(time_s: &[f64]) -> Sampling {
    timed(time_s).sampling()
}

fn timed(time_s: &[f64]) -> Recording {
    let parts = RecordingParts {
        time_s: Some(time_s.to_vec()),
        drive: vec![0.0; time_s.len()],
        output: vec![0.0; time_s.len()],
        ..RecordingParts::default()
    };
    Recording::new(parts).unwrap()
}

fn is_uniform(time_s: &[f64]) -> bool {
    matches!(sampling(time_s), Sampling::Uniform { .. })
}

#[test]
fn rounded_stamps_are_uniform() {
    let rounded = |k: u32, scale: f64| (0.287 * f64::from(k) * scale).round() / scale;
    for scale in [100.0, 1000.0, 1e6] {
        let stamps: Vec<f64> = (0..2000).map(|k| rounded(k, scale)).collect();
        assert!(is_uniform(&stamps), "{scale}");
    }
    // Six significant digits, as C's %g prints: 3 decimals below 1000 s, 2 above.
    let stamps: Vec<f64> = (0..9000)
        .map(|k| rounded(k, if k < 3485 { 1000.0 } else { 100.0 }))
        .collect();
    assert!(is_uniform(&stamps));
    // A sum that a logger keeps.
    let mut t = 0.0;
    let stamps: Vec<f64> = std::iter::repeat_with(|| {
        t += 0.1;
        t
    })
    .take(100_000)
    .collect();
    assert!(is_uniform(&stamps));
}

#[test]
fn jitter_beyond_the_printed_digits_is_kept() {
    assert_eq!(
        sampling(&[1.2, 1.4, 1.599, 1.803, 1.999]),
        Sampling::Jittered {
            median_dt_s: 1.599 - 1.4,
            min_dt_s: 1.999 - 1.803,
            max_dt_s: 1.803 - 1.599
        }
    );
    assert!(!is_uniform(&[0.0, 1.0, 2.0, 3.0, 5.0]), "a lost sample");
    // Every step is 0.2 s within a millisecond, but the clock gains half a second.
    let drifting: Vec<f64> = (0..1000)
        .scan(0.0, |t, k| {
            *t += if k < 500 { 0.2 } else { 0.201 };
            Some((*t * 1000.0_f64).round() / 1000.0)
        })
        .collect();
    assert!(!is_uniform(&drifting));
}

#[test]
fn gaps_are_reported() {
    let recording = timed(&[0.0, 1.0, 2.0, 3.0, 9.0, 10.0, 14.0, 15.0]);
    assert_eq!(
        recording.gaps(),
        [Gap {
            index: 3,
            start_s: 3.0,
            dt_s: 6.0
        }]
    );
}

#[test]
fn the_input_of_a_static_loop_keeps_its_unit() {
    let options = ReadOptions {
        columns: Columns {
            drive: Some(ColumnSpec::number(1).in_unit("V")),
            output: Some(ColumnSpec::number(2)),
            ..Columns::default()
        },
        ..ReadOptions::new(Quantity::Temperature)
    };
    let recording = parse_csv("0,0\n0.05,0\n".as_bytes(), "loop", &options).unwrap();
    assert_eq!(recording.drive(), [0.0, 0.05]);
    assert_eq!(recording.drive_unit(), "V");
    assert_eq!(recording.sampling(), Sampling::Untimed);

    let mut csv = Vec::new();
    write_csv(&recording, &mut csv).unwrap();
    assert!(csv.starts_with(b"input [V],displacement [1]\n"));
    let named = ReadOptions {
        columns: Columns {
            drive: Some(ColumnSpec::name("input_v")),
            ..Columns::default()
        },
        ..ReadOptions::new(Quantity::Temperature)
    };
    assert_eq!(
        parse_csv(csv.as_slice(), "loop", &named).unwrap(),
        recording
    );
}

#[test]
fn a_drive_needs_no_output() {
    let folder = std::env::temp_dir().join(format!("drive-only-{}", std::process::id()));
    std::fs::write(&folder, "time_s,current_a,ambient_c\n0,1.5,20\n0.5,0,21\n").unwrap();
    let recording = read_drive_csv(&folder, &ReadOptions::default());
    std::fs::remove_file(&folder).unwrap();
    let recording = recording.unwrap();
    assert_eq!(recording.drive(), [1.5, 0.0]);
    assert_eq!(recording.ambient_degc(), Some([20.0, 21.0].as_slice()));
    assert_eq!(recording.output(), [0.0, 0.0]);
    assert_eq!(recording.output_unit(), "1");
}
