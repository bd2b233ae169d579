//! The library as an importer calls it.
//!
//! `wire.toml` is the model of `sma diagnose` of the recordings of `sma demo`: latent heat and dead time.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod fmi3;

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::fmt::Write;
use std::path::Path;
use std::sync::Mutex;

use identify::predict;
use missing_physics::{RestoredModel, known_effects};
use recording::{Quantity, Recording, RecordingParts, Sampling};
use rig_files::model_file;
use sha2::{Digest, Sha256};
use sma_export::{FmuVariable, fmu_guid};
use sma_fmu::{
    Callbacks, fmi2DoStep, fmi2EnterInitializationMode, fmi2ExitInitializationMode,
    fmi2FreeFMUstate, fmi2FreeInstance, fmi2GetFMUstate, fmi2GetInteger, fmi2GetReal,
    fmi2GetTypesPlatform, fmi2GetVersion, fmi2Instantiate, fmi2Reset, fmi2SetFMUstate, fmi2SetReal,
    fmi2SetupExperiment, fmi2Terminate,
};

const MODEL: &str = include_str!("wire.toml");
const DT_S: f64 = 0.1;
const AMBIENT_DEGC: f64 = 22.0;

fn guid() -> String {
    guid_of(MODEL)
}

fn guid_of(model: &str) -> String {
    let mut sha256 = String::new();
    for byte in Sha256::digest(model.as_bytes()) {
        write!(sha256, "{byte:02x}").unwrap();
    }
    fmu_guid(&sha256)
}

/// A unit's resources, in a folder whose name an URI has to escape.
fn resources() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let resources = folder.path().join("a wire");
    std::fs::create_dir(&resources).unwrap();
    std::fs::write(resources.join("model.toml"), MODEL).unwrap();
    let uri = uri(&resources);
    (folder, uri)
}

fn uri(path: &Path) -> String {
    format!("file://{}", path.to_str().unwrap().replace(' ', "%20"))
}

/// An instance that is freed at its end.
struct Instance(*mut c_void);

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: of fmi2Instantiate, freed here alone.
        unsafe { fmi2FreeInstance(self.0) };
    }
}

impl Instance {
    fn try_new(kind: c_int, guid: &str, uri: &str) -> Option<Self> {
        let [name, guid, uri] = ["wire", guid, uri].map(|text| CString::new(text).unwrap());
        let callbacks = Callbacks::silent();
        // SAFETY: strings end with a zero.
        let pointer = unsafe {
            fmi2Instantiate(
                name.as_ptr(),
                kind,
                guid.as_ptr(),
                uri.as_ptr(),
                &raw const callbacks,
                0,
                0,
            )
        };
        (!pointer.is_null()).then_some(Self(pointer))
    }

    fn new(uri: &str) -> Self {
        Self::try_new(1, &guid(), uri).unwrap()
    }

    fn call(&self, function: unsafe extern "C" fn(*mut c_void) -> c_int) -> c_int {
        // SAFETY: of fmi2Instantiate and not freed.
        unsafe { function(self.0) }
    }

    fn set(&self, variable: FmuVariable, value: f64) -> c_int {
        let reference = variable as u32;
        // SAFETY: one reference and one value.
        unsafe { fmi2SetReal(self.0, &raw const reference, 1, &raw const value) }
    }

    fn get(&self, variable: FmuVariable) -> Option<f64> {
        let reference = variable as u32;
        let mut value = f64::NAN;
        // SAFETY: one reference and room for one value.
        let status = unsafe { fmi2GetReal(self.0, &raw const reference, 1, &raw mut value) };
        (status == 0).then_some(value)
    }

    fn step(&self, length_s: f64) -> c_int {
        // SAFETY: of fmi2Instantiate and not freed.
        unsafe { fmi2DoStep(self.0, 0.0, length_s, 1) }
    }

    fn initialize(&self) {
        // SAFETY: of fmi2Instantiate and not freed.
        let status = unsafe { fmi2SetupExperiment(self.0, 0, 0.0, 0.0, 0, 0.0) };
        assert_eq!(status, 0);
        assert_eq!(self.call(fmi2EnterInitializationMode), 0);
        assert_eq!(self.call(fmi2ExitInitializationMode), 0);
    }

    /// Displacements and temperatures before each sample.
    fn run(&self, drive: &[f64]) -> Vec<[u64; 2]> {
        let samples = drive.iter().map(|&drive| {
            let shown = [FmuVariable::Displacement, FmuVariable::TemperatureDegc];
            let row = shown.map(|one| self.get(one).unwrap().to_bits());
            assert_eq!(self.set(FmuVariable::Drive, drive), 0);
            assert_eq!(self.step(DT_S), 0);
            row
        });
        samples.collect()
    }
}

