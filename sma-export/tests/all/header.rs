//! The C99 header, compiled and run beside the program.

#![allow(clippy::unwrap_used, reason = "helpers of tests")]
#![allow(clippy::print_stdout, reason = "tests say what they skip and find")]

use std::fmt::Write;
use std::path::Path;
use std::process::Command;

use sma_effects::EffectId;
use sma_export::{CNumbers, CPrefix, Exported, c_header};
use wiener::Drive;
use wiener::hysteresis::Rule;

use crate::common::{
    AMBIENT_DEGC, apart, assert_agrees, bits, controlled, deeply_nested, drives, exported,
    of_wild_duty, plain, setpoints, simulated, with_controllers, with_effects,
};

const WARNINGS: [&str; 7] = [
    "-std=c99",
    "-pedantic",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-Wdouble-promotion",
    "-ffp-contract=off",
];

/// The C compiler: `CC`, or `cc`. A machine without one says so.
fn compiler() -> Option<String> {
    let name = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    if Command::new(&name).arg("--version").output().is_ok() {
        return Some(name);
    }
    println!("SKIPPED: no C compiler {name}; set CC");
    None
}

/// Compiles a program that has all models in it, and runs it with the inputs on stdin: what it writes, a row of two
/// numbers a sample, model after model.
fn run(cc: &str, folder: &Path, body: &str, flags: &[&str], inputs: &[f64]) -> Vec<[f64; 2]> {
    let source = folder.join("main.c");
    std::fs::write(&source, body).unwrap();
    let program = folder.join("main");
    let compiled = Command::new(cc)
        .args(WARNINGS)
        .args(flags)
        .arg("-o")
        .arg(&program)
        .arg(&source)
        .arg("-lm")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&compiled.stderr);
    assert!(compiled.status.success(), "{flags:?}: {said}");
    let bytes: Vec<u8> = inputs
        .iter()
        .flat_map(|input| input.to_ne_bytes())
        .collect();
    let input = folder.join("input");
    std::fs::write(&input, bytes).unwrap();
    let ran = Command::new(&program)
        .stdin(std::fs::File::open(&input).unwrap())
        .output()
        .unwrap();
    assert!(ran.status.success(), "{flags:?}");
    let number = |bytes: &[u8]| f64::from_ne_bytes(bytes.try_into().unwrap());
    let rows = ran.stdout.chunks_exact(16);
    rows.map(|row| [number(&row[..8]), number(&row[8..])])
        .collect()
}

/// A program that steps plants one after another through the same inputs. Each has a factor and an exponent that turn
/// a current into its drive.
fn plants(folder: &Path, models: &[Exported], numbers: CNumbers) -> String {
    let mut body = String::from("#include <stdio.h>\n");
    let mut main = String::from(
        "int main(void) {\n    static double input[200000];\n    size_t n = fread(input, sizeof *input, 200000, stdin), k, each;\n",
    );
    let _ = writeln!(main, "    each = n / {};", models.len());
    for (m, model) in models.iter().enumerate() {
        let prefix = CPrefix::new(&format!("m{m}")).unwrap();
        let header = c_header(model, numbers, &prefix).unwrap();
        std::fs::write(folder.join(format!("m{m}.h")), header).unwrap();
        let _ = writeln!(body, "#include \"m{m}.h\"");
        let _ = write!(
            main,
            "    {{\n        m{m}_plant plant;\n        m{m}_plant_start(&plant, (m{m}_real){AMBIENT_DEGC:?} + M{m}_START_RISE_K, M{m}_START_SHARE);\n        for (k = 0; k < each; ++k) {{\n            double row[2];\n            row[0] = (double)m{m}_plant_output(&plant);\n            row[1] = (double)m{m}_plant_temperature_degc(&plant);\n            fwrite(row, sizeof *row, 2, stdout);\n            m{m}_plant_step(&plant, (m{m}_real)input[{m} * each + k], (m{m}_real){AMBIENT_DEGC:?});\n        }}\n    }}\n"
        );
    }
    body + &main + "    return 0;\n}\n"
}

