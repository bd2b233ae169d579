//! All tests of `sma-cli` that see its public API, in one program: each by itself would be linked with everything again.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod another_each_run;
mod antagonist;
mod bad_input;
mod batch;
mod browser;
mod demo;
mod diagnose;
mod docs;
mod drawn_rigs;
mod export;
mod faults;
mod folder;
#[path = "../../examples/generate_recording.rs"]
mod generate_recording;
mod identify;
mod init;
mod inspect;
mod invariance;
mod kills;
#[path = "../../examples/make_fleet.rs"]
mod make_fleet;
mod mutations;
mod reference_page;
mod reports;
mod resume;
mod shell;
mod simulate;
mod spoiled;
mod thermal;
mod trial;
mod tune;
