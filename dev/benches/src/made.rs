//! A made-up rig, recorded as often as is asked for.

use fixtures::wire::{AMBIENT_DEGC, ROD};
use identify::Rod;
use missing_physics::setting_of_rod;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Recording, RecordingParts};
use rig_files::rod_file;
use sma_effects::{EffectId, EffectSet, EffectValues, Extended, Member, Setting};
use wiener::hysteresis::LoopParams;
use wiener::thermal::RodParams;
use wiener::{Profile, Start, WienerParams};

/// Stroke, mm.
const STROKE_MM: f64 = 5.0;

/// Standard deviation of the noise, share of the stroke.
const NOISE_SHARE: f64 = 0.0015;

/// Seed of rig and noise.
const SEED: u64 = 1;

/// A made-up rig with its recordings.
#[derive(Debug, Clone)]
pub struct MadeUp {
    /// Known parameters of the rig.
    pub rod: Rod,
    /// To be fitted: one recording of 717 s.
    pub training: Vec<Recording>,
    /// To be predicted: one of 255 s.
    pub unseen: Vec<Recording>,
}

/// A wire with one effect of its typical size and white noise, which is recorded every `dt_s`, 1 ms to 1 s: its loop and its convection
/// are drawn.
#[must_use]
pub fn made_up(effect: EffectId, dt_s: f64) -> MadeUp {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let mut drawn = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    let rod = RodParams {
        diameter_m: 0.75e-3,
        density_kg_per_m3: 6450.0,
        specific_heat_j_per_kg_k: 480.0,
        resistance_ohm_per_m: 2.13,
        convective_coefficient_w_per_m2_k: drawn(50.0, 75.0),
    };
    let params = WienerParams {
        heat: rod
            .heat_balance()
            .unwrap_or_else(|_| unreachable!("positive values")),
        limiting_loop: LoopParams {
            loop_center_degc: drawn(52.0, 62.0),
            loop_half_width_k: drawn(5.0, 9.0),
            loop_spread_k: drawn(2.5, 5.0),
            ..LoopParams::default()
        },
        zeta: drawn(0.6, 0.95),
        gain: STROKE_MM,
        offset: drawn(-1.0, 1.0),
    };
    let known = rod_file::parse("rod.toml", ROD).unwrap_or_else(|error| unreachable!("{error}"));
    let played = |name: &str, current_a: Vec<f64>, stream: u64| {
        let mut noise = ChaCha8Rng::seed_from_u64(SEED);
        noise.set_stream(stream);
        recording(
            name,
            (&current_a, dt_s),
            effect,
            &params,
            &known,
            &mut noise,
        )
    };
    MadeUp {
        training: vec![played("train.csv", training_current_a(dt_s), 1)],
        unseen: vec![played("held.csv", unseen_current_a(dt_s), 2)],
        rod: known,
    }
}

fn recording(
    name: &str,
    (current_a, dt_s): (&[f64], f64),
    effect: EffectId,
    params: &WienerParams,
    rod: &Rod,
    rng: &mut ChaCha8Rng,
) -> Recording {
    let setting = Setting {
        active: EffectSet::of(effect),
        run_length_s: Some(dt_s * current_a.len() as f64),
        ..setting_of_rod(rod, "mm")
    };
    let member = Member {
        params: *params,
        effects: EffectValues::typical(effect, 1.0),
        start: Start::rest(AMBIENT_DEGC),
    };
    let profile = Profile::uniform(current_a, dt_s, AMBIENT_DEGC)
        .unwrap_or_else(|error| unreachable!("{error}"));
    let mut output = Vec::new();
    let run = Extended { setting }.run(&[member], &profile, &mut |block| {
        output.extend(block.displacement.iter().step_by(block.stride).copied());
    });
    run.unwrap_or_else(|error| unreachable!("{error}"));
    for value in &mut output {
        let normal: f64 = StandardNormal.sample(rng);
        *value += NOISE_SHARE * STROKE_MM * normal;
    }
    let parts = RecordingParts {
        name: name.to_owned(),
        time_s: Some((0..output.len()).map(|k| dt_s * k as f64).collect()),
        drive: current_a.to_vec(),
        output,
        output_unit: "mm".to_owned(),
        ..RecordingParts::default()
    };
    Recording::new(parts).unwrap_or_else(|error| unreachable!("{error}"))
}

/// Three equal cycles, a hot hold, inner loops, fast steps, rest: what the guide asks for.
fn training_current_a(dt_s: f64) -> Vec<f64> {
    let mut drive = Played::every(dt_s);
    drive.hold(0.0, 20.0);
    for _ in 0..3 {
        drive.ramp(0.0, 2.4, 40.0);
        drive.ramp(2.4, 0.0, 40.0);
        drive.hold(0.0, 20.0);
    }
    drive.hold(2.1, 75.0);
    drive.hold(0.0, 60.0);
    for (from, to, seconds) in [
        (0.0, 2.2, 30.0),
        (2.2, 1.2, 20.0),
        (1.2, 2.0, 20.0),
        (2.0, 1.4, 15.0),
        (1.4, 2.2, 20.0),
        (2.2, 0.0, 25.0),
    ] {
        drive.ramp(from, to, seconds);
    }
    for _ in 0..6 {
        drive.hold(2.4, 6.0);
        drive.hold(0.9, 6.0);
    }
    drive.hold(0.0, 60.0);
    drive.current_a
}

/// Another order, other rates and levels.
fn unseen_current_a(dt_s: f64) -> Vec<f64> {
    let mut drive = Played::every(dt_s);
    drive.hold(0.0, 15.0);
    drive.ramp(0.0, 2.3, 60.0);
    drive.ramp(2.3, 1.0, 20.0);
    drive.ramp(1.0, 2.1, 10.0);
    drive.hold(0.0, 40.0);
    for level in [2.2, 0.6, 1.9, 1.1, 2.4] {
        drive.hold(level, 12.0);
    }
    drive.hold(0.0, 50.0);
    drive.current_a
}

/// A drive, stretch after stretch.
struct Played {
    dt_s: f64,
    current_a: Vec<f64>,
}

impl Played {
    fn every(dt_s: f64) -> Self {
        Self {
            dt_s,
            current_a: Vec::new(),
        }
    }

    fn hold(&mut self, level: f64, seconds: f64) {
        self.ramp(level, level, seconds);
    }

    fn ramp(&mut self, from: f64, to: f64, seconds: f64) {
        let n = (seconds / self.dt_s).round() as usize;
        let step = (to - from) / n as f64;
        self.current_a
            .extend((0..n).map(|k| from + step * k as f64));
    }
}
