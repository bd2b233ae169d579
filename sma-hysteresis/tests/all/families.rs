//! Laws of loops of other families, and their curves by another route.

use crate::common::{self, drawn};

use common::{material, walk};
use drawn::{any_path, any_rule, any_shape};
use proptest::prelude::*;
use sma_hysteresis::{Branch, Hysteresis, LoopFamily, Rule, SecondPopulation};
use std::f64::consts::PI;

/// Rounding of a few operations, of a share of 1, on a branch that is a thousand times steeper than relays alone make it.
const ROUNDING: f64 = 1e-10;

fn any_family() -> impl Strategy<Value = LoopFamily> {
    prop_oneof![Just(LoopFamily::Relays), Just(LoopFamily::Kinetics)]
}

/// A family, the tails of its relays or the sharpness of its kinetics' onset, a second population of relays, and bends.
type Kind = (LoopFamily, f64, SecondPopulation, [f64; 3]);

fn any_second() -> impl Strategy<Value = SecondPopulation> {
    let some = (0.0..1.0, -4.0..4.0, -1.5..1.5, -1.5..1.5, -1.0..1.0).prop_map(
        |(share, shift, log_half_width, log_spread, zeta_difference)| SecondPopulation {
            share,
            shift,
            log_half_width,
            log_spread,
            zeta_difference,
        },
    );
    prop_oneof![Just(SecondPopulation::default()), some]
}

fn any_kind() -> impl Strategy<Value = Kind> {
    let bend = || -0.3333..0.3333;
    let bends = prop_oneof![
        Just([0.0; 3]),
        (bend(), -0.3333..0.6666, bend()).prop_map(|(skew, bend, third)| [skew, bend, third])
    ];
    (
        any_family(),
        prop_oneof![Just(0.0), 0.0..2.0],
        any_second(),
        bends,
    )
}

fn of_kind(kind: Kind, shape: (f64, f64, f64), rule: Rule) -> Hysteresis<1> {
    let (family, own, second, bends) = kind;
    of_family(family, shape, rule)
        .with_tails([own])
        .unwrap()
        .with_onset([0.5 * own])
        .unwrap()
        .with_second_population([second])
        .unwrap()
        .with_bends(bends.map(|bend| [bend]))
        .unwrap()
}

fn of_family(family: LoopFamily, shape: (f64, f64, f64), rule: Rule) -> Hysteresis<1> {
    let (width, spread, zeta) = shape;
    material(width, spread, zeta, rule).of_family(family)
}

