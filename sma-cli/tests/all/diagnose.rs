//! `sma diagnose` as a user calls it.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use assert_cmd::Command;
use missing_physics::{known_effects, setting_of_rod};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};
use recording::{Recording, RecordingParts, read_csv, write_csv};
use rig_files::{model_file, rod_file};
use serde_json::Value;
use sma_effects::{EffectId, EffectSet, EffectValues, ExtendedPlant, Setting};
use wiener::{Plant, Profile, run};

use crate::folder;
use crate::generate_recording;

const AMBIENT_DEGC: f64 = 22.0;
const NOISE_MM: f64 = 0.005;
const LATENT_HEAT_J_PER_KG: f64 = 12e3;

fn bundled(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("bundled")
        .join(name)
}

/// A folder with the bundled rod file, and the bundled drives played on the same rod with latent heat.
fn with_latent_heat() -> tempfile::TempDir {
    sampled_with_latent_heat(1)
}

/// With a row for so many of the bundled ones.
pub(crate) fn sampled_with_latent_heat(every: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let rod = rod_file::read(&bundled("rod.toml")).unwrap();
    std::fs::copy(bundled("rod.toml"), folder.path().join("rod.toml")).unwrap();
    let setting = Setting {
        active: EffectSet::of(EffectId::LatentHeat),
        ..setting_of_rod(&rod, "mm")
    };
    let mut effects = EffectValues::default();
    effects.latent_heat.latent_heat_j_per_kg = LATENT_HEAT_J_PER_KG;
    let truth = generate_recording::truth().unwrap();
    let plant = ExtendedPlant::new(&setting, &truth, &effects).unwrap();
    let noise = Normal::new(0.0, NOISE_MM).unwrap();
    for (name, seed) in [("train.csv", 1), ("validate.csv", 2)] {
        let driven = read_csv(bundled(name), &rod.read_options()).unwrap();
        let drive: Vec<f64> = driven.drive().iter().copied().step_by(every).collect();
        let time_s = driven.time_s().iter().copied().step_by(every);
        let profile = Profile::uniform(&drive, 0.2 * every as f64, AMBIENT_DEGC).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut output = Vec::new();
        run(
            &plant,
            &mut plant.rest(AMBIENT_DEGC),
            &profile,
            |_, shown| {
                output.push(shown.displacement[0] + noise.sample(&mut rng));
            },
        );
        let recording = Recording::new(RecordingParts {
            name: name.to_owned(),
            time_s: Some(time_s.collect()),
            drive,
            output_unit: "mm".to_owned(),
            output,
            ..RecordingParts::default()
        })
        .unwrap();
        let mut bytes = Vec::new();
        write_csv(&recording, &mut bytes).unwrap();
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

fn diagnose(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::cargo_bin("sma").unwrap();
    command
        .current_dir(folder)
        .args(["diagnose", "rod.toml", "--train", "train.csv"])
        .args(args);
    command
}

/// The document for the rod with latent heat, without unseen recordings.
fn not_validated() -> &'static Value {
    static DOCUMENT: OnceLock<Value> = OnceLock::new();
    DOCUMENT.get_or_init(|| json(with_latent_heat().path(), &["--threads", "1"]))
}

/// The document for the rod with latent heat, with an unseen recording.
fn validated() -> &'static Value {
    &diagnosed().document
}

/// A diagnosis whose model was saved.
struct Diagnosed {
    document: Value,
    /// Text on stderr.
    notes: String,
    model: String,
    /// Files of the figures, by name.
    figures: BTreeMap<String, String>,
    /// The page.
    report: String,
}

/// That of the rod with latent heat, with an unseen recording.
fn diagnosed() -> &'static Diagnosed {
    static DIAGNOSED: OnceLock<Diagnosed> = OnceLock::new();
    DIAGNOSED.get_or_init(|| {
        let folder = with_latent_heat();
        let args = ["--validate", "validate.csv", "--json", "-"];
        let assert = diagnose(folder.path(), &args)
            .args(["--save-model", "model.toml", "--plots", "figures"])
            .args(["--report", "report.html"])
            .assert()
            .success();
        let output = assert.get_output();
        let figures = std::fs::read_dir(folder.path().join("figures")).unwrap();
        let figures = figures.map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            (name, std::fs::read_to_string(path).unwrap())
        });
        Diagnosed {
            report: std::fs::read_to_string(folder.path().join("report.html")).unwrap(),
            figures: figures.collect(),
            document: serde_json::from_slice(&output.stdout).unwrap(),
            notes: String::from_utf8(output.stderr.clone()).unwrap(),
            model: std::fs::read_to_string(folder.path().join("model.toml")).unwrap(),
        }
    })
}

