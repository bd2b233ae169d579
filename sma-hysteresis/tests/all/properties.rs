//! Laws of the operator, over random materials and paths.

use crate::common::{self, drawn};

use common::{material, walk};
use drawn::{any_path, any_rule, any_shape};
use proptest::prelude::*;
use sma_hysteresis::{
    Branch, ExponentialProximity, Hysteresis, LimitingLoop, LoopParams, Memory, NESTING_CAPACITY,
    Proximity, Rule, SineProximity,
};

/// Rounding of a few operations on temperatures of some ten degrees, carried to the fraction.
const ROUNDING: f64 = 1e-12;

proptest! {
    #[test]
    fn fraction_stays_inside_the_limiting_loop(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(),
    ) {
        let material = material(width, spread, zeta, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        for &temperature in &path {
            let fraction = walk(&material, &mut memory, &[temperature]);
            let [lower] = material.limits().fraction(Branch::Heating, [temperature]);
            let [upper] = material.limits().fraction(Branch::Cooling, [temperature]);
            prop_assert!(fraction >= lower - ROUNDING && fraction <= upper + ROUNDING);
            prop_assert!((0.0..=1.0).contains(&fraction));
        }
    }

    #[test]
    fn branches_are_monotone_and_peek_knows_their_slope(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(),
    ) {
        let material = material(width, spread, zeta, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        for pair in path.windows(2) {
            walk(&material, &mut memory, &[pair[0]]);
            let mut before = walk(&material, &mut memory, &[pair[0]]);
            for k in 1..=20 {
                let temperature = pair[0] + (pair[1] - pair[0]) * f64::from(k) / 20.0;
                let sensed = material.peek(&memory, [temperature]);
                prop_assert!(sensed.slope_per_k[0] >= 0.0);
                let fraction = walk(&material, &mut memory, &[temperature]);
                prop_assert!((fraction - before) * (pair[1] - pair[0]).signum() >= -ROUNDING);
                before = fraction;
            }
        }
    }

    #[test]
    fn slope_is_the_derivative_of_what_peek_sees(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(),
        ahead in 0.1..10.0,
    ) {
        let material = material(width, spread, zeta, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        walk(&material, &mut memory, &path);
        let last = path[path.len() - 1];
        let step = 1e-5;
        let [before, here, after] = [-step, 0.0, step]
            .map(|offset| material.peek(&memory, [last + ahead + offset]));
        let difference = (after.fraction[0] - before.fraction[0]) / (2.0 * step);
        // A corner between two branches may lie inside the step: then the slope is that of one side.
        let sides = [before.slope_per_k[0], after.slope_per_k[0]];
        let margin = 1e-6 + (sides[0] - sides[1]).abs();
        prop_assert!((here.slope_per_k[0] - difference).abs() <= margin);
    }

    #[test]
    fn reversals_are_continuous(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(),
    ) {
        let material = material(width, spread, zeta, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        for pair in path.windows(2) {
            let here = walk(&material, &mut memory, &[pair[0]]);
            let towards = (pair[1] - pair[0]).signum();
            // Steepest slope of the limiting curve: 1/(π h0).
            let nearby = walk(&material, &mut memory, &[pair[0] + towards * 1e-8]);
            prop_assert!((nearby - here).abs() <= 1e-8 / spread + ROUNDING);
            walk(&material, &mut memory, &[pair[1]]);
        }
    }

    #[test]
    fn every_branch_returns_to_the_limiting_curve(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(),
    ) {
        let material = material(width, spread, zeta, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        walk(&material, &mut memory, &path);
        // Beyond all that the path has visited, and π T_c/ζ further: the longest branch there is.
        let far = 50.0 + std::f64::consts::PI * width / zeta + 1.0;
        let fraction = walk(&material, &mut memory, &[far]);
        let [limit] = material.limits().fraction(Branch::Heating, [far]);
        prop_assert!((fraction - limit).abs() <= ROUNDING);
        // A saturating excursion forgets the past.
        let fraction = walk(&material, &mut memory, &[-far]);
        let [limit] = material.limits().fraction(Branch::Cooling, [-far]);
        prop_assert!((fraction - limit).abs() <= ROUNDING);
    }

    #[test]
    fn the_path_counts_and_not_its_speed(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(),
        parts in 2_u32..9,
    ) {
        let material = material(width, spread, zeta, rule);
        let mut fast = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        let mut slow = fast.clone();
        for pair in path.windows(2) {
            let fraction = walk(&material, &mut fast, &[pair[1]]);
            let mut slowly = f64::NAN;
            for k in 1..=parts {
                let temperature = if k == parts {
                    pair[1]
                } else {
                    pair[0] + (pair[1] - pair[0]) * f64::from(k) / f64::from(parts)
                };
                slowly = walk(&material, &mut slow, &[temperature, temperature]);
            }
            prop_assert_eq!(fraction.to_bits(), slowly.to_bits());
        }
    }

    #[test]
    fn nested_loops_close_and_are_wiped_out(
        (width, spread, zeta) in any_shape(), path in any_path(),
        inner in prop::collection::vec(0.0..1.0, 1..60), top in -40.0..50.0, depth in 1.0..60.0,
    ) {
        let material = material(width, spread, zeta, Rule::Nested);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [-60.0]);
        walk(&material, &mut memory, &path);
        // A branch heating up to `top`, which no older reversal lies below.
        let highest = path.iter().fold(top, |a: f64, &b| a.max(b));
        let left = walk(&material, &mut memory, &[highest]);
        let mut straight = memory.clone();
        // Any walk below it, not deeper than the last lower reversal remembered.
        let floor = material
            .reversals(&memory, 0)
            .map(|reversal| reversal.temperature_degc)
            .filter(|&temperature| temperature < highest)
            .fold(highest - depth, f64::max);
        for share in &inner {
            walk(&material, &mut memory, &[floor + share * (highest - floor)]);
        }
        let back = walk(&material, &mut memory, &[highest]);
        prop_assert!((back - left).abs() <= ROUNDING, "{} {}", back, left);
        // Past the return point as if the loop had never been.
        for beyond in [0.5, 3.0, 30.0, -10.0, -70.0] {
            let after = walk(&material, &mut memory, &[highest + beyond]);
            let without = walk(&material, &mut straight, &[highest + beyond]);
            prop_assert!((after - without).abs() <= ROUNDING, "{} {}", after, without);
        }
    }

    #[test]
    fn the_smallest_nested_loops_are_defined(
        (width, spread, _) in any_shape(), center in prop::sample::select(vec![0.0, 20.0, 45.0, 70.0]),
        // Decimal logarithms of the sizes, K: of some, no digit of the height is left.
        turn in -1.0..1.0, sizes in prop::collection::vec(-9.0..-6.0, 1..20),
    ) {
        let limits = LimitingLoop::new([LoopParams {
            loop_center_degc: center,
            loop_half_width_k: width,
            loop_spread_k: spread,
            ..LoopParams::default()
        }])
        .unwrap();
        let material = Hysteresis::new(limits, SineProximity::new([1.0]).unwrap(), Rule::Nested);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [center - 60.0]);
        let first = center + turn * width;
        walk(&material, &mut memory, &[first]);
        for size in sizes {
            let size = 10_f64.powf(size);
            for share in [-1.0, -0.1, -0.9, -0.5, 0.0, 0.1] {
                let temperature = first + share * size;
                let sensed = material.peek(&memory, [temperature]);
                let fraction = walk(&material, &mut memory, &[temperature]);
                let [lower] = material.limits().fraction(Branch::Heating, [temperature]);
                let [upper] = material.limits().fraction(Branch::Cooling, [temperature]);
                prop_assert!(fraction >= lower - ROUNDING && fraction <= upper + ROUNDING, "{}", fraction);
                prop_assert!(sensed.slope_per_k[0] >= 0.0, "{:e}", sensed.slope_per_k[0]);
            }
        }
    }

    #[test]
    fn fractions_follow_the_share_onto_the_cooling_curve(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(),
    ) {
        let material = material(width, spread, zeta, rule);
        let mut on = material.between_limiting_curves([path[0]], [1.0]);
        let mut beside = material.between_limiting_curves([path[0]], [1.0 - 1e-12]);
        for &temperature in &path {
            let expected = walk(&material, &mut on, &[temperature]);
            let fraction = walk(&material, &mut beside, &[temperature]);
            prop_assert!((fraction - expected).abs() <= 1e-7, "{} {}", fraction, expected);
        }
    }

    #[test]
    fn a_memory_that_begins_anew_is_as_another_one(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(), share in 0.0..=1.0,
    ) {
        let material = material(width, spread, zeta, rule);
        let mut used = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        walk(&material, &mut used, &path);
        material.restart(&mut used, [path[0]], [share]);
        let mut fresh = material.between_limiting_curves([path[0]], [share]);
        for &temperature in &path {
            let expected = walk(&material, &mut fresh, &[temperature]);
            let fraction = walk(&material, &mut used, &[temperature]);
            prop_assert_eq!(fraction.to_bits(), expected.to_bits());
            prop_assert_eq!(material.reversals(&used, 0).count(), material.reversals(&fresh, 0).count());
        }
    }

    #[test]
    fn a_start_since_a_reversal_is_where_a_material_that_turned_there_stands(
        (width, spread, zeta) in any_shape(), path in any_path(), share in 0.05..0.95, since_k in 1.0..20.0,
    ) {
        let material = material(width, spread, zeta, Rule::LastReversal);
        let (start, turn) = (path[0], path[0] - since_k);
        let mut gone = material.between_limiting_curves([turn], [share]);
        let fraction = walk(&material, &mut gone, &[start]);
        let at = |share: f64| material.peek(&material.between_limiting_curves([start], [share]), [start]).fraction[0];
        let [lower, upper] = [0.0, 1.0].map(at);
        // Levels lie straight between the curves, and fractions do not.
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if at(middle) < fraction { low = middle } else { high = middle }
        }
        prop_assume!(upper - lower > 1e-3);
        let mut begun = material.since_reversal([start], [low], [since_k]);
        for &temperature in &path {
            let expected = walk(&material, &mut gone, &[temperature]);
            let fraction = walk(&material, &mut begun, &[temperature]);
            prop_assert!((fraction - expected).abs() <= 1e-7, "{} {}", fraction, expected);
        }
    }

    #[test]
    fn a_start_since_a_reversal_has_the_share_where_the_branch_can_lead_there(
        (width, spread, zeta) in any_shape(), rule in any_rule(), share in 0.0..=1.0, start in -30.0..30.0, since_k in -30.0..30.0,
    ) {
        let material = material(width, spread, zeta, rule);
        let fraction = |memory: &Memory<1>| material.peek(memory, [start]).fraction[0];
        let wanted = fraction(&material.between_limiting_curves([start], [share]));
        let begun = fraction(&material.since_reversal([start], [share], [since_k]));
        let turned = |share: f64| {
            let mut memory = material.between_limiting_curves([start - since_k], [share]);
            walk(&material, &mut memory, &[start])
        };
        let [least, most] = [0.0, 1.0].map(turned);
        let nearest = wanted.min(most).max(least);
        prop_assert!((begun - nearest).abs() <= 1e-7, "{begun} {wanted} {least} {most}");
    }

    #[test]
    fn a_reversal_that_is_no_number_leaves_none(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(), share in 0.0..=1.0,
    ) {
        let material = material(width, spread, zeta, rule);
        let mut memory = material.since_reversal([path[0]], [share], [f64::NAN]);
        prop_assert!(walk(&material, &mut memory, &path).is_nan());
    }

    #[test]
    fn lanes_begin_each_by_itself(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(), shares in prop::array::uniform2(0.0..=1.0),
        since_k in -30.0..30.0,
    ) {
        let limits = LimitingLoop::new([LoopParams {
            loop_center_degc: 0.0,
            loop_half_width_k: width,
            loop_spread_k: spread,
            ..LoopParams::default()
        }; 2]).unwrap();
        let both = Hysteresis::new(limits, SineProximity::new([zeta; 2]).unwrap(), rule);
        let alone = material(width, spread, zeta, rule);
        let mut memory = both.since_reversal([path[0]; 2], shares, [0.0, since_k]);
        let mut alone_at_once = alone.between_limiting_curves([path[0]], [shares[0]]);
        let mut alone_since = alone.since_reversal([path[0]], [shares[1]], [since_k]);
        for &temperature in &path {
            let found = both.commit(&mut memory, [temperature; 2]);
            let expected = [&mut alone_at_once, &mut alone_since].map(|one| walk(&alone, one, &[temperature]));
            prop_assert_eq!(found.map(f64::to_bits), expected.map(f64::to_bits));
        }
    }

    #[test]
    fn a_small_first_movement_moves_little(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(),
        share in prop_oneof![Just(0.0), 0.0..1.0, Just(1.0)],
        wobble in prop_oneof![Just(-1e-10), Just(1e-10), Just(-1e-8), Just(1e-8)],
    ) {
        let material = material(width, spread, zeta, rule);
        let mut straight = material.between_limiting_curves([path[0]], [share]);
        let mut moved = straight.clone();
        walk(&material, &mut moved, &[path[0] + wobble]);
        for &temperature in &path[1..] {
            let expected = walk(&material, &mut straight, &[temperature]);
            let fraction = walk(&material, &mut moved, &[temperature]);
            prop_assert!((fraction - expected).abs() <= 1e-5, "{} {}", fraction, expected);
        }
    }

    #[test]
    fn both_memories_agree_up_to_the_second_reversal(
        (width, spread, zeta) in any_shape(), start in -50.0..0.0, high in 0.0..60.0, low in 0.0..60.0,
    ) {
        // From one limiting curve up, and down to the other or until the branch is left.
        let run = |rule, swing: f64| {
            let material = material(width, spread, zeta, rule);
            let mut memory = material.on_limiting_curve(Branch::Cooling, [start]);
            let up: Vec<f64> = (0..=20).map(|k| start + high * f64::from(k) / 20.0).collect();
            let mut fractions: Vec<f64> = up
                .iter()
                .map(|&temperature| walk(&material, &mut memory, &[temperature]))
                .collect();
            let mut heating = material.on_limiting_curve(Branch::Heating, [high]);
            for k in 0..=20 {
                let temperature = high - swing * f64::from(k) / 20.0;
                fractions.push(walk(&material, &mut heating, &[temperature]));
            }
            fractions
        };
        prop_assert_eq!(run(Rule::LastReversal, low), run(Rule::Nested, low));
    }

    #[test]
    fn peek_sees_what_commit_does(
        (width, spread, zeta) in any_shape(), rule in any_rule(), path in any_path(),
    ) {
        let material = material(width, spread, zeta, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        for &temperature in &path {
            let before = memory.clone();
            let sensed = material.peek(&memory, [temperature]);
            prop_assert_eq!(&memory, &before);
            let fraction = walk(&material, &mut memory, &[temperature]);
            prop_assert_eq!(sensed.fraction[0].to_bits(), fraction.to_bits());
        }
    }

    #[test]
    fn lanes_give_equal_bits(
        shapes in prop::collection::vec(any_shape(), 32), rule in any_rule(), path in any_path(),
    ) {
        let wide = lanes::<32>(&shapes, rule);
        let narrow = lanes::<8>(&shapes, rule);
        let mut wide_memory = wide.on_limiting_curve(Branch::Cooling, [path[0]; 32]);
        let mut narrow_memory = narrow.on_limiting_curve(Branch::Cooling, [path[0]; 8]);
        let single: Vec<Hysteresis<1>> =
            shapes.iter().map(|shape| lanes::<1>(&[*shape], rule)).collect();
        let mut memories: Vec<Memory<1>> = single
            .iter()
            .map(|one| one.on_limiting_curve(Branch::Cooling, [path[0]]))
            .collect();
        for &temperature in &path {
            // Each lane goes its own way, so that they reverse at different samples.
            let own = |l: usize| temperature * (1.0 - 0.02 * l as f64);
            let from_wide = wide.commit(&mut wide_memory, std::array::from_fn(own));
            let from_narrow = narrow.commit(&mut narrow_memory, std::array::from_fn(own));
            for l in 0..32 {
                let [alone] = single[l].commit(&mut memories[l], [own(l)]);
                prop_assert_eq!(alone.to_bits(), from_wide[l].to_bits());
                if l < 8 {
                    prop_assert_eq!(alone.to_bits(), from_narrow[l].to_bits());
                }
            }
        }
    }

    #[test]
    fn other_proximity_functions_keep_the_laws(
        (width, spread, rate) in any_shape(), path in any_path(),
    ) {
        let limits = limiting_loop([(width, spread, rate)]);
        let material =
            Hysteresis::new(limits, ExponentialProximity::new([rate]).unwrap(), Rule::Nested);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        for pair in path.windows(2) {
            let [before] = material.commit(&mut memory, [pair[0]]);
            let [after] = material.commit(&mut memory, [pair[1]]);
            prop_assert!((after - before) * (pair[1] - pair[0]).signum() >= -ROUNDING);
            let [lower] = material.limits().fraction(Branch::Heating, [pair[1]]);
            let [upper] = material.limits().fraction(Branch::Cooling, [pair[1]]);
            prop_assert!(after >= lower - ROUNDING && after <= upper + ROUNDING);
        }
    }
}

fn limiting_loop<const L: usize>(shapes: [(f64, f64, f64); L]) -> LimitingLoop<L> {
    LimitingLoop::new(shapes.map(|(width, spread, _)| LoopParams {
        loop_center_degc: 0.0,
        loop_half_width_k: width,
        loop_spread_k: spread,
        ..LoopParams::default()
    }))
    .unwrap()
}

fn lanes<const L: usize>(shapes: &[(f64, f64, f64)], rule: Rule) -> Hysteresis<L> {
    let shapes: [_; L] = std::array::from_fn(|l| shapes[l]);
    let proximity = SineProximity::new(shapes.map(|(_, _, zeta)| zeta)).unwrap();
    Hysteresis::new(limiting_loop(shapes), proximity, rule)
}

#[test]
fn a_full_memory_forgets_its_smallest_loop() {
    let material = material(10.0, 6.0, 0.9, Rule::Nested);
    let mut memory = material.on_limiting_curve(Branch::Cooling, [-40.0]);
    let mut outer = Vec::new();
    for k in 0..60 {
        let size = 30.0 * 0.95_f64.powi(k);
        let top = walk(&material, &mut memory, &[size]);
        outer.push((size, top));
        walk(&material, &mut memory, &[-size]);
    }
    // No more than there were reversals.
    assert!((1..=120).contains(&memory.forgotten()[0]));
    assert!(memory.depth()[0] <= NESTING_CAPACITY);
    // The largest loops still close.
    for &(size, top) in outer[..10].iter().rev() {
        let back = walk(&material, &mut memory, &[size]);
        assert!((back - top).abs() < ROUNDING, "{size}: {back} {top}");
    }
}

#[test]
fn movements_below_the_dead_band_add_up_to_a_reversal() {
    let material = material(10.0, 6.0, 0.9, Rule::Nested);
    let mut memory = material.on_limiting_curve(Branch::Heating, [5.0]);
    walk(&material, &mut memory, &[5.0]);
    let creeping: Vec<f64> = (1..=20).map(|k| 5.0 - 2e-10 * f64::from(k)).collect();
    walk(&material, &mut memory, &creeping);
    assert_eq!(memory.branch(0), Some(Branch::Cooling));
    assert_eq!(material.reversals(&memory, 0).count(), 1);
    let [reversal] = [material.reversals(&memory, 0).next().unwrap()];
    assert!((reversal.temperature_degc - 5.0).abs() < 1e-12);
}

#[test]
fn a_reversal_deep_in_saturation_is_defined() {
    for rule in [Rule::LastReversal, Rule::Nested] {
        let material = material(10.0, 0.01, 1.0, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [-1e6]);
        for temperature in [1e6, -1e6, 1e6, 0.0, 1e9, -1e9] {
            let fraction = walk(&material, &mut memory, &[temperature]);
            assert!((0.0..=1.0).contains(&fraction), "{temperature}: {fraction}");
        }
    }
}

#[test]
fn a_temperature_that_is_no_number_leaves_no_trace() {
    for rule in [Rule::LastReversal, Rule::Nested] {
        let material = material(10.0, 6.0, 0.9, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [-40.0]);
        walk(&material, &mut memory, &[20.0, 3.0]);
        let before = memory.clone();
        assert!(walk(&material, &mut memory, &[f64::NAN]).is_nan());
        assert_eq!(memory, before);
        assert!(material.peek(&memory, [f64::NAN]).slope_per_k[0].is_nan());
    }
}

#[test]
fn an_infinite_temperature_is_a_saturating_excursion() {
    let path = [20.0, 3.0, 9.0, 5.0];
    for rule in [Rule::LastReversal, Rule::Nested] {
        let material = material(10.0, 6.0, 0.9, rule);
        for visited in 0..=path.len() {
            for far in [1.0, -1.0] {
                let mut memory = material.on_limiting_curve(Branch::Cooling, [-40.0]);
                walk(&material, &mut memory, &path[..visited]);
                let mut finite = memory.clone();
                let sensed = material.peek(&memory, [far * f64::INFINITY]);
                assert!(sensed.slope_per_k[0].abs() < ROUNDING);
                for factor in [1.0, -1.0, 1.0] {
                    let at_infinity = walk(&material, &mut memory, &[factor * far * f64::INFINITY]);
                    assert!((at_infinity - 0.5 - 0.5 * factor * far).abs() < ROUNDING);
                    walk(&material, &mut finite, &[factor * far * 1000.0]);
                    for temperature in [7.0, -7.0, 2.0, 30.0, -12.0] {
                        let after = walk(&material, &mut memory, &[temperature]);
                        let expected = walk(&material, &mut finite, &[temperature]);
                        assert!((after - expected).abs() < 1e-9, "{after} {expected}");
                    }
                }
            }
        }
        let mut started = material.between_limiting_curves([f64::INFINITY], [0.5]);
        assert!(walk(&material, &mut started, &[12.0, 11.0, 13.0]).is_finite());
    }
}

#[test]
fn a_start_between_the_curves_is_a_reversal_if_left_by_heating() {
    let material = material(10.0, 6.0, 0.9, Rule::Nested);
    let started = material.between_limiting_curves([0.0], [0.4]);
    let mut still = started.clone();
    let here = walk(&material, &mut still, &[0.0]);
    for (towards, depth) in [(-30.0, 0), (30.0, 1)] {
        let mut memory = started.clone();
        let nearby = walk(&material, &mut memory, &[towards * 1e-7]);
        assert!((nearby - here).abs() < 1e-5);
        walk(&material, &mut memory, &[towards]);
        assert_eq!(memory.depth()[0], depth);
    }
    // The loop that began at the start closes there, and the curve goes on without a step.
    let mut memory = started.clone();
    let back = walk(&material, &mut memory, &[30.0, 0.0]);
    assert!((back - here).abs() < ROUNDING, "{back} {here}");
    let past = walk(&material, &mut memory, &[-30.0 * 1e-7]);
    assert!((past - here).abs() < 1e-5);
    let same = material.at([0.0], [here]).unwrap();
    assert!((material.peek(&same, [0.0]).fraction[0] - here).abs() < ROUNDING);
    // On the heating curve, as if come along it.
    let mut memory = material.between_limiting_curves([0.0], [0.0]);
    walk(&material, &mut memory, &[30.0]);
    assert_eq!(memory.depth()[0], 0);
}

#[test]
fn slopes_of_proximities_are_those_of_their_differences() {
    let exponential = ExponentialProximity::new([0.3]).unwrap();
    let sine = SineProximity::new([0.8]).unwrap();
    let all: [&dyn Proximity; 2] = [&exponential, &sine];
    for proximity in all {
        for x in [0.1, 0.5, 1.2, 1.7] {
            let [after, before] = [1e-5, -1e-5].map(|step| proximity.decay(0, x + step));
            let slope = proximity.decay_slope(0, x);
            assert!(
                (slope - (after - before) / 2e-5).abs() < 1e-8,
                "{x} {slope}"
            );
        }
    }
}