proptest! {
    #[test]
    fn branches_are_monotone_continuous_and_within_0_and_1(
        kind in any_kind(), shape in any_shape(), rule in any_rule(), path in any_path(),
        share in prop_oneof![Just(0.0), 0.0..1.0],
    ) {
        let material = of_kind(kind, shape, rule);
        // Only what is remembered whole, from a limiting curve, leads no branch farther than relays do.
        let is_stretched = share > 0.0 || rule == Rule::LastReversal;
        let rounding = if is_stretched { 1e-5 } else { ROUNDING };
        let mut memory = material.between_limiting_curves([path[0]], [share]);
        for pair in path.windows(2) {
            let mut before = walk(&material, &mut memory, &[pair[0]]);
            let nudged = walk(&material, &mut memory, &[pair[0] + 2e-9 * (pair[1] - pair[0]).signum()]);
            prop_assert!((nudged - before).abs() < 1e-4, "{} {}", before, nudged);
            before = nudged;
            for k in 1..=20 {
                let temperature = pair[0] + (pair[1] - pair[0]) * f64::from(k) / 20.0;
                let sensed = material.peek(&memory, [temperature]);
                prop_assert!(sensed.slope_per_k[0] >= 0.0);
                let fraction = walk(&material, &mut memory, &[temperature]);
                prop_assert_eq!(sensed.fraction[0].to_bits(), fraction.to_bits());
                prop_assert!((-rounding..=1.0 + rounding).contains(&fraction), "{}", fraction);
                prop_assert!((fraction - before) * (pair[1] - pair[0]).signum() >= -rounding);
                before = fraction;
            }
        }
    }

    #[test]
    fn slope_is_the_derivative(
        kind in any_kind(), shape in any_shape(), rule in any_rule(), path in any_path(),
        ahead in 0.1..10.0,
    ) {
        let material = of_kind(kind, shape, rule);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        walk(&material, &mut memory, &path);
        let last = path[path.len() - 1];
        let step = 1e-5;
        let [before, here, after] = [-step, 0.0, step]
            .map(|offset| material.peek(&memory, [last + ahead + offset]));
        let difference = (after.fraction[0] - before.fraction[0]) / (2.0 * step);
        let sides = [before.slope_per_k[0], after.slope_per_k[0]];
        // Where hardly anything is left to transform a branch may be steep.
        let margin = 1e-4 * (1.0 + here.slope_per_k[0]) + (sides[0] - sides[1]).abs();
        prop_assert!((here.slope_per_k[0] - difference).abs() <= margin);
    }

    #[test]
    fn a_saturating_excursion_forgets_the_past_and_the_path_counts(
        family in any_family(), shape in any_shape(), path in any_path(), parts in 2_u32..9,
    ) {
        let material = of_family(family, shape, Rule::Nested);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [path[0]]);
        let mut slow = memory.clone();
        for pair in path.windows(2) {
            let fraction = walk(&material, &mut memory, &[pair[1]]);
            let mut slowly = f64::NAN;
            for k in 1..=parts {
                let share = f64::from(k) / f64::from(parts);
                let temperature = if k == parts { pair[1] } else { pair[0] + (pair[1] - pair[0]) * share };
                slowly = walk(&material, &mut slow, &[temperature, temperature]);
            }
            prop_assert_eq!(fraction.to_bits(), slowly.to_bits());
        }
        let hot = walk(&material, &mut memory, &[1000.0]);
        prop_assert!((hot - 1.0).abs() < ROUNDING);
        let mut fresh = material.on_limiting_curve(Branch::Heating, [1000.0]);
        walk(&material, &mut fresh, &[1000.0]);
        for temperature in [30.0, 0.0, -7.0] {
            let aged = walk(&material, &mut memory, &[temperature]);
            let new = walk(&material, &mut fresh, &[temperature]);
            prop_assert!((aged - new).abs() < 1e-9, "{} {}", aged, new);
        }
        prop_assert!(walk(&material, &mut memory, &[-1000.0]).abs() < ROUNDING);
    }

    #[test]
    fn loops_of_relays_close(
        shape in any_shape(), tails in 0.0..2.0, second in any_second(), path in any_path(), top in 50.0..60.0,
        inner in prop::collection::vec(0.0..1.0, 1..40),
    ) {
        let material = of_kind((LoopFamily::Relays, tails, second, [0.0; 3]), shape, Rule::Nested);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [-60.0]);
        walk(&material, &mut memory, &path);
        let left = walk(&material, &mut memory, &[top]);
        let floor = material
            .reversals(&memory, 0)
            .map(|reversal| reversal.temperature_degc)
            .filter(|&temperature| temperature < top)
            .fold(-60.0, f64::max);
        for share in &inner {
            walk(&material, &mut memory, &[floor + share * (top - floor)]);
        }
        let back = walk(&material, &mut memory, &[top]);
        prop_assert!((back - left).abs() <= ROUNDING, "{} {}", back, left);
    }

    #[test]
    fn a_start_of_known_fraction_has_it(
        family in any_family(), shape in any_shape(), degc in -20.0..20.0, share in 0.0..1.0,
    ) {
        let material = of_family(family, shape, Rule::Nested);
        let between = material.between_limiting_curves([degc], [share]);
        let [fraction] = material.peek(&between, [degc]).fraction;
        // Where nothing lies between the curves, rounding alone may put it outside.
        let ends = [0.0, 1.0].map(|end| material.peek(&material.between_limiting_curves([degc], [end]), [degc]));
        prop_assume!(ends[1].fraction[0] - ends[0].fraction[0] > ROUNDING);
        let memory = material.at([degc], [fraction]).unwrap();
        let [again] = material.peek(&memory, [degc]).fraction;
        prop_assert!((again - fraction).abs() < 1e-9, "{} {}", again, fraction);
        prop_assert!(material.at([degc], [1.01]).is_err());
    }

    #[test]
    fn lanes_give_equal_bits(
        family in any_family(), shape in any_shape(), rule in any_rule(), path in any_path(), second in any_second(),
    ) {
        let (width, spread, zeta) = shape;
        let limits = sma_hysteresis::LimitingLoop::new(
            [sma_hysteresis::LoopParams {
                loop_center_degc: 0.0,
                loop_half_width_k: width,
                loop_spread_k: spread,
                ..sma_hysteresis::LoopParams::default()
            }; 4],
        )
        .unwrap();
        let proximity = sma_hysteresis::SineProximity::new([zeta; 4]).unwrap();
        // Lanes with a second population beside such without.
        let seconds = [second, SecondPopulation::default(), second, SecondPopulation { share: 0.0, ..second }];
        let four = Hysteresis::new(limits, proximity, rule).of_family(family).with_second_population(seconds).unwrap();
        let ones = seconds.map(|second| of_family(family, shape, rule).with_second_population([second]).unwrap());
        let mut together = four.on_limiting_curve(Branch::Cooling, [path[0]; 4]);
        let mut alone: Vec<_> = ones.iter().map(|one| one.on_limiting_curve(Branch::Cooling, [path[0]])).collect();
        for &temperature in &path {
            let own = |l: usize| temperature * (1.0 - 0.1 * l as f64);
            let fractions = four.commit(&mut together, std::array::from_fn(own));
            for l in 0..4 {
                let fraction = walk(&ones[l], &mut alone[l], &[own(l)]);
                prop_assert_eq!(fraction.to_bits(), fractions[l].to_bits());
            }
        }
    }
}

