//! Generated recordings of a wire with some effects, and the baseline fitted to them, for tests.

use std::ops::{ControlFlow, Range};

use fixtures::wire::{AMBIENT_DEGC, ROD};
use identify::{Fit, FitConfig, ForwardModel, ParameterVector, WienerModel, fit};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use recording::{Quantity, Recording, RecordingParts};
use rig_files::rod_file;
use wiener::hysteresis::{LoopParams, Rule};
use wiener::{Profile, Start, WienerParams};

use crate::model::case::Case;
use crate::{EffectSet, EffectValues, Extended, LoopFamily, Member, Setting, setting_of_rod};

const CONDUCTANCE_W_PER_M_K: f64 = 0.141;

/// Standard deviation of the noise, mm: 0.2 % of the stroke.
pub(crate) const NOISE_MM: f64 = 0.01;

/// Recordings and what was fitted to them.
pub(crate) struct Synthetic {
    pub(crate) base: WienerModel,
    pub(crate) fit: Fit,
    pub(crate) training: Vec<Recording>,
    pub(crate) setting: Setting,
}

impl Synthetic {
    /// A slow run with partial cycles and a run of steps, with these effects and white noise.
    pub(crate) fn of(active: EffectSet, effects: EffectValues, seed: u64) -> Self {
        Self::with_loop(LoopFamily::Proximity, active, effects, seed)
    }

    /// Such recordings of a wire with a loop of some family.
    pub(crate) fn with_loop(
        loop_family: LoopFamily,
        active: EffectSet,
        effects: EffectValues,
        seed: u64,
    ) -> Self {
        let rod = rod_file::parse("rod.toml", ROD).unwrap();
        let setting = Setting {
            rule: Rule::LastReversal,
            ..setting_of_rod(&rod, "mm")
        };
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let training: Vec<Recording> = [("slow", slow_a(), 0.3), ("steps", steps_a(), 0.1)]
            .into_iter()
            .map(|(name, drive, dt_s)| {
                let plant = Setting {
                    active,
                    loop_family,
                    ..setting
                };
                let clean = output_mm(plant, effects, &drive, dt_s);
                let noisy = |mm: &f64| {
                    let normal: f64 = StandardNormal.sample(&mut rng);
                    mm + NOISE_MM * normal
                };
                let parts = RecordingParts {
                    name: name.to_owned(),
                    time_s: Some((0..drive.len()).map(|k| dt_s * k as f64).collect()),
                    drive_quantity: Quantity::Current,
                    output: clean.iter().map(noisy).collect(),
                    output_unit: "mm".to_owned(),
                    drive,
                    ..RecordingParts::default()
                };
                Recording::new(parts).unwrap()
            })
            .collect();
        let base = WienerModel::new(&rod, Rule::LastReversal, &training).unwrap();
        Self {
            fit: fitted(&base, &training),
            base,
            training,
            setting,
        }
    }

    /// Moves the output of a recording by some millimeters for some seconds, and fits anew.
    pub(crate) fn shift(&mut self, recording: usize, seconds: Range<f64>, mm: f64) {
        let before = &self.training[recording];
        let shifted = before.output().iter().zip(before.time_s());
        let parts = RecordingParts {
            name: before.name().to_owned(),
            time_s: Some(before.time_s().to_vec()),
            drive_quantity: before.drive_quantity(),
            drive: before.drive().to_vec(),
            output_unit: before.output_unit().to_owned(),
            output: shifted
                .map(|(output, time_s)| {
                    if seconds.contains(time_s) {
                        output + mm
                    } else {
                        *output
                    }
                })
                .collect(),
            ..RecordingParts::default()
        };
        self.training[recording] = Recording::new(parts).unwrap();
        self.fit = fitted(&self.base, &self.training);
    }

    pub(crate) fn case(&self) -> Case<'_> {
        Case::new(&self.base, &self.fit, &self.training, self.setting)
    }
}

/// From where the generator stands: no swarm is needed to find it.
fn fitted(base: &WienerModel, training: &[Recording]) -> Fit {
    let vector = ParameterVector::new(base.parameters(), training.len());
    let from = vector.coordinates(|parameter, _| {
        let params = params();
        Some(match base.parameters()[parameter].name {
            "tau_s" => params.heat.heat_capacity_j_per_m_k / params.heat.conductance_w_per_m_k,
            "loop_center_degc" => params.limiting_loop.loop_center_degc,
            "loop_half_width_k" => params.limiting_loop.loop_half_width_k,
            "loop_spread_k" => params.limiting_loop.loop_spread_k,
            _ => params.zeta,
        })
    });
    let config = FitConfig {
        starts: 0,
        from: vec![from],
        ..FitConfig::default()
    };
    fit(base, training, &config, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// A wire with τ = 9.7 s that transforms between 40 and 70 °C, with a stroke of 5 mm.
fn params() -> WienerParams {
    let heat_capacity_j_per_m_k = 6450.0 * 480.0 * std::f64::consts::PI * 0.25 * 0.75e-3 * 0.75e-3;
    WienerParams {
        heat: wiener::thermal::HeatBalanceParams {
            heat_capacity_j_per_m_k,
            conductance_w_per_m_k: CONDUCTANCE_W_PER_M_K,
            resistance_ohm_per_m: 2.13,
        },
        limiting_loop: LoopParams {
            loop_center_degc: 55.0,
            loop_half_width_k: 8.0,
            loop_spread_k: 3.0,
            ..LoopParams::default()
        },
        zeta: 0.85,
        gain: 5.0,
        offset: 1.0,
    }
}

fn output_mm(setting: Setting, effects: EffectValues, drive: &[f64], dt_s: f64) -> Vec<f64> {
    let fleet = Extended {
        setting: Setting {
            run_length_s: Some(dt_s * drive.len() as f64),
            ..setting
        },
    };
    let member = Member {
        params: params(),
        effects,
        start: Start {
            temperature_degc: AMBIENT_DEGC,
            share: 1.0,
            since_reversal_k: 0.0,
        },
    };
    let profile = Profile::uniform(drive, dt_s, AMBIENT_DEGC).unwrap();
    let mut output = Vec::new();
    fleet
        .run(&[member], &profile, &mut |block| {
            output.extend(block.displacement.iter().step_by(block.stride));
        })
        .unwrap();
    output
}

/// 360 s in steps of 0.3 s: up and down to ever other turning points, A.
fn slow_a() -> Vec<f64> {
    let corners = [
        (0.0, 10.0),
        (2.4, 60.0),
        (0.0, 60.0),
        (2.0, 45.0),
        (1.3, 25.0),
        (1.9, 25.0),
        (0.9, 30.0),
        (2.3, 45.0),
        (0.0, 60.0),
    ];
    let mut current_a = Vec::new();
    let mut from = 0.0;
    for (to, length_s) in corners {
        let n_samples = (length_s / 0.3_f64).round() as usize;
        let share = |k: usize| k as f64 / n_samples as f64;
        current_a.extend((0..n_samples).map(|k| from + (to - from) * share(k)));
        from = to;
    }
    current_a
}

/// 120 s in steps of 0.1 s: a full cycle, partial ones, holds, A.
fn steps_a() -> Vec<f64> {
    let levels = [
        (0.0, 30),
        (2.4, 150),
        (0.0, 180),
        (2.1, 120),
        (1.5, 60),
        (2.2, 60),
        (1.0, 60),
        (2.0, 90),
        (0.6, 90),
        (1.9, 120),
        (0.0, 240),
    ];
    let held = levels.into_iter();
    held.flat_map(|(level, n_samples)| std::iter::repeat_n(level, n_samples))
        .collect()
}