/// The folder of the rod with latent heat, with the saved model in it.
fn with_saved_model() -> tempfile::TempDir {
    let folder = with_latent_heat();
    std::fs::write(folder.path().join("model.toml"), &diagnosed().model).unwrap();
    folder
}

fn sma(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::cargo_bin("sma").unwrap();
    command.current_dir(folder).args(args);
    command
}

/// Number behind the last "to " of a note.
fn rms(notes: &str) -> f64 {
    let said = notes
        .lines()
        .find(|line| line.contains("has an output too"));
    let number = said.unwrap().rsplit(" to ").next().unwrap();
    number.split(' ').next().unwrap().parse().unwrap()
}

fn stdout(command: &mut Command) -> String {
    String::from_utf8(command.assert().success().get_output().stdout.clone()).unwrap()
}

fn json(folder: &Path, args: &[&str]) -> Value {
    serde_json::from_str(&stdout(diagnose(folder, args).args(["--json", "-"]))).unwrap()
}

/// Exit code and stderr of a call that fails.
fn refusal(folder: &Path, args: &[&str]) -> (i32, String) {
    let assert = diagnose(folder, args).assert().failure();
    let output = assert.get_output();
    assert!(output.stdout.is_empty(), "stdout is for results");
    let error = String::from_utf8(output.stderr.clone()).unwrap();
    (output.status.code().unwrap(), error)
}

fn keys(value: &Value) -> Vec<&str> {
    value
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect()
}

