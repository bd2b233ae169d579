//! Figure 3 of [Sadeghi], the cascade, by a second route: the corrected equations as they stand in the
//! paper, in scalar code with the standard library's functions.

use crate::common;

use std::f64::consts::{FRAC_PI_2, PI};

use common::{AMBIENT_DEGC, model, outputs, params};
use fixtures::sadeghi;
use sma_hysteresis::Rule;
use wiener::{Input, Plant, Profile, WienerParams};

/// The paper's sampling time, s.
fn sample_time_s() -> f64 {
    sadeghi::setting("rig.sample_time").unwrap().value()
}

/// The operator of eqs 4-12, in the temperature relative to the middle of the loop.
struct Proximity {
    params: WienerParams,
    delta: f64,
    reversal_k: f64,
    /// T_pr; 0 on a limiting curve.
    proximity_k: f64,
}

impl Proximity {
    /// P(x), eq. 12.
    fn fading(&self, x: f64) -> f64 {
        let angle = self.params.zeta * x;
        if angle < FRAC_PI_2 {
            1.0 - angle.sin()
        } else {
            0.0
        }
    }

    /// ξ(T), eq. 11 with its ξ_0.
    fn fraction(&self, relative_k: f64) -> f64 {
        let shape = self.params.limiting_loop;
        // Eq. 10; x is not defined on the limiting curve, and not needed.
        let on_branch_k = if self.proximity_k.abs() > 1e-9 {
            self.proximity_k * self.fading((relative_k - self.reversal_k) / self.proximity_k)
        } else {
            0.0
        };
        let numerator_k = on_branch_k + relative_k - self.delta * shape.loop_half_width_k;
        2.0 * shape.fraction_swing / PI * (numerator_k / shape.loop_spread_k).atan()
            + shape.fraction_center
    }

    /// Eq. 8 with ξ_r.
    fn reverse(&mut self, delta: f64, relative_k: f64) {
        let shape = self.params.limiting_loop;
        let fraction = self.fraction(relative_k);
        let angle = PI * (fraction - shape.fraction_center) / (2.0 * shape.fraction_swing);
        self.proximity_k =
            shape.loop_spread_k * angle.tan() + delta * shape.loop_half_width_k - relative_k;
        self.reversal_k = relative_k;
        self.delta = delta;
    }
}

/// Displacements by the paper's equations, from rest; y_k before the current of sample k acts.
fn by_the_paper(params: WienerParams, currents_a: &[f64], dt_s: f64) -> Vec<f64> {
    let center_degc = params.limiting_loop.loop_center_degc;
    let tau_s = params.heat.heat_capacity_j_per_m_k / params.heat.conductance_w_per_m_k;
    let lambda_k_per_a2 = params.heat.resistance_ohm_per_m / params.heat.conductance_w_per_m_k;
    let mut temperature_degc = AMBIENT_DEGC;
    let mut hysteresis = Proximity {
        params,
        delta: -1.0,
        reversal_k: 0.0,
        proximity_k: 0.0,
    };
    let mut displacements = Vec::new();
    for &current_a in currents_a {
        let fraction = hysteresis.fraction(temperature_degc - center_degc);
        displacements.push(params.gain * fraction + params.offset);
        // Eq. 2.
        let left = (-dt_s / tau_s).exp();
        let next_degc = AMBIENT_DEGC
            + (temperature_degc - AMBIENT_DEGC) * left
            + current_a * current_a * lambda_k_per_a2 * (1.0 - left);
        // δ = sign(dT/dt).
        if (next_degc - temperature_degc) * hysteresis.delta < 0.0 {
            hysteresis.reverse(-hysteresis.delta, temperature_degc - center_degc);
        }
        temperature_degc = next_degc;
    }
    displacements
}

/// Currents that change at irregular times, with pauses: a multiplicative generator, no clock.
fn restless_currents(n_samples: usize) -> Vec<f64> {
    let mut state = 20_240_229_u64;
    let mut share = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (state >> 40) as f64 / f64::from(1_u32 << 24)
    };
    let mut currents_a = Vec::new();
    while currents_a.len() < n_samples {
        let current_a = if share() < 0.2 {
            0.0
        } else {
            0.9 + 1.2 * share()
        };
        let held = 1 + (60.0 * share() * share()) as usize;
        currents_a.extend(std::iter::repeat_n(current_a, held));
    }
    currents_a.truncate(n_samples);
    currents_a
}

#[test]
fn figure_3_the_cascade_is_gain_times_fraction_of_temperature() {
    let currents_a = restless_currents(5000);
    let profile = Profile::uniform(&currents_a, sample_time_s(), AMBIENT_DEGC).unwrap();
    let model = model(Rule::LastReversal);
    let found = outputs(&model, model.rest(AMBIENT_DEGC), &profile);
    let expected = by_the_paper(params(), &currents_a, sample_time_s());
    assert_eq!(found.len(), expected.len());
    let mut worst: f64 = 0.0;
    let mut reversals = 0;
    for k in 0..expected.len() {
        worst = worst.max((found[k].displacement[0] - expected[k]).abs());
        let temperature = |k: usize| found[k].temperature_degc[0];
        let turned = k >= 2
            && (temperature(k) - temperature(k - 1)) * (temperature(k - 1) - temperature(k - 2))
                < 0.0;
        reversals += u32::from(turned);
    }
    assert!(worst < 1e-10, "{worst:e}");
    // The comparison is worth something: many minor loops, over most of the stroke.
    assert!(reversals > 100, "{reversals}");
    let highest = expected.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = expected.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(highest - lowest > 0.8 * params().gain);
}

#[test]
fn the_first_output_is_that_of_the_initial_state() {
    for rule in [Rule::LastReversal, Rule::Nested] {
        let model = model(rule);
        let at_rest = model.output(&model.rest(AMBIENT_DEGC)).displacement[0];
        for current_a in [0.0, 2.0] {
            let currents_a = [current_a; 3];
            let profile = Profile::uniform(&currents_a, sample_time_s(), AMBIENT_DEGC).unwrap();
            let found = outputs(&model, model.rest(AMBIENT_DEGC), &profile);
            assert_eq!(found[0].displacement[0].to_bits(), at_rest.to_bits());
        }
    }
}

#[test]
fn a_sample_is_read_before_its_drive_acts() {
    const PULSE: usize = 5;
    let mut currents_a = [0.0; 10];
    currents_a[PULSE] = 3.0;
    let profile = Profile::uniform(&currents_a, sample_time_s(), AMBIENT_DEGC).unwrap();
    let model = model(Rule::LastReversal);
    let found = outputs(&model, model.rest(AMBIENT_DEGC), &profile);
    let at_rest = found[0].displacement[0];
    assert_eq!(found[PULSE].displacement[0].to_bits(), at_rest.to_bits());
    assert!(found[PULSE + 1].displacement[0] > at_rest + 1e-3);
}

#[test]
fn the_state_is_left_behind_the_last_sample() {
    let currents_a = restless_currents(200);
    let model = model(Rule::LastReversal);
    let mut whole = model.rest(AMBIENT_DEGC);
    let profile = Profile::uniform(&currents_a, sample_time_s(), AMBIENT_DEGC).unwrap();
    wiener::run(&model, &mut whole, &profile, |_, _| {});
    let mut by_steps = model.rest(AMBIENT_DEGC);
    for current_a in currents_a {
        let input = Input {
            drive: [current_a],
            ambient_degc: AMBIENT_DEGC,
        };
        model.step(&mut by_steps, &input, sample_time_s());
    }
    assert_eq!(whole, by_steps);
}
