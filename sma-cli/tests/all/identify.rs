//! `sma identify` as a user calls it.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::path::PathBuf;

use assert_cmd::Command;

use crate::generate_recording;

fn bundled(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("bundled")
        .join(name)
}

fn sma() -> Command {
    let mut command = Command::cargo_bin("sma").unwrap();
    command.current_dir(bundled(""));
    command
}

fn identify_bundled() -> Command {
    let mut command = sma();
    command.args([
        "identify",
        "rod.toml",
        "--train",
        "train.csv",
        "--validate",
        "validate.csv",
    ]);
    command
}

fn stdout(command: &mut Command) -> String {
    String::from_utf8(command.assert().success().get_output().stdout.clone()).unwrap()
}

/// Exit code and stderr of a call that fails.
fn refusal(command: &mut Command) -> (i32, String) {
    let assert = command.assert().failure();
    let output = assert.get_output();
    assert!(output.stdout.is_empty(), "stdout is for results");
    (
        output.status.code().unwrap(),
        String::from_utf8(output.stderr.clone()).unwrap(),
    )
}

/// A folder with the bundled rod file and one recording of the given text.
fn folder(recording: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(bundled("rod.toml"), folder.path().join("rod.toml")).unwrap();
    std::fs::write(folder.path().join("run.csv"), recording).unwrap();
    folder
}

#[test]
fn the_bundled_recordings_are_what_the_generator_makes() {
    for (name, bytes) in generate_recording::files().unwrap() {
        assert!(
            std::fs::read(bundled(name)).unwrap() == bytes,
            "{name}: run the generator again"
        );
    }
}

#[test]
fn the_bundled_rod_is_found_again() {
    let text = stdout(identify_bundled().args(["--json", "-"]));
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["schema_version"], 1);
    assert_eq!(json["command"], "identify");
    // Noise of 5 µm and a converter step of 1.2 µm: nothing is left but them, also where unseen.
    for key in ["train_rmse", "validate_rmse"] {
        let rmse = json["fit"][key].as_f64().unwrap();
        assert!((0.0045..0.0055).contains(&rmse), "{key} = {rmse}");
    }
    assert!(json["fit"]["fit_percent"].as_f64().unwrap() > 99.0);
    let truth = generate_recording::truth().unwrap();
    let tau_s = truth.heat.heat_capacity_j_per_m_k / truth.heat.conductance_w_per_m_k;
    for (name, truth) in [
        ("tau_s", tau_s),
        ("loop_center_degc", truth.limiting_loop.loop_center_degc),
        ("loop_half_width_k", truth.limiting_loop.loop_half_width_k),
        ("loop_spread_k", truth.limiting_loop.loop_spread_k),
        ("zeta", truth.zeta),
        ("gain", truth.gain),
        ("offset", truth.offset),
    ] {
        let parameters = json["parameters"].as_array().unwrap();
        let parameter = parameters.iter().find(|one| one["name"] == name).unwrap();
        let value = parameter["values"][0].as_f64().unwrap();
        assert!(
            (value / truth - 1.0).abs() < 0.005,
            "{name}: {value} {truth}"
        );
    }
}

#[test]
fn the_text_says_the_verdict_first() {
    insta::assert_snapshot!(stdout(&mut identify_bundled()));
}

#[test]
fn notes_go_to_stderr_unless_quiet() {
    let notes = |command: &mut Command| {
        String::from_utf8(command.assert().success().get_output().stderr.clone()).unwrap()
    };
    let said = notes(&mut identify_bundled());
    assert!(
        said.contains("of 4 independent starts ended here"),
        "{said}"
    );
    assert!(
        said.lines().all(|line| line.starts_with("note: ")),
        "{said}"
    );
    assert_eq!(notes(identify_bundled().arg("--quiet")), "");
    // A training recording is not unseen.
    let same = notes(sma().args([
        "identify",
        "rod.toml",
        "--train",
        "train.csv",
        "--validate",
        "train.csv",
    ]));
    assert!(
        same.contains(
            "note: train.csv holds the data of the training recording train.csv: it is not unseen\n"
        ),
        "{same}"
    );
}

