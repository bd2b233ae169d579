use fixtures::wire::{AMBIENT_DEGC, ROD};
use identify::Rod;
use missing_physics::{
    EffectId, EffectSet, EffectValues, Extended, Member, Setting, setting_of_rod,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Recording, RecordingParts};
use wiener::hysteresis::LoopParams;
use wiener::thermal::RodParams;
use wiener::{Profile, Start, WienerParams};

/// Time between samples, s.
const DT_S: f64 = 0.1;

/// Stroke, mm.
const STROKE_MM: f64 = 5.0;

/// Color of the noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoiseKind {
    /// Neighbors independent.
    White,
    /// First-order autoregressive with this coefficient.
    Autoregressive(f64),
}

/// What to make up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Made {
    /// Effects with their values.
    pub effects: EffectSet,
    /// Their values.
    pub values: EffectValues,
    /// Color of the noise.
    pub noise: NoiseKind,
    /// Its standard deviation, share of the stroke.
    pub noise_share: f64,
    /// Seed of rig and noise.
    pub seed: u64,
}

/// A made-up rig with its recordings.
#[derive(Debug, Clone)]
pub struct MadeUp {
    /// What is known of it.
    pub rod: Rod,
    /// To be fitted.
    pub training: Vec<Recording>,
    /// To be predicted.
    pub unseen: Vec<Recording>,
    /// Standard deviation of the noise, mm.
    pub noise_mm: f64,
}

/// Makes up a rig: its loop and its convection are drawn, the rest is one wire.
///
/// # Panics
///
/// If a value is outside its bounds.
#[must_use]
pub fn made_up(made: &Made) -> MadeUp {
    driven(made, training_current_a())
}

/// The same with `n_samples` for training: the drive starts again, or is cut.
///
/// # Panics
///
/// As [`made_up`].
#[must_use]
pub fn made_up_of_length(made: &Made, n_samples: usize) -> MadeUp {
    let round = training_current_a();
    driven(made, round.into_iter().cycle().take(n_samples).collect())
}

fn driven(made: &Made, training_current_a: Vec<f64>) -> MadeUp {
    let mut rng = ChaCha8Rng::seed_from_u64(made.seed);
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
    let known = Rod::parse("rod.toml", ROD).unwrap_or_else(|error| unreachable!("{error}"));
    let noise_mm = made.noise_share * STROKE_MM;
    let played = |name: &str, current_a: Vec<f64>, stream: u64| {
        let mut noise = ChaCha8Rng::seed_from_u64(made.seed);
        noise.set_stream(stream);
        recording(name, &current_a, made, &params, &known, &mut noise)
    };
    MadeUp {
        training: vec![played("train.csv", training_current_a, 1)],
        unseen: vec![played("held.csv", unseen_current_a(), 2)],
        rod: known,
        noise_mm,
    }
}

fn recording(
    name: &str,
    current_a: &[f64],
    made: &Made,
    params: &WienerParams,
    rod: &Rod,
    rng: &mut ChaCha8Rng,
) -> Recording {
    let setting = Setting {
        active: made.effects,
        run_length_s: Some(DT_S * current_a.len() as f64),
        ..setting_of_rod(rod, "mm")
    };
    let member = Member {
        params: *params,
        effects: made.values,
        start: Start::rest(AMBIENT_DEGC),
    };
    let profile = Profile::uniform(current_a, DT_S, AMBIENT_DEGC)
        .unwrap_or_else(|error| unreachable!("{error}"));
    let (mut output, mut temperature_degc) = (Vec::new(), Vec::new());
    let run = Extended { setting }.run(&[member], &profile, &mut |block| {
        output.extend(block.displacement.iter().step_by(block.stride).copied());
        temperature_degc.extend(block.temperature_degc.iter().step_by(block.stride).copied());
    });
    run.unwrap_or_else(|error| unreachable!("{error}"));
    add_noise(&mut output, made.noise, made.noise_share * STROKE_MM, rng);
    let has_thermocouple = made.effects.contains(EffectId::ThermocoupleLag);
    if has_thermocouple {
        add_noise(&mut temperature_degc, NoiseKind::White, 0.2, rng);
    }
    let parts = RecordingParts {
        name: name.to_owned(),
        time_s: Some((0..output.len()).map(|k| DT_S * k as f64).collect()),
        drive: current_a.to_vec(),
        output,
        output_unit: "mm".to_owned(),
        temperature_degc: has_thermocouple.then_some(temperature_degc),
        ..RecordingParts::default()
    };
    Recording::new(parts).unwrap_or_else(|error| unreachable!("{error}"))
}

fn add_noise(series: &mut [f64], kind: NoiseKind, deviation: f64, rng: &mut ChaCha8Rng) {
    let phi = match kind {
        NoiseKind::White => 0.0,
        NoiseKind::Autoregressive(phi) => phi,
    };
    let innovation = deviation * (1.0 - phi * phi).sqrt();
    let first: f64 = StandardNormal.sample(rng);
    let mut state = deviation * first;
    for value in series {
        *value += state;
        let next: f64 = StandardNormal.sample(rng);
        state = phi * state + innovation * next;
    }
}

/// Three equal cycles, a hot hold, inner loops, fast steps, rest: what the guide asks for.
fn training_current_a() -> Vec<f64> {
    let mut drive = Played::default();
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
fn unseen_current_a() -> Vec<f64> {
    let mut drive = Played::default();
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
#[derive(Default)]
struct Played {
    current_a: Vec<f64>,
}

impl Played {
    fn hold(&mut self, level: f64, seconds: f64) {
        self.ramp(level, level, seconds);
    }

    fn ramp(&mut self, from: f64, to: f64, seconds: f64) {
        let n = (seconds / DT_S).round() as usize;
        let step = (to - from) / n as f64;
        self.current_a
            .extend((0..n).map(|k| from + step * k as f64));
    }
}
