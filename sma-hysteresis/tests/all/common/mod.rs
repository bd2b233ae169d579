//! Materials that the tests share.

pub(crate) mod drawn;

use sma_hysteresis::{Hysteresis, LimitingLoop, LoopParams, Rule, SineProximity};

/// One material with loop center 0, so that temperatures are those of the paper's equations.
pub(crate) fn material(half_width_k: f64, spread_k: f64, zeta: f64, rule: Rule) -> Hysteresis<1> {
    let limits = LimitingLoop::new([LoopParams {
        loop_center_degc: 0.0,
        loop_half_width_k: half_width_k,
        loop_spread_k: spread_k,
        ..LoopParams::default()
    }])
    .unwrap();
    Hysteresis::new(limits, SineProximity::new([zeta]).unwrap(), rule)
}

/// Walks through temperatures and returns the last fraction.
pub(crate) fn walk(
    material: &Hysteresis<1>,
    memory: &mut sma_hysteresis::Memory<1>,
    temperatures_degc: &[f64],
) -> f64 {
    let mut fraction = f64::NAN;
    for &temperature_degc in temperatures_degc {
        [fraction] = material.commit(memory, [temperature_degc]);
    }
    fraction
}
