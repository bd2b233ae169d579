//! Rows of documents, and the picture that they make.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use serde_json::{Value, json};

use super::*;
use crate::fleet::{Failure, Task, Unit};
use crate::page;

fn task(command: &str) -> Task {
    Task {
        program: "0a".repeat(32),
        version: "0.1.0".to_owned(),
        command: command.to_owned(),
        flags: Vec::new(),
        input: Vec::new(),
    }
}

fn parameter(name: &str, unit: &str, value: f64) -> Value {
    json!({"name": name, "unit": unit, "values": [value], "ci95": [[value - 1.0, value + 1.0]], "per_recording": false,
        "fixed": false})
}

/// A finding with one size, and names that it could have instead.
fn finding(effect: &str, others: &[&str], size: (&str, f64, &str)) -> Value {
    let (name, value, unit) = size;
    json!({"effect": effect, "could_also_be": others, "probability": 0.75,
        "parameters": [{"name": name, "value": value, "unit": unit, "ci95": [value - 1.0, value + 2.0]}]})
}

/// A diagnosis with these findings, and a parameter beyond them that makes room.
fn diagnosis(verdict: &str, findings: &[Value]) -> Value {
    let mut shared = vec![parameter("tau_s", "s", 12.0)];
    let mut fixed = parameter("zeta", "1", 0.8);
    fixed["fixed"] = json!(true);
    shared.push(fixed);
    let mut extended = shared.clone();
    extended[0] = parameter("tau_s", "s", 11.0);
    extended.push(parameter("latent_heat_j_per_kg", "J/kg", 9000.0));
    extended.push(parameter("emissivity", "1", 0.1));
    json!({
        "verdict": verdict,
        "implausible": [],
        "output_unit": "mm",
        "noise_floor": {"lower": 0.004, "upper": 0.005},
        "baseline": {"train_rmse": 0.06, "validate_rmse": 0.07, "parameters": shared},
        "extended": {"train_rmse": 0.005, "validate_rmse": 0.006, "parameters": extended},
        "findings": findings,
    })
}

fn report() -> FleetReport<'static> {
    let latent = |size: f64| finding("latent-heat", &[], ("latent_heat_j_per_kg", size, "J/kg"));
    let lag = finding("supply-lag", &["output-lag"], ("supply_lag_s", 0.5, "s"));
    let done = |rig: &str, exit_code: i32, result: Value| {
        Row::of(rig, "0a", &Unit::done(task("diagnose"), exit_code, result))
    };
    let failed = Unit::failed(task("diagnose"), Some(3), "e.csv:2: time_s = \"a, b\"");
    let failure = Failure::said("was killed", std::iter::empty());
    FleetReport {
        command: "diagnose",
        seed: 1,
        rows: vec![
            done("a.csv", 0, diagnosis("explained", &[latent(9000.0)])),
            done("b.csv", 0, diagnosis("ambiguous", &[latent(9500.0), lag])),
            done("c.csv", 0, diagnosis("adequate", &[])),
            done("d.csv", 4, diagnosis("not_converged", &[latent(1e6)])),
            Row::of("e.csv", "0b", &failed),
            Row::without("<f>", Some("0c".to_owned()), RowStatus::Open, failure),
        ],
        left_out: &[],
    }
}

#[test]
fn a_row_has_the_numbers_of_its_document() {
    let report = report();
    let row = &report.rows[0];
    let errors = [
        row.train_rmse,
        row.validate_rmse,
        row.extended_train_rmse,
        row.extended_validate_rmse,
        row.noise_lower,
        row.noise_upper,
    ];
    assert_eq!(
        errors.map(|error| error.unwrap().to_string()),
        ["0.06", "0.07", "0.005", "0.006", "0.004", "0.005"]
    );
    let names = |row: &Row| -> Vec<String> {
        let own = row.parameters.iter();
        own.map(|one| format!("{} {}", one.name, one.value))
            .collect()
    };
    assert_eq!(names(row), ["tau_s 11", "latent_heat_j_per_kg 9000"]);
    assert_eq!(
        names(&report.rows[2]),
        ["tau_s 12"],
        "of the baseline model"
    );
    let identified = |converged: bool| {
        let result = json!({"fit": {"converged": converged, "train_rmse": 0.1}, "parameters": [parameter("tau_s", "s", 3.0)]});
        Row::of("a", "0a", &Unit::done(task("identify"), 0, result))
    };
    assert_eq!(identified(true).verdict.as_deref(), Some("identified"));
    assert_eq!(identified(false).verdict.as_deref(), Some("not_converged"));
    assert_eq!(names(&identified(true)), ["tau_s 3"]);
}

