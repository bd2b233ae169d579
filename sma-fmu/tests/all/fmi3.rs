//! The library as an importer of FMI 3.0 calls it.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};

use sma_export::{FMU_TIME, FmuVariable};
use sma_fmu::{
    fmi3DoStep, fmi3EnterInitializationMode, fmi3ExitInitializationMode, fmi3FreeFMUState,
    fmi3FreeInstance, fmi3GetFMUState, fmi3GetFloat64, fmi3GetInt32, fmi3GetVersion,
    fmi3InstantiateCoSimulation, fmi3InstantiateModelExchange, fmi3Reset, fmi3SetFMUState,
    fmi3SetFloat64, fmi3Terminate,
};

use crate::{AMBIENT_DEGC, DT_S, drive, guid, predicted, resources};

thread_local! {
    /// Messages of the log.
    static LOGGED: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

extern "C" fn log(_: *mut c_void, status: c_int, category: *const c_char, message: *const c_char) {
    // SAFETY: strings end with a zero.
    let category = unsafe { CStr::from_ptr(category) };
    assert_eq!((status, category), (3, c"logStatusError"));
    // SAFETY: as above.
    let message = unsafe { CStr::from_ptr(message) };
    let message = message.to_str().unwrap().to_owned();
    LOGGED.with_borrow_mut(|all| all.push(message));
}

fn last() -> String {
    LOGGED.with_borrow(|all| all.last().cloned().unwrap_or_default())
}

/// An instance that is freed at its end.
struct Instance(*mut c_void);

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: of fmi3InstantiateCoSimulation, freed here alone.
        unsafe { fmi3FreeInstance(self.0) };
    }
}

impl Instance {
    fn try_new(token: &str, resources: &str) -> Option<Self> {
        let [name, token, resources] =
            ["wire", token, resources].map(|text| CString::new(text).unwrap());
        // SAFETY: strings end with a zero, and the log is a function.
        let pointer = unsafe {
            fmi3InstantiateCoSimulation(
                name.as_ptr(),
                token.as_ptr(),
                resources.as_ptr(),
                false,
                true,
                false,
                false,
                std::ptr::null(),
                0,
                std::ptr::null_mut(),
                Some(log),
                std::ptr::null(),
            )
        };
        (!pointer.is_null()).then_some(Self(pointer))
    }

    fn set(&self, variable: FmuVariable, value: f64) -> c_int {
        let reference = variable as u32;
        // SAFETY: one reference and one value.
        unsafe { fmi3SetFloat64(self.0, &raw const reference, 1, &raw const value, 1) }
    }

    fn get<const N: usize>(&self, references: [u32; N]) -> [f64; N] {
        let mut values = [f64::NAN; N];
        // SAFETY: as many references and places.
        let status =
            unsafe { fmi3GetFloat64(self.0, references.as_ptr(), N, values.as_mut_ptr(), N) };
        assert_eq!(status, 0);
        values
    }

    fn time_bits(&self) -> u64 {
        self.get([FMU_TIME])[0].to_bits()
    }

    /// Takes a step, and returns its status and what it says of events, of an end, of an early return, and of its last time.
    fn step(&self, time_s: f64, length_s: f64) -> (c_int, [bool; 3], f64) {
        let ([mut event, mut end, mut early], mut last_s) = ([true; 3], f64::NAN);
        // SAFETY: places for all results.
        let status = unsafe {
            fmi3DoStep(
                self.0,
                time_s,
                length_s,
                true,
                &raw mut event,
                &raw mut end,
                &raw mut early,
                &raw mut last_s,
            )
        };
        (status, [event, end, early], last_s)
    }

    fn initialize(&self, start_s: f64) {
        // SAFETY: of fmi3InstantiateCoSimulation and not freed.
        let begun = unsafe { fmi3EnterInitializationMode(self.0, false, 0.0, start_s, false, 0.0) };
        // SAFETY: as above.
        let ended = unsafe { fmi3ExitInitializationMode(self.0) };
        assert_eq!((begun, ended), (0, 0), "{}", last());
    }

    /// Displacements and temperatures before each sample from the k-th.
    fn run(&self, k: usize, drive: &[f64]) -> Vec<[u64; 2]> {
        let samples = drive.iter().enumerate().map(|(more, &drive)| {
            let shown = [FmuVariable::Displacement, FmuVariable::TemperatureDegc];
            let row = self.get(shown.map(|one| one as u32)).map(f64::to_bits);
            assert_eq!(self.set(FmuVariable::Drive, drive), 0);
            let time_s = (k + more) as f64 * DT_S;
            assert_eq!(
                self.step(time_s, DT_S),
                (0, [false; 3], time_s + DT_S),
                "{}",
                last()
            );
            row
        });
        samples.collect()
    }
}