/// A program that runs closed loops one after another along the same set points.
fn loops(folder: &Path, models: &[Exported]) -> String {
    let mut body = String::from("#include <stdio.h>\n");
    let mut main = String::from(
        "int main(void) {\n    static double input[200000];\n    size_t n = fread(input, sizeof *input, 200000, stdin), k;\n",
    );
    for (m, model) in models.iter().enumerate() {
        let prefix = CPrefix::new(&format!("m{m}")).unwrap();
        let header = c_header(model, CNumbers::Double, &prefix).unwrap();
        std::fs::write(folder.join(format!("m{m}.h")), header).unwrap();
        let _ = writeln!(body, "#include \"m{m}.h\"");
        let _ = write!(
            main,
            "    {{\n        m{m}_plant plant;\n        m{m}_pid pid;\n        m{m}_plant_rest(&plant, {AMBIENT_DEGC:?});\n        m{m}_pid_rest(&pid, m{m}_plant_output(&plant));\n        for (k = 0; k < n; ++k) {{\n            double row[2];\n            row[0] = m{m}_plant_output(&plant);\n            row[1] = m{m}_pid_step(&pid, input[k], row[0], 0);\n            fwrite(row, sizeof *row, 2, stdout);\n            m{m}_plant_step(&plant, row[1], {AMBIENT_DEGC:?});\n        }}\n    }}\n"
        );
    }
    body + &main + "    return 0;\n}\n"
}

#[test]
fn plain_models_have_the_bits_of_the_program_however_they_are_compiled() {
    let Some(cc) = compiler() else { return };
    let folder = tempfile::tempdir().unwrap();
    let models = plain();
    let n_samples = 10_000;
    let drives = drives(&models, n_samples);
    let expected: Vec<[f64; 2]> = models
        .iter()
        .zip(&drives)
        .flat_map(|(model, drive)| simulated(model, drive))
        .collect();
    let mean = |rows: &[[f64; 2]]| rows.iter().map(|row| row[0]).sum::<f64>() / rows.len() as f64;
    // The rod moves.
    let moved = mean(&expected[..n_samples]);
    assert!((2.0..5.0).contains(&moved), "{moved}");
    let body = plants(folder.path(), &models, CNumbers::Double);
    let found = run(&cc, folder.path(), &body, &["-O2"], &drives.concat());
    assert_eq!(found.len(), models.len() * n_samples);
    assert!(bits(&found) == bits(&expected));
    // The last reversal under a current, all of them under a duty.
    let few = [models[0].clone(), models[5].clone()];
    let inputs = [&drives[0][..], &drives[5]].concat();
    let expected = [
        &expected[..n_samples],
        &expected[5 * n_samples..][..n_samples],
    ]
    .concat();
    let body = plants(folder.path(), &few, CNumbers::Double);
    for optimized in ["-O0", "-O3", "-Os"] {
        let found = run(&cc, folder.path(), &body, &[optimized], &inputs);
        assert!(bits(&found) == bits(&expected), "{optimized}");
    }
}

#[test]
fn every_exported_effect_agrees_with_the_program() {
    let Some(cc) = compiler() else { return };
    let folder = tempfile::tempdir().unwrap();
    let models = with_effects();
    let n_samples = 5_000;
    let drives = drives(&models, n_samples);
    let body = plants(folder.path(), &models, CNumbers::Double);
    let found = run(&cc, folder.path(), &body, &["-O2"], &drives.concat());
    assert_eq!(found.len(), models.len() * n_samples);
    let plain = exported(Drive::Current, Rule::LastReversal, &[]);
    let without = simulated(&plain, &drives[0]);
    for (m, model) in models.iter().enumerate() {
        let active: Vec<&str> = model.setting.active.iter().map(EffectId::id).collect();
        let expected = simulated(model, &drives[m]);
        let found = &found[m * n_samples..][..n_samples];
        assert_agrees(model, [&expected, found], &[EffectId::SupplyLag]);
        // It acts.
        assert!(bits(&expected) != bits(&without), "{active:?}");
    }
}

