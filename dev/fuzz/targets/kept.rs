//! Any text as a line of the file of `--resume`, or as the kept result of a unit of a fleet: refused, or read again as it was.
#![no_main]

use identify::EndedStart;
use libfuzzer_sys::fuzz_target;
use workbench::fleet::Unit;

fuzz_target!(|text: &str| {
    if let Ok(start) = serde_json::from_str::<EndedStart>(text) {
        let written = serde_json::to_string(&start).expect("a start is JSON");
        let again: EndedStart =
            serde_json::from_str(&written).expect("what was written can be read");
        assert_eq!(again, start);
    }
    if let Ok(unit) = serde_json::from_str::<Unit>(text) {
        let written = serde_json::to_string(&unit).expect("a unit is JSON");
        let again: Unit = serde_json::from_str(&written).expect("what was written can be read");
        assert_eq!(serde_json::to_string(&again).expect("and written"), written);
    }
});
