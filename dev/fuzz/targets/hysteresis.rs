//! Any path of temperatures through any loop: the fraction stays between 0 and 1, does not jump, and is a number.
#![no_main]

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use sma_hysteresis::{
    Branch, Hysteresis, LimitingLoop, LoopFamily, LoopParams, Rule, SecondPopulation, SineProximity,
};

#[derive(Debug, Arbitrary)]
struct Drawn {
    family: u8,
    is_nested: bool,
    is_extreme: bool,
    shape: [u16; 5],
    second: [u16; 5],
    bends: [u16; 3],
    raw: [f64; 3],
    start: u8,
    path: Vec<i16>,
    far: Vec<f64>,
}

/// Rounding of a few operations on a share of 1; a branch that was stretched to its return point rounds more.
const ROUNDING: f64 = 1e-4;

fn between(raw: u16, lower: f64, upper: f64) -> f64 {
    lower + (upper - lower) * f64::from(raw) / f64::from(u16::MAX)
}

/// None in every second loop.
fn asymmetry_of([width, _, _, asymmetry, _]: [u16; 5]) -> f64 {
    if width % 2 == 0 {
        0.0
    } else {
        between(asymmetry, -0.8, 0.8)
    }
}

fuzz_target!(|drawn: Drawn| {
    let [width, spread, zeta, _, tails] = drawn.shape;
    let mut params = LoopParams {
        loop_center_degc: 60.0,
        loop_half_width_k: between(width, 0.01, 100.0),
        loop_spread_k: between(spread, 0.05, 100.0),
        ..LoopParams::default()
    };
    if drawn.is_extreme {
        [
            params.loop_center_degc,
            params.loop_half_width_k,
            params.loop_spread_k,
        ] = drawn.raw;
    }
    let Ok(limits) = LimitingLoop::new([params]) else {
        return;
    };
    let Ok(limits) = limits.with_asymmetry([asymmetry_of(drawn.shape)]) else {
        return;
    };
    let Ok(proximity) = SineProximity::new([between(zeta, 0.001, 1.0)]) else {
        return;
    };
    let rule = if drawn.is_nested {
        Rule::Nested
    } else {
        Rule::LastReversal
    };
    let family = LoopFamily::ALL[usize::from(drawn.family) % 3];
    let material = Hysteresis::new(limits, proximity, rule).of_family(family);
    let Ok(material) = material.with_tails([between(tails, 0.0, 4.0)]) else {
        return;
    };
    let Ok(material) = material.with_onset([between(tails, 0.0, 1.0)]) else {
        return;
    };
    let [share, shift, log_half_width, log_spread, zeta_difference] = drawn.second;
    let second = SecondPopulation {
        share: between(share, 0.0, 1.0),
        shift: between(shift, -10.0, 10.0),
        log_half_width: between(log_half_width, -3.0, 3.0),
        log_spread: between(log_spread, -3.0, 3.0),
        zeta_difference: between(zeta_difference, -1.0, 1.0),
    };
    let Ok(material) = material.with_second_population([second]) else {
        return;
    };
    let bends = drawn.bends.map(|bend| [between(bend, -1.0, 1.0)]);
    // Those that would turn a branch back are refused.
    let material = material.with_bends(bends).unwrap_or(material);
    let start = f64::from(drawn.start);
    // Loops that are asymmetric jump at some reversals: see `LimitingLoop::with_asymmetry`.
    let may_jump = asymmetry_of(drawn.shape) != 0.0
        && match family {
            LoopFamily::Kinetics => {
                2.25 * params.loop_spread_k * asymmetry_of(drawn.shape).abs()
                    >= params.loop_half_width_k
            }
            _ => drawn.is_nested,
        };
    let mut memory = match drawn.start % 3 {
        0 => material.on_limiting_curve(Branch::Heating, [start]),
        1 => material.on_limiting_curve(Branch::Cooling, [start]),
        _ => material.between_limiting_curves([start], [0.5]),
    };
    // Relays that begin between the curves are stretched to return there, within next to no temperature where none would switch.
    let mut was_far = drawn.start % 3 == 2 && family == LoopFamily::Relays;
    let [mut before] = material.commit(&mut memory, [start]);
    let path = drawn.path.iter().map(|&step| f64::from(step) * 0.01);
    let far = drawn.far.iter().copied().filter(|degc| degc.is_finite());
    for degc in path.chain(far) {
        let seen = material.peek(&memory, [degc]);
        let [fraction] = material.commit(&mut memory, [degc]);
        assert_eq!(seen.fraction[0].to_bits(), fraction.to_bits());
        // Loops of thousands of kelvins end beyond what is remembered.
        let is_within = (-ROUNDING..=1.0 + ROUNDING).contains(&fraction);
        assert!(
            is_within || drawn.is_extreme && fraction.is_finite(),
            "{fraction} at {degc}"
        );
        assert!(seen.slope_per_k[0] >= 0.0, "slope {}", seen.slope_per_k[0]);
        // A stay changes nothing.
        let [stayed] = material.commit(&mut memory, [degc]);
        assert!(
            (stayed - fraction).abs() <= ROUNDING,
            "{fraction} {stayed} at {degc}"
        );
        was_far |= degc.abs() > 1e4;
        if !drawn.is_extreme && !may_jump && !was_far {
            // Nor does a nudge there and back move it far.
            for nudge in [1e-7, -1e-7] {
                let mut aside = memory.clone();
                let [nudged] = material.commit(&mut aside, [degc + nudge]);
                assert!(
                    (nudged - fraction).abs() <= 10.0 * ROUNDING,
                    "{fraction} {nudged} at {degc}"
                );
            }
        }
        before = fraction;
    }
    assert!(before.is_finite());
});
