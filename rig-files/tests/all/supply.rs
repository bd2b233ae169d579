//! Accepted keys of `[drive]` for supply and leads, and their effects.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

use crate::common;

use common::{ROD, rod, truth};
use identify::Supply;
use recording::parse_csv;
use rig_files::rod_file;
use wiener::Drive;

/// Ω, of the rod of the tests: 200 mm of 1.2 Ω/m.
const ROD_OHM: f64 = 0.24;

fn with_drive(keys: &str) -> String {
    format!("{ROD}[drive]\n{keys}\n")
}

fn refused(text: &str) -> String {
    rod_file::parse("rod.toml", text).unwrap_err().to_string()
}

fn limit(keys: &str) -> f64 {
    rod(&with_drive(keys)).supply.limit.unwrap()
}

#[test]
fn leads_take_their_share_of_a_voltage() {
    let lead_ohm = 0.15;
    let r = truth().heat.resistance_ohm_per_m;
    for (keys, volts) in [
        ("kind = \"voltage\"", 0.9),
        ("kind = \"duty\"\nsupply_v = 1.3", 0.4),
    ] {
        let text = with_drive(&format!("{keys}\nlead_resistance_ohm = {lead_ohm}"));
        let drive = rod(&text).drive().unwrap();
        let [power_w_per_m] = drive.power_w_per_m([volts], [r]);
        let square_v2 = if matches!(drive, Drive::Duty { .. }) {
            1.3 * 1.3 * volts
        } else {
            volts * volts
        };
        let expected = square_v2 * ROD_OHM / (ROD_OHM + lead_ohm).powi(2) / 0.2;
        assert!((power_w_per_m / expected - 1.0).abs() < 1e-14, "{keys}");
    }
    let share = rod(&with_drive(
        "kind = \"voltage\"\nlead_resistance_ohm = 0.12",
    ))
    .lead_share();
    assert!((share - 1.0 / 3.0).abs() < 1e-14);
}

#[test]
fn without_leads_nothing_moves() {
    let rod = rod(&with_drive("kind = \"voltage\""));
    assert_eq!(rod.drive().unwrap(), Drive::Voltage { length_m: 0.2 });
    assert!(rod.lead_share().abs() <= 0.0);
    assert_eq!(rod.supply, Supply::default());
}

#[test]
fn leads_are_refused_where_they_do_nothing() {
    for (kind, reason) in [
        (
            "current",
            "a current is the same in the rod, whatever the leads",
        ),
        (
            "power",
            "a power is that in the rod; take off what the leads heat",
        ),
        ("temperature", "a static loop has no supply"),
    ] {
        let text = format!("[drive]\nkind = \"{kind}\"\nlead_resistance_ohm = 1.2\n");
        assert_eq!(
            refused(&text),
            format!(
                "rod.toml:3:23: drive.lead_resistance_ohm = 1.2: only for kind = \"voltage\" or \"duty\": {reason}"
            )
        );
    }
}

#[test]
fn leads_need_the_resistance_of_the_rod() {
    let keys = "kind = \"voltage\"\nlead_resistance_ohm = 1.2";
    for (line, key) in [
        ("length_mm = 200.0\n", "rod.length_mm"),
        ("resistance_ohm_per_m = 1.2\n", "rod.resistance_ohm_per_m"),
    ] {
        assert_eq!(
            refused(&with_drive(keys).replace(line, "")),
            format!(
                "rod.toml: {key} is missing: leads take their share of the voltage beside the rod's own resistance, \
                 length times resistance per meter"
            )
        );
    }
    for value in ["0", "-1", "nan", "inf"] {
        let text = with_drive(&format!(
            "kind = \"voltage\"\nlead_resistance_ohm = {value}"
        ));
        assert!(
            refused(&text).ends_with(": must be finite and > 0"),
            "{value}"
        );
    }
}

#[test]
fn a_supply_saturates_at_its_limit() {
    assert!((limit("limit = 0.45") - 0.45).abs() <= 0.0);
    let of_current = limit("kind = \"voltage\"\ncurrent_max_a = 2.0\nlead_resistance_ohm = 0.1");
    assert!((of_current - 2.0 * (ROD_OHM + 0.1)).abs() < 1e-14);
    assert!((limit("voltage_max_v = 0.6") - 0.6 / ROD_OHM).abs() < 1e-14);
    // Of two the lower one.
    assert!((limit("voltage_max_v = 0.6\nlimit = 2.0") - 2.0).abs() <= 0.0);

    let supply = Supply {
        limit: Some(0.45),
        ..Supply::default()
    };
    for (asked, given) in [
        (-0.6, -0.45),
        (-0.3, -0.3),
        (0.0, 0.0),
        (0.45, 0.45),
        (2.0, 0.45),
    ] {
        assert!((supply.limited(asked) - given).abs() <= 0.0, "{asked}");
    }
    assert!((Supply::default().limited(7.0) - 7.0).abs() <= 0.0);
}

#[test]
fn recordings_are_read_behind_the_supply() {
    let rod = rod(&with_drive("limit = 0.45"));
    let csv = "time_s,current_a,position_mm\n0,0,1\n1,0.62,1\n";
    let read = parse_csv(csv.as_bytes(), "a.csv", &rod.read_options()).unwrap();
    assert_eq!(read.drive(), [0.0, 0.45]);
}

#[test]
fn what_a_rig_stands_is_no_more_than_the_supply_gives() {
    let drive_max = |keys: &str| {
        rod(&(with_drive(keys) + "[limits]\ndrive_max = 2.5\n"))
            .limits
            .drive_max
    };
    assert_eq!(drive_max("limit = 0.45"), Some(0.45));
    assert_eq!(drive_max("limit = 3.0"), Some(2.5));
    assert_eq!(rod(&with_drive("limit = 0.45")).limits.drive_max, None);
}

#[test]
fn limits_are_refused_where_they_cannot_be() {
    for (keys, said) in [
        (
            "kind = \"temperature\"\nlimit = 90",
            "rod.toml:3:9: drive.limit = 90: a static loop has no supply that saturates",
        ),
        (
            "kind = \"duty\"\nlimit = 80",
            "rod.toml:3:9: drive.limit = 80: must lie from 0 to 1, as a duty does",
        ),
        (
            "kind = \"duty\"\ncurrent_max_a = 2",
            "rod.toml:3:17: drive.current_max_a = 2: only for kind = \"voltage\"; of another drive say limit, in its own unit",
        ),
        (
            "kind = \"power\"\nvoltage_max_v = 2",
            "rod.toml:3:17: drive.voltage_max_v = 2: only for kind = \"current\"; of another drive say limit, in its own unit",
        ),
        (
            "kind = \"voltage\"\ncurrent_max_a = 2",
            "rod.toml: rod.length_mm is missing: a largest current is a voltage by the resistance of the rod, length times \
             resistance per meter",
        ),
        (
            "kind = \"current\"\nvoltage_max_v = 2",
            "rod.toml: rod.length_mm is missing: a largest voltage is a current by the resistance of the rod, length times \
             resistance per meter",
        ),
    ] {
        assert_eq!(refused(&format!("[drive]\n{keys}\n")), said);
    }
    for key in ["limit", "current_max_a", "voltage_max_v"] {
        for value in ["nan", "0.0", "-1.0"] {
            let said = refused(&with_drive(&format!("{key} = {value}")));
            assert!(said.ends_with(": must be finite and > 0"), "{said}");
        }
    }
}
