//! `sma export`: what leaves the program computes what the program computes.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]
#![allow(clippy::print_stdout, reason = "tests say what they skip")]

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use sma_export::FMU_MARK;

use crate::folder::sma;

/// A folder with a model, identified from the bundled recordings.
fn identified() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let bundled = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("bundled");
    for name in ["rod.toml", "train.csv", "validate.csv"] {
        std::fs::copy(bundled.join(name), folder.path().join(name)).unwrap();
    }
    called(
        folder.path(),
        "identify rod.toml --train train.csv --save-model model.toml --quiet",
    );
    folder
}

/// stdout and stderr of a call that does its work.
fn called(folder: &Path, call: &str) -> (String, String) {
    let (code, text, notes) = sma(folder, call);
    assert_eq!(code, 0, "{call}: {notes}");
    (text, notes)
}

/// stderr of a call whose input is refused.
fn refused(folder: &Path, call: &str) -> String {
    let (code, text, error) = sma(folder, call);
    assert_eq!((code, text.as_str()), (3, ""), "{call}: {error}");
    error
}

fn read(folder: &Path, name: &str) -> String {
    std::fs::read_to_string(folder.join(name)).unwrap()
}

/// Columns of a table of numbers, from a column on.
fn columns(text: &str, of: &str, first: usize) -> Vec<Vec<f64>> {
    let rows = text.lines().skip(1).filter(|line| line.starts_with(of));
    let numbers = |row: &str| {
        row.split(',')
            .skip(first)
            .map(|field| field.parse().unwrap())
            .collect()
    };
    rows.map(numbers).collect()
}

/// Rows of numbers that a C program writes, a line each; `None` on a machine without a compiler, which says so.
fn compiled(folder: &Path, main: &str) -> Option<Vec<Vec<f64>>> {
    let cc = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    if Command::new(&cc).arg("--version").output().is_err() {
        println!("SKIPPED: no C compiler {cc}; set CC");
        return None;
    }
    std::fs::write(folder.join("main.c"), main).unwrap();
    let flags = "-std=c99 -pedantic -Wall -Wextra -Werror -O2 -ffp-contract=off -o main main.c -lm";
    let output = Command::new(cc)
        .args(flags.split(' '))
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let output = Command::new(folder.join("main")).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let numbers = |row: &str| row.split(',').map(|field| field.parse().unwrap()).collect();
    Some(text.lines().map(numbers).collect())
}

#[test]
fn a_header_predicts_what_simulate_predicts() {
    let folder = identified();
    let folder = folder.path();
    let profile: Vec<String> = read(folder, "validate.csv")
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(',').take(2).collect::<Vec<_>>().join(","))
        .collect();
    std::fs::write(folder.join("profile.csv"), profile.join("\n") + "\n").unwrap();
    called(
        folder,
        "simulate model.toml --drive profile.csv --output predicted.csv --quiet",
    );
    let (_, notes) = called(folder, "export model.toml --to c --output rod.h");
    assert!(notes.starts_with("note: offset 0.3"), "{notes}");
    assert!(
        notes.ends_with("start are those of train.csv; sample time 0.2 s\n"),
        "{notes}"
    );
    let predicted = columns(&read(folder, "predicted.csv"), "", 1);
    assert!(predicted.len() > 1_000);
    let mut main =
        String::from("#include <stdio.h>\n#include \"rod.h\"\nstatic const double drive[] = {\n");
    for row in &predicted {
        writeln!(main, "    {:?},", row[0]).unwrap();
    }
    main += "};\nint main(void) {\n    sma_plant plant;\n    size_t k;\n    sma_plant_start(&plant, 22 + SMA_START_RISE_K, SMA_START_SHARE);\n    for (k = 0; k < sizeof drive / sizeof *drive; ++k) {\n        printf(\"%.17g,%.17g,%.17g\\n\", drive[k], sma_plant_output(&plant), sma_plant_temperature_degc(&plant));\n        sma_plant_step(&plant, drive[k], 22);\n    }\n    return 0;\n}\n";
    if let Some(found) = compiled(folder, &main) {
        assert!(found == predicted);
    }
}