#[test]
fn an_output_that_has_nothing_to_do_with_the_drive_is_not_described() {
    let folder = sampled_with_latent_heat(8);
    let text = std::fs::read_to_string(folder.path().join("train.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let mut spoiled = String::new();
    for (k, row) in rows.iter().enumerate() {
        let output = match k {
            0 => row[2],
            _ => rows[rows.len() - k][2],
        };
        spoiled += &format!("{},{},{output}\n", row[0], row[1]);
    }
    std::fs::write(folder.path().join("backward.csv"), spoiled).unwrap();
    let (code, text, _) = folder::sma(
        folder.path(),
        "diagnose rod.toml --train backward.csv --quiet",
    );
    assert_eq!(code, 4, "{text}");
    let first = "UNEXPLAINED: the model does not describe this recording.";
    assert!(text.contains(first), "{text}");
}

#[test]
fn latent_heat_is_named_and_measured() {
    let json = validated();
    assert_eq!(json["schema_version"], 1);
    assert_eq!(json["command"], "diagnose");
    assert_eq!(json["seed"], 1);
    assert_eq!(json["output_unit"], "mm");
    assert_eq!(json["verdict"], "explained");
    let finding = &json["findings"][0];
    assert_eq!(finding["effect"], "latent-heat");
    assert_eq!(finding["plausible"], true);
    assert_eq!(finding["literature"], serde_json::json!([4000.0, 37000.0]));
    let size = &finding["parameters"][0];
    assert_eq!(size["name"], "latent_heat_j_per_kg");
    assert_eq!(size["unit"], "J/kg");
    let value = size["value"].as_f64().unwrap();
    assert!((value / LATENT_HEAT_J_PER_KG - 1.0).abs() < 0.05, "{value}");
    assert_eq!(
        json["extended"]["effects"],
        serde_json::json!(["latent-heat"])
    );
    for (stage, key) in [("extended", "train_rmse"), ("extended", "validate_rmse")] {
        let rmse = json[stage][key].as_f64().unwrap();
        assert!((0.0045..0.0055).contains(&rmse), "{stage} {key} = {rmse}");
    }
    let share = json["explained_fraction"]["validate"].as_f64().unwrap();
    assert!((0.98..1.02).contains(&share), "{share}");
}

#[test]
fn the_document_has_its_keys() {
    let json = validated();
    insta::assert_snapshot!(
        [
            ("", json),
            ("noise_floor", &json["noise_floor"]),
            ("baseline", &json["baseline"]),
            ("baseline.parameters", &json["baseline"]["parameters"][0]),
            ("extended", &json["extended"]),
            ("explained_fraction", &json["explained_fraction"]),
            ("mismatch", &json["mismatch"]),
            ("findings", &json["findings"][0]),
            ("findings.parameters", &json["findings"][0]["parameters"][0]),
            ("catalogue", &json["catalogue"][0]),
        ]
        .map(|(place, value)| format!("{place}: {}", keys(value).join(" ")))
        .join("\n")
    );
    let effects: Vec<&str> = json["catalogue"]
        .as_array()
        .unwrap()
        .iter()
        .map(|entry| entry["effect"].as_str().unwrap())
        .collect();
    assert_eq!(effects, EffectId::ALL.map(EffectId::id));
}

#[test]
fn the_verdict_comes_first_and_can_be_read_aloud() {
    let folder = with_latent_heat();
    let text = stdout(&mut diagnose(
        folder.path(),
        &["--validate", "validate.csv", "--quiet"],
    ));
    // The class, the effect, the error on what was not seen.
    let headline: String = text.lines().take(2).collect::<Vec<_>>().join(" ");
    let first = "EXPLAINED: latent heat is missing from the baseline model. With it the error on the unseen recording falls from ";
    assert!(headline.starts_with(first), "{text}");
    assert!(headline.ends_with(" times the noise."), "{text}");
    // The size, and the rules that decided.
    let paragraph = |beginning: &str| -> String {
        let lines = text
            .lines()
            .skip_while(|line| !line.trim_start().starts_with(beginning));
        let joined: Vec<&str> = lines.map(str::trim).take(3).collect();
        joined.join(" ")
    };
    assert!(
        paragraph("1. ").contains("kJ/kg while transforming"),
        "{text}"
    );
    let why = paragraph("Why: ");
    for reason in [
        "Why: without it ",
        " of the explainable error comes back; chance does as much in ",
        " of draws (needs ≤ 1 %); in unseen data ",
        " of the change that it predicts is there (needs 50-150 %).",
    ] {
        assert!(why.contains(reason), "{reason}: {text}");
    }
    // A page of a terminal, without pictures of dots and without the catalogue.
    assert!(text.lines().count() <= 40, "{text}");
    assert!(
        text.lines().all(|line| line.chars().count() <= 100),
        "{text}"
    );
    assert!(!text.contains("recorded - "), "{text}");
    assert!(!text.contains("sensor-drift"), "{text}");
    // Without unseen data, and with all that is behind the verdict.
    let text = stdout(&mut diagnose(folder.path(), &["-v", "--quiet"]));
    let flowing = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for said in [
        "not yet tested on unseen recordings (--validate).",
        "explained on stretches of the training that were held out.",
        "The catalogue",
        "sensor-drift",
    ] {
        assert!(flowing.contains(said), "{said}: {text}");
    }
}

#[test]
fn pictures_are_for_a_terminal() {
    let call = ["--plot", "--json", "fit.json"];
    let folder = tempfile::tempdir().unwrap();
    for name in ["rod.toml", "train.csv"] {
        std::fs::copy(bundled(name), folder.path().join(name)).unwrap();
    }
    let mut sma = Command::cargo_bin("sma").unwrap();
    let run = sma
        .current_dir(folder.path())
        .args(["identify", "rod.toml", "--train", "train.csv"])
        .args(call)
        .assert()
        .success();
    let output = run.get_output();
    let notes = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(
        notes.contains("note: --plot draws in a terminal, and stdout is none; "),
        "{notes}"
    );
    assert!(!String::from_utf8_lossy(&output.stdout).contains("Met worst"));
}

#[test]
fn figures_are_drawn_and_their_numbers_stand_beside_them() {
    let figures = &diagnosed().figures;
    let names: Vec<&str> = figures.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "drive.csv",
            "drive.svg",
            "ladder.csv",
            "ladder.svg",
            "loop-after.csv",
            "loop-after.svg",
            "loop-before.csv",
            "loop-before.svg",
            "recording.csv",
            "recording.svg",
            "series-1-validate.csv",
            "series-2-train.csv",
            "what-is-left.csv",
            "what-is-left.svg",
        ]
    );
    let lines = |name: &str| figures[name].lines().count();
    let n_samples = lines("loop-before.csv") / 2;
    assert_eq!(lines("recording.csv"), 1 + 3 * n_samples);
    assert_eq!(lines("what-is-left.csv"), 1 + 2 * n_samples);
    assert!(
        figures["recording.csv"].starts_with("curve,\"time, s\",\"output, mm\"\n\"recorded\",0,")
    );
    // Error of the baseline model and with what was found, on both recordings, and the noise.
    assert_eq!(lines("ladder.csv"), 1 + 2 + 2 + 2);
    assert!(figures["ladder.svg"].contains("+ latent-heat"));
    // All recordings, sample by sample.
    let of_unseen = figures["series-1-validate.csv"].lines().next().unwrap();
    assert_eq!(
        of_unseen,
        "time_s,drive,recorded_mm,baseline_mm,extended_mm"
    );
    assert_eq!(lines("series-1-validate.csv"), 1 + n_samples);
    let drawn = |name: &str, color: &str| {
        let lines = figures[name].lines();
        let of_color = |line: &&str| line.starts_with("<polyline") && line.contains(color);
        lines.filter(of_color).count()
    };
    for color in ["#D55E00", "#0072B2"] {
        assert_eq!(drawn("what-is-left.svg", color), 1, "{color}");
        assert_eq!(drawn("recording.svg", color), 1, "{color}");
    }
    assert_eq!(drawn("recording.svg", "#AAAAAA"), 1);
    assert!(figures["recording.svg"].len() < 100_000);
}