#[test]
fn physics_is_counted_in_rigs_whose_result_is_to_be_used() {
    let report = report();
    assert_eq!(
        report.head(),
        "6 rigs: 4 with a result (1 not to be used), 1 failed, 1 not run yet."
    );
    let physics = report.physics();
    let counts: Vec<(&str, usize, usize)> = physics
        .iter()
        .map(|one| (one.effect.as_str(), one.named, one.ambiguous))
        .collect();
    assert_eq!(
        counts,
        [
            ("latent-heat", 2, 0),
            ("output-lag", 0, 1),
            ("supply-lag", 0, 1)
        ]
    );
    let size = physics[0].size.as_ref().unwrap();
    assert_eq!(size.said(), "9000 … 9250 … 9500 J/kg");
    assert_eq!(physics[1].size, None, "nobody knows which it is");
    let text = report.text();
    for line in [
        "latent-heat 2 67 % 0 9000 … 9250 … 9500 J/kg",
        "e.csv:2: time_s = \"a, b\"",
        "<f>: was killed",
    ] {
        let mut lines = text.lines();
        let is_there = lines.any(|own| own.split_whitespace().eq(line.split_whitespace()));
        assert!(is_there, "{line}\n{text}");
    }
    let json = report.json();
    assert_eq!(
        json["counts"],
        json!({"done": 4, "to_be_used": 3, "failed": 1, "open": 1})
    );
}

#[test]
fn the_table_has_a_row_a_rig() {
    let csv = report().csv();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 7);
    assert!(
        lines[0].ends_with(
            ",unit,command,tau_s,tau_s_lower,tau_s_upper,latent_heat_j_per_kg,latent_heat_j_per_kg_lower,latent_heat_j_per_kg_upper"
        ),
        "{}",
        lines[0]
    );
    assert_eq!(
        lines[2],
        "b.csv,done,ambiguous,\"latent-heat (latent_heat_j_per_kg = 9500 J/kg [9499, 9502], p = 0.75); supply-lag or output-lag \
         (supply_lag_s = 0.5 s [-0.5, 2.5], p = 0.75)\",mm,0.06,0.07,0.005,0.006,0.004,0.005,,0,,,,0a,diagnose,11,10,12,9000,8999,9001"
    );
    assert_eq!(
        lines[5],
        "e.csv,failed,,,,,,,,,,,3,\"e.csv:2: time_s = \"\"a, b\"\"\",,,0b,diagnose,,,,,,"
    );
    let n_cells = lines[0].split(',').count();
    assert_eq!(lines[3].split(',').count(), n_cells);
}

#[test]
fn the_picture_has_a_mark_for_every_rig() {
    let page = page::fleet(&report()).made("sma batch rigs", "1", &[]);
    let marks = |row: &str, color: &str| {
        page.matches(&format!("fill=\"var(--{color})\"><title>{row}"))
            .count()
    };
    assert_eq!(marks("a.csv: latent-heat 9000 J/kg", "extended"), 1);
    assert_eq!(marks("b.csv: supply-lag 0.50 s", "recorded"), 1);
    assert_eq!(marks("b.csv: output-lag, or another", "recorded"), 1);
    assert_eq!(marks("c.csv: adequate", "training"), 1);
    assert_eq!(marks("d.csv: not_converged<", "shade"), 1);
    assert_eq!(marks("e.csv:2: time_s", "plain"), 1);
    assert_eq!(marks("&lt;f&gt;: was killed", "plain"), 1);
    assert_eq!(page.matches("<rect").count(), 8);
}
