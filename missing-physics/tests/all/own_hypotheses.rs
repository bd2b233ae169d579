//! Hypotheses of one's own compete with the catalogue: one that is true is named, one that is not is not.

#![allow(
    clippy::unwrap_used,
    reason = "a test fails by panicking wherever it makes its data"
)]

use crate::common;

use common::{diagnosed, noisy, output_mm, setting};
use missing_physics::{Status, Verdict};
use sma_effects::{EffectId, EffectSet, EffectValues, Hypothesis, Setting};

/// A draught that comes and goes, and a spring that pulls the loop up with the stroke's square.
const OWN: &str = r#"
[[hypothesis]]
id = "fan"
name = "a fan that turns"
sentence = "the wire loses up to {value} more, once a {partner}"
heat_flow_w_per_m = "-k * (T - Ta) * (1 - cos(2 * pi * t / period)) / 2"
[hypothesis.parameters.k]
unit = "W/(m K)"
typical = 0.02
bounds = [0.0, 0.2]
[hypothesis.parameters.period]
unit = "s"
typical = 45.0
bounds = [30.0, 60.0]
size = false

[[hypothesis]]
id = "stiff-spring"
shift_k = "a * xi^2"
[hypothesis.parameters.a]
unit = "K"
typical = 10.0
bounds = [-40.0, 40.0]
"#;

fn own() -> &'static [Hypothesis] {
    Hypothesis::parse("own.toml", OWN).unwrap()
}

/// The wire in the draught of a fan.
fn in_a_draught() -> Vec<f64> {
    let setting = Setting {
        hypotheses: own(),
        ..setting()
    };
    let mut effects = EffectValues::default();
    effects.own[0][..2].copy_from_slice(&[0.03, 50.0]);
    noisy(output_mm(setting, effects))
}

#[test]
fn one_that_is_true_is_named_with_its_numbers() {
    let found = diagnosed(in_a_draught(), own());
    assert_eq!(found.verdict, Verdict::Explained);
    let [fan] = &found.findings[..] else {
        panic!("{:?}", found.findings);
    };
    assert_eq!(fan.effect.id(), "fan");
    let [k, period] = &fan.parameters[..] else {
        panic!("{:?}", fan.parameters);
    };
    assert!((k.value / 0.03 - 1.0).abs() < 0.05, "{}", k.value);
    assert!((period.value / 50.0 - 1.0).abs() < 0.02, "{}", period.value);
    let [lower, upper] = k.ci95.unwrap();
    assert!((lower..=upper).contains(&0.03));
    assert!(
        fan.sentence.contains("the wire loses up to"),
        "{}",
        fan.sentence
    );
    // The catalogue's entries are still there, and those of both hypotheses.
    assert_eq!(found.catalogue.len(), EffectId::ALL.len() + 2);
}

#[test]
fn without_it_the_catalogue_does_not_know() {
    let found = diagnosed(in_a_draught(), &[]);
    assert_eq!(found.verdict, Verdict::Unexplained, "{:?}", found.findings);
}

#[test]
fn one_that_is_not_true_takes_nothing_from_the_catalogue() {
    let setting = Setting {
        active: EffectSet::of(EffectId::LatentHeat),
        ..setting()
    };
    let truth = EffectValues::typical(EffectId::LatentHeat, 1.0);
    let found = diagnosed(noisy(output_mm(setting, truth)), own());
    assert_eq!(found.verdict, Verdict::Explained);
    assert_eq!(found.findings.len(), 1);
    assert_eq!(found.findings[0].effect, EffectId::LatentHeat);
    let fan = found
        .catalogue
        .iter()
        .find(|entry| entry.effect.id() == "fan");
    assert!(!matches!(fan.unwrap().status, Status::Detected));
}