/// Steps of the drive, up and down, that make the rod turn inside of its loop.
fn drive() -> Vec<f64> {
    let levels = [
        0.0, 2.4, 0.0, 2.1, 1.4, 2.2, 1.0, 2.0, 0.4, 1.9, 0.0, 2.3, 1.7, 0.3, 0.0,
    ];
    let held = levels.into_iter().map(|level| vec![level; 200]);
    held.flatten().collect()
}

/// Prediction of `sma simulate`.
fn predicted(drive: &[f64]) -> Vec<[u64; 2]> {
    let saved = model_file::parse_with("model.toml", MODEL, &known_effects).unwrap();
    let model = RestoredModel::new(&saved).unwrap();
    let recording = Recording::new(RecordingParts {
        name: "profile".to_owned(),
        time_s: Some((0..drive.len()).map(|k| DT_S * k as f64).collect()),
        drive_quantity: Quantity::Current,
        drive: drive.to_vec(),
        output_unit: "mm".to_owned(),
        output: vec![0.0; drive.len()],
        ambient_degc: Some(vec![AMBIENT_DEGC; drive.len()]),
        ..RecordingParts::default()
    })
    .unwrap();
    let Sampling::Uniform { dt_s } = recording.sampling() else {
        unreachable!("times of equal steps");
    };
    assert_eq!(dt_s.to_bits(), DT_S.to_bits());
    let prediction = predict(&model, &model.point(), &recording).unwrap();
    let pairs = prediction.output.iter().zip(&prediction.temperature_degc);
    pairs.map(|(y, t)| [y.to_bits(), t.to_bits()]).collect()
}

#[test]
fn a_unit_has_the_bits_of_the_program_with_latent_heat_and_dead_time() {
    assert!(MODEL.contains("effects = [\"dead-time\", \"latent-heat\"]"));
    let (_folder, uri) = resources();
    let unit = Instance::new(&uri);
    assert_eq!(unit.set(FmuVariable::AmbientDegc, AMBIENT_DEGC), 0);
    unit.initialize();
    let drive = drive();
    assert_eq!(drive.len(), 3_000);
    let expected = predicted(&drive);
    let outputs = expected.iter().map(|row| f64::from_bits(row[0]));
    let (low, high) = outputs.fold((f64::MAX, f64::MIN), |(low, high), y| {
        (y.min(low), y.max(high))
    });
    assert!(high - low > 1.0, "{low} {high}");
    assert!(unit.run(&drive) == expected);
    assert_eq!(unit.call(fmi2Terminate), 0);
    // Once more from the start.
    assert_eq!(unit.call(fmi2Reset), 0);
    assert_eq!(unit.set(FmuVariable::AmbientDegc, AMBIENT_DEGC), 0);
    unit.initialize();
    assert!(unit.run(&drive) == expected);
}

#[test]
fn a_duty_beyond_its_range_acts_as_its_ends() {
    let model = MODEL
        .replace("kind = \"current\"", "kind = \"duty\"\nsupply_v = 0.7")
        .replace("drive_unit = \"A\"", "drive_unit = \"1\"")
        .replace("drive_max = 2.793", "drive_max = 1.0");
    let (folder, uri) = resources();
    std::fs::write(folder.path().join("a wire/model.toml"), &model).unwrap();
    let run = |duties: &[f64]| {
        let unit = Instance::try_new(1, &guid_of(&model), &uri).unwrap();
        unit.initialize();
        unit.run(duties)
    };
    let within: Vec<f64> = drive().iter().map(|level| level - 1.0).collect();
    let beyond: Vec<f64> = within.iter().map(|level| 3.0 * level).collect();
    let clamped: Vec<f64> = beyond.iter().map(|duty| duty.clamp(0.0, 1.0)).collect();
    assert!(run(&beyond) == run(&clamped));
    assert!(run(&within) != run(&clamped));
}

