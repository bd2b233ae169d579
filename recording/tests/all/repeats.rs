//! How far a rig repeats, told from what outputs of the same drive differ by.

use recording::{Difference, Recording, RecordingParts, RepeatFloor, repeat_floor};

const DT_S: f64 = 0.1;

/// A run: seconds at 0 and at 1 in turn, beginning at rest, into a lag of 3 s.
struct Run {
    name: &'static str,
    levels_s: &'static [f64],
    gain: f64,
    tau_s: f64,
    late_s: f64,
    offset: f64,
    /// Time of the first sample, s.
    from_s: f64,
    /// Stamps scatter by so much either way, s.
    jitter_s: f64,
}

impl Default for Run {
    fn default() -> Self {
        Self {
            name: "run",
            levels_s: &[5.0, 20.0, 25.0],
            gain: 1.0,
            tau_s: 3.0,
            late_s: 0.0,
            offset: 0.0,
            from_s: 0.0,
            jitter_s: 0.0,
        }
    }
}

/// White noise of about one, the same each time.
fn noise(k: usize, seed: u64) -> f64 {
    let mut state = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15)
        ^ seed.wrapping_mul(0xD1B5_4A32_D192_ED03);
    let mut sum = 0.0;
    for _ in 0..12 {
        state ^= state >> 27;
        state = state.wrapping_mul(0x2545_F491_4F6C_DD1D);
        state ^= state >> 31;
        sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
    }
    sum - 6.0
}

impl Run {
    fn recorded(&self, seed: u64) -> Recording {
        let n = (self.levels_s.iter().sum::<f64>() / DT_S).round() as usize;
        let time_s: Vec<f64> = (0..n)
            .map(|k| {
                self.from_s
                    + k as f64 * DT_S
                    + self.jitter_s * (noise(k, seed + 7) / 4.0).clamp(-1.0, 1.0)
            })
            .collect();
        let level = |t: f64| {
            let mut until_s = 0.0;
            for (k, lasts_s) in self.levels_s.iter().enumerate() {
                until_s += lasts_s;
                if t < until_s - 1e-6 {
                    return f64::from(u8::from(k % 2 == 1));
                }
            }
            0.0
        };
        // A hundredth of a sample at a time.
        let fine_s = 0.01 * DT_S;
        let (mut at, mut fine) = (0.0, 0_usize);
        let mut output = Vec::with_capacity(n);
        for (k, t) in time_s.iter().enumerate() {
            while (fine as f64) * fine_s < *t {
                at += (level(fine as f64 * fine_s - self.late_s) - at) * fine_s / self.tau_s;
                fine += 1;
            }
            output.push(self.offset + self.gain * at + 0.001 * noise(k, seed));
        }
        Recording::new(RecordingParts {
            name: self.name.to_owned(),
            drive: time_s.iter().map(|t| level(*t)).collect(),
            time_s: Some(time_s),
            output_unit: "mm".to_owned(),
            output,
            ..RecordingParts::default()
        })
        .unwrap()
    }
}

fn floor(runs: &[Run]) -> Option<RepeatFloor> {
    let recorded: Vec<Recording> = runs
        .iter()
        .zip(1..)
        .map(|(run, seed)| run.recorded(seed))
        .collect();
    repeat_floor(&recorded)
}

