//! Any text as model.toml: refused with its name, or a model that is written as it was read, and whose plant can be made or not.
#![no_main]

use libfuzzer_sys::fuzz_target;
use missing_physics::{RestoredModel, known_effects};
use rig_files::model_file;

fuzz_target!(|text: &str| {
    match model_file::parse_with("model.toml", text, &known_effects) {
        Err(error) => assert!(error.to_string().contains("model.toml"), "{error}"),
        Ok(model) => {
            let written =
                model_file::to_toml(&model).expect("a model that was read can be written");
            let again = model_file::parse_with("model.toml", &written, &known_effects)
                .expect("what was written can be read");
            assert_eq!(model_file::to_toml(&again).expect("and written"), written);
            if let Ok(restored) = RestoredModel::new(&model) {
                assert!(restored.point().iter().all(|value| value.is_finite()));
            }
        }
    }
});
