//! A rig that is another from run to run, as a user sees it.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::fmt::Write;
use std::fs;
use std::path::Path;

use serde_json::Value;
use wiener::hysteresis::{LoopParams, Rule};
use wiener::thermal::RodParams;
use wiener::{Drive, Plant, Profile, Wiener, WienerParams, run};

use crate::folder::sma;

const AMBIENT_DEGC: f64 = 22.0;
const DT_S: f64 = 0.5;

pub(crate) const ROD: &str = "\
[rod]
diameter_mm = 0.75
length_mm = 125.0
density_kg_per_m3 = 6450.0
specific_heat_j_per_kg_k = 480.0
resistance_ohm_per_m = 2.13

[surroundings]
ambient_degc = 22.0

[columns]
drive = \"current_a\"
output = \"displacement_mm\"
";

/// Two triangles of these heights, A, under which a wire moves that loses more heat by a share, and moves further by another.
pub(crate) fn ran(folder: &Path, name: &str, heights_a: [f64; 2], [heat_loss, stroke]: [f64; 2]) {
    let rod = RodParams {
        diameter_m: 0.75e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 480.0,
        resistance_ohm_per_m: 2.13,
        convective_coefficient_w_per_m2_k: 60.0 * (1.0 + heat_loss),
    };
    let params = WienerParams {
        heat: rod.heat_balance().unwrap(),
        limiting_loop: LoopParams {
            loop_center_degc: 55.0,
            loop_half_width_k: 8.0,
            loop_spread_k: 3.0,
            ..LoopParams::default()
        },
        zeta: 0.85,
        gain: 5.0 * (1.0 + stroke),
        offset: 0.2,
    };
    let triangle = |height_a: f64| {
        let share = |k: u32| match k {
            0..40 => 0.0,
            40..130 => f64::from(k - 40) / 90.0,
            _ => 1.0 - f64::from(k - 130) / 90.0,
        };
        (0..220).map(move |k| height_a * share(k))
    };
    let drive: Vec<f64> = heights_a.into_iter().flat_map(triangle).collect();
    let wire = Wiener::new(Drive::Current, Rule::LastReversal, &[params]).unwrap();
    let profile = Profile::uniform(&drive, DT_S, AMBIENT_DEGC).unwrap();
    let mut text = "time_s,current_a,displacement_mm\n".to_owned();
    let (mut noise, mut k) = (0.5_f64, 0);
    run(&wire, &mut wire.rest(AMBIENT_DEGC), &profile, |_, shown| {
        noise = (noise * 997.0 + 0.123).fract();
        let displacement_mm = shown.displacement[0] + 0.02 * (noise - 0.5);
        let current_a = drive[k];
        writeln!(
            text,
            "{:.1},{current_a:.5},{displacement_mm:.5}",
            DT_S * k as f64
        )
        .unwrap();
        k += 1;
    });
    fs::write(folder.join(name), text).unwrap();
}

/// Copies a recording whose output is shown half a second late.
pub(crate) fn late(folder: &Path, of: &str, name: &str) {
    let recorded = fs::read_to_string(folder.join(of)).unwrap();
    let rows = recorded
        .lines()
        .skip(1)
        .map(|line| line.split(',').collect());
    let rows: Vec<Vec<&str>> = rows.collect();
    let mut text = "time_s,current_a,displacement_mm\n".to_owned();
    for (k, row) in rows.iter().enumerate() {
        let shown = rows[k.saturating_sub(1)][2];
        writeln!(text, "{},{},{shown}", row[0], row[1]).unwrap();
    }
    fs::write(folder.join(name), text).unwrap();
}

