//! Any text as model.toml: refused with its name, or a model that is written as it was read, and whose plant can be made or not.
#![no_main]

use libfuzzer_sys::fuzz_target;
use missing_physics::{RestoredModel, parse_model};

fuzz_target!(|text: &str| {
    match parse_model("model.toml", text) {
        Err(error) => assert!(error.to_string().contains("model.toml"), "{error}"),
        Ok(model) => {
            let written = model
                .to_toml()
                .expect("a model that was read can be written");
            let again = parse_model("model.toml", &written).expect("what was written can be read");
            assert_eq!(again.to_toml().expect("and written"), written);
            if let Ok(restored) = RestoredModel::new(&model) {
                assert!(restored.point().iter().all(|value| value.is_finite()));
            }
        }
    }
});
