//! The exact text of every fault.

use std::io::{self, Read};

use recording::{
    ColumnSpec, Columns, Quantity, ReadOptions, Recording, RecordingError, RecordingParts,
    Resistance, parse_csv, read_csv,
};

fn text(result: Result<Recording, RecordingError>) -> String {
    match result {
        Ok(recording) => format!("read: {recording:?}"),
        Err(fault) => fault.to_string(),
    }
}

/// Error text of reading `csv` as `run3.csv` with default columns.
fn fault_of(quantity: Quantity, csv: impl AsRef<[u8]>) -> String {
    text(parse_csv(
        csv.as_ref(),
        "run3.csv",
        &ReadOptions::new(quantity),
    ))
}

fn fault(csv: &str) -> String {
    fault_of(Quantity::Current, csv)
}

fn fault_with(columns: Columns, csv: &str) -> String {
    let options = ReadOptions {
        columns,
        ..ReadOptions::default()
    };
    text(parse_csv(csv.as_bytes(), "run3.csv", &options))
}

const HEADER: &str = "time_s,current_a,displacement_mm\n";

fn rows(rows: &str) -> String {
    fault(&format!("{HEADER}{rows}"))
}

#[test]
fn unreadable() {
    let fault = read_csv("no-such-folder/run3.csv", &ReadOptions::default()).unwrap_err();
    assert_eq!(fault.to_string(), "no-such-folder/run3.csv: cannot be read");
    let source = std::error::Error::source(&fault).unwrap();
    assert_eq!(
        source.downcast_ref::<io::Error>().unwrap().kind(),
        io::ErrorKind::NotFound
    );
}

#[test]
fn unreadable_half_way() {
    struct Broken;
    impl Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::ErrorKind::TimedOut.into())
        }
    }
    let file = format!("{HEADER}0,0,0\n");
    let reader = file.as_bytes().chain(Broken);
    let result = parse_csv(reader, "run3.csv", &ReadOptions::default());
    assert_eq!(text(result), "run3.csv: cannot be read");
}

#[test]
fn empty() {
    for csv in ["", "\n", "\u{feff}", "# a comment\r\n  \r\n"] {
        assert_eq!(
            fault(csv),
            "run3.csv: empty; expected a header line and at least 2 rows",
            "{csv:?}"
        );
    }
}

#[test]
fn too_few_samples() {
    assert_eq!(rows(""), "run3.csv: rows of data: 0; expected at least 2");
    assert_eq!(
        rows("0,0,0"),
        "run3.csv: rows of data: 1; expected at least 2"
    );
    let none = Recording::new(RecordingParts {
        name: "run".to_owned(),
        ..Default::default()
    });
    assert_eq!(text(none), "run: rows of data: 0; expected at least 2");
}

#[test]
fn too_many_samples() {
    let options = ReadOptions {
        max_samples: 2,
        ..ReadOptions::default()
    };
    let csv = format!("# three\n{HEADER}0,0,0\n1,0,0\n2,0,0\n");
    assert_eq!(
        text(parse_csv(csv.as_bytes(), "run3.csv", &options)),
        "run3.csv:5: more than 2 samples; expected a shorter recording, or a higher max_samples"
    );
}

#[test]
fn line_too_long() {
    let mut csv = HEADER.as_bytes().to_vec();
    csv.resize(3 << 20, b'0');
    assert_eq!(
        fault_of(Quantity::Current, csv),
        "run3.csv:2: line of more than 1048576 bytes; expected CSV text"
    );
}

#[test]
fn not_utf8() {
    assert_eq!(
        fault_of(
            Quantity::Current,
            [HEADER.as_bytes(), b"0,0,0\n1,\xb0,0\n"].concat()
        ),
        "run3.csv:3: byte 3 of the line is not UTF-8; expected text in UTF-8"
    );
    assert_eq!(
        fault_of(Quantity::Current, b"\xff\xfet\0i\0m\0e\0_\0s\0\n\0"),
        "run3.csv:1: byte 1 of the line is not UTF-8; expected text in UTF-8"
    );
}

