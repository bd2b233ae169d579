//! Texts of errors.

use sma_effects::{EffectId, Hypothesis};
use sma_export::{CNumbers, CPrefix, ExportError, Exported, Fmi, c_header, fmu, python_module};
use wiener::Drive;
use wiener::hysteresis::{LoopFamily, Rule};

use crate::common::{controller, exported};
use pid_tune::{AntiWindup, DerivativeOf};

fn refused(exported: &Exported, numbers: CNumbers) -> String {
    let error = c_header(exported, numbers, &CPrefix::default()).unwrap_err();
    let source = std::error::Error::source(&error).map(ToString::to_string);
    match source {
        Some(source) => format!("{error}: {source}"),
        None => error.to_string(),
    }
}

#[test]
fn what_has_no_formula_is_refused_by_name() {
    for effect in EffectId::ALL {
        let model = exported(Drive::Current, Rule::LastReversal, &[effect]);
        if Exported::formulas().contains(effect) {
            assert!(c_header(&model, CNumbers::Double, &CPrefix::default()).is_ok());
        } else {
            let text = refused(&model, CNumbers::Double);
            let start = format!("{effect}: needs a search for the end of each sample");
            assert!(text.starts_with(&start), "{text}");
            assert!(
                text.contains("expected a model of supply-limit, "),
                "{text}"
            );
        }
    }
    let mut relays = exported(Drive::Current, Rule::Nested, &[]);
    relays.setting.loop_family = LoopFamily::Relays;
    assert_eq!(
        refused(&relays, CNumbers::Double),
        "loop family relays: has no formula in this export yet; expected limiting-loop-proximity; --to fmu exports all families"
    );
}

#[test]
fn numbers_that_cannot_be_are_refused() {
    for value in [0.0, -0.1, f64::NAN, f64::INFINITY] {
        let mut model = exported(Drive::Current, Rule::Nested, &[]);
        model.dt_s = value;
        assert_eq!(
            refused(&model, CNumbers::Double),
            format!("sample time {value} s: must be finite and > 0")
        );
    }
    let mut model = exported(Drive::Current, Rule::Nested, &[]);
    model.member.params.gain = 1e40;
    assert_eq!(
        refused(&model, CNumbers::Float),
        "gain = 10000000000000000000000000000000000000000: beyond the range of a float; leave out --float, or look at the model"
    );
    let mut model = exported(Drive::Current, Rule::Nested, &[]);
    model.member.params.zeta = 2.0;
    let text = refused(&model, CNumbers::Double);
    assert!(text.starts_with("the model is refused: "), "{text}");
    let mut model = exported(Drive::Current, Rule::Nested, &[]);
    let mut bad = controller(AntiWindup::Off, DerivativeOf::Error);
    bad.gains.kp = -1.0;
    model.controller = Some(bad);
    let text = refused(&model, CNumbers::Double);
    assert!(text.starts_with("the controller is refused: "), "{text}");
}

#[test]
fn own_hypotheses_are_refused() {
    let text = "[[hypothesis]]\nid = \"leak\"\nheat_flow_w_per_m = \"-k * (T - Ta)\"\n[hypothesis.parameters.k]\nunit = \"W/(m K)\"\ntypical = 0.02\nbounds = [0.0, 1.0]\n";
    let mut model = exported(Drive::Current, Rule::Nested, &[]);
    model.setting.hypotheses = Hypothesis::parse("own.toml", text).unwrap();
    let said = "hypotheses of your own: have no export; expected effects of the catalogue";
    assert_eq!(refused(&model, CNumbers::Double), said);
    assert_eq!(python_module(&model).unwrap_err().to_string(), said);
}

#[test]
fn units_are_refused_by_what_they_lack() {
    let mut model = exported(Drive::Current, Rule::Nested, &[EffectId::LatentHeat]);
    assert_eq!(
        fmu(&model, Fmi::V2, "", b"no library")
            .unwrap_err()
            .to_string(),
        format!(
            "the library is no 64-bit ELF file; expected libsma_fmu.so of sma {}, beside the program or as --library",
            env!("CARGO_PKG_VERSION")
        )
    );
    model.dt_s = -1.0;
    assert_eq!(
        fmu(&model, Fmi::V2, "", b"no library")
            .unwrap_err()
            .to_string(),
        "sample time -1 s: must be finite and > 0"
    );
    assert_eq!(
        ExportError::TooLarge.to_string(),
        "the unit would have more than 4 GiB: expected a library and a model of a few MB"
    );
    let file = "model.toml".to_owned();
    assert_eq!(
        ExportError::NoSampleTime { file }.to_string(),
        "model.toml: no recording of the model has a sample time; give --sample-time-s"
    );
}
