//! Progress and notes while a command runs, and output of its text.

use std::borrow::Cow;
use std::env;
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

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
    begun: Instant,
    /// The stage that goes on, and when it began.
    stage: (&'static str, Duration),
    /// True if it says how long the rest may take.
    says_left: bool,
}

impl Progress {
    pub(crate) fn new(quiet: bool, length: u64, template: &str) -> Self {
        Self {
            bar: bar(quiet, length, template),
            quiet,
            said: Vec::new(),
            begun: Instant::now(),
            stage: ("", Duration::ZERO),
            says_left: true,
        }
    }

    /// Progress of a search that is a part of something longer: it does not say how long the rest may take.
    pub(crate) fn of_a_part(self) -> Self {
        Self {
            says_left: false,
            ..self
        }
    }

    /// [`Self::show`] of a stage before which usually such a share of the whole time is over: with a word on how long the rest may take.
    pub(crate) fn show_timed(&mut self, stage: &'static str, usual_share: f64, how_far: &str) {
        let elapsed = self.begun.elapsed();
        if self.stage.0 != stage {
            self.stage = (stage, elapsed);
        }
        let left = left(self.stage.1, elapsed, usual_share).filter(|_| self.says_left);
        let left = left
            .and_then(about)
            .map_or(String::new(), |left| format!(", about {left} left"));
        self.show(stage, None, &format!("{how_far}{left}"));
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

/// Time that is left, if a stage began when this share of the whole is usually over; `None` where it takes longer than that.
fn left(begun: Duration, elapsed: Duration, usual_share: f64) -> Option<Duration> {
    let whole = begun.as_secs_f64() / usual_share;
    Duration::try_from_secs_f64(whole - elapsed.as_secs_f64()).ok()
}

/// A time as roughly as it is known: 1, 2 or 5 of a decade of seconds or minutes; `None` below two seconds.
fn about(time: Duration) -> Option<String> {
    const SECONDS: [u64; 6] = [2, 5, 10, 20, 30, 45];
    const MINUTES: [u64; 7] = [1, 2, 5, 10, 20, 30, 60];
    let seconds = time.as_secs();
    let minutes = MINUTES.into_iter().rev().find(|one| 60 * one <= seconds);
    if let Some(minutes) = minutes {
        return Some(format!("{minutes} min"));
    }
    let seconds = SECONDS.into_iter().rev().find(|one| *one <= seconds);
    seconds.map(|seconds| format!("{seconds} s"))
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
    use super::{about, harmless, left};
    use std::time::Duration;

    #[test]
    fn what_is_left_goes_by_the_usual_share_and_is_said_roughly() {
        let seconds = Duration::from_secs;
        // Begun after 6 s, which is usually 0.6 of the whole.
        assert_eq!(left(seconds(6), seconds(6), 0.6), Some(seconds(4)));
        assert_eq!(left(seconds(6), seconds(9), 0.6), Some(seconds(1)));
        assert_eq!(left(seconds(6), seconds(11), 0.6), None);
        let said = [1, 4, 19, 59, 60, 299, 86_400].map(|time| about(seconds(time)));
        let expected = ["", "2 s", "10 s", "45 s", "1 min", "2 min", "60 min"];
        assert_eq!(said.map(Option::unwrap_or_default), expected);
    }

    #[test]
    fn escape_sequences_do_not_reach_a_terminal() {
        assert_eq!(harmless("a\tb\n°C ─ ⣿"), "a\tb\n°C ─ ⣿");
        assert_eq!(
            harmless("\u{1b}]0;owned\u{7}.csv\r"),
            "\u{fffd}]0;owned\u{fffd}.csv\u{fffd}"
        );
    }
}
