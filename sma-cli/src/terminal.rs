//! Progress and notes while a command runs, and output of its text.

use std::borrow::Cow;
use std::env;
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle, TermLike};

/// Variable of the environment by which a program that runs this one asks for progress as lines: `SMA_PROGRESS=lines`.
const PROGRESS: &str = "SMA_PROGRESS";

/// Most lines of progress in a second.
const LINES_HZ: u8 = 4;

/// A bar on a terminal; lines that begin with `progress: ` for a program that asks for them; nothing elsewhere.
pub(crate) fn bar(quiet: bool, length: u64, template: &str) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    if env::var_os(PROGRESS).is_some_and(|form| form == "lines") {
        let lines = Box::new(Lines::default());
        let target = ProgressDrawTarget::term_like_with_hz(lines, LINES_HZ);
        let bar = ProgressBar::with_draw_target(Some(length), target);
        if let Ok(style) = ProgressStyle::with_template(&template.replace("{bar:20} ", "")) {
            bar.set_style(style);
        }
        return bar;
    }
    if !io::stderr().is_terminal() {
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
    /// Stages that were said.
    said: Vec<&'static str>,
}

impl Progress {
    pub(crate) fn new(quiet: bool, length: u64, template: &str) -> Self {
        Self {
            bar: bar(quiet, length, template),
            quiet,
            said: Vec::new(),
        }
    }

    /// A stage has begun or goes on, with so many of its parts done and a word on how far it is.
    pub(crate) fn show(&mut self, stage: &'static str, done: Option<[u64; 2]>, how_far: &str) {
        if let Some([done, of]) = done {
            self.bar.set_length(of);
            self.bar.set_position(done);
        }
        self.bar.set_message(format!("{stage}{how_far}"));
        if self.bar.is_hidden() && !self.quiet && !self.said.contains(&stage) {
            // Progress that cannot be written is no reason to stop.
            let _ = writeln!(io::stderr(), "{stage} …");
            self.said.push(stage);
        }
    }

    pub(crate) fn end(&self) {
        self.bar.finish_and_clear();
    }
}

/// Progress as lines on stderr, each that differs from the one before.
#[derive(Debug, Default)]
struct Lines(Mutex<Written>);

#[derive(Debug, Default)]
struct Written {
    line: String,
    last: String,
}

impl TermLike for Lines {
    fn width(&self) -> u16 {
        200
    }

    fn move_cursor_up(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_down(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_right(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn move_cursor_left(&self, _: usize) -> io::Result<()> {
        Ok(())
    }

    fn write_line(&self, text: &str) -> io::Result<()> {
        self.write_str(text)
    }

    fn write_str(&self, text: &str) -> io::Result<()> {
        let mut written = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        written.line.push_str(text);
        Ok(())
    }

    fn clear_line(&self) -> io::Result<()> {
        Ok(())
    }

    fn flush(&self) -> io::Result<()> {
        let mut written = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let line = std::mem::take(&mut written.line);
        let words: Vec<&str> = line.split_whitespace().collect();
        let line = words.join(" ");
        if !line.is_empty() && line != written.last {
            writeln!(io::stderr(), "progress: {}", harmless(&line))?;
            written.last = line;
        }
        Ok(())
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
