//! Damaged files through the program: whatever a file has become, the program says so or answers with numbers.
//!
//! A few dozen by default; `SMA_MUTATIONS=5000` tries as many (docs/reliability.md).

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests, which say what was tried"
)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::{Duration, Instant};

use assert_cmd::Command;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use serde_json::Value;

/// Mutations where the environment does not say how many.
const FEW: usize = 18;

/// A call that takes longer hangs: sound files take at most two seconds.
const LONGEST: Duration = Duration::from_secs(60);

/// Words that a number, a key or a name may have become.
const TOKENS: [&str; 24] = [
    "NaN",
    "inf",
    "-inf",
    "1e999",
    "1e308",
    "-1e308",
    "1e-320",
    "0",
    "-0",
    "-1",
    "",
    " ",
    "-",
    "1,5",
    "0x10",
    "\"",
    "\u{0}",
    "é",
    "[[",
    "]",
    "\n",
    "\t",
    "true",
    "99999999999999999999",
];

/// A file, and the calls that read it in the place of the sound one.
struct Kind {
    /// Its name in the folder.
    file: &'static str,
    /// Calls; `diagnose` and `tune`, which take longer, are made for one mutation in eight.
    calls: &'static [&'static str],
}

const KINDS: [Kind; 6] = [
    Kind {
        file: "train.csv",
        calls: &[
            "inspect train.csv --rod rod.toml --json",
            "identify rod.toml --train train.csv --validate validate.csv --quiet --json -",
            "simulate model.toml --drive train.csv --quiet",
            "init train.csv --force --rod first.toml",
            "diagnose rod.toml --train train.csv --validate validate.csv --quiet --json -",
        ],
    },
    Kind {
        file: "rod.toml",
        calls: &[
            "inspect train.csv --rod rod.toml --json",
            "identify rod.toml --train train.csv --validate validate.csv --quiet --json -",
            "diagnose rod.toml --train train.csv --validate validate.csv --quiet --json -",
        ],
    },
    Kind {
        file: "model.toml",
        calls: &[
            "simulate model.toml --drive train.csv --quiet",
            "export model.toml --to python --quiet --output -",
            "identify rod.toml --train train.csv --from-model model.toml --quiet --json -",
            "tune model.toml --step-output 2.5 --drive-max 5.5 --quiet --json -",
        ],
    },
    Kind {
        file: "own.toml",
        calls: &[
            "diagnose rod.toml --train train.csv --hypothesis own.toml --effort quick --quiet --json -",
        ],
    },
    Kind {
        file: "tuned.json",
        calls: &["export model.toml --to c --tuned tuned.json --quiet --output -"],
    },
    Kind {
        file: "kept.jsonl",
        calls: &[
            "identify rod.toml --train train.csv --starts 64 --resume kept.jsonl --quiet --json -",
        ],
    },
];

const OWN: &str = r#"[[hypothesis]]
id = "fan"
name = "stronger convection"
heat_flow_w_per_m = "-k * max(T - Ta, 0)^1.25"

[hypothesis.parameters.k]
unit = "W/(m K^1.25)"
typical = 0.02
bounds = [0.0, 1.0]
"#;

/// Every eighth row of a bundled recording.
fn thinned(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("bundled")
        .join(name);
    let text = fs::read_to_string(path).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let header_and_rows = lines.enumerate().filter(|(k, _)| *k == 0 || k % 8 == 1);
    header_and_rows
        .map(|(_, line)| format!("{line}\n"))
        .collect()
}

fn run(folder: &Path, call: &str) -> Output {
    Command::cargo_bin("sma")
        .unwrap()
        .current_dir(folder)
        .args(call.split(' '))
        .args(["--threads", "1"].iter().filter(|_| has_threads(call)))
        .timeout(LONGEST)
        .output()
        .unwrap()
}

fn has_threads(call: &str) -> bool {
    ["identify", "diagnose", "tune"]
        .iter()
        .any(|command| call.starts_with(command))
}