#[test]
fn no_header() {
    assert_eq!(
        fault("0,0,0\n1,0,0\n"),
        "run3.csv:1: time = \"time_s\": the file has no header; expected a header line, or the \
         number of the column under [columns], such as time = 1"
    );
    let columns = Columns {
        time: Some(ColumnSpec::number(1).in_unit("s")),
        drive: Some(ColumnSpec::name("Izadg")),
        ..Columns::default()
    };
    assert_eq!(
        fault_with(columns, "0,0,0\n"),
        "run3.csv:1: drive = \"Izadg\": the file has no header; expected a header line, or the \
         number of the column under [columns], such as drive = 1"
    );
}

#[test]
fn missing_column() {
    assert_eq!(
        fault("# rig 2\ntime_s,duty,position_mm\n"),
        "run3.csv:2: drive = \"current_a\": no such column; expected drive under [columns] to be \
         one of the 3 present: time_s, duty, position_mm"
    );
    assert_eq!(
        fault("t_s,current_a,position_mm\n"),
        "run3.csv:1: time = \"time_s\": no such column; expected time under [columns] to be one of \
         the 3 present: t_s, current_a, position_mm"
    );
    let named = Columns {
        output: Some(ColumnSpec::name("angle")),
        ..Columns::default()
    };
    assert_eq!(
        fault_with(named, HEADER),
        "run3.csv:1: output = \"angle\": no such column; expected output under [columns] to be one \
         of the 3 present: time_s, current_a, displacement_mm"
    );
    for number in [0, 4] {
        let columns = Columns {
            output: Some(ColumnSpec::number(number)),
            ..Columns::default()
        };
        assert_eq!(
            fault_with(columns, HEADER),
            format!(
                "run3.csv:1: output = {number}: no such column; expected output under [columns] to \
                 be one of the 3 present: time_s, current_a, displacement_mm"
            )
        );
    }
}

#[test]
fn missing_column_lists_no_more_than_a_reader_wants() {
    let header = vec!["x".repeat(100); 1000].join(",");
    let fault = fault(&header);
    assert!(fault.len() < 1500, "{fault}");
    assert!(fault.ends_with("…, …"), "{fault}");
}

#[test]
fn doubled_column() {
    assert_eq!(
        fault("time_s,current_a,Current [A],displacement_mm\n"),
        "run3.csv:1: drive = \"current_a\": several columns fit, current_a (column 2), Current [A] \
         (column 3); expected one, give its name or number under [columns]"
    );
    assert_eq!(
        fault("time_s,current_a,position_mm,position_2_mm\n"),
        "run3.csv:1: output = \"displacement_mm\": several columns fit, position_mm (column 3), \
         position_2_mm (column 4); expected one, give its name or number under [columns]"
    );
}

#[test]
fn shared_column() {
    let columns = Columns {
        output: Some(ColumnSpec::name("current_a")),
        ..Columns::default()
    };
    assert_eq!(
        fault_with(columns, HEADER),
        "run3.csv:1: current_a is both drive and output; expected different columns"
    );
}

#[test]
fn missing_unit() {
    let named = |unit: Option<&str>| Columns {
        time: Some(ColumnSpec {
            unit: unit.map(str::to_owned),
            ..ColumnSpec::name("t")
        }),
        ..Columns::default()
    };
    let csv = "t,current_a,displacement_mm\n0,0,0\n1,0,0\n";
    assert_eq!(
        fault_with(named(None), csv),
        "run3.csv:1: time = t: no unit; expected s, ms, us, min or h at the end of its name, or as unit under \
         [columns]"
    );
    assert!(fault_with(named(Some("s")), csv).starts_with("read:"));
    let numbered = Columns {
        time: Some(ColumnSpec::number(1).in_unit("s")),
        drive: Some(ColumnSpec::number(2)),
        output: Some(ColumnSpec::number(3)),
        ..Columns::default()
    };
    assert_eq!(
        fault_with(numbered, "0,0,0\n"),
        "run3.csv:1: drive = column 2: no unit; expected a or ma at the end of its name, or as \
         unit under [columns]"
    );
}