#[test]
fn the_report_is_one_page_that_says_the_verdict_first() {
    let page = &diagnosed().report;
    assert!(page.len() < 1_000_000, "{}", page.len());
    let tree = roxmltree::Document::parse(page.trim_start_matches("<!DOCTYPE html>")).unwrap();
    let all = |name: &'static str| {
        let nodes = tree.descendants();
        nodes.filter(move |node| node.tag_name().name() == name)
    };
    let heading = all("h1").next().unwrap().text().unwrap();
    assert!(
        heading.starts_with("EXPLAINED: latent heat is missing "),
        "{heading}"
    );
    // Errors, recording, what is left, two loops.
    let figures: Vec<_> = all("figure").collect();
    assert!(figures.len() >= 5, "{}", figures.len());
    for figure in &figures {
        let of = |name: &'static str| {
            let mut parts = figure.descendants();
            parts.find(move |part| part.tag_name().name() == name)
        };
        assert!(!of("figcaption").unwrap().text().unwrap().is_empty());
        let Some(plot) = figure.attribute("data-plot") else {
            continue;
        };
        let plot: Value = serde_json::from_str(plot).unwrap();
        let curves = figure.descendants().filter(|part| {
            let points = part.attribute("points").unwrap_or("");
            part.tag_name().name() == "polyline" && points.split_whitespace().count() > 2
        });
        assert_eq!(curves.count(), plot["labels"].as_array().unwrap().len());
    }
    let guilty = all("li").find(|item| item.attribute("class") == Some("guilty"));
    let guilty = guilty.unwrap().descendants().find_map(|part| part.text());
    assert_eq!(guilty, Some("heat balance"));
    // Nothing is fetched, and the call stands at the end.
    for attribute in ["src", "href"] {
        assert!(
            tree.descendants()
                .all(|node| node.attribute(attribute).is_none())
        );
    }
    assert!(page.contains("sma diagnose rod.toml --train train.csv"));
}

#[test]
fn an_effect_that_may_not_be_found_is_no_finding() {
    let folder = with_latent_heat();
    let json = json(folder.path(), &["--without", "latent-heat"]);
    assert_ne!(json["verdict"], "adequate");
    for key in ["findings", "suspects"] {
        let named = json[key].as_array().unwrap();
        assert!(named.iter().all(|one| one["effect"] != "latent-heat"));
        let is_sure = key == "findings";
        assert!(
            named
                .iter()
                .all(|one| one["probability"].is_f64() == is_sure)
        );
    }
    let entries = json["catalogue"].as_array().unwrap();
    let entry = entries
        .iter()
        .find(|one| one["effect"] == "latent-heat")
        .unwrap();
    assert_eq!(entry["verdict"], "not_testable");
    assert_eq!(entry["reason"], "left out by --without");
}

#[test]
fn a_rod_that_lacks_nothing_is_adequate() {
    let text = stdout(&mut diagnose(
        &bundled(""),
        &["--validate", "validate.csv", "--no-plot", "-q"],
    ));
    insta::assert_snapshot!(text);
    let json = json(&bundled(""), &["--validate", "validate.csv"]);
    assert_eq!(json["verdict"], "adequate");
    assert_eq!(json["findings"], serde_json::json!([]));
    assert_eq!(json["extended"], Value::Null);
    assert_eq!(json["mismatch"]["block"], Value::Null);
}

#[test]
fn training_data_are_not_unseen() {
    let assert = diagnose(&bundled(""), &["--validate", "train.csv", "--json", "-"])
        .assert()
        .success();
    let output = assert.get_output();
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["baseline"]["validate_rmse"], Value::Null);
    let notes = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(notes.contains("train.csv: it is not unseen\n"), "{notes}");
}