/// The sound files, and a place for the damaged ones.
struct Bench {
    folder: tempfile::TempDir,
    sound: BTreeMap<&'static str, String>,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        for name in ["train.csv", "validate.csv"] {
            fs::write(place(name), thinned(name)).unwrap();
        }
        fs::copy(
            PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("bundled/rod.toml"),
            place("rod.toml"),
        )
        .unwrap();
        fs::write(place("own.toml"), OWN).unwrap();
        let made = run(
            folder.path(),
            "identify rod.toml --train train.csv --save-model model.toml --quiet",
        );
        assert_eq!(made.status.code(), Some(0), "{}", said(&made));
        let made = run(
            folder.path(),
            "tune model.toml --step-output 2.5 --drive-max 5.5 --quiet --json tuned.json",
        );
        assert!(
            made.status
                .code()
                .is_some_and(|code| code == 0 || code == 4),
            "{}",
            said(&made)
        );
        fs::write(place("kept.jsonl"), Self::kept(folder.path())).unwrap();
        let sound = KINDS
            .iter()
            .map(|kind| (kind.file, fs::read_to_string(place(kind.file)).unwrap()))
            .collect();
        Self { folder, sound }
    }

    /// The file of a search that was killed, up to its eighth start.
    fn kept(folder: &Path) -> String {
        let path = folder.join("kept.jsonl");
        let begun = Instant::now();
        let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("sma"))
            .current_dir(folder)
            .args("identify rod.toml --train train.csv --starts 64 --resume kept.jsonl --quiet --json -".split(' '))
            .args(["--threads", "1"])
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        let mut text = String::new();
        while begun.elapsed() < LONGEST && text.lines().count() < 9 {
            // It is gone where the search has ended.
            text = fs::read_to_string(&path).unwrap_or(text);
            std::thread::sleep(Duration::from_millis(1));
        }
        let _ = child.kill();
        let _ = child.wait();
        let whole = text.lines().take(9).map(|line| format!("{line}\n"));
        whole.collect()
    }
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A number from 0 on and below `n`.
fn below(rng: &mut ChaCha8Rng, n: usize) -> usize {
    (rng.next_u64() % n.max(1) as u64) as usize
}

/// Start and end of one number in a text, the next after a random place.
fn a_number(rng: &mut ChaCha8Rng, text: &[u8]) -> Option<(usize, usize)> {
    let from = below(rng, text.len());
    let is_digit = |byte: &u8| byte.is_ascii_digit() || b".-+e".contains(byte);
    let start = from + text[from..].iter().position(u8::is_ascii_digit)?;
    let end = start
        + text[start..]
            .iter()
            .position(|byte| !is_digit(byte))
            .unwrap_or(text.len() - start);
    Some((start, end))
}

/// A damaged text: one to three changes.
fn mutated(rng: &mut ChaCha8Rng, sound: &str) -> Vec<u8> {
    let mut text = sound.as_bytes().to_vec();
    for _ in 0..=below(rng, 3) {
        let place = below(rng, text.len());
        let token = TOKENS[below(rng, TOKENS.len())].as_bytes();
        match below(rng, 10) {
            0 => text[place] = rng.next_u32().to_le_bytes()[0],
            1 => text.truncate(place),
            2 => {
                let end = (place + below(rng, 80)).min(text.len());
                text.drain(place..end);
            }
            3 => {
                let end = (place + below(rng, 200)).min(text.len());
                let again = text[place..end].to_vec();
                text.splice(place..place, again);
            }
            4 => {
                text.splice(place..place, token.iter().copied());
            }
            5 => {
                // Two lines change places.
                let mut lines: Vec<&[u8]> = text.split(|byte| *byte == b'\n').collect();
                let [a, b] = [0, 1].map(|_| below(rng, lines.len()));
                lines.swap(a, b);
                text = lines.join(&b'\n');
            }
            6 | 7 => {
                if let Some((start, end)) = a_number(rng, &text) {
                    text.splice(start..end, token.iter().copied());
                }
            }
            _ => {
                // A number of another size or sign.
                if let Some((start, end)) = a_number(rng, &text) {
                    let word = String::from_utf8_lossy(&text[start..end]).into_owned();
                    let factors = [-1.0, 0.0, 1e-6, 0.5, 2.0, 1e3, 1e9, 1e100];
                    let value = word.parse::<f64>().unwrap_or(1.0) * factors[below(rng, 8)];
                    text.splice(start..end, value.to_string().into_bytes());
                }
            }
        }
        if text.is_empty() {
            break;
        }
    }
    text
}

