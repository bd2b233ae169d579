//! `sma tune` as a user calls it.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use serde_json::Value;

/// A folder with the model identified from the bundled recording.
fn identified() -> tempfile::TempDir {
    let bundled = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("bundled");
    let folder = tempfile::tempdir().unwrap();
    Command::cargo_bin("sma")
        .unwrap()
        .current_dir(bundled)
        .args([
            "identify",
            "rod.toml",
            "--train",
            "train.csv",
            "--quiet",
            "--no-plot",
        ])
        .arg("--save-model")
        .arg(folder.path().join("model.toml"))
        .assert()
        .success();
    folder
}

fn tune(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::cargo_bin("sma").unwrap();
    command
        .current_dir(folder)
        .args(["tune", "model.toml", "--step-output", "2.5"])
        .args(args);
    command
}

fn json(folder: &Path, args: &[&str]) -> Value {
    let mut command = tune(folder, args);
    let assert = command
        .args(["--drive-max", "5.5", "--json", "-"])
        .assert()
        .success();
    serde_json::from_slice(&assert.get_output().stdout).unwrap()
}

/// Exit code and stderr of a call that fails.
fn refusal(folder: &Path, args: &[&str]) -> (i32, String) {
    let assert = tune(folder, args).assert().failure();
    let output = assert.get_output();
    assert!(output.stdout.is_empty(), "stdout is for results");
    let error = String::from_utf8(output.stderr.clone()).unwrap();
    (output.status.code().unwrap(), error)
}

/// The controller of a name.
fn controller<'a>(result: &'a Value, name: &str) -> &'a Value {
    let controllers = result["controllers"].as_array().unwrap();
    controllers.iter().find(|one| one["name"] == name).unwrap()
}

#[test]
fn the_tuned_gains_cost_less_than_rules_and_meet_what_is_required() {
    let folder = identified();
    let result = json(folder.path(), &["--draws", "20"]);
    assert_eq!(result["command"], "tune");
    assert_eq!(result["effects"], serde_json::json!([]));
    let number = |name: &str, key: &str| controller(&result, name)[key].as_f64().unwrap();
    let cost = |name| number(name, "cost");
    // Each of its terms counts one, but for an overshoot within the band of 2 %, and the drive's way.
    assert!((3.5..=6.0).contains(&cost("SIMC")), "{}", cost("SIMC"));
    for rule in ["SIMC", "relay test"] {
        assert!(
            cost("tuned") < 1.001 * cost(rule),
            "{rule}: {} {}",
            cost("tuned"),
            cost(rule)
        );
        assert!(number(rule, "kick") <= 0.0501);
    }
    // The current and mm of this rig are those of the paper.
    assert_eq!(controller(&result, "paper")["gains"]["kp"], 200.0);
    assert!(
        number("paper", "kick") > 0.05,
        "what the paper's gains do with this sensor"
    );
    let tuned = controller(&result, "tuned");
    let margins = &tuned["margins"];
    assert_eq!(margins["stable"], true);
    assert!(margins["gain_margin"].as_f64().unwrap() > 1.98);
    assert!(margins["phase_margin_deg"].as_f64().unwrap() > 44.5);
    assert!(number("tuned", "kick") <= 0.05);
    // The recorded sensor: noise of 5 µm, 5 mm in 12 bits.
    let sensor = &result["sensor"];
    assert!(
        (sensor["noise"].as_f64().unwrap() / 0.005 - 1.0).abs() < 0.2,
        "{sensor}"
    );
    assert_eq!(result["dead_time_samples"], 1);
    let ends = result["limit_cycles"][1]["ends"].as_array().unwrap();
    assert!(ends.iter().all(|end| end["end"] == "rests"), "{ends:?}");
    assert_eq!(result["robustness"]["draws"], 20);
    assert_eq!(result["limit_cycles"].as_array().unwrap().len(), 2);
    // tau, center, half width, spread, zeta, gain.
    assert_eq!(result["sensitivities"].as_array().unwrap().len(), 6);
}

