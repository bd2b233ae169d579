//! A diagnosis with the whole catalogue, and the number of simulations that it takes.

use std::io::{self, Write};
use std::ops::ControlFlow;

use benches::sound;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use identify::{IdentifyError, WienerModel};
use missing_physics::{
    DiagnoseConfig, Diagnosis, EffectId, EffectSet, EffectValues, diagnose, setting_of_rod,
};
use studies::{Made, MadeUp, NoiseKind, made_up_of_length};
use wiener::hysteresis::Rule;

/// Samples of the training recording.
const N_SAMPLES: usize = 10_000;

/// A rig with latent heat and white noise.
fn rig(n_samples: usize) -> MadeUp {
    let made = Made {
        effects: EffectSet::of(EffectId::LatentHeat),
        values: EffectValues::typical(EffectId::LatentHeat, 1.0),
        noise: NoiseKind::White,
        noise_share: 0.0015,
        seed: 1,
    };
    made_up_of_length(&made, n_samples)
}

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

#[divan::bench(args = [N_SAMPLES], sample_count = 5)]
fn latent_heat(bencher: Bencher, n_samples: usize) {
    let rig = rig(n_samples);
    bencher
        .counter(ItemsCount::new(n_samples))
        .bench_local(|| diagnosed(black_box(&rig)));
}

fn main() {
    // The count is that of the seed, on any machine.
    let counted = sound(diagnosed(&rig(N_SAMPLES)));
    let text = format!(
        "latent_heat/{N_SAMPLES}: {} simulations, {}\n",
        counted.simulations,
        counted.verdict.id()
    );
    // A closed pipe is not a fault of the bench.
    let _ = io::stdout().write_all(text.as_bytes());
    divan::main();
}
