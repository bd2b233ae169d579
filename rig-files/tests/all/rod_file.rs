//! Accepted content of `rod.toml`, and the text of every error for any other content.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

#[allow(dead_code, reason = "the other tests use the rest")]
use crate::common;

use std::path::Path;

use common::{ROD, recording, rod, steps};
use identify::{RecordingUse, WienerModel};
use recording::Quantity;
use rig_files::rod_file;
use wiener::hysteresis::Rule;

fn refused(text: &str) -> String {
    rod_file::parse("rod.toml", text).unwrap_err().to_string()
}

#[test]
fn the_whole_file_is_read() {
    let rod = rod("\
# A rig.
[rod]
diameter_mm = 1.2
length_mm = 110
density_kg_per_m3 = 6450.0
specific_heat_j_per_kg_k = { value = 480.0, range = [450.0, 840.0] }
resistance_ohm_per_m = 0.83
[surroundings]
ambient_degc = 22.0
[drive]
kind = \"duty\"
supply_v = 24.0
[load]
spring_n_per_mm = 0.07
preload_n = 6.5
lever = 1.0
[limits]
drive_max = 2.5
temperature_max_degc = 120.0
duration_s = 1800.0
[columns]
time = \"time_s\"
drive = \"duty\"
output = { name = \"position_mm\", unit = \"mm\" }
[model]
zeta = { fixed = 0.8 }
tau_s = { bounds = [1.0, 30.0] }
");
    assert_eq!(rod.drive_kind, Quantity::Duty);
    assert!((rod.length_m.unwrap() - 0.11).abs() < 1e-15);
    assert!((rod.diameter_m.unwrap() - 1.2e-3).abs() < 1e-15);
    assert_eq!(rod.specific_heat_j_per_kg_k, Some(480.0));
    assert_eq!(
        rod.specific_heat_range.map(|range| range.upper),
        Some(840.0)
    );
    assert_eq!(rod.limits.drive_max, Some(2.5));
    assert_eq!(rod.load.and_then(|load| load.preload_n), Some(6.5));
    assert_eq!(rod.model.len(), 2);
    assert!(rod.material().is_some() && rod.drive().is_ok());
}

#[test]
fn an_empty_file_knows_nothing() {
    let rod = rod("");
    assert_eq!(rod.drive_kind, Quantity::Current);
    assert!(rod.material().is_none());
}

#[test]
fn unknown_keys_are_errors_with_their_place() {
    assert_eq!(
        refused("[rod]\ndiametr_mm = 1.2\n"),
        "rod.toml:2:1: unknown field `diametr_mm`, expected one of `diameter_mm`, `length_mm`, \
         `density_kg_per_m3`, `specific_heat_j_per_kg_k`, `resistance_ohm_per_m`"
    );
    assert_eq!(
        refused("\n[rods]\n"),
        "rod.toml:2:2: unknown field `rods`, expected one of `rod`, `surroundings`, `drive`, `load`, \
         `limits`, `columns`, `model`, `recordings`"
    );
}

#[test]
fn physical_nonsense_is_refused_with_its_place() {
    for (value, shown) in [
        ("-1.2", "-1.2"),
        ("0.0", "0"),
        ("nan", "NaN"),
        ("inf", "inf"),
    ] {
        for (table, key) in [
            ("rod", "diameter_mm"),
            ("rod", "length_mm"),
            ("rod", "density_kg_per_m3"),
            ("rod", "specific_heat_j_per_kg_k"),
            ("rod", "resistance_ohm_per_m"),
            ("drive", "supply_v"),
            ("load", "spring_n_per_mm"),
            ("load", "lever"),
            ("limits", "drive_max"),
            ("limits", "duration_s"),
        ] {
            let column = key.len() + 4;
            assert_eq!(
                refused(&format!("[{table}]\n{key} = {value}\n")),
                format!("rod.toml:2:{column}: {table}.{key} = {shown}: must be finite and > 0")
            );
        }
    }
    assert_eq!(
        refused("[surroundings]\nambient_degc = nan\n"),
        "rod.toml:2:16: surroundings.ambient_degc = NaN: must be finite"
    );
}

#[test]
fn measures_are_those_of_a_rod() {
    // Found by fuzzing: the section of such a rod is no number.
    for value in ["2e222", "1e-10"] {
        for key in ["diameter_mm", "length_mm"] {
            let column = key.len() + 4;
            let refused = refused(&format!("[rod]\n{key} = {value}\n"));
            assert!(
                refused.starts_with(&format!("rod.toml:2:{column}: rod.{key} = ")),
                "{refused}"
            );
            assert!(
                refused.ends_with(": must be from 1e-9 to 1e9 mm"),
                "{refused}"
            );
        }
    }
}

#[test]
fn ranges_must_rise() {
    assert_eq!(
        refused("[rod]\nspecific_heat_j_per_kg_k = { value = 480.0, range = [840.0, 450.0] }\n"),
        "rod.toml:2:28: rod.specific_heat_j_per_kg_k.range = 450: must be > 840, the lower end"
    );
    assert_eq!(
        refused("[rod]\nspecific_heat_j_per_kg_k = { value = 480.0, range = [600.0, 700.0] }\n"),
        "rod.toml:2:28: rod.specific_heat_j_per_kg_k.value = 480: must lie in its range, 600 to 700"
    );
    assert_eq!(
        refused("[model]\nzeta = { bounds = [0.9, 0.2] }\n"),
        "rod.toml:2:25: model.zeta.bounds = 0.2: must be > 0.9, the lower end"
    );
    assert_eq!(
        refused("[model]\nzeta = { fixed = nan }\n"),
        "rod.toml:2:18: model.zeta.fixed = NaN: must be finite"
    );
}

#[test]
fn text_where_a_number_belongs() {
    assert_eq!(
        refused("[rod]\ndiameter_mm = \"thin\"\n"),
        "rod.toml:2:15: invalid type: string \"thin\", expected a number"
    );
    assert_eq!(
        refused("[rod]\nspecific_heat_j_per_kg_k = \"much\"\n"),
        "rod.toml:2:28: expected a number, or { value = number, range = [low, high] }"
    );
    assert_eq!(
        refused("[drive]\nkind = \"steam\"\n"),
        "rod.toml:2:8: unknown variant `steam`, expected one of `current`, `duty`, `voltage`, \
         `power`, `temperature`"
    );
}

#[test]
fn a_duty_needs_its_supply() {
    let text = format!("{ROD}[drive]\nkind = \"duty\"\n");
    assert_eq!(
        rod(&text).drive().unwrap_err().to_string(),
        "rod.toml: drive.supply_v is missing: a duty says how long the supply is on, not how strong it is"
    );
}

#[test]
fn ambient_must_be_known() {
    let training = [recording("a.csv", steps(300), 0.0)];
    let error = WienerModel::new(&rod(""), Rule::LastReversal, &training).unwrap_err();
    assert_eq!(
        error.to_string(),
        "rod.toml: surroundings.ambient_degc is missing: no recording has a column for it either"
    );
}

#[test]
fn parameters_that_do_not_exist_are_named_with_those_that_do() {
    let training = [recording("a.csv", steps(300), 0.0)];
    let rod = rod(&format!("{ROD}[model]\nteta = {{ fixed = 0.8 }}\n"));
    let error = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap_err();
    assert_eq!(
        error.to_string(),
        "rod.toml:11:1: [model] teta: no such parameter; this rig has tau_s, loop_center_degc, \
         loop_half_width_k, loop_spread_k, zeta, gain, offset, start_rise_k, start_share, \
         start_since_reversal_k, ambient_level_k, run_heat_loss, run_gain"
    );
}

#[test]
fn entries_of_the_model_must_say_one_thing_that_can_be() {
    let training = [recording("a.csv", steps(300), 0.0)];
    let refused = |entry: &str| {
        let text = format!("{ROD}[model]\n{entry}\n");
        let parsed = rod_file::parse("rod.toml", &text);
        let made =
            parsed.and_then(|rod| Ok(WienerModel::new(&rod, Rule::LastReversal, &training)?));
        made.map(|_| ()).unwrap_err().to_string()
    };
    let one_thing = "must be { fixed = value } or { bounds = [low, high] }";
    assert_eq!(
        refused("zeta = {}"),
        format!("rod.toml:11:1: [model] zeta: {one_thing}")
    );
    assert_eq!(
        refused("zeta = { fixed = 0.5, bounds = [0.1, 0.9] }"),
        format!("rod.toml:11:1: [model] zeta: {one_thing}")
    );
    assert_eq!(
        refused("zeta = { fixed = 1.5 }"),
        "rod.toml:11:1: [model] zeta: must lie from 1e-6 to 1e0 1"
    );
    assert_eq!(
        refused("tau_s = { bounds = [0.0, 5.0] }"),
        "rod.toml:11:1: [model] tau_s: must lie from 1e-12 to 1e12 s"
    );
    assert_eq!(
        refused("gain = { bounds = [0.0, 5.0] }"),
        "rod.toml:11:1: [model] gain: is solved for, not searched: fix it or leave it out"
    );
}

#[test]
fn static_data_have_no_heat_balance() {
    assert_eq!(
        rod("drive.kind = \"temperature\"")
            .drive()
            .unwrap_err()
            .to_string(),
        "rod.toml: drive.kind = \"temperature\": such data have no heat balance to identify; give \
         current, duty, voltage or power"
    );
}

#[test]
fn what_is_missing_for_temperatures_depends_on_the_drive() {
    let missing = |text: &str| rod(text).missing_for_temperature();
    assert!(missing(ROD).is_empty());
    assert_eq!(
        missing(&ROD.replace("resistance_ohm_per_m = 1.2\n", "")),
        ["resistance_ohm_per_m"]
    );
    let power = ROD.replace("resistance_ohm_per_m = 1.2\n", "") + "[drive]\nkind = \"power\"\n";
    assert!(missing(&power).is_empty());
    let voltage = ROD.replace("length_mm = 200.0\n", "") + "[drive]\nkind = \"voltage\"\n";
    assert_eq!(missing(&voltage), ["length_mm"]);
}

#[test]
fn a_file_that_is_not_there() {
    let error = rod_file::read(std::path::Path::new("no/such/rod.toml")).unwrap_err();
    assert_eq!(error.to_string(), "no/such/rod.toml: cannot be read");
}

#[test]
fn what_is_used_of_a_recording_stands_under_its_name() {
    let rod = rod("\
[recordings.\"run3.csv\"]
window_s = [20, 140]
exclude_s = [[130, 140.5], [0, 25]]
decimate = 10
detrend = true
ambient_degc = 26.4
");
    let used = rod.use_of(Path::new("runs/run3.csv"));
    assert_eq!(used, rod.uses["run3.csv"]);
    assert_eq!(used.window_s, Some([20.0, 140.0]));
    assert_eq!(used.exclude_s, [[130.0, 140.5], [0.0, 25.0]]);
    assert_eq!((used.decimate, used.detrend), (Some(10), true));
    assert_eq!(used.ambient_degc, Some(26.4));
    assert_eq!(rod.use_of(Path::new("run4.csv")), RecordingUse::default());
    let key = |line: &str| refused(&format!("[recordings.\"a.csv\"]\n{line}\n"));
    assert_eq!(
        key("exclude_s = [[1, 2], [4, 3]]"),
        "rod.toml:2:26: recordings.\"a.csv\".exclude_s = 3: must be > 4, the lower end"
    );
    assert_eq!(
        key("window_s = [nan, 3]"),
        "rod.toml:2:13: recordings.\"a.csv\".window_s = NaN: must be finite"
    );
    for n in ["1", "0", "-3"] {
        assert_eq!(
            key(&format!("decimate = {n}")),
            format!(
                "rod.toml:2:12: recordings.\"a.csv\".decimate = {n}: must be a whole number ≥ 2"
            )
        );
    }
    assert_eq!(
        key("ambient_degc = 299.5"),
        "rod.toml:2:16: recordings.\"a.csv\".ambient_degc = 299.5: must lie from -100 to 200 °C; 299.5 K would be 26.35 °C"
    );
    assert!(key("decimate = 2.5").starts_with("rod.toml:2:12: "));
    assert!(key("detrent = true").contains(
        "unknown field `detrent`, expected one of `window_s`, `exclude_s`, `decimate`, `detrend`, `ambient_degc`"
    ));
}
