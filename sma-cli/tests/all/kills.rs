//! Processes that are killed anywhere: no torn file, and the same call again ends with the bytes of a call that was left alone.
//!
//! A few kills by default; `SMA_KILLS=500` makes as many (docs/reliability.md).

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests, which say what was tried"
)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

use crate::make_fleet::make;

/// Kills where the environment does not say how many.
const FEW: usize = 8;

/// A command that is killed and made again until it ends.
struct Killed {
    call: &'static str,
    /// Files that may be there only until the command ends.
    meanwhile: &'static [&'static str],
    /// Files that tell of times, and differ.
    of_times: &'static [&'static str],
    /// Kills of it in a hundred; those that take longest are killed least.
    in_a_hundred: usize,
    /// False for one that a short run leaves out, since it takes seconds.
    is_short: bool,
}

const COMMANDS: [Killed; 6] = [
    Killed {
        call: "identify rod.toml --train train.csv --validate validate.csv --starts 48 --resume kept --json out.json \
               --save-model model-2.toml --report page.html --quiet --threads 1",
        meanwhile: &["kept"],
        of_times: &[],
        in_a_hundred: 30,
        is_short: true,
    },
    Killed {
        call: "diagnose rod.toml --train train.csv --validate validate.csv --resume kept --json out.json --series series.json \
               --report page.html --quiet --threads 1",
        meanwhile: &["kept"],
        of_times: &[],
        in_a_hundred: 25,
        is_short: false,
    },
    Killed {
        call: "tune model.toml --step-output 2.5 --drive-max 5.5 --json tuned.json --report page.html --responses steps.csv \
               --quiet --threads 1",
        meanwhile: &[],
        of_times: &[],
        in_a_hundred: 6,
        is_short: false,
    },
    Killed {
        call: "export model.toml --to c --quiet --output rod.h",
        meanwhile: &[],
        of_times: &[],
        in_a_hundred: 18,
        is_short: true,
    },
    Killed {
        call: "batch rigs --do identify --out night --csv night/table.csv --json night/fleet.json --jobs 1 --quiet",
        meanwhile: &[],
        of_times: &[],
        in_a_hundred: 18,
        is_short: true,
    },
    Killed {
        call: "trial --seed kills --family clean-outliers --cases 2 --jobs 1 --out t --json out.json --quiet",
        meanwhile: &[],
        of_times: &["t/times.csv", "t/runs.csv", "out.json"],
        in_a_hundred: 3,
        is_short: false,
    },
];

/// Rod, model and recordings, and a small fleet.
fn inputs(folder: &Path) {
    let bundled = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("bundled");
    fs::copy(bundled.join("rod.toml"), folder.join("rod.toml")).unwrap();
    for name in ["train.csv", "validate.csv"] {
        let text = fs::read_to_string(bundled.join(name)).unwrap();
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        let kept = lines.enumerate().filter(|(k, _)| *k == 0 || k % 8 == 1);
        let kept: String = kept.map(|(_, line)| format!("{line}\n")).collect();
        fs::write(folder.join(name), kept).unwrap();
    }
    let call = "identify rod.toml --train train.csv --save-model model.toml --quiet";
    assert!(sma(folder, call).status().unwrap().success());
    make(&folder.join("rigs"), 3, 1, 200).unwrap();
}

fn sma(folder: &Path, call: &str) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("sma"));
    command
        .current_dir(folder)
        .args(call.split_whitespace())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
}

/// All files below a folder, hidden ones as well.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        // What a child of a killed process removes meanwhile is not there.
        if path.is_dir() {
            let below = files(&path).into_iter();
            all.extend(below.map(|(file, bytes)| (format!("{name}/{file}"), bytes)));
        } else if let Ok(bytes) = fs::read(&path) {
            all.insert(name, bytes);
        }
    }
    all
}

impl Killed {
    /// Files of a call that nobody disturbed, and how long it took.
    fn whole(&self) -> (BTreeMap<String, Vec<u8>>, Duration) {
        let folder = tempfile::tempdir().unwrap();
        inputs(folder.path());
        let begun = Instant::now();
        let status = sma(folder.path(), self.call).status().unwrap();
        assert!(
            matches!(status.code(), Some(0 | 1 | 4)),
            "{}: {status}",
            self.call
        );
        (self.compared(folder.path()), begun.elapsed())
    }

