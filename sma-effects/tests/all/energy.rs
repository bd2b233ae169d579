//! Latent heat is enthalpy.

use crate::support;

use sma_effects::{EffectId, EffectSet, EffectValues};
use support::{AMBIENT_DEGC, params, rod, setting, trace};

/// Heat that the rod lost to the air over a sample, J/m, from its temperatures alone. They run exponentially
/// with the time constant.
///
/// T = b + (T_0 - b) e^(-t/τ) with b such that T(dt) = T_1.
fn lost_j_per_m(from_degc: f64, to_degc: f64, dt_s: f64) -> f64 {
    let heat = params().heat;
    let tau_s = heat.heat_capacity_j_per_m_k / heat.conductance_w_per_m_k;
    let gone = -(-dt_s / tau_s).exp_m1();
    let balance_degc = from_degc + (to_degc - from_degc) / gone;
    let integral_k_s =
        (balance_degc - AMBIENT_DEGC) * dt_s + (from_degc - balance_degc) * tau_s * gone;
    heat.conductance_w_per_m_k * integral_k_s
}

#[test]
fn latent_heat_conserves_energy_over_a_closed_cycle() {
    let dt_s = 0.2;
    let period = 300;
    // Through the whole loop and back, with an inner cycle, until each period repeats the one before.
    let one: Vec<f64> = (0..period)
        .map(|k| match k {
            0..60 => 2.4,
            60..90 => 1.3,
            90..120 => 2.2,
            _ => 0.0,
        })
        .collect();
    let current_a: Vec<f64> = std::iter::repeat_n(one, 20)
        .flatten()
        .chain([0.0])
        .collect();
    let mut values = EffectValues::default();
    values.latent_heat.latent_heat_j_per_kg = 20e3;
    let shown = trace(
        &setting(EffectSet::of(EffectId::LatentHeat)),
        &params(),
        &values,
        &current_a,
        dt_s,
    );
    let balance = |first: usize| {
        let (mut heated, mut lost) = (0.0, 0.0);
        for k in first..first + period {
            heated += current_a[k] * current_a[k] * rod().resistance_ohm_per_m * dt_s;
            lost += lost_j_per_m(
                shown.temperature_degc[k],
                shown.temperature_degc[k + 1],
                dt_s,
            );
        }
        let last = first + period;
        let warmed_k = shown.temperature_degc[last] - shown.temperature_degc[first];
        let stored = params().heat.heat_capacity_j_per_m_k * warmed_k;
        let transformed = shown.fraction[last] - shown.fraction[first];
        let latent = rod().mass_kg_per_m() * 20e3 * transformed;
        (heated, lost, stored, latent)
    };
    // The first period does not close: the rod came from rest. Enthalpy makes up for it.
    let (heated, lost, stored, latent) = balance(0);
    assert!((heated - lost - stored - latent).abs() < 1e-9 * heated);
    // The last one does: nothing is left of the latent heat, nor of the sensible.
    let (heated, lost, stored, latent) = balance(19 * period);
    assert!(latent.abs() < 1e-9 * heated, "{latent}");
    assert!((heated - lost - stored).abs() < 1e-9 * heated);
    // And it was no small matter on the way.
    let mass = rod().mass_kg_per_m();
    let swing = shown.fraction.iter().copied().fold(0.0, f64::max) - shown.fraction[0];
    assert!(mass * 20e3 * swing > 0.1 * heated);
}
