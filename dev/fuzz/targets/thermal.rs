//! Any rod and any heating: the temperature goes from where it is towards its balance, and no farther.
#![no_main]

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use sma_thermal::{HeatBalance, HeatBalanceParams, Heating};

#[derive(Debug, Arbitrary)]
struct Drawn {
    params: [f64; 3],
    is_extreme: bool,
    steps: Vec<(u16, u16, i8)>,
}

fuzz_target!(|drawn: Drawn| {
    let [mut capacity, mut conductance, mut resistance] = drawn.params;
    if !drawn.is_extreme {
        let tame = |value: f64| 10f64.powf((value % 6.0).abs() - 3.0);
        [capacity, conductance, resistance] = [tame(capacity), tame(conductance), tame(resistance)];
    }
    let Ok(balance) = HeatBalance::new([HeatBalanceParams {
        heat_capacity_j_per_m_k: capacity,
        conductance_w_per_m_k: conductance,
        resistance_ohm_per_m: resistance,
    }]) else {
        return;
    };
    let is_tame = (1e-6..1e6).contains(&conductance) && (1e-6..1e6).contains(&capacity);
    let mut temperature = [20.0];
    for &(power, dt, ambient) in &drawn.steps {
        let sample = balance.over(f64::from(dt) * 1e-3);
        let heating = Heating {
            power_w_per_m: [f64::from(power) * 1e-2],
            ambient_degc: f64::from(ambient),
        };
        let next = balance.step(temperature, &heating, &sample);
        if !is_tame {
            temperature = next;
            continue;
        }
        let goal = heating.ambient_degc + heating.power_w_per_m[0] / conductance;
        let (low, high) = (temperature[0].min(goal), temperature[0].max(goal));
        let rounding = 1e-9 * (1.0 + low.abs() + high.abs());
        assert!(
            next[0] >= low - rounding && next[0] <= high + rounding,
            "{low} {} {high}",
            next[0]
        );
        let [sensitivity] = balance.sensitivity_k_m_per_w(&sample);
        assert!((0.0..=(1.0 + 1e-12) / conductance).contains(&sensitivity));
        temperature = next;
    }
});
