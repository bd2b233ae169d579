//! The measured recordings of a Flexinol wire against a bias spring, where they are present.

#![allow(
    clippy::unwrap_used,
    reason = "tests fail by panicking, in their helpers too"
)]

use fixtures::bologna;
use identify::{FitConfig, WienerModel, fit, validate};
use recording::read_csv;
use rig_files::rod_file;
use std::ops::ControlFlow;
use wiener::hysteresis::Rule;

#[test]
fn three_recordings_are_met_together() {
    let rod = rod_file::parse("rod.toml", bologna::ROD).unwrap();
    let read = |name: &str| {
        let path = fixtures::shared::path(&format!("{}/{name}", bologna::FOLDER))?;
        Some(read_csv(path, &rod.read_options()).unwrap())
    };
    let Some(training) = bologna::TRAINING
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
    // The baseline model leaves physics out, and it shows on the unseen run.
    let unseen = read(bologna::UNSEEN).unwrap();
    let validated = validate(&model, &fit, &unseen).unwrap();
    assert!((0.5..1.5).contains(&validated.rmse), "{}", validated.rmse);
}