#[test]
fn threads_do_not_move_a_byte() {
    let folder = with_latent_heat();
    let on_two = json(folder.path(), &["--threads", "2"]);
    // Numbers round-trip: equal documents are equal bytes.
    assert_eq!(not_validated().to_string(), on_two.to_string());
}

#[test]
fn an_uncertain_specific_heat_widens_what_scales_with_it() {
    let folder = with_latent_heat();
    let sharp = not_validated();
    let rod = std::fs::read_to_string(folder.path().join("rod.toml")).unwrap();
    let uncertain = rod.replace(
        "specific_heat_j_per_kg_k = 480.0",
        "specific_heat_j_per_kg_k = { value = 480.0, range = [450.0, 840.0] }",
    );
    std::fs::write(folder.path().join("rod.toml"), uncertain).unwrap();
    let wide = json(folder.path(), &[]);
    assert_eq!(
        wide["specific_heat_range_carried"],
        serde_json::json!([450.0, 840.0])
    );
    let width = |json: &Value, stage: &str, name: &str| {
        let parameters = json[stage]["parameters"].as_array().unwrap();
        let parameter = parameters.iter().find(|one| one["name"] == name).unwrap();
        let end = |k: usize| parameter["ci95"][0][k].as_f64().unwrap();
        end(1) - end(0)
    };
    for stage in ["baseline", "extended"] {
        let name = "loop_half_width_k";
        assert!(
            width(&wide, stage, name) > 2.0 * width(sharp, stage, name),
            "{stage}"
        );
    }
    // A heat over a power is a time: no temperature enters.
    assert_eq!(wide["findings"], sharp["findings"]);
}

#[test]
fn without_a_resistance_a_heat_is_counted_in_the_power_of_nitis_resistivity() {
    let folder = with_latent_heat();
    let rod = std::fs::read_to_string(folder.path().join("rod.toml")).unwrap();
    let kept = |line: &&str| !line.starts_with("resistance_ohm_per_m");
    let without: Vec<&str> = rod.lines().filter(kept).collect();
    std::fs::write(folder.path().join("rod.toml"), without.join("\n")).unwrap();
    let json = json(folder.path(), &[]);
    assert_eq!(
        json["resistivity_range_carried"],
        serde_json::json!([0.76e-6, 1e-6])
    );
    let found = &json["findings"][0];
    assert_eq!(found["effect"], "latent-heat");
    let sentence = found["sentence"].as_str().unwrap();
    let said = "; for a resistivity of 0.76 to 1.0 µΩ m, since the resistance is not given: ";
    assert!(sentence.contains(said), "{sentence}");
    let end = |k: usize| found["parameters"][0]["ci95"][k].as_f64().unwrap();
    assert!(end(0) < LATENT_HEAT_J_PER_KG && LATENT_HEAT_J_PER_KG < end(1));
}

#[test]
fn a_saved_model_has_what_was_found() {
    let Diagnosed {
        document,
        notes,
        model,
        ..
    } = diagnosed();
    assert!(
        notes.contains("note: the model with latent-heat is saved\n"),
        "{notes}"
    );
    let saved = model_file::parse_with("model.toml", model, &known_effects).unwrap();
    assert_eq!(model_file::to_toml(&saved).unwrap(), *model);
    assert_eq!(saved.effects.unwrap().ids, ["latent-heat"]);
    assert!(saved.scores.converged);
    assert_eq!(saved.provenance.input.len(), 3);
    assert!(
        saved
            .provenance
            .command
            .starts_with("sma diagnose rod.toml")
    );
    let latent = saved.parameters.last().unwrap();
    assert_eq!(latent.info.name, "latent_heat_j_per_kg");
    let found = &document["findings"][0]["parameters"][0];
    assert_eq!(found["value"], latent.values[0]);
    let interval = latent.intervals[0].unwrap();
    assert_eq!(
        found["ci95"],
        serde_json::json!([interval.lower, interval.upper])
    );
    for (key, rmse) in [
        ("train_rmse", Some(saved.scores.train_rmse)),
        ("validate_rmse", saved.scores.validate_rmse),
    ] {
        assert_eq!(document["extended"][key], serde_json::json!(rmse), "{key}");
    }
}

#[test]
fn a_saved_model_is_simulated_with_what_was_found() {
    let folder = with_saved_model();
    // Its offset is read at rest, and the surroundings are as stated: the diagnosis fits both.
    for (drive, key) in [
        ("validate.csv", "validate_rmse"),
        ("train.csv", "train_rmse"),
    ] {
        let args = [
            "simulate",
            "model.toml",
            "--drive",
            drive,
            "--output",
            "predicted.csv",
        ];
        let assert = sma(folder.path(), &args).assert().success();
        let notes = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
        let said = validated()["extended"][key].as_f64().unwrap();
        assert!((rms(&notes) / said - 1.0).abs() < 0.02, "{said} {notes}");
        assert!(
            notes.ends_with("note: the baseline model with latent-heat is simulated\n"),
            "{notes}"
        );
    }
}