/// True if a text has a number that is none, as a word by itself.
fn has_no_number(text: &str) -> bool {
    let mut words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
    words.any(|word| matches!(word, "NaN" | "nan" | "inf" | "Infinity"))
}

/// Fault in how a call on a damaged file ended.
fn fault(
    kind: &Kind,
    text: &str,
    call: &str,
    output: &Output,
    took: Duration,
) -> Option<&'static str> {
    let stderr = said(output);
    let stdout = String::from_utf8_lossy(&output.stdout);
    if took >= LONGEST {
        return Some("hangs");
    }
    if stderr.contains("panicked") {
        return Some("panics");
    }
    match output.status.code() {
        Some(0 | 4) => {
            // Source code has these words in its remarks, and the unit of a hypothesis may have become one.
            let may_say_so =
                call.starts_with("export") || kind.file == "own.toml" && has_no_number(text);
            if has_no_number(&stdout) && !may_say_so {
                return Some("no number in a result");
            }
            let is_json = call.contains("--json");
            if is_json && serde_json::from_str::<Value>(&stdout).is_err() && !stdout.is_empty() {
                return Some("no JSON");
            }
            None
        }
        Some(3) if !stdout.is_empty() => Some("a refusal with a result"),
        Some(3) if !stderr.contains(kind.file) => Some("a refusal that names no file"),
        Some(3) if stderr.trim_end().len() < 12 => Some("a refusal that says nothing"),
        Some(3) => None,
        _ => Some("ends with another code"),
    }
}

#[test]
fn damaged_files_are_refused_by_name_or_give_numbers() {
    let n = std::env::var("SMA_MUTATIONS").ok();
    let n: usize = n.map_or(FEW, |n| n.parse().unwrap());
    let bench = Bench::new();
    let folder = bench.folder.path();
    let mut rng = ChaCha8Rng::seed_from_u64(40);
    let mut ends: BTreeMap<(&str, Option<i32>), usize> = BTreeMap::new();
    let mut placed = [0, 0];
    let mut slowest = Duration::ZERO;
    let mut faults = Vec::new();
    for number in 0..n {
        let kind = &KINDS[number % KINDS.len()];
        let bytes = mutated(&mut rng, &bench.sound[kind.file]);
        let every = number / KINDS.len();
        for call in kind.calls {
            let takes_long = call.starts_with("diagnose rod.toml --train train.csv --validate")
                || call.starts_with("tune");
            // In a short run each call sees some of them.
            let is_left_out = if n <= FEW {
                !(every + kind.calls.iter().position(|one| one == call).unwrap())
                    .is_multiple_of(kind.calls.len())
            } else {
                takes_long && !every.is_multiple_of(8)
            };
            if is_left_out {
                continue;
            }
            fs::write(folder.join(kind.file), &bytes).unwrap();
            let begun = Instant::now();
            let output = run(folder, call);
            let took = begun.elapsed();
            slowest = slowest.max(took);
            *ends.entry((kind.file, output.status.code())).or_default() += 1;
            if output.status.code() == Some(3) {
                let stderr = said(&output);
                let after = stderr.split(kind.file).nth(1).unwrap_or_default();
                placed[usize::from(after.starts_with(':'))] += 1;
            }
            if let Some(what) = fault(kind, &String::from_utf8_lossy(&bytes), call, &output, took) {
                let kept =
                    std::env::temp_dir().join(format!("sma-mutation-{number}-{}", kind.file));
                if n > FEW {
                    fs::write(&kept, &bytes).unwrap();
                }
                let stderr = said(&output).chars().take(300).collect::<String>();
                faults.push(format!(
                    "{number} {call}: {what}: {:?}: {stderr}",
                    output.status.code()
                ));
            }
        }
        fs::write(folder.join(kind.file), &bench.sound[kind.file]).unwrap();
    }
    let left: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|one| one.unwrap().file_name())
        .collect();
    println!("{n} damaged files, calls by file and exit code: {ends:?}");
    println!(
        "refusals with line or key behind the file, {}, others {}; slowest {slowest:?}",
        placed[1], placed[0]
    );
    assert!(left.len() <= 8, "files were left behind: {left:?}");
    assert!(
        faults.is_empty(),
        "{} faults:\n{}",
        faults.len(),
        faults.join("\n")
    );
    assert!(ends.values().sum::<usize>() >= n);
}
