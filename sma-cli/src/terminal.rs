//! Progress and notes while a command runs, and output of its text.

use std::borrow::Cow;
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

/// Progress of a long search: a bar on a terminal; elsewhere a line on stderr for each stage, so that a log does not stand still.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
    quiet: bool,
    stage: &'static str,
}

impl Progress {
    pub(crate) fn new(quiet: bool, length: u64, template: &str) -> Self {
        Self {
            bar: bar(quiet, length, template),
            quiet,
            stage: "",
        }
    }

    /// A stage has begun or goes on, with so many of its parts done and a word on how far it is.
    pub(crate) fn show(&mut self, stage: &'static str, done: Option<[u64; 2]>, how_far: &str) {
        if let Some([done, of]) = done {
            self.bar.set_length(of);
            self.bar.set_position(done);
        }
        self.bar.set_message(format!("{stage}{how_far}"));
        if self.bar.is_hidden() && !self.quiet && self.stage != stage {
            // Progress that cannot be written is no reason to stop.
            let _ = writeln!(io::stderr(), "{stage} …");
        }
        self.stage = stage;
    }

    pub(crate) fn end(&self) {
        self.bar.finish_and_clear();
    }
}

/// A text without what commands a terminal: names of files may hold escape sequences.
pub(crate) fn harmless(text: &str) -> Cow<'_, str> {
    let commands = |c: char| c.is_control() && c != '\n' && c != '\t';
    if text.contains(commands) {
        Cow::Owned(text.replace(commands, "\u{fffd}"))
    } else {
        Cow::Borrowed(text)
    }
}

/// Notes go to stderr, a line each, unless nobody wants them.
pub(crate) fn say(quiet: bool, notes: &[String]) -> io::Result<()> {
    if !quiet {
        for note in notes {
            writeln!(io::stderr(), "note: {}", harmless(note))?;
        }
    }
    Ok(())
}

/// A closed pipe comes back as an `io::Error` and ends the program quietly.
pub(crate) fn write_stdout(text: &str) -> io::Result<()> {
    io::stdout().write_all(harmless(text).as_bytes())?;
    io::stdout().flush()
}

#[cfg(test)]
mod tests {
    use super::harmless;

    #[test]
    fn escape_sequences_do_not_reach_a_terminal() {
        assert_eq!(harmless("a\tb\n°C ─ ⣿"), "a\tb\n°C ─ ⣿");
        assert_eq!(
            harmless("\u{1b}]0;owned\u{7}.csv\r"),
            "\u{fffd}]0;owned\u{fffd}.csv\u{fffd}"
        );
    }
}