#[test]
fn wrong_unit() {
    let columns = Columns {
        time: Some(ColumnSpec::name("time_mm")),
        ..Columns::default()
    };
    assert_eq!(
        fault_with(columns, "time_mm,current_a,displacement_mm\n"),
        "run3.csv:1: time = time_mm: unit \"mm\"; expected s, ms, us, min or h at the end of its name, or as \
         unit under [columns]"
    );
    let columns = Columns {
        temperature: Some(ColumnSpec::name("tempg [stC]")),
        ..Columns::default()
    };
    assert_eq!(
        fault_with(columns, "time_s,current_a,displacement_mm,tempg [stC]\n"),
        "run3.csv:1: temperature = tempg [stC]: unit \"stC\"; expected degc, k or degf at the end of its \
         name, or as unit under [columns]"
    );
    let columns = Columns {
        drive: Some(ColumnSpec::name("duty_a")),
        ..Columns::default()
    };
    let options = ReadOptions {
        columns,
        ..ReadOptions::new(Quantity::Duty)
    };
    assert_eq!(
        text(parse_csv(
            "time_s,duty_a,position_mm\n".as_bytes(),
            "run3.csv",
            &options
        )),
        "run3.csv:1: drive = duty_a: unit \"a\"; expected 1, %, or counts with full_scale at the end of its name, or as \
         unit under [columns]"
    );
}

#[test]
fn only_the_input_of_a_static_loop_has_a_unit_of_its_own() {
    let parts = RecordingParts {
        drive_unit: "MPa".to_owned(),
        ..parts()
    };
    assert_eq!(
        text(Recording::new(parts)),
        "run: drive in \"MPa\"; expected a current in A: only the input of a static loop has a unit of its \
         own"
    );
}

#[test]
fn invalid_unit() {
    let parts = RecordingParts {
        output_unit: "m\nm".to_owned(),
        ..parts()
    };
    assert_eq!(
        text(Recording::new(parts)),
        "run: unit \"m\\nm\"; expected text such as mm, deg or N, without square brackets, \
         quotes or control characters"
    );
}

#[test]
fn unequal_columns() {
    let then = |then: Columns| {
        let options = ReadOptions {
            columns: Columns {
                drive: Some(ColumnSpec::number(1).in_unit("degc")),
                output: Some(ColumnSpec::number(2).in_unit("mm")),
                then: Some(Box::new(then)),
                ..Columns::default()
            },
            ..ReadOptions::new(Quantity::Temperature)
        };
        text(parse_csv(
            "20,0,3\n30,1,2\n".as_bytes(),
            "loop.csv",
            &options,
        ))
    };
    let same = Columns {
        drive: Some(ColumnSpec::number(1).in_unit("k")),
        output: Some(ColumnSpec::number(3).in_unit("mm")),
        ..Columns::default()
    };
    let stressed = Columns {
        stress: Some(ColumnSpec::number(2).in_unit("mpa")),
        ..same.clone()
    };
    let timed = Columns {
        time: Some(ColumnSpec::number(2).in_unit("s")),
        ..same.clone()
    };
    let other_unit = Columns {
        output: Some(ColumnSpec::number(3).in_unit("um")),
        ..same
    };
    for (columns, what) in [
        (stressed, "stress"),
        (timed, "time"),
        (other_unit, "output"),
    ] {
        assert_eq!(
            then(columns),
            format!(
                "loop.csv:1: [columns.then] and [columns] differ in {what}; expected the same columns in the \
                 same units, and no time"
            )
        );
    }
}

#[test]
fn two_temperatures() {
    let parts = RecordingParts {
        drive_quantity: Quantity::Temperature,
        temperature_degc: Some(vec![20.0, 21.0]),
        ..parts()
    };
    let expected = ": both drive and temperature are temperatures; expected one of them";
    assert_eq!(text(Recording::new(parts)), format!("run{expected}"));
    let columns = Columns {
        temperature: Some(ColumnSpec::name("wall_c")),
        ..Columns::default()
    };
    let options = ReadOptions {
        columns,
        ..ReadOptions::new(Quantity::Temperature)
    };
    let csv = "temperature_c,wall_c,displacement_mm\n";
    assert_eq!(
        text(parse_csv(csv.as_bytes(), "run3.csv", &options)),
        format!("run3.csv{expected}")
    );
}

#[test]
fn field_count() {
    assert_eq!(
        rows("0,0,0\n0.1,0\n"),
        "run3.csv:3: fields: 2; expected 3, as in the first line"
    );
    assert_eq!(
        rows("0,0,0,5,0,0\n"),
        "run3.csv:2: fields: 6; expected 3, as in the first line; if commas stand both between fields and in numbers, save \
         with semicolons or tabs between fields"
    );
    // Nothing is lost where nothing stands.
    assert!(rows("0,0,0,\n1,1,1,,\n").starts_with("read:"));
}

