//! Files as loggers and spreadsheets write them: the same run in many forms.

use std::fs;

use recording::{
    ColumnSpec, Columns, Quantity, ReadOptions, Recording, RecordingError, parse_csv, read_csv,
};

const N: usize = 120;
const DT_S: f64 = 0.1;

/// The run, row for row: time, current, displacement.
fn run() -> Vec<[f64; 3]> {
    let row = |k: usize| {
        let current_a = if (20..70).contains(&k) { 0.45 } else { 0.0 };
        let displacement_mm = 1.2 + ((k * k) as f64 * 0.37).sin().abs();
        [
            DT_S * k as f64,
            current_a,
            (1e4 * displacement_mm).round() / 1e4,
        ]
    };
    (0..N).map(row).collect()
}

/// The run as text, each row by a function.
fn rows(head: &str, row: impl Fn(usize, [f64; 3]) -> String) -> String {
    let rows: Vec<String> = run()
        .into_iter()
        .enumerate()
        .map(|(k, values)| row(k, values))
        .collect();
    format!("{head}{}\n", rows.join("\n"))
}

const HEAD: &str = "time_s,current_a,displacement_mm\n";

fn plain(_: usize, [t, i, x]: [f64; 3]) -> String {
    format!("{t:.4},{i:.4},{x:.4}")
}

fn comma(number: f64, digits: usize) -> String {
    format!("{number:.digits$}").replace('.', ",")
}

