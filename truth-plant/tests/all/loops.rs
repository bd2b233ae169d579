//! Laws of every family of loops, and further ones of Preisach's.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test may end in a panic"
)]

use truth_plant::{
    CosineLoop, Draw, DriveName, FamilyKind, Hysteresis, L2pLoop, LoopFamily, PreisachLoop,
};

/// A reproducible path that wanders through the loop and out of it: extremes only.
fn wandering(n: usize) -> Vec<f64> {
    let mut state = 12_345_u64;
    let mut uniform = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..n).map(|_| 20.0 + 90.0 * uniform()).collect()
}

/// In 0..1, never against the direction of the temperature, and without jumps.
fn keeps_the_laws<H: Hysteresis>(name: &str, operator: &H) {
    let mut memory = operator.rest(20.0);
    let (mut last_degc, mut last) = (20.0, operator.fraction(&memory, 20.0));
    assert!((0.0..0.2).contains(&last), "{name} rests at {last}");
    for goal_degc in wandering(400) {
        let from_degc = last_degc;
        for part in 1..=200 {
            let temperature_degc = from_degc + (goal_degc - from_degc) * f64::from(part) / 200.0;
            let fraction = operator.fraction(&memory, temperature_degc);
            let change = fraction - last;
            let step_k = temperature_degc - last_degc;
            let where_ = format!("{name}: {last_degc} to {temperature_degc}, {last} to {fraction}");
            assert!((0.0..=1.0).contains(&fraction), "{where_}");
            assert!(change * step_k.signum() >= -1e-12, "{where_}");
            // No slope is above the steepest limiting curve's, some 0.2/K, nor that of a branch begun inside.
            assert!(change.abs() <= 1.0 * step_k.abs() + 1e-9, "{where_}");
            operator.commit(&mut memory, temperature_degc);
            (last_degc, last) = (temperature_degc, fraction);
        }
    }
}

#[test]
fn fractions_stay_in_range_and_branches_are_monotone_and_continuous() {
    let l2p = L2pLoop::default();
    keeps_the_laws("l2p", &l2p.operator().unwrap());
    let nested = L2pLoop {
        nested: true,
        ..l2p
    };
    keeps_the_laws("nested", &nested.operator().unwrap());
    let lopsided = L2pLoop {
        cooling_over_heating_spread: 2.0,
        ..l2p
    };
    keeps_the_laws("lopsided", &lopsided.operator().unwrap());
    keeps_the_laws("preisach", &PreisachLoop::default().operator().unwrap());
    // Relays of no width are no relays: they would jump at reversals.
    let narrow = PreisachLoop {
        heating_center_degc: 53.0,
        correlation: 0.0,
        ..PreisachLoop::default()
    };
    let operator = narrow.operator().unwrap();
    keeps_the_laws("narrow preisach", &operator);
    let turned = after(&operator, &[52.3, 52.3 - 1e-6]);
    assert!((turned[0] - turned[1]).abs() < 1e-7, "{turned:?}");
    keeps_the_laws("cosine", &CosineLoop::default().operator().unwrap());
    // Overlapping transformations: a reversal finds the other one under way.
    let overlapping = CosineLoop {
        martensite_start_degc: 68.0,
        ..CosineLoop::default()
    };
    keeps_the_laws("overlapping", &overlapping.operator().unwrap());
}

#[test]
fn a_finer_path_is_the_same_path() {
    fn end<H: Hysteresis>(operator: &H, parts: i32) -> Vec<f64> {
        let mut memory = operator.rest(20.0);
        let mut from_degc = 20.0;
        let mut ends = Vec::new();
        for goal_degc in wandering(60) {
            for part in 1..=parts {
                let share = f64::from(part) / f64::from(parts);
                operator.commit(&mut memory, from_degc + (goal_degc - from_degc) * share);
            }
            ends.push(operator.fraction(&memory, goal_degc));
            from_degc = goal_degc;
        }
        ends
    }
    fn agree<H: Hysteresis>(operator: &H) {
        let pairs = end(operator, 1).into_iter().zip(end(operator, 37));
        for (coarse, fine) in pairs {
            assert!((coarse - fine).abs() < 1e-9, "{coarse} {fine}");
        }
    }
    agree(&L2pLoop::default().operator().unwrap());
    agree(
        &L2pLoop {
            nested: true,
            ..L2pLoop::default()
        }
        .operator()
        .unwrap(),
    );
    agree(&PreisachLoop::default().operator().unwrap());
    agree(&CosineLoop::default().operator().unwrap());
}