#[test]
fn several() {
    assert_eq!(
        rows("0,0,0\n0.1,-,0\n0.2,0,x\n0.3,0,0\n"),
        "run3.csv:3: current_a = \"-\": not a number; expected a finite number in A; 2 such faults in all"
    );
    // One run says all.
    assert_eq!(
        rows("0,0,0\n0.1,-,NaN\n0.05,0,inf\n0.3,0\nlate,0,0\n0.4,0,0\n0.4,0,0\n"),
        "run3.csv: 7 faults; of each kind how many, and the first:\n  \
         2 x run3.csv:3: current_a = \"-\": not a number; expected a finite number in A\n  \
         2 x run3.csv:3: displacement_mm = NaN: not finite; expected a finite number in mm\n  \
         2 x run3.csv:4: time_s = 0.05 after 0.1 in the row before; expected time to rise\n  \
         1 x run3.csv:5: fields: 2; expected 3, as in the first line"
    );
    assert_eq!(
        fault_of(
            Quantity::Duty,
            "time_s,duty,displacement_mm\n0,1.5,0\n0.1,0.5,-\n0.2,-1,0\n"
        ),
        "run3.csv: 3 faults; of each kind how many, and the first:\n  \
         2 x run3.csv:2: duty = 1.5: outside 0..1; expected a duty of 0..1, of 0..100 in a column with unit %, or counts: unit = \
         \"counts\", full_scale = 255\n  \
         1 x run3.csv:3: displacement_mm = \"-\": not a number; expected a finite number in mm"
    );
    // A file of another kind is not read to its end.
    let many = format!("{HEADER}0,0,0\n{}", "a,b,c\n".repeat(200_000));
    assert_eq!(
        fault(&many),
        "run3.csv:3: time_s = \"a\": not a number; expected a finite number in s; 100002 such faults in all"
    );
}

#[test]
fn not_a_number() {
    assert_eq!(
        rows("0,0,0\n# still cold\n\n0.1,-,0\n"),
        "run3.csv:5: current_a = \"-\": not a number; expected a finite number in A"
    );
    assert_eq!(
        rows("0,,0\n"),
        "run3.csv:2: current_a = \"\": not a number; expected a finite number in A"
    );
    assert_eq!(
        fault("time_s;current_ma;position_mm\n0,5;0;0\n"),
        "run3.csv:2: time_s = \"0,5\": not a number; expected a finite number in s, with a decimal point \
         instead of a comma, or decimal = \",\" under [columns]"
    );
    assert_eq!(
        fault(&format!("time_s,current_a,tip [rad]\n{}", ""))
            .split(';')
            .next(),
        Some("run3.csv:1: output = \"displacement_mm\": no such column")
    );
    let columns = Columns {
        time: Some(ColumnSpec::number(1).in_unit("ms")),
        drive: Some(ColumnSpec::number(2).in_unit("mA")),
        output: Some(ColumnSpec::number(3).in_unit("rad")),
        ..Columns::default()
    };
    assert_eq!(
        fault_with(columns, "0,0,\u{7}x\u{7}\n"),
        "run3.csv:1: column 3 = \"\\u{7}x\\u{7}\": not a number; expected a finite number in rad"
    );
}

