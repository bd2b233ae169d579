//! Errors of a user, and the messages of the program: every message whole.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use assert_cmd::Command;

const ROD: &str = "[surroundings]\nambient_degc = 22.0\n";

/// Exit code and stderr of `sma identify` on these files.
fn said(rod: &str, recording: &str) -> (i32, String) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("rod.toml"), rod).unwrap();
    std::fs::write(folder.path().join("run.csv"), recording).unwrap();
    let assert = Command::cargo_bin("sma")
        .unwrap()
        .current_dir(folder.path())
        .args(["identify", "rod.toml", "--train", "run.csv"])
        .args(["--json", "fit.json", "--save-model", "model.toml"])
        .assert()
        .failure();
    let output = assert.get_output();
    assert!(output.stdout.is_empty(), "stdout is for results");
    let files = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(files, 2, "nothing is left half written");
    (
        output.status.code().unwrap(),
        String::from_utf8(output.stderr.clone()).unwrap(),
    )
}

#[track_caller]
fn assert_bad_input(rod: &str, recording: &str, expected: &str) {
    assert_eq!(said(rod, recording), (3, format!("sma: {expected}\n")));
}

/// A recording of these rows under the default header.
fn rows(rows: &str) -> String {
    format!("time_s,current_a,displacement_mm\n{rows}")
}

#[test]
fn columns_that_are_not_there_or_there_twice() {
    assert_bad_input(
        ROD,
        "time_s,displacement_mm\n0,0\n1,1\n",
        "run.csv:1: drive = \"current_a\": no such column; expected drive under [columns] to be one of the 2 present: time_s, displacement_mm",
    );
    assert_bad_input(
        ROD,
        "time_s,current_a,position_mm,position_um\n0,0,0,0\n1,1,1,1\n",
        "run.csv:1: output = \"displacement_mm\": several columns fit, position_mm (column 3), position_um (column 4); expected one, give its name or number under [columns]",
    );
    assert_bad_input(
        ROD,
        "time_s,current_a,Current_A,displacement_mm\n0,0,0,0\n1,1,1,1\n",
        "run.csv:1: drive = \"current_a\": several columns fit, current_a (column 2), Current_A (column 3); expected one, give its name or number under [columns]",
    );
}

#[test]
fn units_that_do_not_suit() {
    let columns = "[columns]\ndrive = { name = \"current\", unit = \"V\" }\n";
    assert_bad_input(
        &format!("{ROD}{columns}"),
        "time_s,current,displacement_mm\n0,0,0\n1,1,1\n",
        "run.csv:1: drive = current: unit \"V\"; expected a or ma at the end of its name, or as unit under [columns]",
    );
    let columns = "[columns]\ntime = \"t\"\n";
    assert_bad_input(
        &format!("{ROD}{columns}"),
        "t,current_a,displacement_mm\n0,0,0\n1,1,1\n",
        "run.csv:1: time = t: no unit; expected s, ms, us, min or h at the end of its name, or as unit under [columns]",
    );
}

#[test]
fn text_and_numbers_that_are_none() {
    assert_bad_input(
        ROD,
        &rows("0,0,0\n0.1,-,0.1\n"),
        "run.csv:3: current_a = \"-\": not a number; expected a finite number in A",
    );
    assert_bad_input(
        ROD,
        &rows("0,0,0\n0.1,nan,0.1\n"),
        "run.csv:3: current_a = nan: not finite; expected a finite number in A",
    );
    assert_bad_input(
        ROD,
        &rows("0,0,0\n0.1,1,-inf\n"),
        "run.csv:3: displacement_mm = -inf: not finite; expected a finite number in mm",
    );
    assert_bad_input(
        ROD,
        &rows("0,0,0\n0.1,1\n"),
        "run.csv:3: fields: 2; expected 3, as in the first line",
    );
}

#[test]
fn commas_that_may_be_decimal_or_not_are_asked_about() {
    assert_bad_input(
        ROD,
        "time_s;current_a;displacement_mm\n0;0;0\n1;1,234;2\n",
        "run.csv:3: current_a = \"1,234\": not a number; expected a finite number in A, with a decimal point instead of a comma, or decimal = \",\" under [columns]",
    );
}

#[test]
fn time_that_falls_or_stands() {
    assert_bad_input(
        ROD,
        &rows("0,0,0\n0.2,1,0.1\n0.1,1,0.1\n"),
        "run.csv:4: time_s = 0.1 after 0.2 in the row before; expected time to rise",
    );
    assert_bad_input(
        ROD,
        &rows("0,0,0\n0,1,0.1\n"),
        "run.csv:3: time_s = 0 after 0 in the row before; expected time to rise",
    );
}

#[test]
fn files_with_nothing_in_them() {
    assert_bad_input(
        ROD,
        "",
        "run.csv: empty; expected a header line and at least 2 rows",
    );
    assert_bad_input(
        ROD,
        &rows(""),
        "run.csv: rows of data: 0; expected at least 2",
    );
    assert_bad_input(
        ROD,
        &rows("0,0,0\n"),
        "run.csv: rows of data: 1; expected at least 2",
    );
}