/// Fractions after each of some straight paths.
fn after<H: Hysteresis>(operator: &H, path_degc: &[f64]) -> Vec<f64> {
    let mut memory = operator.rest(20.0);
    path_degc
        .iter()
        .map(|&degc| {
            operator.commit(&mut memory, degc);
            operator.fraction(&memory, degc)
        })
        .collect()
}

#[test]
fn minor_loops_close_and_are_forgotten() {
    let nested = L2pLoop {
        nested: true,
        ..L2pLoop::default()
    }
    .operator()
    .unwrap();
    let preisach = PreisachLoop::default().operator().unwrap();
    let looped_degc = [68.0, 55.0, 66.0, 57.0, 64.0, 57.0, 66.0, 55.0, 68.0];
    for fractions in [after(&nested, &looped_degc), after(&preisach, &looped_degc)] {
        // Return points, from inside out.
        for (one, other) in [(3, 5), (2, 6), (1, 7), (0, 8)] {
            let gap = (fractions[one] - fractions[other]).abs();
            assert!(gap < 1e-12, "{one} {other}: {gap:e}");
        }
    }
    // Past the return point the loop might as well not have been.
    let [with, without] =
        [&[68.0, 55.0, 66.0, 72.0, 50.0][..], &[72.0, 50.0]].map(|path| after(&preisach, path));
    assert!((with[3] - without[0]).abs() < 1e-12);
    assert!((with[4] - without[1]).abs() < 1e-12);
    let mut memory = preisach.rest(20.0);
    let depths: Vec<usize> = [68.0, 55.0, 66.0, 57.0, 72.0]
        .into_iter()
        .map(|degc| {
            preisach.commit(&mut memory, degc);
            memory.depth()
        })
        .collect();
    assert_eq!(depths, [1, 2, 3, 4, 1]);
}

#[test]
fn the_papers_memory_lets_minor_loops_open() {
    let operator = L2pLoop::default().operator().unwrap();
    let fractions = after(&operator, &[68.0, 60.0, 68.0]);
    assert!(fractions[2] - fractions[0] > 0.01, "{fractions:?}");
}

/// Equal swings switch equal relays, wherever on the limiting loop they hang.
#[test]
fn preisachs_minor_loops_are_congruent() {
    let operator = PreisachLoop::default().operator().unwrap();
    let upper = after(&operator, &[110.0, 55.0, 65.0]);
    let lower = after(&operator, &[65.0, 55.0, 65.0]);
    let heights = [upper[2] - upper[1], lower[2] - lower[1]];
    assert!((heights[0] - heights[1]).abs() < 1e-12, "{heights:?}");
}

#[test]
fn preisachs_limiting_curves_are_the_marginal_distributions() {
    let parameters = PreisachLoop {
        // Far apart: nothing is cut off by β ≤ α.
        heating_center_degc: 90.0,
        ..PreisachLoop::default()
    };
    let operator = parameters.operator().unwrap();
    // Half of the relays have switched at the center, 84.1 % one deviation above it.
    let fractions = after(&operator, &[90.0, 95.0]);
    assert!((fractions[0] - 0.5).abs() < 1e-3, "{fractions:?}");
    assert!((fractions[1] - 0.8413).abs() < 1e-3, "{fractions:?}");
}

#[test]
fn a_cosine_plateau_leaves_no_trace() {
    let operator = CosineLoop::default().operator().unwrap();
    let with = after(&operator, &[66.0, 58.0, 70.0]);
    let without = after(&operator, &[66.0, 66.0, 70.0]);
    assert!(
        (with[1] - with[0]).abs() < 1e-15,
        "58 °C is above M_s: {with:?}"
    );
    assert!((with[2] - without[2]).abs() < 1e-15, "{with:?} {without:?}");
    let full = after(&operator, &[74.0, 42.0]);
    assert!(
        (full[0] - 1.0).abs() < 1e-15 && full[1].abs() < 1e-15,
        "{full:?}"
    );
}

#[test]
fn hot_and_cold_of_every_family_complete_the_transformation() {
    use FamilyKind::{Cosine, L2p, L2pNested, Preisach};
    for family in [L2p, L2pNested, Preisach, Cosine] {
        for seed in 0..20 {
            let plant = Draw::new(seed).plant(family, DriveName::Current);
            let ends = [plant.hysteresis.hot_degc(), plant.hysteresis.cold_degc()];
            let fractions = match plant.hysteresis {
                LoopFamily::L2p(l) => after(&l.operator().unwrap(), &ends),
                LoopFamily::Preisach(l) => after(&l.operator().unwrap(), &ends),
                LoopFamily::Cosine(l) => after(&l.operator().unwrap(), &ends),
                _ => continue,
            };
            assert!(
                fractions[0] > 0.94 && fractions[1] < 0.06,
                "{family:?} {fractions:?}"
            );
        }
    }
}
