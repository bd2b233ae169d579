//! Cases from seeds: they run, they transform, and no draw tells of another.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test may end in a panic"
)]

use truth_plant::{
    Addition, Draw, DriveName, FamilyKind, Logging, Manner, NoiseKind, Shape, TruthPlant,
};

const DRIVES: [DriveName; 4] = [
    DriveName::Current,
    DriveName::Duty,
    DriveName::Voltage,
    DriveName::Power,
];
const FAMILIES: [FamilyKind; 6] = [
    FamilyKind::L2p,
    FamilyKind::L2pNested,
    FamilyKind::Preisach,
    FamilyKind::Cosine,
    FamilyKind::Relays,
    FamilyKind::Tanaka,
];

#[test]
fn every_drawn_case_runs_and_shows_its_loop() {
    for seed in 0..56 {
        let draw = Draw::new(seed);
        let index = seed as usize;
        let shape = Shape::ALL[index % 7];
        let mut plant = draw.plant(FAMILIES[index % 6], DRIVES[index / 4 % 4]);
        draw.noise(NoiseKind::OneOverF, &mut plant);
        let profile = draw.drive(shape, &plant, 1500);
        let traces = plant.simulate(&profile.drive, profile.dt_s, seed).unwrap();
        let top = traces.fraction.iter().copied().fold(0.0, f64::max);
        assert!(top > 0.8, "seed {seed}, {shape:?}: {top}");
        // Rest at both ends, the second only as long as the run is.
        assert!(
            traces.fraction[0] < 0.1,
            "seed {seed}: {}",
            traces.fraction[0]
        );
        let hottest = traces.temperature_degc.iter().copied().fold(0.0, f64::max);
        assert!(
            (60.0..200.0).contains(&hottest),
            "seed {seed}: {hottest} °C"
        );
    }
}

#[test]
fn periods_repeat() {
    let draw = Draw::new(4);
    let plant = draw.plant(FamilyKind::L2p, DriveName::Power);
    for shape in Shape::ALL {
        let drive = draw.drive(shape, &plant, 2500).drive;
        // 8 % of rest, periods of 24 %: 600 samples.
        assert!(drive[..200].iter().all(|w| w.abs() < 1e-12));
        for k in 201..799 {
            let (one, next) = (drive[k], drive[k + 600]);
            let neighbor = drive[k + 599].min(drive[k + 601])..=drive[k + 599].max(drive[k + 601]);
            assert!(
                (one - next).abs() < 1e-6 || neighbor.contains(&one),
                "{shape:?} {k}"
            );
        }
        assert!(
            (drive[2100] - drive[2200]).abs() < 1e-12 && drive[2100] > 0.0,
            "hot hold"
        );
        assert!(drive[2300].abs() < 1e-12);
    }
}

#[test]
fn the_same_seed_draws_the_same_case() {
    for family in FAMILIES {
        let plant = |seed| Draw::new(seed).plant(family, DriveName::Duty);
        assert_eq!(plant(9), plant(9));
        assert_ne!(plant(9), plant(10));
    }
}

/// The answer does not move what the case shows.
#[test]
fn drive_and_noise_do_not_know_the_addition() {
    let draw = Draw::new(11);
    let plain = draw.plant(FamilyKind::Preisach, DriveName::Current);
    let mut noisy = plain.clone();
    draw.noise(NoiseKind::White, &mut noisy);
    for addition in Addition::ALL {
        let mut plant = plain.clone();
        addition.install(&mut plant, draw.size(), 300.0);
        draw.noise(NoiseKind::White, &mut plant);
        assert_eq!(plant.displacement_noise, noisy.displacement_noise);
        let drive = draw.drive(Shape::Holds, &plant, 300);
        assert_eq!(drive, draw.drive(Shape::Holds, &plain, 300), "{addition:?}");
    }
}