#[test]
fn gaps_are_reported() {
    let text = std::fs::read_to_string(bundled("train.csv")).unwrap();
    // Four seconds of the slow ramp are lost.
    let kept = text
        .lines()
        .enumerate()
        .filter(|(k, _)| !(300..320).contains(k));
    let kept: String = kept.map(|(_, line)| format!("{line}\n")).collect();
    let folder = folder(&kept);
    let assert = Command::cargo_bin("sma")
        .unwrap()
        .current_dir(folder.path())
        .args(["identify", "rod.toml", "--train", "run.csv"])
        .assert();
    let notes = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(
        notes.contains(
            "note: run.csv: nothing recorded from 59.4 s for 4.200 s; the drive is taken to have stayed; "
        ) && notes.contains(" times tau_s: if it did not, the state after the gap is another\n"),
        "{notes}"
    );
}

#[test]
fn an_input_is_not_overwritten() {
    for input in ["rod.toml", "./train.csv", "../bundled/validate.csv"] {
        let (code, error) = refusal(identify_bundled().args(["--json", input]));
        assert_eq!(code, 1);
        assert_eq!(
            error,
            format!(
                "sma: {input}: is an input of this command; give another file for the result\n"
            )
        );
    }
}

#[test]
fn a_device_stays_a_device() {
    stdout(identify_bundled().args(["--json", "/dev/null"]));
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn threads_do_not_move_a_byte() {
    let on = |threads| stdout(identify_bundled().args(["--threads", threads, "--json", "-"]));
    let one = on("1");
    assert_eq!(one, on("2"));
    assert_eq!(one, on("7"));
}

#[test]
fn json_goes_to_a_file_whole() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("fit.json");
    let text = stdout(identify_bundled().arg("--json").arg(&file));
    assert!(text.starts_with("The model meets"));
    let json = std::fs::read_to_string(&file).unwrap();
    assert_eq!(json, stdout(identify_bundled().args(["--json", "-"])));
    // A folder that is not there leaves nothing behind.
    let (code, error) = refusal(identify_bundled().args(["--json", "no/such/folder/fit.json"]));
    assert_eq!(code, 1);
    assert!(
        error.starts_with("sma: no/such/folder/fit.json: cannot be written: "),
        "{error}"
    );
}

#[test]
fn a_wrong_call_is_a_usage_error() {
    let (code, error) = refusal(sma().args(["identify", "rod.toml"]));
    assert_eq!(code, 2);
    assert!(error.contains("--train <CSV>..."), "{error}");
    assert_eq!(refusal(&mut sma()).0, 2);
}

#[test]
fn the_paper_s_search_says_that_it_proves_no_minimum() {
    let assert = identify_bundled()
        .args(["--preset", "sadeghi", "--json", "-"])
        .assert()
        .code(4);
    let output = assert.get_output();
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["fit"]["converged"], false);
    // 50 particles, 150 moves and the start.
    assert!(json["fit"]["simulations"].as_u64().unwrap() >= 7550);
    let notes = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(
        notes.contains("the paper leaves their scale open"),
        "{notes}"
    );
}

#[test]
fn argmin_ends_at_the_same_floor() {
    let text = stdout(identify_bundled().args(["--cross-check", "--no-plot"]));
    let said = "argmin, from its own start, ends at the same floor: 0.004996 mm.\n";
    assert!(text.contains(said), "{text}");
}

#[test]
fn static_data_have_no_heat_balance() {
    let folder = folder("input,output\n0,0\n2,0.1\n4,2\n6,3.9\n4,3.5\n2,1\n0,0\n");
    let rod = "[drive]\nkind = \"temperature\"\n[columns]\n\
               drive = { name = \"input\", unit = \"MPa\" }\noutput = { name = \"output\", unit = \"%\" }\n";
    std::fs::write(folder.path().join("rod.toml"), rod).unwrap();
    let mut command = Command::cargo_bin("sma").unwrap();
    command.current_dir(folder.path()).args([
        "identify", "rod.toml", "--train", "run.csv", "--json", "-", "-q",
    ]);
    let assert = command.assert();
    let json: serde_json::Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    let parameters = json["parameters"].as_array().unwrap();
    assert_eq!(parameters[0]["name"], "loop_center");
    assert_eq!(parameters[0]["unit"], "MPa");
    assert_eq!(json["output_unit"], "%");
}