/// A wide loop of relays that switch independently (θ = 1 is ζ = 0, here near it): products of normal shares.
#[test]
fn relays_that_know_nothing_of_one_another_have_normal_curves() {
    // Φ at -2, -1, 0, 1, 2.
    let normal = [0.022_75, 0.158_66, 0.5, 0.841_34, 0.977_25];
    let (width, spread) = (30.0, 2.0);
    let material = of_family(LoopFamily::Relays, (width, spread, 1e-9), Rule::Nested);
    let mut memory = material.on_limiting_curve(Branch::Cooling, [-60.0]);
    for (k, expected) in [-2.0, -1.0, 0.0, 1.0, 2.0].into_iter().zip(normal) {
        let fraction = walk(&material, &mut memory, &[width + 1.5 * spread * k]);
        assert!((fraction - expected).abs() < 3e-4, "{k}: {fraction}");
    }
    // Of those that are up, as many switch down at a temperature as of all.
    for (k, share) in [2.0, 1.0, 0.0, -1.0, -2.0].into_iter().zip(normal) {
        let fraction = walk(&material, &mut memory, &[-width + 1.5 * spread * k]);
        assert!(
            (fraction - 0.977_25 * (1.0 - share)).abs() < 5e-4,
            "{k}: {fraction}"
        );
    }
}

/// The limiting curve of heating by the formula of its tails, and refusals.
#[test]
fn relays_with_tails() {
    let (width, spread, tails) = (30.0, 2.0, 1.5);
    let normal = of_family(LoopFamily::Relays, (width, spread, 0.5), Rule::Nested);
    let tailed = normal.with_tails([tails]).unwrap();
    for x in [-6.0_f64, -2.0, -0.5, 0.0, 0.3, 1.0, 4.0] {
        let counted = x / (1.0 + (tails * x).powi(2)).powf(0.25);
        let shares = [(&tailed, x), (&normal, counted)].map(|(material, x)| {
            let mut memory = material.on_limiting_curve(Branch::Cooling, [-1e5]);
            walk(material, &mut memory, &[width + 1.5 * spread * x])
        });
        assert!((shares[0] - shares[1]).abs() < 1e-12, "{x}: {shares:?}");
    }
    for value in [-0.1, 4.1, f64::NAN] {
        let refused = normal.with_tails([value]).unwrap_err();
        assert_eq!(
            refused.to_string(),
            format!("tails = {value}: must be from 0 to 4")
        );
    }
    // The paper's loop has none.
    let paper = material(width, spread, 0.5, Rule::Nested);
    assert_eq!(paper.with_tails([1.0]).unwrap(), paper);
}

