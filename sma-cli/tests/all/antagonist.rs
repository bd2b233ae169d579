//! Two rods that pull against one another, from the raw file to a prediction.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write;
use std::fs;

use serde_json::Value;

use crate::folder::sma;

const ROD: &str = "\
[surroundings]
ambient_degc = 22.0

[drive]
kind = \"duty\"

[columns]
drive = { name = \"pwm_a\", unit = \"%\" }
antagonist = { name = \"pwm_b\", unit = \"%\" }
output = { name = \"angle\", unit = \"deg\" }
";

/// One after the other, then both at once, each with levels of its own: angle = 20 (a - b) + 5 + noise.
///
/// The rods are first-order lags of 3 and 4 s with loops of two straight branches, which the model does not have.
fn pair(levels: [&[f64]; 2]) -> String {
    let mut text = "time_s,pwm_a,pwm_b,angle\n".to_owned();
    let (mut rise_k, mut moved) = ([0.0_f64; 2], [0.0_f64; 2]);
    let taus_s = [3.0, 4.0];
    let mut noise = 0.5_f64;
    for k in 0..1200 {
        let duty = levels.map(|levels| match k {
            0..25 => 0.0,
            _ => levels[(k - 25) / 50 % levels.len()],
        });
        noise = (noise * 997.0 + 0.123).fract();
        let angle = 20.0 * (moved[0] - moved[1]) + 5.0 + 0.05 * (noise - 0.5);
        writeln!(
            text,
            "{:.1},{},{},{angle:.4}",
            0.2 * f64::from(u16::try_from(k).unwrap()),
            duty[0],
            duty[1]
        )
        .unwrap();
        for rod in 0..2 {
            let end_k = 1.0 * duty[rod];
            rise_k[rod] = end_k + (rise_k[rod] - end_k) * (-0.2_f64 / taus_s[rod]).exp();
            // Play between two branches, 10 K apart, smooth at their ends.
            let branch = |shift_k: f64| 1.0 / (1.0 + (-(rise_k[rod] - 45.0 - shift_k) / 5.0).exp());
            moved[rod] = moved[rod].max(branch(5.0)).min(branch(-5.0));
        }
    }
    text
}

#[test]
fn a_pair_is_identified_and_predicted_and_neither_diagnosed_nor_tuned() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("rod.toml"), ROD).unwrap();
    let trained = pair([
        &[60.0, 0.0, 90.0, 0.0, 45.0, 0.0, 100.0, 30.0],
        &[0.0, 70.0, 0.0, 100.0, 0.0, 50.0, 35.0],
    ]);
    fs::write(folder.join("run.csv"), trained).unwrap();
    let other = pair([&[80.0, 20.0, 0.0], &[0.0, 55.0, 95.0, 0.0, 0.0]]);
    fs::write(folder.join("other.csv"), other).unwrap();

    let (code, said, stderr) = sma(folder, "inspect run.csv --rod rod.toml");
    assert_eq!((code, stderr.as_str()), (0, ""), "{said}");
    assert!(said.contains("antagonist"), "{said}");

    let call = "identify rod.toml --train run.csv --validate other.csv --save-model model.toml --json found.json --no-plot";
    let (code, said, stderr) = sma(folder, call);
    assert_eq!(code, 0, "{said}{stderr}");
    let json = fs::read_to_string(folder.join("found.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    let value = |name: &str| {
        let all = json["parameters"].as_array().unwrap();
        let found = all.iter().find(|one| one["name"] == name).unwrap();
        found["values"][0].as_f64().unwrap()
    };
    // Within what another shape of loop costs.
    assert!((value("tau_s") - 3.0).abs() < 0.3, "{said}");
    assert!((value("antagonist_tau_s") - 4.0).abs() < 0.4, "{said}");
    assert!((value("antagonist_stroke") - 1.0).abs() < 0.1, "{said}");
    let unseen = json["fit"]["validate_rmse"].as_f64().unwrap();
    assert!(unseen < 1.2, "{unseen}: a twentieth of the range\n{said}");

    let (code, _, stderr) = sma(
        folder,
        "simulate model.toml --drive other.csv --output out.csv",
    );
    assert_eq!(code, 0, "{stderr}");
    let met = stderr.split("meets it to ").nth(1).unwrap();
    let met: f64 = met.split(' ').next().unwrap().parse().unwrap();
    assert!((met / unseen - 1.0).abs() < 1e-3, "{met} {unseen}");

    for (call, expected) in [
        (
            "diagnose rod.toml --train run.csv",
            "run.csv: two drives: effects are known of one rod only",
        ),
        (
            "tune model.toml --step-output 5 --drive-max 1",
            "model.toml: two rods with two drives: a controller is tuned for one",
        ),
        (
            "identify rod.toml --train run.csv --preset sadeghi",
            "run.csv: two drives: the paper's unknowns are those of one rod",
        ),
    ] {
        let (code, said, stderr) = sma(folder, call);
        assert_eq!(code, 3, "{said}{stderr}");
        assert!(stderr.contains(expected), "{stderr}");
    }
}

#[test]
fn the_other_drive_is_of_the_same_quantity_and_not_of_a_static_loop() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("run.csv"), pair([&[60.0, 0.0], &[0.0, 170.0]])).unwrap();
    for (rod, expected) in [
        (ROD.to_owned(), "run.csv:77: pwm_b = 170: "),
        (
            ROD.replace("pwm_b", "pwm_c"),
            "run.csv:1: antagonist = \"pwm_c\": no such column",
        ),
        (
            ROD.replace(
                "name = \"pwm_b\", unit = \"%\"",
                "name = \"pwm_b\", unit = \"A\"",
            ),
            "antagonist",
        ),
        (ROD.replace("pwm_b", "pwm_a"), "both drive and antagonist"),
        (
            ROD.replace("kind = \"duty\"", "kind = \"temperature\""),
            "run.csv: a drive that is a temperature has no antagonist",
        ),
    ] {
        fs::write(folder.join("rod.toml"), rod).unwrap();
        let (code, said, stderr) = sma(folder, "inspect run.csv --rod rod.toml");
        assert_eq!(code, 3, "{said}{stderr}");
        assert!(stderr.contains(expected), "{expected}\n{stderr}");
    }
}