#[test]
fn a_closed_loop_responds_as_tune_shows() {
    let folder = identified();
    let folder = folder.path();
    for (set_point, structure) in [
        (2.5, ""),
        (
            2.5,
            " --anti-windup back-calculation --derivative-of error --setpoint-weight 0.7",
        ),
        (
            4.2,
            " --pi --gain-schedule --duration-s 120 --setpoint-weight 0.7 --anti-windup back-calculation",
        ),
    ] {
        let call = format!(
            "tune model.toml --step-output {set_point} --drive-max 5.5 --ideal --draws 0 --json tuned.json --responses responses.csv --quiet{structure}"
        );
        called(folder, &call);
        called(
            folder,
            "export model.toml --to c --tuned tuned.json --output rod.h --quiet",
        );
        let shown = columns(&read(folder, "responses.csv"), "step,tuned,", 3);
        assert!(shown.len() > 500);
        let main = format!(
            "#include <stdio.h>\n#include \"rod.h\"\nint main(void) {{\n    sma_plant plant;\n    sma_pid pid;\n    int k;\n    sma_plant_rest(&plant, 22);\n    sma_pid_rest(&pid, sma_plant_output(&plant));\n    for (k = 0; k < {}; ++k) {{\n        double y = sma_plant_output(&plant);\n        double u = sma_pid_step(&pid, {set_point:?}, y, 0);\n        printf(\"%.17g,%.17g,%.17g\\n\", {set_point:?}, y, u);\n        sma_plant_step(&plant, u, 22);\n    }}\n    return 0;\n}}\n",
            shown.len()
        );
        assert_eq!(
            read(folder, "rod.h").contains("sma_gain_factor"),
            structure.contains("--gain-schedule")
        );
        if let Some(found) = compiled(folder, &main) {
            assert!(found == shown, "{structure}");
        }
    }
}

#[test]
fn source_is_the_same_every_time() {
    let folder = identified();
    let folder = folder.path();
    for language in ["c", "python"] {
        let call =
            format!("export model.toml --to {language} --gains 9 11 0.5 --drive-max 5.5 --quiet");
        let (once, _) = called(folder, &call);
        assert!(
            once.contains(&format!("sma export model.toml --to {language}")),
            "{once}"
        );
        assert!(once.contains("kp 9, ki 11, kd 0.5"), "{once}");
        assert_eq!(called(folder, &call).0, once);
    }
}

/// Description in a unit.
fn described(unit: &[u8]) -> String {
    let text = String::from_utf8_lossy(unit);
    let start = text.find("<fmiModelDescription").unwrap();
    let end = text.find("</fmiModelDescription>").unwrap() + "</fmiModelDescription>".len();
    text[start..end].to_owned()
}

#[test]
fn a_unit_holds_the_library_and_the_model() {
    let folder = identified();
    let folder = folder.path();
    // An ELF file of 64 bits for x86-64, with the mark of this version.
    let mut library = b"\x7fELF\x02\x01".to_vec();
    library.resize(18, 0);
    library.extend([62, 0]);
    library.extend(FMU_MARK.as_bytes());
    std::fs::write(folder.join("libsma_fmu.so"), &library).unwrap();
    let call = "export model.toml --to fmu --library libsma_fmu.so --output rod.fmu --quiet";
    called(folder, call);
    let unit = std::fs::read(folder.join("rod.fmu")).unwrap();
    let holds = |part: &[u8]| unit.windows(part.len()).any(|window| window == part);
    assert!(unit.starts_with(b"PK\x03\x04modelDescription.xml") || holds(b"modelDescription.xml"));
    assert!(holds(b"binaries/linux64/sma_fmu.so") && holds(&library));
    assert!(holds(b"resources/model.toml") && holds(read(folder, "model.toml").as_bytes()));
    let description = described(&unit);
    let description = roxmltree::Document::parse(&description).unwrap();
    let named = |name: &str| {
        let mut variables = description.descendants();
        variables
            .find(|node| node.attribute("name") == Some(name))
            .unwrap()
    };
    assert_eq!(named("drive").attribute("causality"), Some("input"));
    assert_eq!(named("displacement").attribute("valueReference"), Some("2"));
    called(folder, call);
    assert!(std::fs::read(folder.join("rod.fmu")).unwrap() == unit);
    let call = "export model.toml --to fmu3 --library libsma_fmu.so --output rod3.fmu --quiet";
    called(folder, call);
    let unit = std::fs::read(folder.join("rod3.fmu")).unwrap();
    let holds = |part: &[u8]| unit.windows(part.len()).any(|window| window == part);
    assert!(holds(b"binaries/x86_64-linux/sma_fmu.so"));
    let description = described(&unit);
    let description = roxmltree::Document::parse(&description).unwrap();
    let root = description.root_element();
    assert_eq!(root.attribute("fmiVersion"), Some("3.0"));
    let variables = description
        .descendants()
        .filter(|node| node.has_tag_name("Float64"));
    let causalities = variables.filter_map(|node| node.attribute("causality"));
    assert_eq!(causalities.filter(|one| *one == "independent").count(), 1);
    std::fs::write(folder.join("other.so"), &library[..20]).unwrap();
    let error = refused(
        folder,
        "export model.toml --to fmu --library other.so --output new.fmu",
    );
    assert!(
        error.starts_with(
            "sma: the library is another library, or one of another version; expected"
        ),
        "{error}"
    );
    let error = refused(
        folder,
        "export model.toml --to fmu --library none.so --output new.fmu",
    );
    assert!(
        error.contains("none.so: cannot be read: ")
            && error.contains("cargo build --release -p sma-fmu"),
        "{error}"
    );
    assert!(!folder.join("new.fmu").exists());
}