#[test]
fn a_header_of_floats_stays_within_its_tolerance() {
    let Some(cc) = compiler() else { return };
    let folder = tempfile::tempdir().unwrap();
    // A time constant of a thousand samples.
    let slow = Exported {
        dt_s: 0.0097,
        ..exported(Drive::Current, Rule::Nested, &[])
    };
    let models = [vec![slow], plain(), with_effects()].concat();
    let n_samples = 5_000;
    let drives = drives(&models, n_samples);
    let body = plants(folder.path(), &models, CNumbers::Float);
    let found = run(&cc, folder.path(), &body, &["-O1"], &drives.concat());
    for (m, model) in models.iter().enumerate() {
        let active: Vec<&str> = model.setting.active.iter().map(EffectId::id).collect();
        let expected = simulated(model, &drives[m]);
        let [output, kelvin] = apart(&expected, &found[m * n_samples..][..n_samples], 5.0);
        println!("model {m}, {active:?}: {output:e} of the stroke, {kelvin:e} K");
        assert!(output <= 1e-4, "model {m}, {active:?}: {output:e}");
        assert!(output > 1e-9, "model {m} is of floats");
    }
}

#[test]
fn a_closed_loop_has_the_bits_of_the_program() {
    let Some(cc) = compiler() else { return };
    let folder = tempfile::tempdir().unwrap();
    let models = with_controllers();
    let setpoints = setpoints();
    let body = loops(folder.path(), &models);
    let found = run(&cc, folder.path(), &body, &["-O2"], &setpoints);
    assert_eq!(found.len(), models.len() * setpoints.len());
    for (model, found) in models.iter().zip(found.chunks(setpoints.len())) {
        let expected = controlled(model, &setpoints);
        let windup = model.controller.unwrap().params.anti_windup;
        assert!(bits(&expected) == bits(found), "{windup:?}");
        // Both limits are reached, and left.
        assert!(expected.iter().any(|row| row[1] <= 0.0));
        assert!(expected.iter().any(|row| row[1] >= 2.4));
        assert!(expected.iter().any(|row| row[1] > 0.1 && row[1] < 2.3));
    }
}

#[test]
fn a_full_memory_forgets_as_that_of_the_program() {
    let Some(cc) = compiler() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (model, drive) = deeply_nested();
    let body = plants(
        folder.path(),
        std::slice::from_ref(&model),
        CNumbers::Double,
    );
    let found = run(&cc, folder.path(), &body, &["-O1"], &drive);
    assert!(bits(&found) == bits(&simulated(&model, &drive)));
}

#[test]
fn a_duty_beyond_its_range_acts_as_its_ends() {
    let Some(cc) = compiler() else { return };
    let folder = tempfile::tempdir().unwrap();
    let (model, [beyond, within]) = of_wild_duty();
    let body = plants(
        folder.path(),
        std::slice::from_ref(&model),
        CNumbers::Double,
    );
    let found = run(&cc, folder.path(), &body, &["-O1"], &beyond);
    assert!(bits(&found) == bits(&simulated(&model, &within)));
    assert!(bits(&found) != bits(&simulated(&model, &beyond)));
}

#[test]
fn compilers_that_lose_nan_are_refused() {
    let Some(cc) = compiler() else { return };
    let folder = tempfile::tempdir().unwrap();
    let model = exported(Drive::Current, Rule::Nested, &[]);
    let header = c_header(&model, CNumbers::Double, &CPrefix::default()).unwrap();
    std::fs::write(folder.path().join("rod.c"), header).unwrap();
    let compiled = |flag: &str| {
        let output = Command::new(&cc)
            .args(["-std=c99", "-fsyntax-only", flag, "rod.c"])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.success(), said)
    };
    assert!(compiled("-O2").0, "{}", compiled("-O2").1);
    for flag in ["-ffinite-math-only", "-ffast-math"] {
        let (is_compiled, said) = compiled(flag);
        assert!(!is_compiled && said.contains(flag), "{flag}: {said}");
    }
}

#[test]
fn a_header_says_what_it_is() {
    let mut model = exported(Drive::Current, Rule::Nested, &[EffectId::Backlash]);
    model.labels.left_out = vec!["drift of the recordings: sensor-drift".to_owned()];
    let header = c_header(&model, CNumbers::Double, &CPrefix::default()).unwrap();
    for said in [
        "Model:        model.toml, SHA-256 0000",
        "Drive:        current, A",
        "Output:       displacement, mm",
        "Sample time:  0.05 s, fixed",
        "Offset:       1 mm, that of train.csv",
        "Memory rule:  all reversals that enclose the branch",
        "Effects:      backlash",
        "Left out:     drift of the recordings: sensor-drift",
        "Controller:   none",
    ] {
        assert!(header.contains(said), "{said}");
    }
    assert!(!header.contains("{{") && !header.contains("@if"));
}
