//! A loop whose branches spread differently, over random materials and paths.

use crate::common::{self, drawn};

use common::{material, walk};
use drawn::{any_path, any_rule, any_shape};
use proptest::prelude::*;
use sma_hysteresis::{
    Branch, Hysteresis, HysteresisError, LimitingLoop, LoopParams, Rule, SineProximity,
};

fn asymmetric(shape: (f64, f64, f64), asymmetry: f64, rule: Rule) -> Hysteresis<1> {
    let (width, spread, zeta) = shape;
    let limits = *material(width, spread, zeta, rule).limits();
    let proximity = SineProximity::new([zeta]).unwrap();
    Hysteresis::new(limits.with_asymmetry([asymmetry]).unwrap(), proximity, rule)
}

proptest! {
    #[test]
    fn each_limiting_curve_has_its_spread(
        (width, spread, zeta) in any_shape(), asymmetry in -0.8..0.8, at in -40.0..40.0,
    ) {
        let material = asymmetric((width, spread, zeta), asymmetry, Rule::LastReversal);
        for branch in [Branch::Heating, Branch::Cooling] {
            let own = spread * (1.0 - branch.sign() * asymmetry);
            let level: f64 = (at - branch.sign() * width) / own;
            let expected = 0.5 + level.atan() / std::f64::consts::PI;
            let [fraction] = material.limits().fraction(branch, [at]);
            prop_assert!((fraction - expected).abs() < 1e-13);
            let [back] = material.limits().temperature_degc(branch, [fraction]).unwrap();
            prop_assert!((back - at).abs() < 1e-6 * (1.0 + at.abs() / own).powi(2));
        }
    }

    #[test]
    fn branches_are_monotone_and_continuous_and_peek_knows_their_slope(
        shape in any_shape(), asymmetry in -0.8..0.8, rule in any_rule(), path in any_path(),
    ) {
        let material = asymmetric(shape, asymmetry, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        let (step, steepest) = (1e-5, 2.0 / (shape.1 * (1.0 - asymmetry.abs())));
        for pair in path.windows(2) {
            let mut before = walk(&material, &mut memory, &[pair[0]]);
            for k in 0..=20 {
                let temperature = pair[0] + (pair[1] - pair[0]) * f64::from(k) / 20.0;
                let fraction = walk(&material, &mut memory, &[temperature]);
                prop_assert!((fraction - before) * (pair[1] - pair[0]).signum() >= -1e-12);
                let way = (pair[1] - pair[0]).signum() * step;
                let [here, next] = [0.5 * way, way].map(|k| material.peek(&memory, [temperature + k]));
                let rise = next.fraction[0] - fraction;
                prop_assert!(rise.abs() <= step * steepest);
                // A return point may lie within the step.
                let other = material.peek(&memory, [temperature + 0.01 * way]);
                let margin = 1e-5 * steepest + (here.slope_per_k[0] - other.slope_per_k[0]).abs()
                    + (here.slope_per_k[0] - next.slope_per_k[0]).abs();
                prop_assert!((rise / way - here.slope_per_k[0]).abs() <= margin);
                before = fraction;
            }
        }
    }

    #[test]
    fn a_branch_ends_on_its_limiting_curve(
        shape in any_shape(), asymmetry in -0.8..0.8, rule in any_rule(), path in any_path(),
    ) {
        let material = asymmetric(shape, asymmetry, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        walk(&material, &mut memory, &path);
        // Curves of different spreads are far apart far away, in kelvins: the way back from there is long.
        let fraction = walk(&material, &mut memory, &[9e5]);
        let [limit] = material.limits().fraction(Branch::Heating, [9e5]);
        prop_assert!((fraction - limit).abs() <= 1e-9);
    }

    #[test]
    fn minor_loops_close(shape in any_shape(), asymmetry in -0.8..0.8, ends in (-30.0..30.0, 0.5..20.0)) {
        let material = asymmetric(shape, asymmetry, Rule::Nested);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [-60.0]);
        let upper = ends.0 + ends.1;
        let left = walk(&material, &mut memory, &[upper]);
        let back = walk(&material, &mut memory, &[ends.0, upper]);
        // Beyond where the curves cross a branch may miss the point that it returns to.
        let [heating, cooling] =
            [Branch::Heating, Branch::Cooling].map(|branch| material.limits().fraction(branch, [upper])[0]);
        prop_assume!(cooling > heating && material.limits().fraction(Branch::Cooling, [ends.0])
            > material.limits().fraction(Branch::Heating, [ends.0]));
        prop_assert!((back - left).abs() < 1e-10, "{left} {back}");
    }

    #[test]
    fn without_asymmetry_the_bits_are_the_same(shape in any_shape(), rule in any_rule(), path in any_path()) {
        let with = asymmetric(shape, 0.0, rule);
        let without = material(shape.0, shape.1, shape.2, rule);
        let mut memories = [&with, &without].map(|one| one.between_limiting_curves([path[0]], [0.3]));
        for &temperature in &path {
            let [a, b] = &mut memories;
            let fractions = [walk(&with, a, &[temperature]), walk(&without, b, &[temperature])];
            prop_assert_eq!(fractions[0].to_bits(), fractions[1].to_bits());
        }
    }

    #[test]
    fn a_start_has_the_fraction_that_was_asked(
        shape in any_shape(), asymmetry in -0.5..0.5, at in -10.0..10.0, share in 0.0..1.0,
    ) {
        let material = asymmetric(shape, asymmetry, Rule::Nested);
        let memory = material.between_limiting_curves([at], [share]);
        let [fraction] = material.peek(&memory, [at]).fraction;
        let [heating, cooling] =
            [Branch::Heating, Branch::Cooling].map(|branch| material.limits().fraction(branch, [at])[0]);
        prop_assume!(cooling > heating);
        prop_assert!((heating - 1e-12..=cooling + 1e-12).contains(&fraction));
        let again = material.at([at], [fraction]).unwrap();
        prop_assert!((material.peek(&again, [at]).fraction[0] - fraction).abs() < 1e-12);
    }
}

#[test]
fn an_asymmetry_that_leaves_no_spread_is_refused() {
    for value in [1.0, -1.0, f64::NAN] {
        let refused = LimitingLoop::new([LoopParams::default()])
            .unwrap()
            .with_asymmetry([value])
            .unwrap_err();
        assert!(matches!(refused, HysteresisError::Asymmetry { .. }));
        assert!(refused.to_string().contains("must be > -1 and < 1"));
    }
}
