//! Recordings of a temperature, and of cycles without time, from the raw file to what is said of them.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write;
use std::fs;

use serde_json::Value;

use crate::folder::sma;

/// A duty of steps on a rod of τ = 3 s that a duty of 1 heats by 80 K, in surroundings of 23 °C, to a tenth of a kelvin.
fn polled() -> String {
    let mut text = "Time(sec),Temperature(C),PWM(%)\n".to_owned();
    let mut rise_k = 0.0;
    for k in 0..300 {
        let duty = match k {
            30..100 => 40.0,
            150..220 => 100.0,
            _ => 0.0,
        };
        let shown = (10.0_f64 * (23.0 + rise_k)).round() / 10.0;
        writeln!(text, "{:.1},{shown:.1},{duty}", 0.2 * f64::from(k)).unwrap();
        let end_k = 0.8 * duty;
        rise_k = end_k + (rise_k - end_k) * (-0.2_f64 / 3.0).exp();
    }
    text
}

#[test]
fn a_temperature_is_identified_in_two_commands() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("run.csv"), polled()).unwrap();
    let (code, said, stderr) = sma(folder, "init run.csv");
    assert_eq!((code, stderr.as_str()), (0, ""), "{said}");
    // Nothing is asked: rise, surroundings and start are found.
    assert!(said.contains("rod.toml is written.\n"), "{said}");
    let call = "identify rod.toml --train run.csv --save-model model.toml --json found.json --report page.html --no-plot";
    let (code, said, stderr) = sma(folder, call);
    assert_eq!(code, 0, "{said}{stderr}");
    for expected in [
        "The output is the temperature: this is the heat balance alone.",
        "rise_k_per_duty",
        "ambient_degc (run.csv)",
        "RMSE degC",
    ] {
        assert!(said.contains(expected), "{expected}:\n{said}");
    }
    assert!(!said.contains("loop_") && !said.contains("mm"), "{said}");
    for expected in [
        "nothing states the temperature of the surroundings",
        "no lag of the sensor shows",
        "watts are not told",
    ] {
        assert!(stderr.contains(expected), "{expected}:\n{stderr}");
    }
    let json = fs::read_to_string(folder.join("found.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["memory"], Value::Null);
    let value = |name: &str| {
        let all = json["parameters"].as_array().unwrap();
        let found = all.iter().find(|one| one["name"] == name).unwrap();
        found["values"][0].as_f64().unwrap()
    };
    assert!((value("tau_s") - 3.0).abs() < 0.02, "{}", value("tau_s"));
    assert!((value("rise_k_per_duty") - 80.0).abs() < 0.2);
    assert!((value("ambient_degc") - 23.0).abs() < 0.05);
    let page = fs::read_to_string(folder.join("page.html")).unwrap();
    assert!(page.contains("heat balance alone") && !page.contains("the loop over"));

    // What it was fitted to it predicts as well as it said.
    let rmse = json["fit"]["train_rmse"].as_f64().unwrap();
    let (code, _, stderr) = sma(
        folder,
        "simulate model.toml --drive run.csv --output out.csv",
    );
    assert_eq!(code, 0, "{stderr}");
    let met = stderr.split("meets it to ").nth(1).unwrap();
    let met: f64 = met.split(' ').next().unwrap().parse().unwrap();
    // Four digits are printed.
    assert!((met / rmse - 1.0).abs() < 1e-3, "{met} {rmse}");

    let (code, _, stderr) = sma(folder, "diagnose rod.toml --train run.csv");
    assert_eq!(code, 3);
    assert_eq!(
        stderr,
        "sma: run.csv: the output is the temperature: no effect of the catalogue shows in it alone; use `sma identify`, or record \
         what the actuator does beside its temperature\n"
    );
    let (code, _, stderr) = sma(folder, "tune model.toml --step-output 60");
    assert_eq!(code, 3);
    assert_eq!(
        stderr,
        "sma: model.toml: the output is the temperature: only an actuator that moves is controlled; identify it from a recording \
         of what it does\n"
    );
}

/// Temperature and strain of a loop, whose rest rises with the cycles.
fn cycled(cycles: usize, only_heating: bool) -> String {
    // Without a name whatever rises from the first row to the last is taken for time.
    let mut text = match only_heating {
        true => "temperature_degc\tstrain\n".to_owned(),
        false => String::new(),
    };
    let half = 40;
    let n = if only_heating {
        half
    } else {
        2 * half * cycles
    };
    for k in 0..n {
        let phase = (k % (2 * half)) as f64 / half as f64;
        let (degc, center_degc) = if phase < 1.0 {
            (25.0 + 100.0 * phase, 80.0)
        } else {
            (225.0 - 100.0 * phase, 65.0)
        };
        let fraction = 0.5 + ((degc - center_degc) / 4.0).atan() / std::f64::consts::PI;
        let rest = 5e-6 * k as f64;
        // The last digits of a sensor.
        let noise = 1e-4 * ((k * 7919 % 101) as f64 / 50.0 - 1.0);
        writeln!(
            text,
            "{degc:.2}\t{:.6}",
            0.04 * (1.0 - fraction) + rest + noise
        )
        .unwrap();
    }
    text
}

#[test]
fn cycles_without_time_or_names_are_a_loop_that_drifts() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("cycles.txt"), cycled(8, false)).unwrap();
    let (code, said, stderr) = sma(folder, "init cycles.txt");
    assert_eq!((code, stderr.as_str()), (0, ""), "{said}");
    for expected in [
        "drive, temperature (by its values)",
        "output (by its values)",
        "kind = \"temperature\": no name says what the input is",
    ] {
        assert!(said.contains(expected), "{expected}:\n{said}");
    }
    // No room is asked for where nothing cools.
    assert!(!said.contains("ambient_degc"), "{said}");
    let (code, said, stderr) = sma(folder, "identify rod.toml --train cycles.txt --no-plot");
    assert_eq!(code, 0, "{said}{stderr}");
    assert!(
        stderr.contains("without time only the loop is identified"),
        "{stderr}"
    );
    let (code, said, stderr) = sma(folder, "diagnose rod.toml --train cycles.txt");
    assert_eq!(code, 0, "{said}{stderr}");
    assert!(
        said.contains("\nFunctional fatigue is missing: the loop and its stroke drift with the number of cycles; after 8 over the whole range"),
        "{said}"
    );
}