#[test]
fn additions_and_sizes_are_all_drawn() {
    let mut seen = std::collections::BTreeSet::new();
    let mut sizes = [0; 3];
    for seed in 0..600 {
        seen.extend(Draw::new(seed).addition(&Addition::ALL));
        let size = Draw::new(seed).size();
        sizes[if size < 0.7 {
            0
        } else if size < 1.5 {
            1
        } else {
            2
        }] += 1;
    }
    assert_eq!(seen.len(), Addition::ALL.len());
    assert!(sizes.iter().all(|&n| n > 150), "{sizes:?}");
    assert_eq!(Draw::new(0).addition(&[]), None);
}

#[test]
fn every_addition_runs_in_every_family_at_twice_its_size() {
    for family in FAMILIES {
        let draw = Draw::new(21);
        let plain = draw.plant(family, DriveName::Duty);
        let profile = draw.drive(Shape::Holds, &plain, 600);
        for addition in Addition::ALL {
            let mut plant = plain.clone();
            addition.install(&mut plant, 2.0, 600.0 * profile.dt_s);
            let traces = plant.simulate(&profile.drive, profile.dt_s, 1).unwrap();
            let finite = traces.displacement_mm.iter().all(|mm| mm.is_finite());
            assert!(finite, "{family:?} {addition:?}");
            let in_range = traces.fraction.iter().all(|xi| (0.0..=1.0).contains(xi));
            assert!(in_range, "{family:?} {addition:?}");
        }
    }
}

fn lab_drive(seed: u64, manner: Manner, dead_zone: f64) -> (TruthPlant, truth_plant::LabDrive) {
    let draw = Draw::new(seed);
    let plant = draw.plant(FAMILIES[seed as usize % 6], DRIVES[seed as usize % 4]);
    let n_samples = 900 + 300 * (seed as usize % 5);
    let dt_s = plant.time_constant_s() * manner.shortest_time_constants() / n_samples as f64;
    let logging = Logging {
        n_samples,
        dt_s,
        dead_zone,
    };
    let drive = draw.lab_drive(manner, &plant, logging);
    assert_eq!(drive.profile.drive.len() - drive.n_before, n_samples);
    (plant, drive)
}

#[test]
fn every_manner_of_a_lab_runs_and_shows_the_loop() {
    for manner in Manner::ALL {
        for seed in 0..8 {
            let (plant, lab) = lab_drive(seed, manner, 0.04);
            let profile = &lab.profile;
            let traces = plant.simulate(&profile.drive, profile.dt_s, seed).unwrap();
            let recorded = &traces.fraction[lab.n_before..];
            let top = recorded.iter().copied().fold(0.0, f64::max);
            let bottom = recorded.iter().copied().fold(1.0, f64::min);
            assert!(top - bottom > 0.4, "{manner:?} {seed}: {bottom} to {top}");
            assert_eq!(lab.n_before > 0, manner == Manner::WarmStart);
            let largest = profile.drive.iter().copied().fold(0.0, f64::max);
            let small = |value: &f64| *value > 0.0 && *value < 0.04 * largest;
            assert!(!profile.drive.iter().any(small), "{manner:?} {seed}");
            assert_eq!(lab, lab_drive(seed, manner, 0.04).1);
        }
    }
}

#[test]
fn a_warm_start_is_warm_and_partly_transformed() {
    let starts = (0..30).map(|seed| {
        let (plant, lab) = lab_drive(seed, Manner::WarmStart, 0.0);
        let profile = &lab.profile;
        let traces = plant.simulate(&profile.drive, profile.dt_s, seed).unwrap();
        assert!(
            traces.temperature_degc[lab.n_before] > plant.ambient_degc + 5.0,
            "{seed}"
        );
        traces.fraction[lab.n_before]
    });
    let partly = starts
        .filter(|fraction| (0.1..0.95).contains(fraction))
        .count();
    assert!(partly >= 12, "{partly} of 30");
}
