//! Runs whose drive is asked for at every sample.

use truth_plant::{Converter, Noise, NoiseKind, Supply, TruthError, TruthPlant};

fn noisy() -> TruthPlant {
    TruthPlant {
        supply: Some(Supply {
            dead_time_s: 0.25,
            ..Supply::default()
        }),
        displacement_noise: Some(Noise {
            kind: NoiseKind::Ar1 { correlation: 0.8 },
            deviation: 5e-6,
        }),
        converter: Some(Converter {
            full_scale_m: 6e-3,
            lowest_m: -5e-4,
            bits: 12,
        }),
        ..TruthPlant::default()
    }
}

#[test]
fn a_controller_that_replays_a_drive_gives_the_same_run() {
    let plant = noisy();
    let drive: Vec<f64> = (0..300).map(|k| f64::from(k / 60 % 2) * 2.0).collect();
    let open = plant.simulate(&drive, 0.1, 7).unwrap();
    let mut seen = Vec::new();
    let closed = plant.controlled(300, 0.1, 7, &mut |k, shown_mm| {
        seen.push(shown_mm);
        drive[k]
    });
    assert_eq!(closed.unwrap(), open);
    assert_eq!(
        seen, open.displacement_mm,
        "it sees what is recorded, noise and steps included"
    );
    assert_eq!(open.drive, drive);
}

#[test]
fn a_loop_that_is_closed_holds_what_an_open_one_does_not() {
    let plant = TruthPlant {
        ambient_degc: 17.0,
        ..TruthPlant::default()
    };
    let target_mm = 2.5;
    let mut integral_a = 0.0;
    let traces = plant.controlled(3000, 0.1, 1, &mut |_, shown_mm| {
        let error_mm = target_mm - shown_mm;
        integral_a = f64::clamp(integral_a + 0.005 * error_mm, 0.0, 2.5);
        (integral_a + 0.3 * error_mm).clamp(0.0, 2.5)
    });
    let last_mm = *traces.unwrap().displacement_mm.last().unwrap();
    assert!((last_mm - target_mm).abs() < 0.02, "{last_mm} mm");
}

#[test]
fn what_no_supply_gives_is_refused_with_its_sample() {
    let plant = TruthPlant::default();
    let asked =
        |value: f64| plant.controlled(10, 0.1, 1, &mut |k, _| if k == 4 { value } else { 1.0 });
    for value in [f64::NAN, -1e9, f64::INFINITY] {
        match asked(value) {
            Err(TruthError::Drive { index: 4, .. }) => {}
            other => panic!("{value}: {other:?}"),
        }
    }
    let none = plant.controlled(0, 0.1, 1, &mut |_, _| 0.0);
    assert_eq!(none.unwrap_err(), TruthError::EmptyDrive);
}
