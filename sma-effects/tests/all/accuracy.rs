//! How far integration, search and differences may be trusted.

use crate::support;

use sma_effects::{EffectId, EffectSet, EffectValues, Setting};
use support::{Trace, all_typical, current_a, largest, params, setting, trace, with_effect};
use wiener::WienerParams;

/// Largest change of the output over the stroke when each sample is divided by `parts`.
fn refined(effect: EffectId, dt_s: f64, parts: usize) -> f64 {
    let current = current_a(dt_s);
    let fine_current: Vec<f64> = current
        .iter()
        .flat_map(|&i| std::iter::repeat_n(i, parts))
        .collect();
    let values = EffectValues::typical(effect, 1.0);
    let setting = setting(EffectSet::of(effect));
    let coarse = trace(&setting, &params(), &values, &current, dt_s);
    let fine_s = dt_s / parts as f64;
    let fine = trace(&setting, &params(), &values, &fine_current, fine_s);
    let sampled = |values: &[f64]| -> Vec<f64> { values.iter().step_by(parts).copied().collect() };
    let shown = largest(&coarse.displacement, &sampled(&fine.displacement)) / params().gain;
    // The recorded temperature counts where it is what the effect changes: 1e-4 of a span of 50 K.
    let recorded = largest(&coarse.recorded_degc, &sampled(&fine.recorded_degc)) / 50.0;
    if effect == EffectId::ThermocoupleLag {
        shown.max(recorded)
    } else {
        shown
    }
}

#[test]
fn halving_the_step_changes_less_than_a_ten_thousandth_of_the_stroke() {
    for effect in EffectId::ALL {
        for dt_s in [0.1, 0.2, 0.3] {
            let change = refined(effect, dt_s, 2);
            // A lag of a third of a sample sees more of the sample's course than a parabola.
            let limit = if effect == EffectId::OutputLag && dt_s > 0.25 {
                2.5e-4
            } else {
                1e-4
            };
            assert!(change < limit, "{effect} {dt_s} {change:e}");
        }
    }
}

#[test]
fn a_step_far_smaller_changes_little_more() {
    for effect in EffectId::ALL {
        let change = refined(effect, 0.2, 40);
        assert!(change < 1e-4, "{effect} {change:e}");
    }
}

#[test]
fn three_iterations_of_newton_leave_nothing() {
    for effect in EffectId::ALL {
        for dt_s in [0.1, 0.3] {
            let shown = with_effect(effect, &EffectValues::typical(effect, 1.0), dt_s);
            let residual_k = shown.largest_residual_k;
            assert!(residual_k <= 1e-10, "{effect} {dt_s} {residual_k:e}");
        }
    }
}

/// All effects at once, and each alone at the end of its bounds, in a steep narrow loop.
fn worst(newton_iterations: usize) -> f64 {
    let steep = WienerParams {
        limiting_loop: wiener::hysteresis::LoopParams {
            loop_spread_k: 1.0,
            loop_half_width_k: 4.0,
            ..params().limiting_loop
        },
        ..params()
    };
    let run = |active: EffectSet, values: &EffectValues| -> Trace {
        let setting = Setting {
            newton_iterations,
            ..setting(active)
        };
        trace(&setting, &steep, values, &current_a(0.3), 0.3)
    };
    let mut worst_k = run(EffectSet::all(), &all_typical()).largest_residual_k;
    for effect in EffectId::ALL {
        for end in [0, 1] {
            let mut values = EffectValues::default();
            for (index, parameter) in effect.info().parameters.iter().enumerate() {
                *values.slot(effect, index).unwrap() = parameter.bounds[end];
            }
            let shown = run(EffectSet::of(effect), &values);
            assert!(shown.displacement.iter().all(|y| y.is_finite()), "{effect}");
            worst_k = worst_k.max(shown.largest_residual_k);
        }
    }
    worst_k
}

#[test]
fn newton_stays_near_in_the_worst_case_and_converges_with_more_iterations() {
    let few_k = worst(3);
    let many_k = worst(20);
    assert!(few_k < 1.0, "{few_k:e}");
    assert!(many_k < 1e-3, "{many_k:e}");
}

#[test]
fn secants_agree_from_a_thousandth_to_a_millionth() {
    for effect in EffectId::ALL {
        let zero = with_effect(effect, &EffectValues::default(), 0.2);
        let secant = |step: f64| -> Vec<f64> {
            let moved = with_effect(effect, &EffectValues::typical(effect, step), 0.2);
            let outputs = moved.displacement.iter().zip(&zero.displacement);
            let recorded = moved.recorded_degc.iter().zip(&zero.recorded_degc);
            outputs
                .chain(recorded)
                .map(|(a, b)| (a - b) / step)
                .collect()
        };
        let (large, small) = (secant(1e-3), secant(1e-6));
        let size = support::rms(&small, &vec![0.0; small.len()]);
        let difference = support::rms(&large, &small);
        assert!(size > 0.0, "{effect}");
        assert!(difference < 0.01 * size, "{effect} {:e}", difference / size);
    }
}