/// The limiting curve of heating by the formula of its onset, and refusals.
#[test]
fn kinetics_with_a_sharp_onset() {
    let (width, spread, sharpness) = (20.0, 4.0, 0.6);
    let smooth = of_family(
        LoopFamily::Kinetics,
        (width, spread, 0.5),
        Rule::LastReversal,
    );
    let sharp = smooth.with_onset([sharpness]).unwrap();
    let start_degc = width - 2.25 * spread;
    for u in [-0.1_f64, 0.0, 0.01, 0.3, 0.5, 0.9, 1.0, 1.2] {
        let sine = (0.5 * PI * u.clamp(0.0, 1.0)).sin();
        let expected = (1.0 - sharpness) * sine * sine + sharpness * sine;
        let mut memory = sharp.on_limiting_curve(Branch::Cooling, [-1e5]);
        let share = walk(&sharp, &mut memory, &[start_degc + 4.5 * spread * u]);
        assert!((share - expected).abs() < 1e-12, "{u}: {share} {expected}");
    }
    // It sets in at a finite rate: π/2 s of the range.
    let memory = sharp.on_limiting_curve(Branch::Cooling, [-1e5]);
    let [slope] = sharp.peek(&memory, [start_degc + 1e-9]).slope_per_k;
    assert!((slope - 0.5 * PI * sharpness / (4.5 * spread)).abs() < 1e-9);
    for value in [-0.1, 1.1, f64::NAN] {
        let refused = smooth.with_onset([value]).unwrap_err();
        assert_eq!(
            refused.to_string(),
            format!("sharpness of the onset = {value}: must be from 0 to 1")
        );
    }
    // Relays and the paper's loop have none.
    let shape = (width, spread, 0.5);
    let relays = of_family(LoopFamily::Relays, shape, Rule::Nested);
    let paper = material(width, spread, 0.5, Rule::Nested);
    for other in [relays, paper] {
        assert_eq!(other.with_onset([1.0]).unwrap(), other);
    }
}

/// A limiting curve of two populations is that of both, by their shares; and refusals.
#[test]
fn relays_of_two_populations() {
    let (width, spread, zeta) = (20.0, 2.0, 0.5);
    let first = of_family(LoopFamily::Relays, (width, spread, zeta), Rule::Nested);
    let second = SecondPopulation {
        share: 0.3,
        shift: 2.0,
        log_half_width: -0.4,
        log_spread: 0.5,
        zeta_difference: 0.2,
    };
    let both = first.with_second_population([second]).unwrap();
    let other = of_family(
        LoopFamily::Relays,
        (width * (-0.4_f64).exp(), spread * 0.5_f64.exp(), 0.7),
        Rule::Nested,
    );
    let shift_k = 2.0 * spread;
    let [mut at_both, mut at_first, mut at_other] =
        [&both, &first, &other].map(|one| one.on_limiting_curve(Branch::Cooling, [-90.0]));
    for degc in [
        -60.0, 5.0, 15.0, 19.0, 21.0, 24.0, 60.0, 10.0, -15.0, -19.0, -22.0, -60.0,
    ] {
        let fraction = walk(&both, &mut at_both, &[degc]);
        let apart = [
            walk(&first, &mut at_first, &[degc]),
            walk(&other, &mut at_other, &[degc - shift_k]),
        ];
        let expected = 0.7 * apart[0] + 0.3 * apart[1];
        assert!(
            (fraction - expected).abs() < 1e-9,
            "{degc}: {fraction} {expected}"
        );
    }
    let refused = first.with_second_population([SecondPopulation {
        share: 1.1,
        ..second
    }]);
    assert_eq!(
        refused.unwrap_err().to_string(),
        "share of the second population = 1.1: must be from 0 to 1"
    );
    let unknown = SecondPopulation {
        log_half_width: f64::NAN,
        ..second
    };
    assert!(first.with_second_population([unknown]).is_err());
    // A share of none is no population, and the paper's loop has none.
    let none = SecondPopulation {
        share: 0.0,
        ..second
    };
    assert_eq!(both.with_second_population([none]).unwrap(), first);
    let paper = material(width, spread, zeta, Rule::Nested);
    assert_eq!(paper.with_second_population([second]).unwrap(), paper);
}