fn read_with(
    columns: Columns,
    quantity: Quantity,
    bytes: &[u8],
) -> Result<Recording, RecordingError> {
    let folder = std::env::temp_dir().join(format!("recording-loggers-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let unique = format!("{:?}", std::thread::current().id());
    let path = folder.join(format!("run-{}.csv", unique.replace(['(', ')'], "-")));
    fs::write(&path, bytes).unwrap();
    let options = ReadOptions {
        columns,
        ..ReadOptions::new(quantity)
    };
    let found = read_csv(&path, &options);
    fs::remove_file(&path).unwrap();
    found
}

fn read(bytes: impl AsRef<[u8]>) -> Recording {
    read_with(Columns::default(), Quantity::Current, bytes.as_ref()).unwrap()
}

fn refused(bytes: impl AsRef<[u8]>) -> String {
    let found = read_with(Columns::default(), Quantity::Current, bytes.as_ref());
    found.unwrap_err().to_string()
}

fn said(found: &Recording) -> String {
    let said: Vec<String> = found
        .adaptations()
        .iter()
        .map(ToString::to_string)
        .collect();
    said.join("; ")
}

/// Asserts that a recording is the run, and that it says what was done.
fn is_the_run(found: &Recording, expected: &str) {
    let said = said(found);
    assert!(said.contains(expected), "{said}");
    let run = run();
    assert_eq!(found.drive().len(), run.len(), "{said}");
    let time_s = found.time_s();
    for (k, [t, i, x]) in run.into_iter().enumerate() {
        let row = (time_s[k] - time_s[0], found.drive()[k], found.output()[k]);
        assert!((row.0 - t).abs() < 1e-6, "{said}: row {k}: {row:?}, {t}");
        assert!((row.1 - i).abs() < 1e-9, "{said}: row {k}: {row:?}, {i}");
        assert!((row.2 - x).abs() < 1e-9, "{said}: row {k}: {row:?}, {x}");
    }
}

#[test]
fn what_stands_before_and_behind_the_table_is_left_out() {
    let table = rows(HEAD, plain);
    for before in [
        "Ready.\nSD card ok\n",
        "0.12,1.20\n",
        "\0\0r,5.2\n",
        "Author;lab\n\n",
    ] {
        is_the_run(
            &read(format!("{before}{table}")),
            "left out before the table",
        );
    }
    is_the_run(
        &read(format!("{table}\nAverage,0.21,3.20\nDone\n")),
        "left out behind the table (2 lines",
    );
    is_the_run(
        &read(format!("#Digilent WaveForms\n#Device: x\n\n{table}")),
        "",
    );
    let skipped = Columns {
        skip: 2,
        ..Columns::default()
    };
    let text = format!("1,2,3\n4,5,6\n{table}");
    is_the_run(
        &read_with(skipped, Quantity::Current, text.as_bytes()).unwrap(),
        "",
    );
}

#[test]
fn a_measurement_of_labview_is_read() {
    let head = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDate\t2024/05/02\nTime\t10:11:12.201\n\
                ***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t1500\t1500\t\nX0\t0\t0\t\nDelta_X\t0.1\t0.1\t\n\
                ***End_of_Header***\t\t\t\nX_Value\tCurrent\tDisplacement\tComment\n";
    let text = rows(head, |_, [t, i, x]| format!("{t:.4}\t{i:.4}\t{x:.4}"));
    let columns = Columns {
        time: Some(ColumnSpec::name("X_Value").in_unit("s")),
        drive: Some(ColumnSpec::name("Current").in_unit("A")),
        output: Some(ColumnSpec::name("Displacement").in_unit("mm")),
        ..Columns::default()
    };
    let found = read_with(columns, Quantity::Current, text.as_bytes()).unwrap();
    is_the_run(&found, "left out before the table");
}

#[test]
fn encodings_and_ends_of_lines_are_known() {
    let table = rows(HEAD, plain);
    is_the_run(&read(table.replace('\n', "\r")), "carriage returns");
    let utf16: Vec<u8> = std::iter::once(0xfeff)
        .chain(table.encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect();
    is_the_run(&read(utf16), "UTF-16LE");
    let latin1 = rows(
        "time_s,current_a,displacement_mm,Temperatur (@C)\n",
        |k, values| format!("{},24.00", plain(k, values)),
    );
    let latin1: Vec<u8> = latin1
        .bytes()
        .map(|byte| if byte == b'@' { 0xb0 } else { byte })
        .collect();
    is_the_run(&read(latin1), "windows-1252");
}

#[test]
fn numbers_are_read_as_they_are_written() {
    let semicolons = "time_s;current_a;displacement_mm\n";
    let german =
        |_, [t, i, x]: [f64; 3]| format!("{};{};{}", comma(t, 4), comma(i, 4), comma(x, 4));
    is_the_run(&read(rows(semicolons, german)), "decimal comma");
    is_the_run(
        &read(format!("sep=;\n{}", rows(semicolons, german))),
        "decimal comma",
    );
    let named = rows("Zeit [s];Strom [A];Weg [mm]\n", german);
    is_the_run(&read(named), "\"Strom [A]\" is taken for the drive");
    let fortran = |_, [t, i, x]: [f64; 3]| {
        [t, i, x]
            .map(|value| format!("{value:.9e}").replace('e', "D"))
            .join("  ")
    };
    is_the_run(
        &read(rows("time_s current_a displacement_mm\n", fortran)),
        "Fortran",
    );
    let thousands = |_, [t, i, x]: [f64; 3]| {
        let ms = (1e3 * t).round() as u64;
        let time = match ms / 1000 {
            0 => format!("\"{ms}\""),
            thousands => format!("\"{thousands},{:03}\"", ms % 1000),
        };
        format!("{time},{i},{x}")
    };
    let text = rows("time_ms,current_a,displacement_mm\n", thousands);
    is_the_run(&read(text), "thousands are set apart");
    let minus = |_, [t, i, x]: [f64; 3]| format!("{t:.4},{i:.4},\u{2212}{x:.4}");
    let found = read(rows(HEAD, minus));
    assert!(found.output()[0] < 0.0 && said(&found).contains("minus"));
    let labels = |_, [t, i, x]: [f64; 3]| format!("t={t:.4},I={i:.4},x={x:.4}");
    is_the_run(&read(rows(HEAD, labels)), "label");
    let bars = |k, values| plain(k, values).replace(',', "|");
    is_the_run(&read(rows(&HEAD.replace(',', "|"), bars)), "bar");
}

#[test]
fn units_stand_anywhere() {
    let own_row = rows("Time,Current,Displacement\n(s),(A),(mm)\n", plain);
    is_the_run(&read(own_row), "a row of units (line 2)");
    let behind = |_, [t, i, x]: [f64; 3]| format!("{t:.4} s,{i:.4} A,{x:.4} mm");
    is_the_run(
        &read(rows("time,current,displacement\n", behind)),
        "as its values say",
    );
    is_the_run(&read(rows(HEAD, behind)), "unit stands behind");
    let others = |_, [t, i, x]: [f64; 3]| format!("{:.12},{:.3},{x}", t / 60.0, 1e3 * i);
    let text = rows("time [min],current [mA],displacement [mm]\n", others);
    is_the_run(&read(text), "");
    let long = rows(
        "Elapsed Time (sec),Wire Current (Amps),LVDT Position (inch)\n",
        plain,
    );
    let found = read(long);
    is_the_run(&found, "\"Wire Current (Amps)\" is taken for the drive");
    assert_eq!(found.output_unit(), "in");
}

#[test]
fn clocks_are_read() {
    let stamped = |of: &dyn Fn(u64) -> String| {
        rows("timestamp,current_a,displacement_mm\n", |k, [_, i, x]| {
            format!("{},{i},{x}", of(k as u64))
        })
    };
    let of_day = |k: u64| format!("10:00:{:02}.{}00", k / 10, k % 10);
    is_the_run(&read(stamped(&of_day)), "stamps");
    let dated = |k: u64| format!("2024-05-02 23:59:{:02}.{}00", 48 + k / 10, k % 10);
    is_the_run(&read(stamped(&|k| dated(k))), "stamps");
    let midnight = |k: u64| match k {
        0..60 => format!("23:59:{:02}.{}", 54 + k / 10, k % 10),
        _ => format!("00:00:{:02}.{}", k / 10 - 6, k % 10),
    };
    is_the_run(&read(stamped(&midnight)), "midnight passes (line 62)");
    // What the reader takes as it is.
    let unix = rows("time_ms,current_a,displacement_mm\n", |k, [_, i, x]| {
        format!("{},{i},{x}", 1_714_644_672_100 + 100 * k as u64)
    });
    is_the_run(&read(unix), "");
    let counter = rows("time_ms,current_a,displacement_mm\n", |k, [_, i, x]| {
        format!("{},{i},{x}", (4_294_963_000 + 100 * k as u64) % (1 << 32))
    });
    is_the_run(&read(counter), "counter of the clock ran over");
    let twice = rows(HEAD, |k, [_, i, x]| {
        format!("{},{i},{x}", 0.2 * (k / 2) as f64)
    });
    is_the_run(&read(twice), "spread up to the next");
    let table = rows(HEAD, plain);
    let mut lines: Vec<&str> = table.lines().collect();
    lines.insert(31, lines[30]);
    is_the_run(&read(lines.join("\n")), "the row stands twice (line 32)");
    lines.remove(31);
    lines.swap(50, 51);
    is_the_run(&read(lines.join("\n")), "stood too late");
    let counted = Columns {
        time: Some(ColumnSpec::every_s(DT_S)),
        ..Columns::default()
    };
    let text = rows("current_a,displacement_mm\n", |_, [_, i, x]| {
        format!("{i},{x}")
    });
    is_the_run(
        &read_with(counted, Quantity::Current, text.as_bytes()).unwrap(),
        "",
    );
}

#[test]
fn a_few_numbers_may_be_missing() {
    for missing in ["", "--", "NaN", "n/a"] {
        let text = rows(HEAD, |k, [t, i, x]| match k {
            40 | 80 => format!("{t},{i},{missing}"),
            _ => format!("{t},{i},{x}"),
        });
        let found = read(&text);
        let run = run();
        assert!((found.output()[40] - 0.5 * (run[39][2] + run[41][2])).abs() < 1e-12);
        assert!(
            said(&found).contains("taken from its neighbors (2 lines, first 42)"),
            "{}",
            said(&found)
        );
        assert!(parse_csv(text.as_bytes(), "run", &ReadOptions::default()).is_err());
    }
    let held = rows(HEAD, |k, [t, i, x]| match k {
        70 => format!("{t},,{x}"),
        _ => format!("{t},{i},{x}"),
    });
    assert!(read(held).drive()[70] > 0.4);
    // More than a few are for the user to look at.
    let many = rows(HEAD, |k, [t, i, x]| match k {
        40..50 => format!("{t},{i},"),
        _ => format!("{t},{i},{x}"),
    });
    assert!(refused(many).contains("displacement_mm"));
}

#[test]
fn a_line_that_was_cut_off_is_left_out() {
    let table = rows(HEAD, plain);
    for end in ["12.0000,", "12.0000,0.0000,1."] {
        is_the_run(&read(format!("{table}{end}")), "left out");
    }
}

#[test]
fn counts_need_their_full_scale() {
    let text = rows("time_s,pwm,displacement_mm\n", |_, [t, i, x]| {
        format!("{t},{},{x}", (255.0 * i).round())
    });
    let in_counts = |full_scale: Option<f64>| Columns {
        drive: Some(ColumnSpec {
            full_scale,
            ..ColumnSpec::name("pwm").in_unit("counts")
        }),
        ..Columns::default()
    };
    let found = read_with(in_counts(Some(255.0)), Quantity::Duty, text.as_bytes()).unwrap();
    assert!((found.drive()[30] - 115.0 / 255.0).abs() < 1e-12);
    let fault = read_with(in_counts(None), Quantity::Duty, text.as_bytes()).unwrap_err();
    assert!(fault.to_string().contains("full_scale = 255"), "{fault}");
    // Never taken for a percentage in silence.
    let fault = read_with(Columns::default(), Quantity::Duty, text.as_bytes()).unwrap_err();
    assert!(fault.to_string().contains("counts"), "{fault}");
}

#[test]
fn what_cannot_be_read_says_what_can() {
    let half = rows(HEAD, |_, [t, i, x]| {
        format!("{},{i:.3},{x:.3}", comma(t, 4))
    });
    assert!(refused(&half).contains("save with semicolons"));
    let half = half.replacen("0,0000,", "0,", 1);
    assert!(refused(half).contains("save with semicolons"));
    assert!(
        refused("{\"time_s\":[0,1,2]}").contains("JSON; expected a table with one row a sample")
    );
    assert!(refused(b"PK\x03\x04\x14").contains("the sheet saved as CSV"));
    let anew = rows(HEAD, |k, [t, i, x]| {
        format!("{},{i},{x}", if k < 80 { t } else { t - 8.0 })
    });
    assert!(refused(anew).contains("begins another recording"));
    let twice = rows(HEAD, plain);
    assert!(refused(twice.repeat(2)).contains("second header"));
    // No unit anywhere.
    assert!(refused(rows("t,i,x\n", plain)).contains("no unit"));
    // 1,234 may be either.
    let doubt = rows("time_s;current_a;displacement_mm\n", |k, _| {
        format!("{k};1,234;{k}")
    });
    assert!(refused(doubt).contains("decimal"));
}

#[test]
fn an_output_may_be_the_temperature() {
    let text = rows("time_s,current_a,temperature_degc\n", plain);
    let columns = Columns {
        output: Some(ColumnSpec::name("temperature_degc")),
        ..Columns::default()
    };
    let found = read_with(columns, Quantity::Current, text.as_bytes()).unwrap();
    assert_eq!(
        (found.output_unit(), found.temperature_degc()),
        ("degC", None)
    );
}

#[test]
fn strict_files_are_as_the_format_says() {
    let text = rows("Ready.\ntime_s,current_a,displacement_mm\n", plain);
    let strict = Columns {
        strict: true,
        ..Columns::default()
    };
    let fault = read_with(strict, Quantity::Current, text.as_bytes()).unwrap_err();
    assert!(fault.to_string().contains("no such column"), "{fault}");
}