#[test]
fn a_state_that_was_kept_comes_back() {
    let (_folder, uri) = resources();
    let unit = Instance::new(&uri);
    unit.initialize();
    let drive = drive();
    unit.run(&drive[..700]);
    let mut state = std::ptr::null_mut();
    // SAFETY: a place for a new state.
    assert_eq!(unsafe { fmi2GetFMUstate(unit.0, &raw mut state) }, 0);
    let once = unit.run(&drive[700..1500]);
    // SAFETY: of the call above.
    assert_eq!(unsafe { fmi2SetFMUstate(unit.0, state) }, 0);
    assert!(unit.run(&drive[700..1500]) == once);
    // Another state in the same place.
    // SAFETY: as above.
    assert_eq!(unsafe { fmi2GetFMUstate(unit.0, &raw mut state) }, 0);
    let later = unit.run(&drive[1500..2000]);
    // SAFETY: as above.
    assert_eq!(unsafe { fmi2SetFMUstate(unit.0, state) }, 0);
    assert!(unit.run(&drive[1500..2000]) == later);
    // SAFETY: as above, freed here alone.
    assert_eq!(unsafe { fmi2FreeFMUstate(unit.0, &raw mut state) }, 0);
    assert!(state.is_null());
    // SAFETY: null is no state.
    assert_ne!(unsafe { fmi2SetFMUstate(unit.0, state) }, 0);
}

#[test]
fn parameters_move_the_start() {
    let (_folder, uri) = resources();
    let unit = Instance::new(&uri);
    assert_eq!(unit.set(FmuVariable::Offset, 7.5), 0);
    assert_eq!(unit.set(FmuVariable::StartRiseK, 60.0), 0);
    assert_eq!(unit.set(FmuVariable::StartShare, 0.0), 0);
    assert_eq!(unit.call(fmi2EnterInitializationMode), 0);
    let heating = unit.get(FmuVariable::Displacement).unwrap();
    assert_eq!(unit.set(FmuVariable::StartShare, 1.0), 0);
    let cooling = unit.get(FmuVariable::Displacement).unwrap();
    assert!(7.5 < heating && heating < cooling, "{heating} {cooling}");
    assert_eq!(unit.call(fmi2ExitInitializationMode), 0);
    assert_eq!(unit.get(FmuVariable::Displacement), Some(cooling));
}

/// Messages of the log.
static LOGGED: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Logger of an importer. A function of this language takes no further arguments: it is told by the format that there is
/// one, and reads it where a fixed argument would stand, as both stand in the same registers.
extern "C" fn log(
    _: *mut c_void,
    _: *const c_char,
    status: c_int,
    _: *const c_char,
    format: *const c_char,
    message: *const c_char,
) {
    // SAFETY: strings end with a zero.
    let format = unsafe { CStr::from_ptr(format) };
    assert_eq!((status, format), (3, c"%s"));
    // SAFETY: as above.
    let message = unsafe { CStr::from_ptr(message) };
    LOGGED
        .lock()
        .unwrap()
        .push(message.to_str().unwrap().to_owned());
}