#[test]
fn margins_and_structure_are_those_that_are_asked_for() {
    let folder = identified();
    let asked = [
        "--gain-margin",
        "4",
        "--phase-margin-deg",
        "60",
        "--kick",
        "0.01",
        "--pi",
        "--anti-windup",
        "back-calculation",
        "--setpoint-weight",
        "0.5",
        "--derivative-filter-s",
        "3",
        "--feed-forward",
        "--derivative-of",
        "error",
        "--across",
        "mean",
        "--draws",
        "0",
        "--rods",
        "3",
    ];
    let result = json(folder.path(), &asked);
    let tuned = controller(&result, "tuned");
    assert!(tuned["margins"]["gain_margin"].as_f64().unwrap() > 3.96);
    assert!(tuned["margins"]["phase_margin_deg"].as_f64().unwrap() > 59.4);
    assert!(tuned["kick"].as_f64().unwrap() <= 0.01);
    assert_eq!(tuned["gains"]["kd"], 0.0);
    assert_eq!(result["rods"], 3);
    assert_eq!(
        result["controller"],
        serde_json::json!({
            "anti_windup": "back-calculation",
            "derivative_of": "error",
            "derivative_filter_s": 3.0,
            "setpoint_weight": 0.5,
            "feed_forward": true,
        })
    );
}