#[test]
fn not_finite() {
    for value in ["NaN", "inf", "-Infinity", "1e999"] {
        assert_eq!(
            rows(&format!("0,0,0\n0.1,0,{value}\n")),
            format!(
                "run3.csv:3: displacement_mm = {value}: not finite; expected a finite number in mm"
            )
        );
    }
    for (value, shown) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf")] {
        let time = RecordingParts {
            time_s: Some(vec![0.0, value]),
            ..parts()
        };
        assert_eq!(
            text(Recording::new(time)),
            format!("run, sample 1: time_s = {shown}: not finite; expected a finite number in s")
        );
        let drive = RecordingParts {
            drive: vec![value, 0.0],
            ..parts()
        };
        assert_eq!(
            text(Recording::new(drive)),
            format!(
                "run, sample 0: current_a = {shown}: not finite; expected a finite number in A"
            )
        );
        let output = RecordingParts {
            output: vec![value, 0.0],
            ..parts()
        };
        assert_eq!(
            text(Recording::new(output)),
            format!("run, sample 0: output = {shown}: not finite; expected a finite number in mm")
        );
        let stress = RecordingParts {
            stress_pa: Some(vec![value, 0.0]),
            ..parts()
        };
        assert_eq!(
            text(Recording::new(stress)),
            format!(
                "run, sample 0: stress_pa = {shown}: not finite; expected a finite number in Pa"
            )
        );
        let resistance = RecordingParts {
            resistance: Some(Resistance::VoltageOverCurrent {
                voltage_v: vec![0.0, 0.0],
                current_a: vec![0.0, value],
            }),
            ..parts()
        };
        assert_eq!(
            text(Recording::new(resistance)),
            format!(
                "run, sample 1: resistance_current_a = {shown}: not finite; expected a finite number in A"
            )
        );
        let ambient = RecordingParts {
            ambient_degc: Some(vec![0.0, value]),
            ..parts()
        };
        assert_eq!(
            text(Recording::new(ambient)),
            format!(
                "run, sample 1: ambient_degc = {shown}: not finite; expected a finite number in degC"
            )
        );
    }
}

#[test]
fn time_not_rising() {
    assert_eq!(
        fault("time_ms,current_a,position_mm\n0,0,0\n287,0,0\n286.5,0,0\n"),
        "run3.csv:4: time_ms = 286.5 after 287 in the row before; expected time to rise"
    );
    assert_eq!(
        rows("0,0,0\n0.1,0,0\n0.1,0,0\n"),
        "run3.csv:4: time_s = 0.1 after 0.1 in the row before; expected time to rise"
    );
    let parts = RecordingParts {
        time_s: Some(vec![1.0, 0.5]),
        ..parts()
    };
    assert_eq!(
        text(Recording::new(parts)),
        "run, sample 1: time_s = 0.5 after 1 in the row before; expected time to rise"
    );
}

#[test]
fn duty_out_of_range() {
    assert_eq!(
        fault_of(Quantity::Duty, "time_s,duty,position_mm\n0,0,0\n1,35,0\n"),
        "run3.csv:3: duty = 35: outside 0..1; expected a duty of 0..1, of 0..100 in a column with unit %, or \
         counts: unit = \"counts\", full_scale = 255"
    );
    assert_eq!(
        fault_of(Quantity::Duty, "time_s,duty [%],position_mm\n0,-1,0\n"),
        "run3.csv:2: duty [%] = -1: outside 0..100; expected a duty of 0..1, of 0..100 in a \
         column with unit %, or counts: unit = \"counts\", full_scale = 255"
    );
    let parts = RecordingParts {
        drive_quantity: Quantity::Duty,
        drive: vec![0.0, 1.5],
        ..parts()
    };
    assert_eq!(
        text(Recording::new(parts)),
        "run, sample 1: duty = 1.5: outside 0..1; expected a duty of 0..1, of 0..100 in a \
         column with unit %, or counts: unit = \"counts\", full_scale = 255"
    );
}

#[test]
fn unequal_lengths() {
    let parts = RecordingParts {
        output: vec![0.0; 5],
        ..parts()
    };
    assert_eq!(
        text(Recording::new(parts)),
        "run: output has 5 samples; expected 2, as many as the drive"
    );
}

#[test]
fn never_changes() {
    let still = |csv: &str| {
        let recording = parse_csv(csv.as_bytes(), "run3.csv", &ReadOptions::default()).unwrap();
        recording.check_identifiable().unwrap_err().to_string()
    };
    assert_eq!(
        still("time_s,current_ma,position_mm\n0,500,0\n1,500,1\n"),
        "run3.csv: drive is 0.5 A in all 2 samples; expected it to change, there is nothing to \
         identify"
    );
    assert_eq!(
        still("time_s,current_a,angle_deg,position_um\n0,0,0,7\n1,1,1,7\n2,1,1,7\n"),
        "run3.csv: output is 7 um in all 3 samples; expected it to change, there is nothing to \
         identify"
    );
}

fn parts() -> RecordingParts {
    RecordingParts {
        name: "run".to_owned(),
        time_s: Some(vec![0.0, 1.0]),
        drive: vec![0.0, 1.0],
        output_unit: "mm".to_owned(),
        output: vec![0.0, 1.0],
        ..RecordingParts::default()
    }
}