#[test]
fn heating_alone_has_no_half_width() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("heating.txt"), cycled(1, true)).unwrap();
    let (code, ..) = sma(folder, "init heating.txt");
    assert_eq!(code, 0);
    let call =
        "identify rod.toml --train heating.txt --no-plot --json found.json --save-model model.toml";
    let (code, said, stderr) = sma(folder, call);
    assert_eq!(code, 0, "{said}{stderr}");
    let row = |name: &str| said.lines().find(|line| line.contains(name)).unwrap();
    let half_width = row("loop_half_width_k");
    assert!(half_width.contains("not determined: no cooling"), "{said}");
    assert!(!half_width.contains('…'), "{said}");
    assert!(
        row("loop_center_degc").contains("of the heating branch"),
        "{said}"
    );
    assert!(stderr.contains("record the cooling"), "{stderr}");
    let json = fs::read_to_string(folder.join("found.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    let all = json["parameters"].as_array().unwrap();
    let half_width = all
        .iter()
        .find(|one| one["name"] == "loop_half_width_k")
        .unwrap();
    assert_eq!(half_width["values"][0], Value::Null);
    assert_eq!(half_width["not_determined"], "not determined: no cooling");
    let (code, _, stderr) = sma(
        folder,
        "simulate model.toml --drive heating.txt --output out.csv",
    );
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("knows one branch of its loop"), "{stderr}");
}
