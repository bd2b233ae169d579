//! A diagnosis with the whole catalogue, and the number of simulations that it takes.

use std::io::{self, Write};
use std::ops::ControlFlow;

use benches::{MadeUp, made_up, sound};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use identify::{IdentifyError, WienerModel};
use missing_physics::{DiagnoseConfig, Diagnosis, diagnose, setting_of_rod};
use sma_effects::EffectId;
use wiener::hysteresis::Rule;

/// Time between samples, s.
const DT_S: f64 = 0.1;

fn diagnosed(rig: &MadeUp) -> Result<Diagnosis, IdentifyError> {
    let base = WienerModel::new(&rig.rod, Rule::LastReversal, &rig.training)?;
    let config = DiagnoseConfig {
        setting: setting_of_rod(&rig.rod, "mm"),
        ..DiagnoseConfig::default()
    };
    diagnose(&base, &rig.training, &rig.unseen, &config, &mut |_| {
        ControlFlow::Continue(())
    })
}

#[divan::bench(sample_count = 5)]
fn latent_heat(bencher: Bencher) {
    let rig = made_up(EffectId::LatentHeat, DT_S);
    bencher
        .counter(ItemsCount::new(rig.training[0].len()))
        .bench_local(|| diagnosed(black_box(&rig)));
}

fn main() {
    // The count is that of the seed, on any machine.
    let counted = sound(diagnosed(&made_up(EffectId::LatentHeat, DT_S)));
    let text = format!(
        "latent_heat: {} simulations, {}\n",
        counted.simulations.total(),
        counted.verdict.id()
    );
    // A closed pipe is not a fault of the bench.
    let _ = io::stdout().write_all(text.as_bytes());
    divan::main();
}