#[test]
fn gains_are_tuned_on_what_was_found() {
    let folder = with_saved_model();
    let model = &diagnosed().model;
    let saved = model_file::parse_with("model.toml", model, &known_effects).unwrap();
    let latent = format!("value = {:?}\n", saved.parameters.last().unwrap().values[0]);
    assert_eq!(model.matches(&latent).count(), 1, "{latent}{model}");
    let without = model.replace(&latent, "value = 0.0\n");
    std::fs::write(folder.path().join("without.toml"), without).unwrap();
    // A short search: that it runs on the plant with its effects is to be seen.
    let tune = |model: &str, options: &[&str]| {
        let args = ["tune", model, "--drive-max", "5.5", "--duration-s", "60"];
        let short = ["--preset", "sadeghi", "--draws", "10", "-q"];
        sma(folder.path(), &[&args[..], &short, options].concat())
    };
    let tuned = |model: &str| -> Value {
        let text = stdout(&mut tune(model, &["--step-output", "2.5", "--json", "-"]));
        serde_json::from_str(&text).unwrap()
    };
    let [without, with] = ["without.toml", "model.toml"].map(tuned);
    assert_eq!(with["effects"], serde_json::json!(["latent-heat"]));
    let term = |result: &Value, controller: usize, term: &str| {
        result["controllers"][controller]["terms"][term]
            .as_f64()
            .unwrap()
    };
    // The heat of the transformation has to come from the drive: the same gains rise later.
    let [short_s, long_s] = [&without, &with].map(|result| term(result, 0, "rise_time_s"));
    assert!(long_s > 1.05 * short_s, "{long_s} {short_s}");
    assert_ne!(
        without["controllers"][1]["gains"],
        with["controllers"][1]["gains"]
    );
    let names: Vec<&str> = with["sensitivities"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["parameter"].as_str().unwrap())
        .collect();
    assert!(
        names.contains(&"tau_s") && names.contains(&"latent_heat_j_per_kg"),
        "{names:?}"
    );
    let text = stdout(&mut tune("model.toml", &["--step-output", "2.5"]));
    assert!(
        text.contains("\nAll of it is with latent-heat.\n"),
        "{text}"
    );
    // Too far for the rod, latent heat or not.
    let assert = tune("model.toml", &["--step-output", "9"]).assert().code(3);
    let error = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(
        error.starts_with("sma: set point 9 mm: beyond what the rig reaches, 0."),
        "{error}"
    );
}

#[test]
fn the_plain_part_of_a_saved_model_is_a_start() {
    let folder = with_saved_model();
    let args = [
        "identify",
        "rod.toml",
        "--train",
        "train.csv",
        "--from-model",
        "model.toml",
    ];
    let options = ["--starts", "1", "--json", "-"];
    let assert = sma(folder.path(), &[&args[..], &options].concat())
        .assert()
        .success();
    let output = assert.get_output();
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["fit"]["starts"], 2);
    let notes = String::from_utf8(output.stderr.clone()).unwrap();
    assert!(
        notes.contains(
            "note: model.toml has effects (latent-heat): its baseline part is the start, the baseline model is fitted\n"
        ),
        "{notes}"
    );
}