#[test]
fn a_unit_of_version_3_has_the_bits_of_the_program_too() {
    let (folder, _) = resources();
    let path = folder.path().join("a wire");
    // Importers end the path with a separator.
    let unit = Instance::try_new(&guid(), &format!("{}/", path.display())).unwrap();
    assert_eq!(unit.set(FmuVariable::AmbientDegc, AMBIENT_DEGC), 0);
    unit.initialize(12.5);
    assert_eq!(unit.time_bits(), 12.5_f64.to_bits());
    let drive = drive();
    let expected = predicted(&drive);
    assert!(unit.run(0, &drive[..1500]) == expected[..1500]);
    let mut state = std::ptr::null_mut();
    // SAFETY: a place for a new state.
    assert_eq!(unsafe { fmi3GetFMUState(unit.0, &raw mut state) }, 0);
    assert!(unit.run(1500, &drive[1500..]) == expected[1500..]);
    let end_s = (drive.len() - 1) as f64 * DT_S + DT_S;
    assert_eq!(unit.time_bits(), end_s.to_bits());
    // SAFETY: of the call above.
    assert_eq!(unsafe { fmi3SetFMUState(unit.0, state) }, 0);
    assert_eq!(unit.time_bits(), (1499.0 * DT_S + DT_S).to_bits());
    assert!(unit.run(1500, &drive[1500..]) == expected[1500..]);
    // SAFETY: as above, freed here alone.
    assert_eq!(unsafe { fmi3FreeFMUState(unit.0, &raw mut state) }, 0);
    assert!(state.is_null());
    // SAFETY: of fmi3InstantiateCoSimulation and not freed.
    assert_eq!(unsafe { fmi3Terminate(unit.0) }, 0);
    // SAFETY: as above.
    assert_eq!(unsafe { fmi3Reset(unit.0) }, 0);
    unit.initialize(0.0);
}

#[test]
fn what_is_refused_in_version_3_is_logged() {
    let (folder, uri) = resources();
    let path = folder.path().join("a wire").display().to_string();
    assert!(Instance::try_new("{0}", &path).is_none());
    assert!(
        last().starts_with("instantiation token {0}: expected {"),
        "{}",
        last()
    );
    // A URI is that of version 2.
    assert!(Instance::try_new(&guid(), &uri).is_none());
    assert!(last().ends_with("expected an absolute path"), "{}", last());
    let unit = Instance::try_new(&guid(), &path).unwrap();
    let (status, flags, last_s) = unit.step(3.0, DT_S);
    assert_eq!((status, flags, last_s), (3, [false; 3], 3.0));
    assert_eq!(last(), "DoStep: not while the instance is instantiated");
    let (references, mut value) = ([2_u32, 3], 0.0);
    // SAFETY: two references, and it is said that there is room for one value.
    let status = unsafe { fmi3GetFloat64(unit.0, references.as_ptr(), 2, &raw mut value, 1) };
    assert_eq!(status, 3);
    assert_eq!(
        last(),
        "fmi3GetFloat64: 2 variables, but no place for their values"
    );
    // SAFETY: as above.
    let status = unsafe { fmi3SetFloat64(unit.0, references.as_ptr(), 2, &raw const value, 1) };
    assert_eq!(status, 3);
    let none = std::ptr::null_mut::<i32>();
    assert_eq!(fmi3GetInt32(unit.0, references.as_ptr(), 0, none, 0), 0);
    assert_eq!(fmi3GetInt32(unit.0, references.as_ptr(), 1, none, 0), 3);
    let text = std::ptr::null();
    let null = std::ptr::null_mut();
    let instance =
        // SAFETY: null pointers are not read, and the log is a function.
        unsafe { fmi3InstantiateModelExchange(text, text, text, false, true, null, Some(log)) };
    assert!(instance.is_null());
    assert!(last().ends_with("expected co-simulation"), "{}", last());
    let (time, value) = (FMU_TIME, 1.0);
    // SAFETY: one reference and one value.
    let status = unsafe { fmi3SetFloat64(unit.0, &raw const time, 1, &raw const value, 1) };
    assert_eq!(status, 3);
    assert_eq!(
        last(),
        "time: is the time of the importer: it cannot be set"
    );
    // SAFETY: of fmi3InstantiateCoSimulation and not freed.
    let status = unsafe { fmi3EnterInitializationMode(unit.0, false, 0.0, f64::NAN, false, 0.0) };
    assert_eq!(status, 3);
    assert_eq!(last(), "start time = NaN: must be a finite number");
    // SAFETY: a null pointer is refused, and its places are not written.
    let status = unsafe {
        let no = std::ptr::null_mut();
        fmi3DoStep(null, 0.0, 1.0, true, no, no, no, std::ptr::null_mut())
    };
    assert_eq!(status, 3);
    // SAFETY: a text that ends with a zero.
    assert_eq!(unsafe { CStr::from_ptr(fmi3GetVersion()) }, c"3.0");
}
