//! One spoiled drive sample beside a step.

use crate::common;

use common::{ROD, fitted, recording, steps, with_output};
use identify::{OddStep, odd_step};
use recording::Recording;

/// Two recordings of steps, with a noise of some micrometers.
fn sound() -> [Recording; 2] {
    [("a.csv", 0.5), ("b.csv", 0.4)].map(|(name, offset)| {
        let whole = recording(name, steps(900), offset);
        let noise = |k: usize| 0.004 * ((k * k) as f64 * 0.7).sin();
        let output = whole.output().iter().enumerate();
        let noisy = output.map(|(k, y)| y + noise(k)).collect();
        with_output(&whole, "mm", noisy)
    })
}

/// Odd sample that is found in recordings.
fn found(training: &[Recording]) -> Option<OddStep> {
    let (model, fit) = fitted(ROD, training);
    odd_step(&model, &fit, training).unwrap()
}

#[test]
fn a_drive_sample_beside_a_step_that_the_output_contradicts_is_found() {
    // The first sample behind a step: as before it, beyond it, as before a falling one. The last one before.
    for (sample, spoiled) in [(420, 2.4), (420, 6.0), (520, 4.0), (419, 4.0)] {
        let [first, second] = sound();
        let drive = second.drive()[sample];
        let training = [first, second.driven_in(sample, spoiled)];
        let expected = OddStep {
            recording: 1,
            sample,
            drive,
        };
        let odd = found(&training);
        assert_eq!(odd, Some(expected), "{sample}, {spoiled} A for {drive} A");
        let right = expected.put_right(&training[1]);
        assert_eq!(right.drive(), second.drive());
        let said = right.adaptations().last().unwrap().to_string();
        let start = format!(
            "the drive of {spoiled} A at {} s does",
            sample as f64 * 0.25
        );
        assert!(said.starts_with(&start), "{said}");
    }
}

#[test]
fn nothing_is_odd_where_all_steps_are_alike_or_few() {
    assert_eq!(found(&sound()), None);
    // A delay, which each step shows.
    let late = sound().map(|one| {
        let output = (0_usize..900).map(|k| one.output()[k.saturating_sub(2)]);
        with_output(&one, "mm", output.collect())
    });
    assert_eq!(found(&late), None);
    // Of five steps one is too few to see that it stands alone.
    let [first, _] = sound();
    let short = first.driven_in(320, 0.0).within(0.0, 115.0).unwrap();
    assert_eq!(found(&[short]), None);
}