#[test]
fn model_files_with_effects_that_cannot_be_are_refused() {
    let folder = with_saved_model();
    let at = folder.path();
    let model = &diagnosed().model;
    let line_of = |what: &str| model[..model.find(what).unwrap()].matches('\n').count() + 1;
    let known = EffectId::ALL.map(EffectId::id).join(" ");
    for (from, to, expected) in [
        (
            "effects = [\"latent-heat\"]",
            "effects = [\"latent-heta\"]",
            format!(
                "model.toml:{}:12: effects: \"latent-heta\": no such effect; known are {known}",
                line_of("effects = ")
            ),
        ),
        (
            "name = \"latent_heat_j_per_kg\"\nvalue = ",
            "name = \"latent_heat_j_per_kg\"\nvalue = -",
            format!(
                "model.toml:{}:1: parameter latent_heat_j_per_kg = -{}: must lie from 0e0 to 6e4 J/kg",
                line_of("name = \"latent_heat_j_per_kg\"") - 1,
                model_file::parse_with("model.toml", model, &known_effects)
                    .unwrap()
                    .parameters
                    .last()
                    .unwrap()
                    .values[0],
            ),
        ),
        (
            "newton_iterations = 3",
            "newton_iterations = 0",
            "model: newton_iterations = 0: must be in 1..=50".to_owned(),
        ),
    ] {
        assert!(model.contains(from), "{from}\n{model}");
        std::fs::write(at.join("model.toml"), model.replacen(from, to, 1)).unwrap();
        for args in [
            &["simulate", "model.toml", "--drive", "train.csv"][..],
            &[
                "tune",
                "model.toml",
                "--step-output",
                "2.5",
                "--drive-max",
                "5.5",
            ],
        ] {
            let assert = sma(at, args).assert().code(3);
            let output = assert.get_output();
            assert!(output.stdout.is_empty(), "stdout is for results");
            let error = String::from_utf8(output.stderr.clone()).unwrap();
            assert_eq!(error, format!("sma: {expected}\n"));
        }
    }
}

#[test]
fn effects_that_do_not_exist_are_named_with_those_that_do() {
    let (code, error) = refusal(&bundled(""), &["--without", "latent-heta"]);
    assert_eq!(code, 2);
    assert!(
        error.contains(
            "effect 'latent-heta': unknown; known are supply-limit supply-lag dead-time latent-heat"
        ),
        "{error}"
    );
}

#[test]
fn the_help_lists_every_effect() {
    let mut command = Command::cargo_bin("sma").unwrap();
    let help = stdout(command.args(["diagnose", "--help"]));
    for effect in EffectId::ALL {
        assert!(help.contains(effect.id()), "{effect}");
    }
}

#[test]
fn errors_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(bundled("rod.toml"), folder.path().join("rod.toml")).unwrap();
    let outputs = [
        "--json",
        "found.json",
        "--save-next",
        "next.csv",
        "--save-model",
        "model.toml",
    ];
    let (code, error) = refusal(folder.path(), &outputs);
    assert_eq!(code, 3);
    assert_eq!(
        error,
        "sma: train.csv: cannot be read: No such file or directory (os error 2)\n"
    );
    std::fs::copy(bundled("train.csv"), folder.path().join("train.csv")).unwrap();
    for flag in ["--json", "--save-next", "--save-model", "--report"] {
        let (code, error) = refusal(folder.path(), &[flag, "train.csv"]);
        assert_eq!(code, 1);
        assert_eq!(
            error,
            "sma: train.csv: is an input of this command; give another file for the result\n"
        );
    }
    let (code, error) = refusal(folder.path(), &["--plots", "train.csv"]);
    assert_eq!(code, 1);
    assert_eq!(
        error,
        "sma: train.csv: is a file; give a folder for the figures\n"
    );
    let (code, error) = refusal(
        folder.path(),
        &["--from-model", "none.toml", "--save-next", "next.csv"],
    );
    assert_eq!(code, 3);
    assert!(
        error.starts_with("sma: none.toml: cannot be read: "),
        "{error}"
    );
    let files = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(files, 2, "nothing is left half written");
}

#[test]
fn no_next_run_is_no_file_and_nothing_found_is_a_plain_model() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["rod.toml", "train.csv"] {
        std::fs::copy(bundled(name), folder.path().join(name)).unwrap();
    }
    let args = ["--save-next", "next.csv", "--save-model", "model.toml"];
    let assert = diagnose(folder.path(), &args).assert().success();
    let notes = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    assert!(
        notes.contains("no next run is proposed: --save-next writes nothing\n"),
        "{notes}"
    );
    assert!(!folder.path().join("next.csv").exists());
    // Nothing is missing: what is saved is a baseline model, as one that was identified.
    assert!(
        notes.contains("the baseline model is saved: no effect was found\n"),
        "{notes}"
    );
    let model = std::fs::read_to_string(folder.path().join("model.toml")).unwrap();
    let saved = model_file::parse("model.toml", &model).unwrap();
    assert_eq!(saved.effects, None);
    assert_eq!(model_file::to_toml(&saved).unwrap(), model);
}