#[test]
fn recordings_in_which_nothing_happens() {
    assert_bad_input(
        ROD,
        &rows("0,1,0\n0.1,1,0.1\n"),
        "run.csv: drive is 1 A in all 2 samples; expected it to change, there is nothing to identify",
    );
    assert_bad_input(
        ROD,
        &rows("0,1,0.5\n0.1,2,0.5\n"),
        "run.csv: output is 0.5 mm in all 2 samples; expected it to change, there is nothing to identify",
    );
}

#[test]
fn rod_files_with_keys_or_values_that_cannot_be() {
    let recording = rows("0,0,0\n0.1,1,0.1\n");
    assert_bad_input(
        "[rod]\ndiametre_mm = 1.0\n",
        &recording,
        "rod.toml:2:1: unknown field `diametre_mm`, expected one of `diameter_mm`, `length_mm`, `density_kg_per_m3`, `specific_heat_j_per_kg_k`, `resistance_ohm_per_m`",
    );
    assert_bad_input(
        "[rod]\ndiameter_mm = -1.2\n",
        &recording,
        "rod.toml:2:15: rod.diameter_mm = -1.2: must be finite and > 0",
    );
    assert_bad_input(
        "[rod]\nlength_mm = nan\n",
        &recording,
        "rod.toml:2:13: rod.length_mm = NaN: must be finite and > 0",
    );
    assert_bad_input(
        "[surroundings]\nambient_degc = \"warm\"\n",
        &recording,
        "rod.toml:2:16: invalid type: string \"warm\", expected a number",
    );
    assert_bad_input(
        "[rod\n",
        &recording,
        "rod.toml:1:5: unclosed table, expected `]`",
    );
    assert_bad_input(
        "",
        &recording,
        "rod.toml: surroundings.ambient_degc is missing: no recording has a column for it either",
    );
    assert_bad_input(
        &format!("{ROD}[model]\ntau = {{ fixed = 3.0 }}\n"),
        &recording,
        "rod.toml:4:1: [model] tau: no such parameter; this rig has tau_s, loop_center_degc, loop_half_width_k, loop_spread_k, zeta, gain, offset, start_rise_k, start_share, start_since_reversal_k, ambient_level_k, run_heat_loss, run_gain, lambda_k_per_a2",
    );
}

#[test]
fn kelvins_and_files_of_another_kind() {
    let recording = rows("0,0,0\n0.1,1,0.1\n");
    assert_bad_input(
        "[surroundings]\nambient_degc = 295\n",
        &recording,
        "rod.toml:2:16: surroundings.ambient_degc = 295: must lie from -100 to 200 °C; 295 K would be 21.85 °C",
    );
    assert_bad_input(
        "schema_version = 1\n[[parameter]]\nname = \"tau_s\"\n",
        &recording,
        "rod.toml:2:3: unknown field `parameter`, expected one of `rod`, `surroundings`, `drive`, `load`, `limits`, `columns`, `model`, `recordings`; this is a model from --save-model",
    );
}

#[test]
fn drives_that_lack_their_wiring() {
    let duty = "time_s,duty,displacement_mm\n0,0,0\n0.1,0.5,0.1\n";
    // All that makes watts of a duty, but for the supply.
    assert_bad_input(
        &format!(
            "{ROD}[rod]\nlength_mm = 200.0\nresistance_ohm_per_m = 4.3\n[drive]\nkind = \"duty\"\n"
        ),
        duty,
        "rod.toml: drive.supply_v is missing: a duty says how long the supply is on, not how strong it is",
    );
    let supplied = format!("{ROD}[drive]\nkind = \"duty\"\nsupply_v = 24.0\n");
    assert_bad_input(
        &supplied,
        "time_s,duty,displacement_mm\n0,0,0\n0.1,50,0.1\n",
        "run.csv:3: duty = 50: outside 0..1; expected a duty of 0..1, of 0..100 in a column with unit %, or counts: unit = \"counts\", full_scale = 255",
    );
}

#[test]
fn files_that_are_not_there() {
    let sma = |args: &[&str]| {
        let assert = Command::cargo_bin("sma")
            .unwrap()
            .args(args)
            .assert()
            .failure();
        let output = assert.get_output().clone();
        (
            output.status.code().unwrap(),
            String::from_utf8(output.stderr).unwrap(),
        )
    };
    let none = ": cannot be read: No such file or directory (os error 2)\n";
    let (code, error) = sma(&["identify", "none.toml", "--train", "none.csv"]);
    assert_eq!((code, error), (3, format!("sma: none.toml{none}")));
    let (code, error) = sma(&["simulate", "none.toml", "--drive", "none.csv"]);
    assert_eq!((code, error), (3, format!("sma: none.toml{none}")));
}