#[test]
fn errors_are_logged_with_name_value_and_what_is_accepted() {
    let (folder, uri) = resources();
    let logger = log as *const ();
    let callbacks = Callbacks {
        // SAFETY: a pointer to a function; where six pointers are handed over in registers, fixed arguments or not, as on
        // all platforms that units are made for, it finds its arguments.
        logger: Some(unsafe { std::mem::transmute::<*const (), sma_fmu::Logger>(logger) }),
        ..Callbacks::silent()
    };
    let instantiate = |kind: c_int, guid: &str, uri: &str| {
        let [name, guid, uri] = ["wire", guid, uri].map(|text| CString::new(text).unwrap());
        // SAFETY: strings end with a zero, and the logger is a function.
        let pointer = unsafe {
            fmi2Instantiate(
                name.as_ptr(),
                kind,
                guid.as_ptr(),
                uri.as_ptr(),
                &raw const callbacks,
                0,
                1,
            )
        };
        (!pointer.is_null()).then_some(Instance(pointer))
    };
    let last = || LOGGED.lock().unwrap().last().cloned().unwrap_or_default();
    assert!(instantiate(1, "{0}", &uri).is_none());
    assert!(last().starts_with("GUID {0}: expected {"), "{}", last());
    assert!(instantiate(0, &guid(), &uri).is_none());
    assert!(last().ends_with("expected co-simulation"), "{}", last());
    let nowhere = format!("file://{}/nothing", folder.path().display());
    assert!(instantiate(1, &guid(), &nowhere).is_none());
    assert!(
        last().contains("nothing/model.toml: cannot be read: "),
        "{}",
        last()
    );
    let broken = MODEL.replace("\"latent-heat\"]", "\"phlogiston\"]");
    std::fs::write(folder.path().join("model.toml"), &broken).unwrap();
    let elsewhere = format!("file://{}", folder.path().display());
    assert!(instantiate(1, &guid_of(&broken), &elsewhere).is_none());
    assert!(last().starts_with("model.toml:10:"), "{}", last());
    assert!(last().contains("phlogiston"), "{}", last());
    let unit = instantiate(1, &guid(), &uri).unwrap();
    assert_ne!(unit.step(DT_S), 0);
    assert_eq!(last(), "DoStep: not while the instance is instantiated");
    assert_eq!(unit.get(FmuVariable::Displacement), None);
    assert_eq!(
        last(),
        "displacement: is an output: it is known from the initialization on"
    );
    assert_ne!(unit.set(FmuVariable::StartShare, 1.5), 0);
    assert_eq!(last(), "start_share = 1.5: must lie from 0 to 1");
    unit.initialize();
    assert_ne!(unit.set(FmuVariable::Drive, f64::NAN), 0);
    assert_eq!(last(), "drive = NaN: must be a finite number");
    assert_ne!(unit.set(FmuVariable::Displacement, 1.0), 0);
    assert_eq!(last(), "displacement: is an output: it cannot be set");
    assert_ne!(unit.set(FmuVariable::Offset, 1.0), 0);
    assert_eq!(
        last(),
        "offset: is a parameter: it is fixed after the initialization"
    );
    assert_ne!(unit.step(-1.0), 0);
    assert_eq!(
        last(),
        "communication step of -1 s: must be finite and >= 0"
    );
    let (reference, mut value) = (7, 0.0);
    // SAFETY: one reference and room for one value.
    let status = unsafe { fmi2GetReal(unit.0, &raw const reference, 1, &raw mut value) };
    assert_ne!(status, 0);
    assert_eq!(last(), "value reference 7: expected 0 to 6");
    let no_values = std::ptr::null_mut();
    // SAFETY: null pointers are not read.
    let status = unsafe { fmi2GetReal(unit.0, std::ptr::null(), 2, &raw mut value) };
    assert_eq!(status, 3);
    assert_eq!(
        last(),
        "fmi2GetReal: 2 variables, but no place for their value references"
    );
    // SAFETY: as above, and there is one reference.
    let status = unsafe { fmi2GetReal(unit.0, &raw const reference, 1, no_values) };
    assert_eq!(status, 3);
    assert_eq!(
        last(),
        "fmi2GetReal: 1 variables, but no place for their values"
    );
    // SAFETY: as above.
    let status = unsafe { fmi2SetReal(unit.0, std::ptr::null(), 2, std::ptr::null()) };
    assert_eq!(status, 3);
    // SAFETY: as above.
    let status = unsafe { fmi2SetReal(unit.0, &raw const reference, 1, std::ptr::null()) };
    assert_eq!(status, 3);
    assert_eq!(
        last(),
        "fmi2SetReal: 1 variables, but no place for their values"
    );
    let before = MODEL.replace("role = \"train\"", "role = \"validate\"");
    std::fs::write(folder.path().join("model.toml"), &before).unwrap();
    assert!(instantiate(1, &guid_of(&before), &elsewhere).is_none());
    assert!(
        last().starts_with("model.toml: recording: none has role = \"train\"; expected "),
        "{}",
        last()
    );
}

#[test]
fn nothing_is_read_through_null_pointers() {
    let null = std::ptr::null_mut();
    // SAFETY: a null pointer is refused.
    assert_ne!(unsafe { fmi2DoStep(null, 0.0, 1.0, 1) }, 0);
    // SAFETY: as above.
    assert_ne!(unsafe { fmi2Reset(null) }, 0);
    // SAFETY: as above.
    let status = unsafe { fmi2SetReal(null, std::ptr::null(), 0, std::ptr::null()) };
    assert_eq!(status, 3);
    // SAFETY: as above.
    unsafe { fmi2FreeInstance(null) };
    let (text, callbacks) = (std::ptr::null(), std::ptr::null());
    // SAFETY: as above.
    let instance = unsafe { fmi2Instantiate(text, 1, text, text, callbacks, 0, 0) };
    assert!(instance.is_null());
    assert!(Instance::try_new(1, "{0}", "file:///").is_none());
    // SAFETY: both return texts that end with a zero.
    let [types, version] =
        [fmi2GetTypesPlatform(), fmi2GetVersion()].map(|text| unsafe { CStr::from_ptr(text) });
    assert_eq!((types, version), (c"default", c"2.0"));
    assert_eq!(
        fmi2GetInteger(null, std::ptr::null(), 0, std::ptr::null_mut()),
        0
    );
}