/// A loop under a load: heated and cooled twice between 20 and 110 °C, once in part, and shifted by a kelvin
/// for each 7.5 MPa.
fn static_loop(stress_mpa: f64) -> String {
    let mut text = "temperature_degc,displacement_mm,stress_mpa\n".to_owned();
    let shift_k = stress_mpa / 7.5;
    let up = (0..90).map(|k| (20.0 + f64::from(k), 66.0));
    let down = (0..90).map(|k| (110.0 - f64::from(k), 52.0));
    for (k, (temperature_degc, center_degc)) in up.chain(down).enumerate() {
        let place = (temperature_degc - center_degc - shift_k) / 8.0;
        // A wiggle in place of noise.
        let wiggle_mm = 0.01 * (7.0 * k as f64).sin();
        let displacement_mm = 2.0 + 4.0 * (0.5 + place.atan() / std::f64::consts::PI) + wiggle_mm;
        let _ = writeln!(text, "{temperature_degc},{displacement_mm:.5},{stress_mpa}");
    }
    text
}

/// A folder with static recordings under these loads, MPa.
fn static_rig(loads_mpa: &[f64]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("rod.toml"),
        "[drive]\nkind = \"temperature\"\n",
    )
    .unwrap();
    for (stress_mpa, name) in loads_mpa.iter().zip(["train.csv", "other.csv"]) {
        std::fs::write(folder.path().join(name), static_loop(*stress_mpa)).unwrap();
    }
    folder
}

#[test]
fn static_recordings_under_two_loads_tell_the_stress_coupling() {
    let folder = static_rig(&[50.0, 150.0]);
    let json = json(folder.path(), &["other.csv", "--quiet"]);
    assert_eq!(json["verdict"], "explained_in_part");
    assert_eq!(json["findings"][0]["effect"], "stress-coupling");
    let parameters = json["findings"][0]["parameters"].as_array().unwrap();
    let found = parameters
        .iter()
        .find(|one| one["name"] == "stress_coupling_mpa_per_k")
        .unwrap();
    let value = found["value"].as_f64().unwrap();
    assert!((value / 7.5 - 1.0).abs() < 0.05, "{value}");
    let entries = json["catalogue"].as_array().unwrap();
    let said = |id: &str| {
        let entry = entries.iter().find(|one| one["effect"] == id).unwrap();
        (entry["verdict"].as_str().unwrap(), entry["reason"].as_str())
    };
    assert_eq!(said("stress-coupling"), ("detected", None));
    assert_eq!(said("latent-heat"), ("not_testable", Some("needs time")));
    assert_eq!(
        said("phase-dependent-resistance"),
        ("not_testable", Some("no recording has a resistance"))
    );
    // The same keys as with time.
    let of_time = [
        "left_out",
        "simulations",
        "simulations_of",
        "specific_heat_range_carried",
        "resistivity_range_carried",
    ];
    for key in keys(not_validated()) {
        assert!(of_time.contains(&key) || json.get(key).is_some(), "{key}");
    }
    let text = stdout(&mut diagnose(folder.path(), &["other.csv", "--quiet"]));
    assert!(
        text.starts_with(
            "EXPLAINED IN PART: stress coupling is missing from the loop.\n\
             Stress coupling is missing: the loop shifts with the stress, 7."
        ),
        "{text}"
    );
}

#[test]
fn one_load_tests_no_coupling_and_the_verdict_is_null() {
    let folder = static_rig(&[50.0]);
    let json = json(folder.path(), &["--quiet"]);
    assert_eq!(json["verdict"], Value::Null);
    assert_eq!(json["findings"], serde_json::json!([]));
}

/// A fan that is not there.
const FAN: &str = r#"
[[hypothesis]]
id = "fan"
heat_flow_w_per_m = "-k * (T - Ta) * (1 - cos(2 * pi * t / 50))"
[hypothesis.parameters.k]
unit = "W/(m K)"
typical = 0.02
bounds = [0.0, 0.2]
"#;

#[test]
fn a_hypothesis_of_ones_own_competes() {
    let folder = with_latent_heat();
    std::fs::write(folder.path().join("own.toml"), FAN).unwrap();
    let json = json(folder.path(), &["--hypothesis", "own.toml"]);
    assert_eq!(json["findings"][0]["effect"], "latent-heat");
    let entries = json["catalogue"].as_array().unwrap();
    let fan = entries.iter().find(|entry| entry["effect"] == "fan");
    assert_eq!(fan.unwrap()["verdict"], "excluded");
}

#[test]
fn a_hypothesis_that_does_not_vanish_is_refused_with_its_place() {
    let folder = with_latent_heat();
    let bad = FAN.replace("-k *", "-0.1 - k *");
    std::fs::write(folder.path().join("own.toml"), bad).unwrap();
    let (code, error) = refusal(folder.path(), &["--hypothesis", "own.toml"]);
    assert_eq!(code, 3, "{error}");
    assert!(error.contains("own.toml:4:"), "{error}");
}