/// Limiting curves of both directions by the formula of the bends, and refusals.
#[test]
fn loops_with_bends() {
    let bends = [0.3, -0.25, 0.2];
    let bent = |p: f64| {
        let x = 1.0 - 2.0 * p;
        let terms = [1.0, x, (5.0 * x * x - 1.0) / 4.0];
        let sum: f64 = bends
            .iter()
            .zip(terms)
            .map(|(bend, term)| bend * term)
            .sum();
        p + p * (1.0 - p) * sum
    };
    for family in [LoopFamily::Relays, LoopFamily::Kinetics] {
        let straight = of_family(family, (8.0, 3.0, 0.6), Rule::Nested);
        let material = straight.with_bends(bends.map(|bend| [bend])).unwrap();
        for (branch, from) in [(Branch::Cooling, -1e5), (Branch::Heating, 1e5)] {
            for temperature in [-14.0, -9.0, -7.0, 0.0, 5.0, 8.0, 11.0] {
                let [shown, plain] = [&material, &straight].map(|material| {
                    let mut memory = material.on_limiting_curve(branch, [from]);
                    walk(material, &mut memory, &[temperature])
                });
                // Of what cools it is the share that has been lost that bends.
                let expected = if from < 0.0 {
                    bent(plain)
                } else {
                    1.0 - bent(1.0 - plain)
                };
                assert!(
                    (shown - expected).abs() < 1e-9,
                    "{family}: {shown} {expected}"
                );
            }
        }
    }
    let paper = material(8.0, 3.0, 0.6, Rule::Nested);
    assert_eq!(paper.with_bends([[0.2]; 3]).unwrap(), paper);
    for bends in [[0.5, 0.4, 0.4], [0.2, -0.5, 0.4], [f64::NAN; 3]] {
        let refused = paper.with_bends(bends.map(|bend| [bend])).unwrap_err();
        let refused = refused.to_string();
        assert!(
            refused.starts_with("bends of the loop lower a slope by "),
            "{refused}"
        );
    }
    // A bend that is strongest in the middle may be larger one way than the other.
    assert!(
        material(8.0, 3.0, 0.6, Rule::Nested)
            .with_bends([[0.2], [1.2], [0.2]])
            .is_ok()
    );
}

/// Relays that are all alike, ζ = 1: nearly a single play with a normal curve behind it.
#[test]
fn alike_relays_leave_a_plateau_after_a_reversal() {
    let material = of_family(LoopFamily::Relays, (10.0, 2.0, 1.0), Rule::Nested);
    let mut memory = material.on_limiting_curve(Branch::Cooling, [-60.0]);
    let turned = walk(&material, &mut memory, &[10.0]);
    let later = walk(&material, &mut memory, &[0.0]);
    assert!((turned - 0.5).abs() < 1e-3 && (later - turned).abs() < 0.02);
}

#[test]
fn kinetics_by_hand() {
    // The source's cosine, and skewed either way.
    for zeta in [0.5, 0.1, 0.9] {
        kinetics_of_skew(zeta);
    }
}

fn kinetics_of_skew(zeta: f64) {
    let (width, spread) = (8.0, 2.0);
    let material = of_family(
        LoopFamily::Kinetics,
        (width, spread, zeta),
        Rule::LastReversal,
    );
    let half = 2.25 * spread;
    let skew = (6.0 * (zeta - 0.5)).exp() - 1.0;
    let done = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        0.5 * (1.0 - (PI * (1.0 + skew) * x / (1.0 + skew * x)).cos())
    };
    let mut memory = material.on_limiting_curve(Branch::Cooling, [-60.0]);
    let up = |at: f64| done((at - (width - half)) / (2.0 * half));
    for at in [0.0, 4.0, 6.0, 9.0] {
        let fraction = walk(&material, &mut memory, &[at]);
        assert!((fraction - up(at)).abs() < 1e-12, "{at}: {fraction}");
    }
    // A plateau, and an excursion on it that leaves no trace.
    for at in [-3.0, 8.0, 9.0, 10.0] {
        let fraction = walk(&material, &mut memory, &[at]);
        let expected = if at < 9.0 { up(9.0) } else { up(at) };
        assert!(
            (fraction - expected).abs() < 1e-12,
            "{at}: {fraction} {expected}"
        );
    }
    // Cooling far enough to transform: heating starts anew, with what is left.
    let down = |at: f64| up(10.0) * (1.0 - done((-width + half - at) / (2.0 * half)));
    assert!((walk(&material, &mut memory, &[-9.0]) - down(-9.0)).abs() < 1e-12);
    let left = down(-9.0);
    let again = left + (1.0 - left) * up(7.0);
    assert!((walk(&material, &mut memory, &[7.0]) - again).abs() < 1e-12);
    // Turned within a transformation that overlaps none: a plateau once more, and back onto the same curve.
    walk(&material, &mut memory, &[0.0, 1.0, -1.0, 2.0]);
    let later = left + (1.0 - left) * up(8.0);
    assert!((walk(&material, &mut memory, &[8.0]) - later).abs() < 1e-12);
}