    /// Files without those that tell of times.
    fn compared(&self, folder: &Path) -> BTreeMap<String, Vec<u8>> {
        let mut all = files(folder);
        all.retain(|name, _| !self.of_times.contains(&name.as_str()));
        all
    }

    /// Kills it one to three times at random moments, and lets it end; what is wrong then, and how often it was killed.
    fn survive(
        &self,
        rng: &mut ChaCha8Rng,
        whole: &BTreeMap<String, Vec<u8>>,
        took: Duration,
    ) -> (Vec<String>, usize) {
        let folder = tempfile::tempdir().unwrap();
        inputs(folder.path());
        let mut faults = Vec::new();
        let mut n_killed = 0;
        for _ in 0..=rng.next_u32() % 3 {
            let mut child = sma(folder.path(), self.call).spawn().unwrap();
            let share = f64::from(rng.next_u32()) / f64::from(u32::MAX);
            std::thread::sleep(took.mul_f64(share));
            if child.try_wait().unwrap().is_some() {
                continue;
            }
            child.kill().unwrap();
            child.wait().unwrap();
            n_killed += 1;
            for (name, bytes) in files(folder.path()) {
                let hidden = name.split('/').any(|part| part.starts_with('.'));
                let passes = self.meanwhile.contains(&name.as_str())
                    || self.of_times.contains(&name.as_str())
                    || name.ends_with(".new")
                    // Lines are added; the last may be torn, which the next call mends.
                    || name.ends_with(".jsonl");
                if !hidden && !passes && whole.get(&name) != Some(&bytes) {
                    faults.push(format!(
                        "{}: {name} is torn, {} bytes",
                        self.call,
                        bytes.len()
                    ));
                }
            }
        }
        let status = sma(folder.path(), self.call).status().unwrap();
        if !matches!(status.code(), Some(0 | 1 | 4)) {
            faults.push(format!("{}: then ends with {status}", self.call));
        }
        let ended = self.compared(folder.path());
        for (name, bytes) in &ended {
            match whole.get(name) {
                None => faults.push(format!("{}: {name} stays", self.call)),
                Some(expected) if expected != bytes => {
                    faults.push(format!("{}: {name} differs", self.call));
                }
                Some(_) => {}
            }
        }
        for name in whole.keys().filter(|name| !ended.contains_key(*name)) {
            faults.push(format!("{}: {name} is not there", self.call));
        }
        (faults, n_killed)
    }
}

#[test]
fn a_killed_command_leaves_no_torn_file_and_ends_with_the_same_bytes() {
    let n = std::env::var("SMA_KILLS").ok();
    let n: usize = n.map_or(FEW, |n| n.parse().unwrap());
    let commands: Vec<&Killed> = COMMANDS
        .iter()
        .filter(|command| command.is_short || n > FEW)
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut faults = Vec::new();
    let mut said = Vec::new();
    for command in &commands {
        let (whole, mut took) = command.whole();
        let wanted = (n * command.in_a_hundred).div_ceil(100);
        let (mut n_killed, mut n_chains) = (0, 0);
        // One that ends before it can be killed ends the chain as well.
        while n_killed < wanted && n_chains < 4 * wanted {
            let (found, killed) = command.survive(&mut rng, &whole, took);
            faults.extend(found);
            n_killed += killed;
            n_chains += 1;
            if killed == 0 {
                // The undisturbed call was slow, as a first one is.
                took /= 2;
            }
        }
        let name = command.call.split(' ').next().unwrap();
        said.push(format!(
            "{name}: {n_killed} kills in {n_chains} chains, {took:.1?} undisturbed"
        ));
        assert!(n_killed > 0, "{name} was never killed");
    }
    println!("{}", said.join("\n"));
    assert!(
        faults.is_empty(),
        "{} faults:\n{}",
        faults.len(),
        faults.join("\n")
    );
}