#[test]
fn what_cannot_leave_is_refused_by_name() {
    let folder = identified();
    let folder = folder.path();
    for (call, said) in [
        (
            "export model.toml --to python --float",
            "--float: for --to c alone; leave it out for --to python",
        ),
        (
            "export model.toml --to fmu --gains 1 1 1 --drive-max 5",
            "--tuned and --gains: for --to c or python alone; leave it out for --to fmu",
        ),
        (
            "export model.toml --to c --prefix Rod",
            "prefix \"Rod\": must be a lower-case letter",
        ),
        (
            "export model.toml --to c --sample-time-s 0",
            "sample time 0 s: must be finite and > 0",
        ),
        (
            "export model.toml --to c --gains 1 1 1",
            "model.toml: limits.drive_max is missing",
        ),
        (
            "export model.toml --to c --tuned rod.toml",
            "rod.toml:1:1: expected value; expected a file of `sma tune --json`",
        ),
        (
            "export model.toml --to c --tuned none.json",
            "none.json: cannot be read: ",
        ),
        (
            "export model.toml --to c --output model.toml",
            "model.toml: is an input of this command",
        ),
        ("export rod.toml --to c", "rod.toml:"),
    ] {
        let (code, text, error) = sma(folder, call);
        assert_ne!(code, 0, "{call}");
        assert_eq!(text, "");
        assert!(
            error.starts_with(&format!("sma: {said}")),
            "{call}: {error}"
        );
    }
    // Models of another kind.
    let mut csv = String::from("temperature_degc,displacement_mm\n");
    for k in 0..=200 {
        let degc = 22.0 + 0.6 * f64::from(if k <= 100 { k } else { 200 - k }) * 1.5;
        let shift = if k <= 100 { 8.0 } else { -8.0 };
        writeln!(
            csv,
            "{degc},{}",
            2.0 + 2.0 * ((degc - 66.0 - shift) / 5.0).tanh()
        )
        .unwrap();
    }
    std::fs::write(folder.join("loop.csv"), csv).unwrap();
    std::fs::write(
        folder.join("loop.toml"),
        "[drive]\nkind = \"temperature\"\n",
    )
    .unwrap();
    let call = "identify loop.toml --train loop.csv --save-model static.toml --quiet";
    let (_, _, notes) = sma(folder, call);
    assert!(folder.join("static.toml").exists(), "{notes}");
    let error = refused(folder, "export static.toml --to c");
    assert_eq!(
        error,
        "sma: static.toml: is a static loop, without a time constant; expected a model of one rod that a drive heats, from recordings with time, drive and displacement\n"
    );
}