#[test]
fn a_rod_that_cannot_be_ends_with_4_and_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let rod = std::fs::read_to_string(bundled("rod.toml")).unwrap();
    let rod = rod.replace("density_kg_per_m3 = 6450.0", "density_kg_per_m3 = 1e300");
    let path = folder.path().join("rod.toml");
    std::fs::write(&path, rod).unwrap();
    let run = |command: &str, arguments: &[&str]| {
        let mut call = sma();
        call.arg(command).arg(&path);
        call.args(["--train", "train.csv", "--quiet", "--no-plot"]);
        let assert = call.args(arguments).assert().code(4);
        String::from_utf8(assert.get_output().stdout.clone()).unwrap()
    };
    let text = run("identify", &["--starts", "2"]);
    let first = "IMPLAUSIBLE: density_kg_per_m3 = 1.0e300, and no metal has that; NiTi has 6450.\n";
    assert!(text.starts_with(first), "{text}");
    for (command, arguments) in [
        ("identify", ["--json", "-", "--starts", "2"].as_slice()),
        ("diagnose", ["--json", "-"].as_slice()),
    ] {
        let json: serde_json::Value = serde_json::from_str(&run(command, arguments)).unwrap();
        assert_eq!(json["implausible"][0]["rule"], "density", "{command}");
    }
}

#[test]
fn series_hold_each_recording_with_the_model_through_it() {
    let folder = tempfile::tempdir().unwrap();
    let [series, json] = ["series.json", "fit.json"].map(|name| folder.path().join(name));
    let mut command = identify_bundled();
    command.arg("--series").arg(&series);
    command.arg("--json").arg(&json).arg("--no-plot");
    command.assert().success();
    let read = |path| -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    };
    let (series, fit) = (read(series), read(json));
    let rmses = fit["recordings"].as_array().unwrap();
    let recordings = series["recordings"].as_array().unwrap();
    let roles: Vec<&str> = recordings
        .iter()
        .map(|one| one["role"].as_str().unwrap())
        .collect();
    assert_eq!(roles, ["train", "validate"]);
    for (one, rmse) in recordings.iter().zip(rmses) {
        let numbers = |value: &serde_json::Value| -> Vec<f64> {
            let values = value.as_array().unwrap().iter();
            values.map(|value| value.as_f64().unwrap()).collect()
        };
        let model = &one["models"][0];
        assert_eq!(model["model"], "identified");
        let (recorded, simulated) = (numbers(&one["output"]), numbers(&model["output"]));
        for other in [
            &one["time_s"],
            &one["drive"],
            &model["output"],
            &model["temperature_degc"],
        ] {
            assert_eq!(numbers(other).len(), recorded.len());
        }
        let squares = recorded
            .iter()
            .zip(&simulated)
            .map(|(y, s)| (y - s).powi(2));
        let found = (squares.sum::<f64>() / recorded.len() as f64).sqrt();
        let stated = rmse["rmse"].as_f64().unwrap();
        assert!(
            (found - stated).abs() < 1e-9 * stated,
            "{found} for {stated}"
        );
    }
}

#[test]
fn progress_comes_in_lines_where_a_program_asks_for_them() {
    let mut command = identify_bundled();
    command.args(["--no-plot"]).env("SMA_PROGRESS", "lines");
    let stderr = command.assert().success().get_output().stderr.clone();
    let stderr = String::from_utf8(stderr).unwrap();
    assert!(
        stderr.starts_with("progress: identify start 0/4\n"),
        "{stderr}"
    );
    let mut quiet = identify_bundled();
    quiet
        .args(["--no-plot", "--quiet"])
        .env("SMA_PROGRESS", "lines");
    quiet.assert().success().stderr("");
}