#[test]
fn an_ideal_sensor_is_one_that_was_asked_for() {
    let folder = identified();
    let ideal = json(folder.path(), &["--ideal", "--draws", "0"]);
    assert_eq!(ideal["sensor"]["noise"], 0.0);
    assert_eq!(ideal["dead_time_samples"], 0);
    let [real, ideal] = [&json(folder.path(), &["--draws", "0"]), &ideal]
        .map(|result| controller(result, "tuned")["gains"]["kp"].as_f64().unwrap());
    assert!(ideal > real, "{ideal} {real}");
    // A model from before sensors were kept.
    let path = folder.path().join("model.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let (before, behind) = text.split_once("[recording.sensor]").unwrap();
    let (_, rest) = behind.split_once("\n\n").unwrap();
    std::fs::write(&path, format!("{before}{rest}")).unwrap();
    let assert = tune(folder.path(), &["--drive-max", "5.5", "--draws", "0"])
        .assert()
        .success();
    let notes = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(
        notes
            .contains("model.toml does not say what the sensor does by itself: identify once more"),
        "{notes}"
    );
    let spoiled = text.replace("correlation_s = ", "correlation_s = -");
    std::fs::write(&path, spoiled).unwrap();
    let (code, error) = refusal(folder.path(), &["--drive-max", "5.5"]);
    assert_eq!(code, 3);
    assert!(error.contains("expected a finite number >= 0"), "{error}");
}

#[test]
fn a_supply_has_the_steps_that_were_recorded() {
    let folder = identified();
    let path = folder.path().join("model.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let coarse = "drive_step = 0.02\ndrive_dead_zone = 0.3\nlargest_drive = ";
    std::fs::write(&path, text.replace("largest_drive = ", coarse)).unwrap();
    let args = ["--drive-max", "5.5", "--draws", "0"];
    let assert = tune(folder.path(), &args).assert().success();
    let said = String::from_utf8(assert.get_output().stdout.clone()).unwrap();
    let sentence =
        "The supply sets the drive in steps of 0.02000 A, and gives nothing below 0.3000 A.";
    assert!(said.contains(sentence), "{said}");
    // Ideal but for what is asked for.
    let ideal = json(
        folder.path(),
        &["--draws", "0", "--ideal", "--drive-step", "0.01"],
    );
    let supply = serde_json::json!({ "step": 0.01, "dead_zone": 0.0 });
    assert_eq!(ideal["supply"], supply);
    let spoiled = coarse.replace("0.02", "-0.02");
    std::fs::write(&path, text.replace("largest_drive = ", &spoiled)).unwrap();
    let (code, error) = refusal(folder.path(), &args);
    assert_eq!(code, 3);
    assert!(error.contains("expected a finite number > 0"), "{error}");
}

#[test]
fn a_gentle_controller_is_slower_than_a_fast_one() {
    let folder = identified();
    let rise_time_s = |pace| {
        let result = json(folder.path(), &["--pace", pace, "--draws", "0"]);
        let terms = &controller(&result, "tuned")["terms"];
        terms["rise_time_s"].as_f64().unwrap()
    };
    let [gentle, fast] = [rise_time_s("0"), rise_time_s("1")];
    assert!(gentle > 1.02 * fast, "{gentle} {fast}");
}

#[test]
fn references_are_followed_from_where_the_recorded_rig_rested() {
    let folder = identified();
    let mut csv = String::from("time_s,reference_mm,displacement_mm\n");
    for k in 0..400 {
        let reference = if k < 50 { 0.8 } else { 2.0 };
        csv += &format!("{},{reference},{}\n", f64::from(k) * 0.2, reference - 0.1);
    }
    std::fs::write(folder.path().join("stairs.csv"), csv).unwrap();
    let args = [
        "--reference",
        "stairs.csv",
        "--draws",
        "0",
        "--responses",
        "responses.csv",
    ];
    let result = json(folder.path(), &args);
    let references = result["references"].as_array().unwrap();
    assert_eq!(references.len(), 4);
    let followed = &references[3];
    assert_eq!(followed["name"], "stairs.csv");
    assert_eq!(followed["controller"], "tuned");
    assert!((followed["recorded_rmse"].as_f64().unwrap() - 0.1).abs() < 1e-9);
    let responses = std::fs::read_to_string(folder.path().join("responses.csv")).unwrap();
    assert!(responses.starts_with("reference,controller,time_s,setpoint_mm,output_mm,drive\n"));
    let first = responses
        .lines()
        .find(|line| line.starts_with("stairs.csv,tuned,0,"))
        .unwrap();
    // At rest where the recorded rig was: 0.7 mm.
    let output: f64 = first.split(',').nth(4).unwrap().parse().unwrap();
    assert!((output - 0.7).abs() < 1e-9, "{first}");
}

#[test]
fn same_bytes_on_any_number_of_threads() {
    let folder = identified();
    let on = |threads| {
        json(
            folder.path(),
            &[
                "--threads",
                threads,
                "--draws",
                "40",
                "--front",
                "--duration-s",
                "120",
            ],
        )
    };
    assert_eq!(on("1").to_string(), on("2").to_string());
}

#[test]
fn gains_follow_level_and_branch_where_that_is_cheaper() {
    let folder = identified();
    let at = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let call = "tune model.toml --step-output 4.2 --drive-max 5.5 --gain-schedule=3 --ideal --pi --duration-s 60 --draws 0 --json tuned.json";
    let ran = |more: &str| {
        let mut command = Command::cargo_bin("sma").unwrap();
        let args = call.split_whitespace().chain(more.split_whitespace());
        let output = command
            .current_dir(folder.path())
            .args(args)
            .output()
            .unwrap();
        assert!(output.status.success());
        let result: Value = serde_json::from_str(&at("tuned.json")).unwrap();
        (result, String::from_utf8(output.stdout).unwrap())
    };
    let (result, _) = ran("--report page.html --test-script steps.csv --threads 1");
    let schedule = &result["controller"]["gain_schedule"];
    let numbers = |key: &str| -> Vec<f64> {
        let values = schedule[key].as_array().unwrap().iter();
        values.map(|value| value.as_f64().unwrap()).collect()
    };
    let [heating, cooling] = ["heating", "cooling"].map(numbers);
    for factors in [&heating, &cooling] {
        assert_eq!(factors.len(), 8);
        assert!(factors.iter().all(|factor| (1.0..=3.0).contains(factor)));
        // Flat at both ends of the loop, steep between them.
        assert!(factors[0] > 2.9);
    }
    let least = heating
        .iter()
        .chain(&cooling)
        .copied()
        .fold(f64::INFINITY, f64::min);
    assert!((least - 1.0).abs() < 1e-12, "1 at the steepest level");
    // From rest to beyond the set point.
    let outputs = numbers("outputs");
    assert!(outputs[0] < 0.5 && (4.3..4.5).contains(&outputs[1]));
    // The tuned gains are the cheapest of all that were tried, beside those that stay.
    let cost = |name: &str| controller(&result, name)["cost"].as_f64().unwrap();
    let tried = result["gain_schedules"]["tried"].as_array().unwrap();
    assert_eq!(tried.len(), 4);
    let cheapest = tried.iter().map(|one| one["cost"].as_f64().unwrap());
    let cheapest = cheapest.fold(f64::INFINITY, f64::min);
    assert!((cost("tuned") / cheapest - 1.0).abs() < 1e-12);
    let staying = result["gain_schedules"]["unscheduled_cost"]
        .as_f64()
        .unwrap();
    assert!((cost("unscheduled") / staying - 1.0).abs() < 1e-12);
    assert!(cost("tuned") < 0.99 * cost("unscheduled"));
    // Both meet what is required at every level.
    for name in ["tuned", "unscheduled"] {
        let margins = &controller(&result, name)["margins"];
        assert!(margins["gain_margin"].as_f64().unwrap() > 1.98, "{name}");
        assert!(
            margins["phase_margin_deg"].as_f64().unwrap() > 44.5,
            "{name}"
        );
    }
    let ends = result["limit_cycles"][1]["ends"].as_array().unwrap();
    assert!(ends.iter().all(|end| end["end"] == "rests"), "{ends:?}");
    let page = at("page.html");
    for said in [
        "Gains by the output",
        "output (mm)",
        "factor on kp, ki, kd: heating (1)",
        "none: gains that stay",
        "at the worst level and branch",
    ] {
        assert!(page.contains(said), "{said}");
    }
    // A rig that does as expected has kept the promise of the same gains.
    let steps = at("steps.csv");
    let rows = steps.lines().skip(1);
    let measured: String = rows
        .map(|row| row.split(',').take(3).collect::<Vec<_>>().join(",") + "\n")
        .collect();
    let csv = format!("time_s,reference_mm,displacement_mm\n{measured}");
    std::fs::write(folder.path().join("measured.csv"), csv).unwrap();
    let (again, said) = ran("--quiet --check measured.csv --threads 2");
    for key in ["controller", "controllers", "gain_schedules"] {
        assert_eq!(again[key], result[key], "on any number of threads");
    }
    assert!(
        said.starts_with("measured.csv: the rig did as promised. 100"),
        "{said}"
    );
    assert!(
        said.contains("kp, ki and kd are those of the level where the rig is steepest"),
        "{said}"
    );
}

#[test]
fn the_paper_s_search_stays_within_its_bounds() {
    let folder = identified();
    let result = json(folder.path(), &["--preset", "sadeghi", "--draws", "0"]);
    let gains = &controller(&result, "tuned")["gains"];
    assert_eq!(result["controllers"][0]["name"], "paper");
    assert_eq!(result["requirements"], Value::Null);
    assert_eq!(result["sensor"]["noise"], 0.0);
    assert!(gains["kp"].as_f64().unwrap() <= 500.0);
    assert!(gains["ki"].as_f64().unwrap() <= 1.0 && gains["kd"].as_f64().unwrap() <= 1.0);
}

#[test]
fn what_cannot_be_tuned_is_said() {
    let folder = identified();
    let at = folder.path();
    for (args, expected) in [
        (
            &["--drive-max", "0"][..],
            "--drive-max 0: must be finite and > 0",
        ),
        (
            &["--drive-max", "4"],
            "set point 2.5 mm: beyond what the rig reaches, 0.4897 to 1.2243 mm with a drive of at most 4 A",
        ),
        (
            &[],
            "model.toml: limits.drive_max is missing: the controller needs it; give it there or as --drive-max; the recordings went to 5.4",
        ),
        (
            &["--drive-max", "5.5", "--sample-time-s", "0"],
            "dt_s = 0: must be finite and > 0",
        ),
        (
            &["--drive-max", "5.5", "--duration-s", "0.1"],
            "--duration-s = 0.1: must be 2 to 1,000,000 sample times long",
        ),
        (
            &["--drive-max", "5.5", "--pace", "2"],
            "pace = 2: must lie in 0 .. 1",
        ),
        (
            &["--drive-max", "5.5", "--weights", "0", "0", "0", "0", "0"],
            "no weight is > 0 on a term that responses to this reference have: at least 1 must be",
        ),
        (
            &["--drive-max", "5.5", "--gain-schedule=1"],
            "--gain-schedule = 1: must be finite and > 1; it is the largest factor on the gains",
        ),
        (
            &["--drive-max", "5.5", "--gain-schedule=NaN"],
            "--gain-schedule = NaN: must be finite and > 1; it is the largest factor on the gains",
        ),
        (
            &[
                "--drive-max",
                "5.5",
                "--gain-schedule",
                "--preset",
                "sadeghi",
            ],
            "a requirement for --gain-schedule is missing: --preset sadeghi requires nothing of gains; leave one of both out",
        ),
        (
            &["--drive-max", "5.5", "--reference", "empty.csv"],
            "empty.csv: empty; expected a header line and at least 2 rows",
        ),
    ] {
        std::fs::write(at.join("empty.csv"), "").unwrap();
        assert_eq!(refusal(at, args), (3, format!("sma: {expected}\n")));
    }
    let (code, error) = refusal(at, &["--sine-hz", "0.007"]);
    assert_eq!(code, 2);
    assert!(error.contains("--sine-amplitude <Y>"), "{error}");
}

#[test]
fn a_rig_is_held_to_what_was_promised() {
    let folder = identified();
    let at = |name: &str| folder.path().join(name);
    let options = ["--draws", "20", "--gain-margin", "3", "--duration-s", "120"];
    let script = json(
        folder.path(),
        &[&options[..], &["--test-script", "steps.csv"]].concat(),
    );
    assert_eq!(script["checked"], Value::Null);
    let text = std::fs::read_to_string(at("steps.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("time_s,reference_mm,expected_mm,lower_mm,upper_mm,drive")
    );
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    assert!(rows.len() > 100);
    assert!(rows.iter().all(|row| row[3] <= row[2] && row[2] <= row[4]));
    assert!(
        rows.iter().any(|row| row[1] > 2.49),
        "the set point is one of the steps"
    );
    // A rig that does as expected, and one that stops half-way.
    for (name, most, kept) in [("good.csv", f64::INFINITY, true), ("stuck.csv", 1.4, false)] {
        let mut csv = String::from("time_s,reference_mm,displacement_mm\n");
        for row in &rows {
            csv += &format!("{},{},{}\n", row[0], row[1], row[2].min(most));
        }
        std::fs::write(at(name), csv).unwrap();
        let mut command = tune(folder.path(), &["--drive-max", "5.5", "--check", name]);
        let output = command.args(options).output().unwrap();
        assert_eq!(
            output.status.code(),
            Some(if kept { 0 } else { 4 }),
            "{name}"
        );
        let said = String::from_utf8(output.stdout).unwrap();
        let expected = if kept {
            "good.csv: the rig did as promised. 100"
        } else {
            "stuck.csv: the rig DID NOT do as promised. Only "
        };
        assert!(said.starts_with(expected), "{said}");
        assert_eq!(
            said.contains("sma diagnose rod.toml --train stuck.csv"),
            !kept
        );
    }
    let mut without = String::from("time_s,reference_mm\n");
    for row in &rows {
        without += &format!("{},{}\n", row[0], row[1]);
    }
    std::fs::write(at("without.csv"), without).unwrap();
    let (code, error) = refusal(
        folder.path(),
        &["--drive-max", "5.5", "--check", "without.csv"],
    );
    assert_eq!(code, 3);
    assert!(error.contains("the output is missing"), "{error}");
}
