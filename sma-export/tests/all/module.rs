//! The Python module, run beside the program.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]
#![allow(clippy::print_stdout, reason = "tests say what they skip and find")]

use std::path::Path;
use std::process::Command;

use sma_effects::EffectId;
use sma_export::{Exported, python_module};

use crate::common::{
    AMBIENT_DEGC, assert_agrees, bits, controlled, deeply_nested, drives, of_wild_duty, plain,
    setpoints, simulated, with_controllers, with_effects,
};

/// Python 3: `PYTHON`, or `python3`. A machine without one says so.
fn python() -> Option<String> {
    let name = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    if Command::new(&name).arg("--version").output().is_ok() {
        return Some(name);
    }
    println!("SKIPPED: no Python {name}; set PYTHON");
    None
}

/// Steps modules through their inputs: what they show, a row of two numbers a sample, model after model.
fn run(
    python: &str,
    folder: &Path,
    models: &[Exported],
    inputs: &[f64],
    step: &str,
) -> Vec<[f64; 2]> {
    let each = inputs.len() / models.len();
    let mut body = String::from(
        "import array, sys\nout = array.array('d')\ninputs = array.array('d')\ninputs.frombytes(open('input', 'rb').read())\n",
    );
    for (m, model) in models.iter().enumerate() {
        let name = format!("m{m}.py");
        std::fs::write(folder.join(name), python_module(model).unwrap()).unwrap();
        body += &format!(
            "import m{m} as model\nplant = model.Plant({AMBIENT_DEGC:?} + model.START_RISE_K, model.START_SHARE)\n"
        );
        body += &format!("rows = inputs[{}:{}]\n{step}", m * each, (m + 1) * each);
    }
    body += "sys.stdout.buffer.write(out.tobytes())\n";
    std::fs::write(folder.join("main.py"), body).unwrap();
    let bytes: Vec<u8> = inputs
        .iter()
        .flat_map(|input| input.to_ne_bytes())
        .collect();
    std::fs::write(folder.join("input"), bytes).unwrap();
    let ran = Command::new(python)
        // Files that are compiled by the way would stay behind.
        .args(["-B", "-W", "error", "main.py"])
        .current_dir(folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{said}");
    let number = |bytes: &[u8]| f64::from_ne_bytes(bytes.try_into().unwrap());
    let rows = ran.stdout.chunks_exact(16);
    rows.map(|row| [number(&row[..8]), number(&row[8..])])
        .collect()
}

/// Lines that step a plant through its rows.
fn stepped() -> String {
    format!(
        "for drive in rows:\n    out.extend((plant.output, plant.temperature_degc))\n    plant.step(drive, {AMBIENT_DEGC:?})\n"
    )
}

#[test]
fn a_duty_beyond_its_range_acts_as_its_ends() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (model, [beyond, within]) = of_wild_duty();
    let models = std::slice::from_ref(&model);
    let found = run(&python, folder.path(), models, &beyond, &stepped());
    assert!(bits(&found) == bits(&simulated(&model, &within)));
}

#[test]
fn a_module_agrees_with_the_program() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let models = [plain(), with_effects()].concat();
    let n_samples = 1_500;
    let drives = drives(&models, n_samples);
    let step = stepped();
    let (nested, drive) = deeply_nested();
    let one = std::slice::from_ref(&nested);
    let found = run(&python, folder.path(), one, &drive, &step);
    assert!(bits(&found) == bits(&simulated(&nested, &drive)));
    let found = run(&python, folder.path(), &models, &drives.concat(), &step);
    assert_eq!(found.len(), models.len() * n_samples);
    let by_library = [EffectId::SupplyLag, EffectId::Backlash];
    for (m, model) in models.iter().enumerate() {
        let expected = simulated(model, &drives[m]);
        let found = &found[m * n_samples..][..n_samples];
        assert_agrees(model, [&expected, found], &by_library);
    }
}

#[test]
fn a_closed_loop_has_the_bits_of_the_program() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let models = with_controllers();
    let setpoints = setpoints();
    let inputs = vec![setpoints.clone(); models.len()].concat();
    let step = format!(
        "pid = model.Pid(plant.output)\nfor setpoint in rows:\n    y = plant.output\n    drive = pid.step(setpoint, y)\n    out.extend((y, drive))\n    plant.step(drive, {AMBIENT_DEGC:?})\n"
    );
    let found = run(&python, folder.path(), &models, &inputs, &step);
    assert_eq!(found.len(), inputs.len());
    for (model, found) in models.iter().zip(found.chunks(setpoints.len())) {
        assert!(bits(&controlled(model, &setpoints)) == bits(found));
    }
}