#[test]
fn what_differs_between_two_runs_is_told_with_its_size() {
    let [plain, further, later] = [(1.0, 0.0), (1.05, 0.0), (1.0, 0.4)].map(|(gain, late_s)| Run {
        gain,
        late_s,
        offset: 0.3,
        ..Run::default()
    });
    let of = |second: Run| floor(&[Run::default(), second]).unwrap();
    let same = of(plain);
    assert!(same.is_noise(), "{:?} {:?}", same.rms(), same.by_noise());
    assert!((same.pairs[0].apart.offset - 0.3).abs() < 0.001);

    let gain = of(further);
    assert!(!gain.is_noise());
    let [Difference::Gain(share)] = gain.pairs[0].apart.differences[..] else {
        panic!("{:?}", gain.pairs[0].apart.differences);
    };
    assert!((share - 0.05).abs() < 0.003, "{share}");
    // Without it noise is left.
    assert!(gain.pairs[0].apart.left < 1.2 * gain.pairs[0].by_noise);
    // A twentieth of what the output varies by, and a half of it each.
    let output = Run::default().recorded(1).output().to_vec();
    let mean = output.iter().sum::<f64>() / output.len() as f64;
    let square = output.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / output.len() as f64;
    let expected = 0.05 * square.sqrt();
    assert!((gain.rms().unwrap() / expected - 1.0).abs() < 0.05);
    assert!((gain.nearest().unwrap() / (0.5 * expected) - 1.0).abs() < 0.05);

    // Of one rise and one fall a delay may as well be a slower course; of two it is not.
    let twice = |run: Run| Run {
        levels_s: &[5.0, 20.0, 25.0, 20.0, 25.0],
        ..run
    };
    let late = floor(&[twice(Run::default()), twice(later)]).unwrap();
    let mut found = (None, None);
    for difference in &late.pairs[0].apart.differences {
        match difference {
            Difference::HeatingLater(by_s) => found.0 = Some(*by_s),
            Difference::CoolingLater(by_s) => found.1 = Some(*by_s),
            _ => {}
        }
    }
    for by_s in [found.0.unwrap(), found.1.unwrap()] {
        assert!((by_s - 0.4).abs() < 0.08, "{by_s}");
    }
}

#[test]
fn only_the_stretch_in_common_is_compared_wherever_it_lies() {
    // The second begins 3 s later and goes on otherwise: what is common is the rise and 20 s of cooling.
    let other = Run {
        name: "other",
        levels_s: &[2.0, 20.0, 20.0, 30.0],
        from_s: 0.0,
        ..Run::default()
    };
    let found = floor(&[Run::default(), other]).unwrap();
    let pair = &found.pairs[0];
    let first = [pair.first.start_s, pair.first.end_s];
    let second = [pair.second.start_s, pair.second.end_s];
    for (found, expected) in first.iter().chain(&second).zip([5.0, 45.0, 2.0, 42.0]) {
        assert!((found - expected).abs() < 0.25, "{first:?} {second:?}");
    }
    assert!(found.is_noise());
}

#[test]
fn clocks_that_scatter_and_begin_within_a_sample_do_not_matter() {
    let other = Run {
        from_s: 0.04,
        jitter_s: 0.02,
        ..Run::default()
    };
    let first = Run {
        jitter_s: 0.02,
        ..Run::default()
    };
    let found = floor(&[first, other]).unwrap();
    // A sample early or late at the steps is 0.03 of the stroke for a few samples.
    assert!(found.rms().unwrap() < 0.01, "{:?}", found.rms());
}

#[test]
fn another_drive_is_not_compared() {
    let with = |levels_s: &'static [f64]| {
        let other = Run {
            levels_s,
            ..Run::default()
        };
        floor(&[Run::default(), other])
    };
    // All that is the same is 18 s of heating.
    let shorter = with(&[5.0, 18.0, 27.0]).unwrap();
    let ends_s = shorter.pairs[0].first.end_s;
    assert!((ends_s - 22.9).abs() < 0.25, "{ends_s}");
    // The first 2 s of it here are too few, and what follows another 5 s of rest is not the same: the rod is still warm.
    assert_eq!(with(&[1.0, 2.0, 5.0, 3.0, 20.0]), None);
}

#[test]
fn a_recording_that_begins_driven_begins_elsewhere() {
    let whole = Run::default().recorded(1);
    // In the middle of the heating: what came before is not in it.
    let cut = whole.slice(120..whole.len()).unwrap();
    let other = Run {
        name: "other",
        levels_s: &[0.0, 13.0, 25.0],
        ..Run::default()
    };
    let found = repeat_floor(&[cut, other.recorded(2)]).unwrap();
    assert_eq!((found.pairs.len(), found.first_cycles.len()), (0, 1));
    assert_eq!(
        (found.rms(), found.nearest(), found.is_noise()),
        (None, None, false)
    );
    assert!(found.first_cycles[0].apart.rms > 0.05);
}

#[test]
fn outputs_in_several_units_are_not_pooled() {
    let runs = [Run::default().recorded(1), Run::default().recorded(2)];
    let [a, b] = &runs;
    let in_degrees = |run: &Recording| {
        Recording::new(RecordingParts {
            time_s: Some(run.time_s()[..400].to_vec()),
            drive: run.drive()[..400].to_vec(),
            output_unit: "deg".to_owned(),
            output: run.output()[..400].iter().map(|y| 100.0 * y).collect(),
            ..RecordingParts::default()
        })
        .unwrap()
    };
    let all = [in_degrees(a), in_degrees(b), a.clone(), b.clone()];
    let found = repeat_floor(&all).unwrap();
    assert_eq!((found.unit.as_str(), found.pairs.len()), ("mm", 1));
    assert_eq!(found.pairs[0].recordings(), [2, 3]);
}

