//! `sma inspect` as a user calls it.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

use assert_cmd::Command;

fn inspect(arguments: &[&str]) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/bundled");
    let mut command = Command::cargo_bin("sma").unwrap();
    let assert = command
        .current_dir(folder)
        .arg("inspect")
        .args(arguments)
        .assert()
        .success();
    String::from_utf8(assert.get_output().stdout.clone()).unwrap()
}

#[test]
fn the_bundled_recordings_are_described() {
    insta::assert_snapshot!(inspect(&["train.csv", "validate.csv"]));
}

#[test]
fn json_says_the_same() {
    let json: serde_json::Value = serde_json::from_str(&inspect(&["train.csv", "--json"])).unwrap();
    assert_eq!(json["command"], "inspect");
    let recording = &json["recordings"][0];
    assert_eq!(recording["n_samples"], 2000);
    assert_eq!(recording["sampling"]["kind"], "uniform");
    // A 12-bit converter over 5 mm.
    let step = recording["channels"][1]["quantization_step"]
        .as_f64()
        .unwrap();
    assert!((step - 5.0 / 4096.0).abs() < 1e-6, "{step}");
}

#[test]
fn a_missing_column_is_bad_input() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/bundled");
    let mut command = Command::cargo_bin("sma").unwrap();
    let assert = command
        .current_dir(folder)
        .args(["inspect", "rod.toml"])
        .assert()
        .code(3);
    let error = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(error.starts_with("sma: rod.toml:"), "{error}");
}

#[test]
fn stress_and_resistance_are_described() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("static.csv");
    let rows = "temperature_degc,displacement_mm,stress_mpa,resistance_ohm\n20,0,50,0.8\n40,1,52,0.75\n60,4,51,0.7\n";
    std::fs::write(&file, rows).unwrap();
    let rod = folder.path().join("rod.toml");
    let resistance =
        "[drive]\nkind = \"temperature\"\n[columns]\nresistance = \"resistance_ohm\"\n";
    std::fs::write(&rod, resistance).unwrap();
    let text = inspect(&[file.to_str().unwrap(), "--rod", rod.to_str().unwrap()]);
    assert!(
        text.contains("  stress      5.000e7 to 5.200e7 Pa\n"),
        "{text}"
    );
    assert!(
        text.contains("  resistance  0.7000 to 0.8000 ohm\n"),
        "{text}"
    );
}

#[test]
fn without_a_rod_file_columns_are_guessed_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let row = |k: i32| {
        (
            0.1 * f64::from(k),
            f64::from(k / 50 % 2),
            (0.1 * f64::from(k)).sin(),
        )
    };
    let rows = (0..200).map(row);
    let timed: String = rows
        .clone()
        .map(|(t, u, y)| format!("{t},{u},{y:.4}\n"))
        .collect();
    std::fs::write(
        path("volt.csv"),
        format!("time_s,voltage_v,displacement_mm\n{timed}"),
    )
    .unwrap();
    let text = inspect(&[&path("volt.csv")]);
    let guess = "read as     \"time_s\" is the time, \"voltage_v\" is the voltage, \"displacement_mm\" is the output: a guess, which \
                 sma init writes into a rod file";
    assert!(text.contains(guess), "{text}");
    assert!(text.contains("0 to 1.000 V"), "{text}");
    std::fs::write(path("bare.csv"), &timed).unwrap();
    assert!(inspect(&[&path("bare.csv")]).contains("column 1 is the time"));
    let loops: String = rows
        .map(|(t, _, y)| format!("{},{y:.4}\n", 20.0 + t))
        .collect();
    std::fs::write(
        path("loop.csv"),
        format!("temperature_degc,displacement_mm\n{loops}"),
    )
    .unwrap();
    let text = inspect(&[&path("loop.csv")]);
    assert!(
        text.contains("\"temperature_degc\" is the temperature") && text.contains("without time"),
        "{text}"
    );
}
