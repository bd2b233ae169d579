//! What is said while a command runs, and where its text goes.

use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar on a terminal, nothing elsewhere.
pub(crate) fn bar(quiet: bool, length: u64, template: &str) -> ProgressBar {
    if quiet || !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// Notes go to stderr, a line each, unless nobody wants them.
pub(crate) fn say(quiet: bool, notes: &[String]) -> io::Result<()> {
    if !quiet {
        for note in notes {
            writeln!(io::stderr(), "note: {note}")?;
        }
    }
    Ok(())
}

/// A closed pipe comes back as an `io::Error` and ends the program quietly.
pub(crate) fn write_stdout(text: &str) -> io::Result<()> {
    io::stdout().write_all(text.as_bytes())?;
    io::stdout().flush()
}
