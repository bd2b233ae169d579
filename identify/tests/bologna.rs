//! The measured recordings of a Flexinol wire against a bias spring, where they are present.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

use identify::{FitConfig, Rod, WienerModel, fit, validate};
use recording::read_csv;
use std::ops::ControlFlow;
use wiener::hysteresis::Rule;

const ROD: &str = "\
[rod]
diameter_mm = 0.5
length_mm = 1000.0
density_kg_per_m3 = 6450.0
specific_heat_j_per_kg_k = 500.0
resistance_ohm_per_m = 4.3
[surroundings]
ambient_degc = 24.0
[drive]
kind = \"duty\"
supply_v = 24.0
[columns]
output = \"position_mm\"
";

#[test]
fn three_recordings_are_met_together() {
    let rod = Rod::parse("rod.toml", ROD).unwrap();
    let read = |name: &str| {
        let path = fixtures::shared::path(&format!("recordings/bologna/{name}.csv"))?;
        Some(read_csv(path, &rod.read_options()).unwrap())
    };
    let Some(training) = ["ramp01", "step01", "step02"]
        .map(read)
        .into_iter()
        .collect::<Option<Vec<_>>>()
    else {
        return;
    };
    let model = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap();
    let fit = fit(&model, &training, &FitConfig::default(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap();
    assert!(fit.train_rmse <= 0.37, "{}", fit.train_rmse);
    assert!(fit.termination.is_minimum());
    // The plain model leaves physics out, and it shows on the unseen run.
    let unseen = read("ramp02").unwrap();
    let validated = validate(&model, &fit, &unseen).unwrap();
    assert!((0.5..1.5).contains(&validated.rmse), "{}", validated.rmse);
}