#[test]
fn a_first_cycle_is_set_apart() {
    let mut run = Run {
        levels_s: &[2.0, 5.0, 6.0, 5.0, 6.0, 5.0, 6.0, 5.0, 6.0],
        ..Run::default()
    }
    .recorded(1);
    let found = repeat_floor(&[run.clone()]).unwrap();
    assert_eq!((found.first_cycles.len(), found.pairs.len()), (1, 2));
    assert!(found.is_noise(), "{:?}", found.rms());
    // The rest position is off until the first heating.
    let output: Vec<f64> = run
        .output()
        .iter()
        .zip(run.time_s())
        .map(|(y, t)| if *t < 5.0 { y + 0.2 } else { *y })
        .collect();
    run = Recording::new(RecordingParts {
        time_s: Some(run.time_s().to_vec()),
        drive: run.drive().to_vec(),
        output_unit: "mm".to_owned(),
        output,
        ..RecordingParts::default()
    })
    .unwrap();
    let found = repeat_floor(&[run]).unwrap();
    assert!(found.is_noise());
    assert!(found.first_cycles[0].apart.rms > 0.05);
}

#[test]
fn cycles_on_their_way_to_their_end_are_set_apart() {
    // Each is two thirds of the time constant.
    const LEVELS_S: &[f64] = &[3.0; 41];
    let run = Run {
        levels_s: LEVELS_S,
        tau_s: 9.0,
        ..Run::default()
    };
    let found = floor(&[run]).unwrap();
    assert!(found.first_cycles.len() > 2, "{}", found.first_cycles.len());
    assert!(found.pairs.len() > 5, "{}", found.pairs.len());
    assert!(found.is_noise(), "{:?} {:?}", found.rms(), found.by_noise());
    assert!(found.first_cycles[1].apart.rms > 5.0 * found.by_noise().unwrap());
}

#[test]
fn static_data_and_one_run_alone_say_nothing() {
    assert_eq!(floor(&[Run::default()]), None);
    let untimed = Recording::new(RecordingParts {
        drive: vec![1.0; 100],
        output: (0..100).map(f64::from).collect(),
        ..RecordingParts::default()
    });
    let untimed = untimed.unwrap();
    assert_eq!(repeat_floor(&[untimed.clone(), untimed]), None);
}

/// A recording of so many samples of an output that moves, with noise of a memory of ten samples.
fn with_memory(name: &str, gain: f64, seed: u64) -> Recording {
    let n = 1200;
    let mut slow = 0.0;
    let output = (0..n).map(|k| {
        slow = 0.9 * slow + 0.19_f64.sqrt() * 0.02 * noise(k, seed);
        gain * (1.0 - (0.02 * k as f64).cos()) + slow
    });
    Recording::new(RecordingParts {
        name: name.to_owned(),
        output: output.collect(),
        time_s: Some((0..n).map(|k| DT_S * k as f64).collect()),
        drive: (0..n)
            .map(|k| 0.5 - 0.5 * (0.02 * k as f64).cos())
            .collect(),
        output_unit: "mm".to_owned(),
        ..RecordingParts::default()
    })
    .unwrap()
}

#[test]
fn noise_with_a_memory_is_noise_and_another_gain_beside_it_is_none() {
    for seed in [1, 11, 21, 31] {
        let of = |gain: f64| {
            let runs = [
                with_memory("a", 1.0, seed),
                with_memory("b", gain, seed + 1),
            ];
            repeat_floor(&runs).unwrap()
        };
        let same = of(1.0);
        // A memory of ten samples makes it some three times the white part.
        assert!(same.is_noise(), "{:?} {:?}", same.rms(), same.by_noise());
        assert!((same.by_noise().unwrap() / 0.028 - 1.0).abs() < 0.25);
        for gain in [1.04, 1.08] {
            let further = of(gain);
            assert_eq!(further.pairs[0].apart.within_stretches, None, "{gain}");
            assert!(
                !further.is_noise(),
                "{:?} {:?}",
                further.rms(),
                further.by_noise()
            );
        }
    }
}