#[test]
fn families_by_name() {
    for family in LoopFamily::ALL {
        assert_eq!(LoopFamily::parse(&family.to_string()), Some(family));
    }
    assert_eq!(LoopFamily::parse("duhem"), None);
}

#[test]
fn no_number_and_infinity() {
    for family in LoopFamily::ALL {
        let material = of_family(family, (8.0, 3.0, 0.7), Rule::Nested);
        let mut memory = material.on_limiting_curve(Branch::Cooling, [-40.0]);
        walk(&material, &mut memory, &[9.0, 3.0]);
        let before = memory.clone();
        assert!(walk(&material, &mut memory, &[f64::NAN]).is_nan());
        assert_eq!(memory, before);
        let hot = walk(&material, &mut memory, &[f64::INFINITY]);
        assert!((hot - 1.0).abs() < ROUNDING, "{family}: {hot}");
        let cold = walk(&material, &mut memory, &[f64::NEG_INFINITY]);
        assert!(cold.abs() < ROUNDING, "{family}: {cold}");
    }
}

#[test]
fn tails_and_bends_are_those_of_both_populations() {
    let relays = of_family(LoopFamily::Relays, (8.0, 4.0, 0.7), Rule::Nested);
    let alike = SecondPopulation {
        share: 0.4,
        ..SecondPopulation::default()
    };
    let shaped = |relays: Hysteresis<1>| {
        let relays = relays.with_tails([0.8]).unwrap();
        relays.with_bends([[0.2], [0.1], [-0.1]]).unwrap()
    };
    let one = shaped(relays);
    let two = shaped(relays.with_second_population([alike]).unwrap());
    let [mut of_one, mut of_two] =
        [&one, &two].map(|one| one.between_limiting_curves([-50.0], [0.0]));
    for degc in [3.0, 12.0, -2.0, 6.0, -9.0, 30.0] {
        let fraction = walk(&one, &mut of_one, &[degc]);
        assert!((walk(&two, &mut of_two, &[degc]) - fraction).abs() < 1e-9);
        let is_heating = of_one.branch(0) == Some(Branch::Heating);
        assert_eq!(is_heating, [3.0, 12.0, 6.0, 30.0].contains(&degc));
    }
    assert_eq!(of_one.branch(1), None);
}

#[test]
fn a_start_on_a_limiting_curve_goes_on_along_it() {
    for family in [LoopFamily::Relays, LoopFamily::Kinetics] {
        let material = of_family(family, (8.0, 4.0, 0.7), Rule::Nested);
        let mut heated = material.between_limiting_curves([-200.0], [0.0]);
        let heating = walk(&material, &mut heated, &[9.0]);
        let mut begun = material.at([9.0], [heating]).unwrap();
        let mut cooled = begun.clone();
        for degc in [10.0, 14.0] {
            let [expected, found] =
                [&mut heated, &mut begun].map(|one| walk(&material, one, &[degc]));
            assert!(
                (found - expected).abs() < 1e-9,
                "{family} {found} {expected}"
            );
        }
        // On the heating curve, and not on that of cooling, where it would fall at once.
        let back = walk(&material, &mut cooled, &[4.0]);
        assert!(heating - back < 0.2 * heating, "{family} {heating} {back}");
        assert!(material.at([9.0], [heating - 0.01]).is_err());
        // Where both curves are one there is one fraction.
        assert!(material.at([1e5], [1.0]).is_ok());
        assert!(material.at([1e5], [0.5]).is_err());
    }
}