#[test]
fn gains_of_another_model_are_refused() {
    let folder = identified();
    let folder = folder.path();
    let tuned = r#"{"command": "tune", "output_unit": "mm", "drive_unit": "A", "sample_time_s": 0.2, "drive_max": 5.5, "signs_turned": false,
        "controller": {"anti_windup": "clamping", "derivative_of": "measurement", "derivative_filter_s": 0.8,
            "setpoint_weight": 1.0, "feed_forward": false},
        "controllers": [{"name": "tuned", "gains": {"kp": 9.0, "ki": 11.0, "kd": 0.1}}]}"#;
    let call = "export model.toml --to c --tuned tuned.json --quiet";
    std::fs::write(folder.join("tuned.json"), tuned).unwrap();
    assert!(called(folder, call).0.contains("kp 9, ki 11, kd 0.1"));
    for (from, to, said) in [
        (
            "\"mm\"",
            "\"um\"",
            "output_unit = um: expected mm, as of this model: was it tuned on another one?",
        ),
        (
            "\"A\"",
            "\"V\"",
            "drive_unit = V: expected A, as of this model: was it tuned on another one?",
        ),
        (
            "\"signs_turned\": false",
            "\"signs_turned\": true",
            "signs_turned = true: expected false",
        ),
        (
            "\"feed_forward\": false",
            "\"feed_forward\": true",
            "controller.feed_forward = true: the inverse of a model has no export",
        ),
        (
            "\"clamping\"",
            "\"hope\"",
            "controller.anti_windup = hope: expected off, clamping or back-calculation",
        ),
        (
            "\"measurement\"",
            "\"luck\"",
            "controller.derivative_of = luck: expected measurement or error",
        ),
        (
            "\"tuned\", \"gains\"",
            "\"mine\", \"gains\"",
            "controllers = mine: expected one of the name tuned",
        ),
        (
            "\"tune\"",
            "\"identify\"",
            "command = identify: expected tune",
        ),
    ] {
        assert!(tuned.contains(from));
        std::fs::write(folder.join("tuned.json"), tuned.replace(from, to)).unwrap();
        let error = refused(folder, call);
        assert!(
            error.starts_with(&format!("sma: tuned.json: {said}")),
            "{error}"
        );
    }
    std::fs::write(
        folder.join("tuned.json"),
        tuned.replace("\"kp\": 9.0", "\"kp\": \"much\""),
    )
    .unwrap();
    let error = refused(folder, call);
    assert!(
        error.starts_with("sma: tuned.json:4:64: invalid type: string \"much\""),
        "{error}"
    );
    std::fs::write(
        folder.join("tuned.json"),
        tuned.replace("\"kp\": 9.0", "\"kp\": -9.0"),
    )
    .unwrap();
    let error = refused(folder, call);
    assert!(
        error.starts_with("sma: the controller is refused: kp = -9"),
        "{error}"
    );
    let ones = "[1, 1, 1, 1, 1, 1, 1, 1]";
    for (factors, said) in [
        (
            format!("\"cooling\": {ones}, \"heatin\": {ones}"),
            "tuned.json:3:154: unknown field `heatin`, expected one of `outputs`, `turn`, `heating`, `cooling`; ",
        ),
        (
            format!("\"cooling\": {ones}, \"heating\": [1, 2]"),
            "tuned.json:3:163: invalid length 2, expected an array of length 8; ",
        ),
        (
            format!("\"cooling\": {ones}, \"heating\": [1, 0.5, 1, 1, 1, 1, 1, 1]"),
            "the controller is refused: heating[1] = 0.5: a factor of a gain schedule must be finite and >= 1\n",
        ),
    ] {
        let schedule = format!(
            "\"feed_forward\": false, \"gain_schedule\": {{\"outputs\": [0, 5], \"turn\": 0.2, {factors}}}"
        );
        let text = tuned.replace("\"feed_forward\": false", &schedule);
        std::fs::write(folder.join("tuned.json"), text).unwrap();
        let error = refused(folder, call);
        assert!(error.starts_with(&format!("sma: {said}")), "{error}");
    }
    std::fs::write(folder.join("tuned.json"), tuned).unwrap();
    let error = refused(folder, &format!("{call} --sample-time-s 0.1"));
    assert!(
        error.starts_with(
            "sma: tuned.json: sample_time_s = 0.2: expected 0.1, that of --sample-time-s"
        ),
        "{error}"
    );
}
