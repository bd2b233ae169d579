//! Any text as rod.toml: refused with its name, or a rod whose numbers are finite.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rig_files::rod_file;

fuzz_target!(|text: &str| {
    match rod_file::parse("rod.toml", text) {
        Err(error) => assert!(error.to_string().contains("rod.toml"), "{error}"),
        Ok(rod) => {
            let _ = (
                rod.drive(),
                rod.read_options(),
                rod.missing_for_temperature(),
            );
            let finite =
                |value: Option<f64>| value.is_none_or(|value| value.is_finite() && value > 0.0);
            // A density may be absurd: the result is called implausible.
            assert!(!rod.heat_capacity_j_per_m_k().is_some_and(f64::is_nan));
            assert!(finite(rod.section_m2()));
            assert!((0.0..=1.0).contains(&rod.lead_share()));
        }
    }
});