#[test]
fn how_far_runs_repeat_and_what_differs_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("rod.toml"), ROD).unwrap();
    ran(folder, "a.csv", [2.3, 1.9], [0.0, 0.0]);
    ran(folder, "b.csv", [2.3, 1.9], [0.07, -0.01]);
    ran(folder, "unseen.csv", [2.0, 2.2], [-0.05, 0.01]);

    let (code, inspected, _) = sma(folder, "inspect a.csv b.csv --rod rod.toml");
    assert_eq!(code, 0);
    assert!(inspected.contains("Runs of the same drive\n  a.csv and b.csv, 0.0 to 219.5 s: "));
    assert!(inspected.contains("Runs of the same drive do not repeat: they are 0.2"));

    let (code, _, notes) = sma(folder, "identify rod.toml --train a.csv b.csv --no-plot");
    assert_eq!(code, 0);
    assert!(
        notes.contains("Runs of the same drive do not repeat"),
        "{notes}"
    );

    let call = "diagnose rod.toml --train a.csv b.csv --validate unseen.csv --quiet -v --json found.json --report page.html \
                --plots figures --save-model model.toml";
    let (code, text, said) = sma(folder, call);
    assert_eq!(code, 0, "{said}");
    assert!(text.starts_with("ADEQUATE: nothing is missing"), "{text}");
    assert!(
        text.contains("Each run therefore has a state of its own: beside a.csv up to "),
        "{text}"
    );
    assert!(
        text.contains("\nDifferences from run to run, relative to the first\n recording "),
        "{text}"
    );
    let json: Value =
        serde_json::from_str(&fs::read_to_string(folder.join("found.json")).unwrap()).unwrap();
    assert!(json["repeats"]["nearest"].as_f64().unwrap() > 0.1);
    assert_eq!(json["repeats"]["pairs"][0]["second"]["recording"], "b.csv");
    let runs = json["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 3);
    assert_eq!(
        (&runs[2]["recording"], &runs[2]["unseen"]),
        (&"unseen.csv".into(), &true.into())
    );
    for (run, [heat_loss, stroke]) in runs.iter().zip([[0.0, 0.0], [0.07, -0.01], [-0.05, 0.01]]) {
        assert!(
            (run["run_heat_loss"].as_f64().unwrap() - heat_loss).abs() < 0.01,
            "{run}"
        );
        assert!(
            (run["run_gain"].as_f64().unwrap() - stroke).abs() < 0.002,
            "{run}"
        );
    }
    let stage = &json["baseline"];
    let [predicted, calibrated] =
        ["predicted_rmse", "validate_rmse"].map(|key| stage[key].as_f64().unwrap());
    assert!(predicted > 5.0 * calibrated, "{predicted} {calibrated}");
    // The rest of a recording does not tell its state: a simulation has the ordinary one, as the predicted error has.
    let (code, _, said) = sma(folder, "simulate model.toml --drive unseen.csv");
    assert_eq!(code, 0, "{said}");
    let (_, met) = said.split_once("the prediction meets it to ").unwrap();
    let met: f64 = met.split(' ').next().unwrap().parse().unwrap();
    assert!(
        (met - predicted).abs() < 1e-3 * predicted,
        "{met} {predicted}"
    );
    assert!(folder.join("figures/same-drive.svg").is_file());
    let page = fs::read_to_string(folder.join("page.html")).unwrap();
    assert!(page.contains("Differences from run to run, relative to the first"));
}

#[test]
fn surroundings_of_one_run_may_be_stated_once() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    ran(folder, "a.csv", [2.3, 1.9], [0.0, 0.0]);
    fs::write(
        folder.join("rod.toml"),
        format!("{ROD}\n[recordings.\"a.csv\"]\nambient_degc = 24.5\n"),
    )
    .unwrap();
    let (code, text, _) = sma(folder, "inspect a.csv --rod rod.toml");
    assert_eq!(code, 0);
    assert!(
        text.contains("its surroundings have 24.5 °C, as is stated"),
        "{text}"
    );
    let recorded = fs::read_to_string(folder.join("a.csv")).unwrap();
    let recorded: String = recorded
        .lines()
        .enumerate()
        .map(|(k, line)| format!("{line},{}\n", if k == 0 { "ambient_degc" } else { "24" }))
        .collect();
    fs::write(folder.join("a.csv"), recorded).unwrap();
    let (code, _, said) = sma(folder, "inspect a.csv --rod rod.toml");
    assert_eq!(code, 3);
    assert!(said.contains("a.csv: ambient_degc = 24.5 °C is stated of it under [recordings], and it has a column of that"), "{said}");
}

#[test]
fn what_has_changed_since_a_reference_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("rod.toml"), ROD).unwrap();
    ran(folder, "a.csv", [2.3, 1.9], [0.0, 0.0]);
    ran(folder, "b.csv", [2.1, 2.4], [0.05, -0.01]);
    ran(folder, "today.csv", [2.0, 2.2], [-0.05, 0.01]);

    let call = "diagnose rod.toml --reference a.csv b.csv --train today.csv --quiet";
    let (code, text, said) = sma(folder, call);
    assert_eq!(code, 0, "{said}");
    assert!(
        text.starts_with(
            "UNCHANGED: nothing has changed since the reference that these runs could show"
        ),
        "{text}"
    );
    assert!(text.contains("\nRuns of the reference, each met by laws from the others\n"));
    late(folder, "today.csv", "late.csv");
    let call = "diagnose rod.toml --reference a.csv b.csv --train late.csv --quiet --json -";
    let (code, json, said) = sma(folder, call);
    assert_eq!(code, 0, "{said}");
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["verdict"], "changed", "{json}");
    assert_eq!(json["finding"]["id"], "dead-time", "{json}");
    assert_eq!(json["finding"]["kind"], "appeared");
    let late_s = json["finding"]["change"].as_f64().unwrap();
    assert!((late_s - 0.5).abs() < 0.05, "{late_s}");

    let (code, _, said) = sma(
        folder,
        "diagnose rod.toml --reference a.csv b.csv --train a.csv",
    );
    assert_eq!(code, 3);
    assert!(
        said.contains(
            "a.csv: its data are given to --reference and to --train; a run is one or the other"
        ),
        "{said}"
    );
    let (code, _, said) = sma(
        folder,
        "diagnose rod.toml --reference a.csv --train b.csv --series series.json",
    );
    assert_eq!(code, 2, "{said}");
}
